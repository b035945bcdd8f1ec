#pragma once
// Scenes made in code, with lightmap coordinates given by hand: the bake's stages are tested without reader and
// unwrapper.

#include "bake/geometry/facet_orientation.h"
#include "bake/geometry/flatten.h"
#include "bake/geometry/indices.h"
#include "bake/lights/channels.h"
#include "bake/texels/rasterize.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/image.h"
#include "halflight/scene/scene.h"
#include "light_pose.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace halflight::test {

struct Rectangle {
    vec3 origin{0.0f};
    vec3 edgeU{1, 0, 0};
    vec3 edgeV{0, 0, -1}; ///< front face towards cross(edgeU, edgeV)
};

/// Texels [min, max] of the page that a rectangle covers; min == max: no lightmap.
struct Place {
    vec2 min{0.0f};
    vec2 max{0.0f};
};

/// A purely diffuse material, for which closed forms hold.
inline int addMaterial(Scene& scene, vec3 albedo, vec3 emission = vec3(0.0f), bool doubleSided = false)
{
    Material material;
    material.baseColor = vec4(albedo, 1.0f);
    material.metallic = 0.0f;
    material.specular = 0.0f;
    material.emissiveNits = emission;
    material.doubleSided = doubleSided;
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

/// A material with holes where the picture's alpha is 0.
inline int addMaterialWithHoles(Scene& scene, vec3 albedo, ImageRgba8 pixels, bool doubleSided = false)
{
    Texture texture;
    texture.pixels = std::move(pixels);
    texture.nearest = true;
    scene.textures.push_back(std::move(texture));
    const int material = addMaterial(scene, albedo, vec3(0.0f), doubleSided);
    scene.materials[std::size_t(material)].alphaMode = Material::AlphaMode::Mask;
    scene.materials[std::size_t(material)].baseColorTexture.texture = int(scene.textures.size()) - 1;
    return material;
}

/// An object of one part; on page 0 where that has lightmap coordinates. Returns the number of its mesh.
inline int addObject(Scene& scene, MeshPart part)
{
    Object object;
    object.mesh = int(scene.meshes.size());
    if (!part.lightmapUv.empty()) object.lightmap.page = 0;
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
    return object.mesh;
}

/// Cut into `divisions` by as many pieces of two triangles.
inline int addRectangle(Scene& scene, const Rectangle& r, int material, int pageSize, Place place = {},
                        int divisions = 1)
{
    MeshPart part;
    part.material = material;
    const auto line = uint32_t(divisions + 1);
    for (uint32_t y = 0; y < line; ++y) {
        for (uint32_t x = 0; x < line; ++x) {
            const vec2 at = vec2(float(x), float(y)) / float(divisions);
            part.positions.push_back(r.origin + at.x * r.edgeU + at.y * r.edgeV);
            part.normals.push_back(glm::normalize(glm::cross(r.edgeU, r.edgeV)));
            part.uv[0].push_back(at);
            if (place.min != place.max) part.lightmapUv.push_back(glm::mix(place.min, place.max, at) / float(pageSize));
            if (x == 0 || y == 0) continue;
            const uint32_t last = y * line + x;
            const uint32_t before = last - line;
            part.indices.insert(part.indices.end(), {before - 1, before, last, before - 1, last, last - 1});
        }
    }
    return addObject(scene, std::move(part));
}

/// Faces of an axis-aligned box turned inward (a room) or outward; no lightmap unless `pageSize` > 0, then each face
/// gets 14 x 14 texels of a 64 x 64 page.
inline void addBox(Scene& scene, vec3 lower, vec3 upper, int material, bool inward, int pageSize = 0)
{
    const vec3 s = upper - lower;
    const vec3 x(s.x, 0, 0);
    const vec3 y(0, s.y, 0);
    const vec3 z(0, 0, s.z);
    const Rectangle outwardFaces[6] = {{lower, y, x},     {lower + z, x, y}, {lower, z, y},
                                       {lower + x, y, z}, {lower, x, z},     {lower + y, z, x}};
    for (int i = 0; i < 6; ++i) {
        Rectangle face = outwardFaces[i];
        if (inward) std::swap(face.edgeU, face.edgeV);
        Place place;
        if (pageSize > 0) {
            place.min = vec2(1 + (i % 3) * 17, 1 + (i / 3) * 17);
            place.max = place.min + vec2(14.0f);
        }
        addRectangle(scene, face, material, pageSize, place);
    }
}

/// Makes one mesh, and one object, of those from number `first` on: what is closed only together is a solid then.
inline void joinObjects(Scene& scene, std::size_t first)
{
    for (std::size_t i = first + 1; i < scene.meshes.size(); ++i)
        scene.meshes[first].parts.push_back(scene.meshes[i].parts[0]);
    scene.meshes.resize(first + 1);
    scene.objects.resize(first + 1);
}

inline Light makeLight(LightType type, vec3 position, vec3 direction, float intensity, LightMode mode)
{
    Light light;
    light.name = "light";
    light.type = type;
    light.worldFromLight = lightPose(position, direction);
    light.intensity = intensity;
    light.mode = mode;
    return light;
}

/// All the parts of a bake, kept alive together.
struct Bench {
    Scene scene;
    BakeGeometry geometry;
    TexelMap map;
    std::unique_ptr<Integrator> integrator;
    std::unique_ptr<PreparedLightmap> lightmap; ///< null until irradiance() is called

    Bench(Scene s, MixedLightingMode mode, int pageSize, const IntegrationSettings& settings, int mostMaskLayers = 1,
          const IntegratorFactory& factory = embreeIntegrators())
        : scene(std::move(s))
    {
        geometry = flattenGeometry(scene, pageSize, GeometryFilter::Static);
        assignShadowmaskChannels(scene, mode, mostMaskLayers);
        integrator = std::move(*repairOrientation(factory, scene, geometry, settings));
        map = rasterizeTexels(geometry, pageSize, 1);
        EXPECT_TRUE(integrator->findValidPoints(map, nullptr, {}));
    }
    std::vector<IrradianceEstimate> irradiance()
    {
        std::vector<IrradianceEstimate> estimates(map.texels.size());
        EXPECT_TRUE(irradiance({allIndices(map.texels.size())}, estimates));
        return estimates;
    }
    Status irradiance(const TexelRequest& request, std::span<IrradianceEstimate> out)
    {
        if (lightmap == nullptr) lightmap = integrator->prepare(map, nullptr);
        return lightmap->irradiance(request, out, {});
    }
    std::vector<vec4> shadowmask(int layer = 0)
    {
        std::vector<vec4> out(map.texels.size());
        EXPECT_TRUE(integrator->shadowmask(map, {allIndices(map.texels.size())}, layer, out, {}));
        return out;
    }

    /// Mean world position of a texel's surface.
    [[nodiscard]] vec3 positionOf(const Texel& texel) const
    {
        vec3 sum(0.0f);
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[texel.firstFragment + f];
            sum += fragment.area * surfacePoint(geometry, fragment.triangle, fragment.barycentric).position;
        }
        return sum / coveredArea(map, texel);
    }
};

/// A mixed point light with a name and a range.
inline Light pointAt(const std::string& name, vec3 position, float range, float intensity = 10.0f)
{
    Light light = makeLight(LightType::Point, position, vec3(0, -1, 0), intensity, LightMode::Mixed);
    light.name = name;
    light.rangeMeters = range;
    return light;
}

/// Black pages of the same size.
inline std::vector<ImageRgb32f> noLight(const std::vector<ImageRgb32f>& pages)
{
    std::vector<ImageRgb32f> black;
    for (const ImageRgb32f& page : pages) black.emplace_back(page.width(), page.height());
    return black;
}

} // namespace halflight::test
