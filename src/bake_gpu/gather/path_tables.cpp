#include "bake_gpu/gather/path_tables.h"

#include "bake_gpu/gather/path_layout.h"
#include "shading/srgb_table.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <array>

namespace halflight {

using namespace shading;

static_assert(kPathTextureSets == kTexCoordSets && kPathLevels == RadianceCache::kLevels);

/// PathTables in shaders/bake/paths/tables.glsl.
struct PathTables::Addresses {
    VkDeviceAddress faces, parts, materials, surfaces, colors;
    std::array<VkDeviceAddress, kPathTextureSets> uv;
    VkDeviceAddress pictures, texels, linear;
    std::array<VkDeviceAddress, kPathLevels> levels, componentLevels;
    VkDeviceAddress lights, choosers, emitters, emitterTree, leafOfEmitter, brightAreas, brightBins;
    GpuPathConstants all;
};

namespace {

/// LightChooser in shaders/bake/paths/tables.glsl.
struct LightChooser {
    VkDeviceAddress always, tree, lightOfItem;
    uint32_t alwaysCount, nodes, component;
};

std::vector<vec3> normalsOf(const RayTracer& surfaces)
{
    std::vector<vec3> normals(surfaces.hitTriangleCount());
    parallelFor(normals.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            normals[i] = surfaces.geometry().geometricNormal(surfaces.triangleAt(uint32_t(i)));
    });
    return normals;
}

GpuTextureUse pathTextureOf(const BakeGeometry& geometry, const TextureRef& ref)
{
    GpuTextureUse use{};
    use.picture = ref ? ref.texture : -1;
    use.set = geometry.uv[std::size_t(ref.texCoord)].empty() ? kNone : uint32_t(ref.texCoord);
    use.offset = ref.offset;
    use.scale = ref.scale;
    use.turn = vec2(math::cos(ref.rotationRadians), math::sin(ref.rotationRadians));
    return use;
}

GpuPathMaterial pathMaterialOf(const BakeGeometry& geometry, const TransportMaterial& m, int component)
{
    return {m.baseColorFactor,
            m.metallicFactor,
            m.roughnessFactor,
            m.specular,
            m.emission,
            uint32_t(component),
            pathTextureOf(geometry, m.baseColor),
            pathTextureOf(geometry, m.metallicRoughness),
            pathTextureOf(geometry, m.emissive)};
}

} // namespace

PathTables::~PathTables() = default;

PathTables::PathTables(gpu::Device& device, const DeviceScene& scene, const GpuSurfaces& surfaces,
                       const PathTracer& paths)
    : device_(device), glossy_(paths.glossy()), addresses_(std::make_unique<Addresses>())
{
    ofScene_.scene = scene.address();
    ofScene_.normals = keep(normalsOf(paths.surfaces()));
    addSky(paths.light().sky());
    addComponents(paths.light());
    addSurfaces(paths);
    addFaces(scene, paths);
    addresses_->surfaces = surfaces.address();
    addPictures(paths.surfaces().materials());
    addLights(paths.light());
}

VkDeviceAddress PathTables::forPaths(int bounces, const RadianceCache* cache, std::vector<gpu::Buffer>& buffers) const
{
    Addresses to = *addresses_;
    for (std::size_t i = 0; cache != nullptr && i < kPathLevels; ++i) {
        const std::span<const vec3> level = cache->levels()[i];
        buffers.push_back(bufferOf(device_, level));
        to.levels[i] = buffers.back().address();
        if (!level.empty()) to.all.levels |= 1u << i;
        buffers.push_back(bufferOf(device_, cache->components().levels[i]));
        to.componentLevels[i] = buffers.back().address();
    }
    if (cache != nullptr && !cache->converged()) {
        to.all.levelOfFirst = cache->bounces() - bounces;
        to.all.levelsPerBounce = 1;
    }
    to.all.bounces = bounces;
    to.all.glossy = glossy_ ? 1 : 0;
    buffers.push_back(bufferOf(device_, std::span<const Addresses>(&to, 1)));
    return buffers.back().address();
}

void PathTables::addSky(const SkyLight& light)
{
    const Sky& sky = light.sky();
    const ImageRgb32f* picture = sky.picture.get();
    ofScene_.picture = keep(picture != nullptr ? std::span<const vec3>(picture->texels()) : std::span<const vec3>());
    GpuGatherConstants& all = ofScene_.all;
    all.sky = (light.black() ? 0u : kSky) | (picture != nullptr ? kSkyPicture : 0u);
    all.zenith = sky.zenith;
    all.horizon = sky.horizon;
    all.ground = sky.ground;
    all.pictureSize = picture != nullptr ? picture->size() : ivec2(0);
    all.turn = light.turn();
    all.limit = light.limit();
}

void PathTables::addComponents(const SceneLight& light)
{
    GpuGatherConstants& all = ofScene_.all;
    all.components = uint32_t(light.components());
    for (std::size_t part = 0; part < 3; ++part) all.skyComponents[part] = uint32_t(light.skyComponents()[part]);
    if (light.splitsSky()) all.sky |= kSkySplit;
    for (const int component : light.emittingComponents()) all.emittingComponents |= 1u << component;
}

void PathTables::addSurfaces(const PathTracer& paths)
{
    const RayTracer& surfaces = paths.surfaces();
    const BakeGeometry& geometry = surfaces.geometry();
    const auto materials = uint32_t(surfaces.materials().all().size());
    std::vector<GpuPathPart> parts;
    for (const BakeGeometry::Part& part : geometry.parts)
        parts.push_back({part.material < 0 ? materials - 1 : uint32_t(part.material), part.instance,
                         part.receiveShadows ? 1u : 0u});
    addresses_->parts = keep(parts);
    addresses_->colors = keep(geometry.colors);
    addresses_->all.coloredVertices = geometry.colors.empty() ? 0 : 1;
    for (std::size_t i = 0; i < kPathTextureSets; ++i) addresses_->uv[i] = keep(geometry.uv[i]);
    std::vector<GpuPathMaterial> looks;
    for (const TransportMaterial& material : surfaces.materials().all()) {
        const auto number = uint32_t(looks.size());
        const int component = paths.light().componentOfMaterial(number + 1 == materials ? -1 : int(number));
        looks.push_back(pathMaterialOf(geometry, material, component));
    }
    addresses_->materials = keep(looks);
}

/// The triangles that rays hit, and those of them that emit.
void PathTables::addFaces(const DeviceScene& scene, const PathTracer& paths)
{
    const RayTracer& surfaces = paths.surfaces();
    const BakeGeometry& geometry = surfaces.geometry();
    const Emitters& emissive = paths.light().emitters();
    std::vector<uint32_t> hitIndexOfEmitter(emissive.all().size(), kNone);
    std::vector<GpuPathFace> faces(surfaces.hitTriangleCount());
    parallelFor(faces.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const uint32_t triangle = surfaces.triangleAt(uint32_t(i));
            const uint32_t hidden = surfaces.materials().backIsHidden(triangle) ? kHiddenBack : 0;
            const uint32_t emitter = emissive.itemOf(triangle);
            faces[i] = {geometry.storedOf(triangle).index, geometry.partNumberOf(triangle) | hidden, emitter};
            if (emitter != Emitters::kNone) hitIndexOfEmitter[emitter] = uint32_t(i);
        }
    });
    addresses_->faces = keep(faces);
    std::vector<GpuEmitter> emitters;
    for (std::size_t i = 0; i < hitIndexOfEmitter.size(); ++i) {
        const Emitters::Emissive& e = emissive.all()[i];
        const uint32_t hitIndex = hitIndexOfEmitter[i];
        const uint32_t flags = (e.uniform ? kUniform : 0) | (e.doubleSided ? kDoubleSided : 0) |
                               (e.rayVisible ? kRayVisible : 0) | uint32_t(e.component) << kComponentShift;
        emitters.push_back({e.origin, e.edge1, e.edge2, e.normal, e.radiance, e.inverseArea, hitIndex,
                            scene.maskedOf(hitIndex), flags});
    }
    addresses_->emitters = keep(emitters);
}

void PathTables::addPictures(const Materials& materials)
{
    std::vector<GpuBytes> pictures;
    std::vector<u8vec4> texels;
    for (int i = 0; i < materials.textureCount(); ++i) {
        const ImageRgba8& picture = materials.smallTexture(i);
        const Texture& texture = materials.texture(i);
        pictures.push_back({picture.size(), int(texture.wrapU), int(texture.wrapV), 1u, uint32_t(texels.size())});
        texels.insert(texels.end(), picture.texels().begin(), picture.texels().end());
    }
    addresses_->pictures = keep(pictures);
    addresses_->texels = keep(texels);
    addresses_->linear = keep(kLinearFromSrgb8);
}

void PathTables::addChoosers(const SceneLight& light)
{
    std::vector<LightChooser> choosers;
    for (std::size_t i = 0; i < light.choosers(); ++i) {
        const SceneLight::Chooser& from = light.chooser(i);
        const auto nodes = from.tree.nodes();
        choosers.push_back({keep(from.always), keep(nodes), keep(from.lightOfItem), uint32_t(from.always.size()),
                            uint32_t(nodes.size()), uint32_t(from.component)});
    }
    addresses_->choosers = keep(choosers);
    addresses_->all.choosers = uint32_t(choosers.size());
}

void PathTables::addLights(const SceneLight& light)
{
    std::vector<LightSource> lights(light.lights().begin(), light.lights().end());
    addresses_->lights = keep(lights);
    addresses_->all.anyLights = lights.empty() ? 0 : 1;
    addChoosers(light);
    addresses_->emitterTree = keep(light.emitters().tree().nodes());
    addresses_->leafOfEmitter = keep(light.emitters().tree().leafOfItem());
    addresses_->all.emitterNodes = uint32_t(light.emitters().tree().nodes().size());
    addresses_->all.cutNodes = uint32_t(light.emitters().tree().cutNodes());
    addresses_->brightAreas = keep(light.sky().brightAreas());
    addresses_->brightBins = keep(light.sky().brightBins());
    addresses_->all.brightAreas = uint32_t(light.sky().brightAreas().size());
    addresses_->all.brightIlluminance = light.sky().brightIlluminance();
}

} // namespace halflight
