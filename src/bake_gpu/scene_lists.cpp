#include "bake_gpu/scene_lists.h"

#include "halflight/base/mathematics.h"
#include "halflight/shading/coverage.h"

#include <algorithm>
#include <array>

namespace halflight {
namespace {

constexpr std::array kHitKinds{Opaque, Transparent};

/// The set of texture coordinates that a masked triangle holds second: the first one that its alpha does not read.
int secondSet(const TransportMaterial& material)
{
    for (const TextureRef& ref : {material.metallicRoughness, material.transmission, material.thickness})
        if (ref && ref.texCoord != material.baseColor.texCoord) return ref.texCoord;
    return material.baseColor.texCoord;
}

} // namespace

SceneLists::SceneLists(const RayScene& scene) : scene_(scene)
{
    const auto addInstance = [&](uint32_t mesh, const std::vector<Place>& places, const BakeGeometry::Instance* place,
                                 uint32_t firstTriangle, const auto& hitIndexOf) {
        if (places.empty()) return;
        instances.push_back({mesh, uint32_t(slots.size()), place});
        for (std::size_t i = 0; i < places.size(); ++i)
            slots.push_back({hitIndexOf(i), firstTriangle, places[i].face, places[i].masked,
                             place != nullptr && place->mirrored ? 1u : 0u});
    };
    std::vector<Place> places;
    std::vector<GeometryKind> kinds;
    Mesh world;
    for (const GeometryKind kind : kHitKinds) {
        const std::span<const uint32_t> triangles = scene.trianglesOf(kind);
        if (triangles.empty()) continue;
        places.push_back(addGeometry(world, kind, triangles, 0));
        kinds.push_back(kind);
    }
    if (!places.empty()) meshes.push_back(std::move(world));
    addInstance(0, places, nullptr, 0, [&](std::size_t i) { return scene.hitIndex(kinds[i], 0); });

    const MeshTrees& trees = scene.meshTrees();
    std::vector<std::vector<Place>> placesOfTree(trees.trees.size());
    std::vector<std::vector<uint32_t>> firstOfGeometry(trees.trees.size());
    const auto firstMesh = uint32_t(meshes.size());
    for (std::size_t t = 0; t < trees.trees.size(); ++t) {
        const MeshTree& tree = trees.trees[t];
        Mesh mesh;
        for (const GeometryKind kind : kHitKinds) {
            const uint32_t begin = tree.firstOfKind[kind];
            const uint32_t end = tree.firstOfKind[kind + 1];
            if (begin == end) continue;
            const auto some = std::span<const uint32_t>(tree.triangles).subspan(begin, end - begin);
            placesOfTree[t].push_back(
                addGeometry(mesh, kind, some, scene.geometry().parts[tree.firstPart].firstTriangle));
            firstOfGeometry[t].push_back(begin);
        }
        meshes.push_back(std::move(mesh));
    }
    for (uint32_t i = 0; i < trees.instances.size(); ++i) {
        const MeshTrees::Instance& instance = trees.instances[i];
        addInstance(firstMesh + instance.tree, placesOfTree[instance.tree], instance.place, instance.firstTriangle,
                    [&](std::size_t g) { return scene.hitIndex(KindCount + i, firstOfGeometry[instance.tree][g]); });
        const MeshTree& tree = trees.trees[instance.tree];
        const uint32_t begin = tree.firstOfKind[NoShadow];
        addUnseen(scene.hitIndex(KindCount + i, begin), std::span<const uint32_t>(tree.triangles).subspan(begin),
                  instance.firstTriangle);
    }
    addUnseen(scene.hitIndex(NoShadow, 0), scene.trianglesOf(NoShadow), 0);
}

/// `first`: added to `triangles`, it makes triangles of the bake.
SceneLists::Place SceneLists::addGeometry(Mesh& mesh, GeometryKind kind, std::span<const uint32_t> triangles,
                                          uint32_t first)
{
    const BakeGeometry& geometry = scene_.geometry();
    Place place{uint32_t(faces.size()), kind == Opaque ? shading::kNone : uint32_t(masked.size())};
    Geometry made{kind == Opaque, {}};
    for (const uint32_t t : triangles) {
        const uint32_t triangle = first + t;
        made.corners.push_back(geometry.triangles[geometry.storedOf(triangle).index]);
        faces.push_back(uint8_t((geometry.isSolid(triangle) ? shading::kFaceSolid : 0u) |
                                (scene_.materials().backIsHidden(triangle) ? shading::kFaceHiddenBack : 0u)));
        if (kind != Opaque) masked.push_back(maskedTriangle(triangle, first));
    }
    mesh.geometries.push_back(std::move(made));
    return place;
}

/// Masks of emitters alone are ever read.
void SceneLists::addUnseen(uint32_t firstHit, std::span<const uint32_t> triangles, uint32_t first)
{
    if (triangles.empty()) return;
    const bool needed = std::any_of(triangles.begin(), triangles.end(), [&](uint32_t t) {
        const TransportMaterial& material = scene_.materials().of(first + t);
        return !material.opaque && material.emission != vec3(0.0f);
    });
    unseen.push_back({firstHit, first, 0, needed ? uint32_t(masked.size()) : shading::kNone, 0});
    if (!needed) return;
    for (const uint32_t t : triangles) masked.push_back(maskedTriangle(first + t, first));
}

shading::GpuMaskedTriangle SceneLists::maskedTriangle(uint32_t triangle, uint32_t first)
{
    const BakeGeometry& geometry = scene_.geometry();
    const TransportMaterial& material = scene_.materials().of(triangle);
    shading::GpuMaskedTriangle out{};
    out.triangle = triangle - first;
    out.mask = maskOf(material);
    glass.addTriangle(scene_, triangle, uint32_t(masked.size()), material);
    const uvec3 corners = geometry.verticesOf(triangle);
    const std::array<int, 2> sets{material.baseColor.texCoord, secondSet(material)};
    for (int c = 0; c < 3; ++c) {
        out.alpha[c] = geometry.colors.empty() ? 1.0f : geometry.colors[corners[c]].w;
        for (int s = 0; s < 2; ++s) {
            const std::vector<vec2>& uv = geometry.uv[std::size_t(sets[std::size_t(s)])];
            out.uv[3 * s + c] = uv.empty() ? vec2(0.0f) : uv[corners[c]];
        }
    }
    return out;
}

uint32_t SceneLists::maskOf(const TransportMaterial& material)
{
    const auto [entry, isNew] = maskNumbers_.try_emplace(&material, uint32_t(masks.size()));
    if (!isNew) return entry->second;
    const Material& source = *material.source;
    shading::GpuMask mask{};
    mask.opacity = material.opacity;
    mask.cutoff = source.alphaMode == Material::AlphaMode::Mask ? source.alphaCutoff : shading::kNoCutoff;
    // Of glass that lets light through by its alpha or its transmission: transmittance() multiplies it.
    mask.blended = source.alphaMode == Material::AlphaMode::Blend ? 1u : 0u;
    mask.multiplied = material.blended ? 1u : 0u;
    mask.glass = kGlassTransmittance * source.transmission;
    mask.metallic = material.metallicFactor;
    mask.tint = material.tints ? tintOf(material) : shading::kNone;
    const int firstSet = material.baseColor.texCoord;
    mask.alpha = useOf(material.baseColor, 3, firstSet);
    mask.metallicTexture = useOf(material.metallicRoughness, 2, firstSet);
    mask.transmissionTexture = useOf(material.transmission, 0, firstSet);
    masks.push_back(mask);
    return entry->second;
}

uint32_t SceneLists::tintOf(const TransportMaterial& material)
{
    const int firstSet = material.baseColor.texCoord;
    shading::GpuGlass made = glassOf(material);
    for (int c = 0; c < 3; ++c) made.baseTexture[c] = useOf(material.baseColor, c, firstSet);
    made.thicknessTexture = useOf(material.thickness, 1, firstSet);
    glass.glass.push_back(made);
    return uint32_t(glass.glass.size() - 1);
}

shading::GpuTextureUse SceneLists::useOf(const TextureRef& ref, int channel, int firstSet)
{
    shading::GpuTextureUse use{};
    use.picture = ref ? pictureOf(ref.texture, channel) : -1;
    use.set = ref.texCoord == firstSet ? 0u : 1u;
    use.offset = ref.offset;
    use.scale = ref.scale;
    use.turn = vec2(math::cos(ref.rotationRadians), math::sin(ref.rotationRadians));
    return use;
}

/// One channel of a texture.
int SceneLists::pictureOf(int texture, int channel)
{
    const auto [entry, isNew] = pictureNumbers_.try_emplace({texture, channel}, int(pictures.size()));
    if (!isNew) return entry->second;
    const Texture& from = scene_.materials().texture(texture);
    const ImageRgba8& pixels = from.pixels;
    pictures.push_back(
        {pixels.size(), int(from.wrapU), int(from.wrapV), from.nearest ? 1u : 0u, uint32_t(texels.size())});
    for (int y = 0; y < pixels.height(); ++y)
        for (int x = 0; x < pixels.width(); ++x) texels.push_back(pixels(x, y)[channel]);
    return entry->second;
}

} // namespace halflight
