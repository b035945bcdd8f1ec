#pragma once
// Scenes for bake_bench: files, and some made in code.

#include "bake/geometry/flatten.h"
#include "bake/lights/channels.h"
#include "bake/texels/rasterize.h"
#include "halflight/scene/gltf.h"
#include "halflight/shading/random.h"
#include "halflight/unwrap/unwrap.h"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace halflight::bench {

inline int addMaterial(Scene& scene, vec3 albedo, vec3 emission = vec3(0.0f))
{
    Material material;
    material.baseColor = vec4(albedo, 1.0f);
    material.metallic = 0.0f;
    material.emissiveNits = emission;
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

/// Front face towards cross(u, v).
inline void addQuad(Scene& scene, vec3 origin, vec3 u, vec3 v, int material, bool lightmapped = true)
{
    MeshPart part;
    part.positions = {origin, origin + u, origin + u + v, origin + v};
    part.normals.assign(4, glm::normalize(glm::cross(u, v)));
    part.indices = {0, 1, 2, 0, 2, 3};
    part.material = material;
    Object object;
    object.mesh = int(scene.meshes.size());
    object.lightmapScale = lightmapped ? 1.0f : 0.0f;
    Mesh mesh;
    mesh.parts.push_back(part);
    scene.meshes.push_back(mesh);
    scene.objects.push_back(object);
}

/// A box around the vertical axis through `center`, without its bottom.
inline void addBlock(Scene& scene, vec3 center, vec3 half, float angle, int material)
{
    const vec3 x = vec3(std::cos(angle), 0.0f, std::sin(angle)) * half.x;
    const vec3 z = vec3(-std::sin(angle), 0.0f, std::cos(angle)) * half.z;
    const vec3 y(0.0f, half.y, 0.0f);
    addQuad(scene, center - x + y + z, 2.0f * x, -2.0f * z, material);
    addQuad(scene, center - x - y + z, 2.0f * x, 2.0f * y, material);
    addQuad(scene, center + x - y - z, -2.0f * x, 2.0f * y, material);
    addQuad(scene, center + x - y + z, -2.0f * z, 2.0f * y, material);
    addQuad(scene, center - x - y - z, 2.0f * z, 2.0f * y, material);
}

inline void addRoom(Scene& scene, vec3 lower, vec3 upper, int white, int left, int right)
{
    const vec3 s = upper - lower;
    const vec3 x(s.x, 0, 0);
    const vec3 y(0, s.y, 0);
    const vec3 z(0, 0, s.z);
    addQuad(scene, lower + z, x, -z, white);     // floor
    addQuad(scene, lower + y, x, z, white);      // ceiling
    addQuad(scene, lower, x, y, white);          // back
    addQuad(scene, lower + x + z, -x, y, white); // front
    addQuad(scene, lower + z, -z, y, left);      // left
    addQuad(scene, lower + x, z, y, right);      // right
}

/// The Cornell box (Goral et al. 1984) in its usual proportions: two blocks under an emissive quad.
inline Scene cornellBox()
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.73f));
    const int red = addMaterial(scene, vec3(0.63f, 0.065f, 0.05f));
    const int green = addMaterial(scene, vec3(0.14f, 0.45f, 0.091f));
    const int lamp = addMaterial(scene, vec3(0.0f), vec3(15.0f));
    addRoom(scene, vec3(-1, 0, -1), vec3(1, 2, 1), white, red, green);
    addBlock(scene, vec3(-0.33f, 0.6f, -0.3f), vec3(0.3f, 0.6f, 0.3f), 0.3f, white);
    addBlock(scene, vec3(0.35f, 0.3f, 0.35f), vec3(0.3f, 0.3f, 0.3f), -0.3f, white);
    addQuad(scene, vec3(-0.24f, 1.995f, -0.19f), vec3(0.48f, 0, 0), vec3(0, 0, 0.38f), lamp, false);
    return scene;
}

/// The Cornell box's room and lamp, and in its middle a ball with bumps of about this many triangles, the same shape
/// whatever their number. The ball has no texels: time is that of rays.
inline Scene roomWithBall(int triangles)
{
    Scene scene = cornellBox();
    scene.objects.erase(scene.objects.begin() + 6, scene.objects.end() - 1); // the blocks
    const int columns = std::max(8, int(std::sqrt(float(triangles))));
    const int rows = columns / 2;
    MeshPart part;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            const float theta = kPi * float(j) / float(rows);
            const float phi = 2.0f * kPi * float(i) / float(columns);
            const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
            const float bump = 0.08f * std::sin(theta) * std::sin(9.0f * theta) * std::sin(8.0f * phi);
            part.positions.push_back(vec3(0.0f, 0.75f, 0.0f) + (0.55f + bump) * n);
            part.normals.push_back(n);
        }
    }
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const auto a = uint32_t(j * (columns + 1) + i);
            const uint32_t b = a + uint32_t(columns) + 1u;
            part.indices.insert(part.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    }
    part.material = 0;
    Object ball;
    ball.mesh = int(scene.meshes.size());
    ball.lightmapScale = 0.0f;
    scene.meshes.emplace_back().parts.push_back(std::move(part));
    scene.objects.push_back(ball);
    return scene;
}

/// A long hall with blocks on its floor and emissive quads under its ceiling, of one total power whatever their number.
inline Scene hallOfQuads(int count)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.6f));
    const vec3 lower(-10, 0, -10);
    const vec3 upper(10, 4, 10);
    addRoom(scene, lower, upper, white, white, white);
    for (int i = 0; i < 25; ++i) {
        addBlock(scene, vec3(-8.0f + 4.0f * float(i % 5), 0.7f, -8.0f + 4.0f * float(i / 5)), vec3(0.5f, 0.7f, 0.5f),
                 0.37f * float(i), white);
    }
    const float side = 0.1f;
    const int lamp = addMaterial(scene, vec3(0.0f), vec3(40.0f / (float(count) * side * side)));
    for (int i = 0; i < count; ++i) {
        const vec2 place = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) * 18.0f - 9.0f;
        const float height = 3.0f + 0.9f * glm::fract(float(i) * 0.6180339887f);
        addQuad(scene, vec3(place.x, height, place.y), vec3(side, 0, 0), vec3(0, 0, side), lamp, false);
    }
    return scene;
}

/// A floor of 200 m under side x side lamps that reach 5 m, 1.5 m above it, with 400 boxes on it.
inline Scene fieldOfLamps(int side, LightMode mode)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.6f));
    const float half = 100.0f;
    addQuad(scene, vec3(-half, 0, half), vec3(2 * half, 0, 0), vec3(0, 0, -2 * half), white);
    for (int i = 0; i < 400; ++i) {
        const vec2 place = r2Point(i) * 196.0f - 98.0f;
        addBlock(scene, vec3(place.x, 0.4f, place.y), vec3(0.4f), 0.0f, white);
    }
    for (int i = 0; i < side * side; ++i) {
        Light light;
        light.name = "lamp " + std::to_string(i);
        light.intensity = 10.0f;
        light.rangeMeters = 5.0f;
        light.mode = mode;
        const vec2 place = (vec2(i % side, i / side) + 0.5f) / float(side) * 2.0f * half - half;
        light.worldFromLight[3] = vec4(place.x, 1.5f, place.y, 1.0f);
        scene.lights.push_back(std::move(light));
    }
    return scene;
}

/// `bakeLights`: all punctual lights fully baked, as a renderer's "combined" bake has them; a sky where the file has
/// neither lights nor emission. A file's name with "@sun" behind it: directional lights and the sky alone.
inline Scene load(std::string name, bool bakeLights, const std::string& settings = {})
{
    const bool sunOnly = name.ends_with("@sun");
    if (sunOnly) name.resize(name.size() - 4);
    Scene scene;
    if (name == "cornell") {
        scene = cornellBox();
    } else {
        Result<Scene> read = readScene(name, {.settingsFile = settings});
        if (!read) {
            std::fprintf(stderr, "%s: %s\n", name.c_str(), read.error().text().c_str());
            std::exit(1);
        }
        scene = std::move(*read);
    }
    if (sunOnly) {
        std::erase_if(scene.lights, [](const Light& light) { return light.type != LightType::Directional; });
        for (Material& material : scene.materials) material.emissiveNits = vec3(0.0f);
    }
    for (Light& light : scene.lights) {
        if (bakeLights) light.mode = LightMode::Baked;
    }
    return scene;
}

struct Prepared {
    Scene scene;
    BakeGeometry geometry;
    TexelMap map;
};

inline std::size_t trianglesOf(const Prepared& p)
{
    return p.geometry.triangleCount();
}

inline Prepared prepareScene(Scene scene, int size, bool bakeLights)
{
    for (Light& light : scene.lights) {
        if (bakeLights) light.mode = LightMode::Baked;
    }
    UnwrapSettings settings;
    settings.uvMode = UvMode::Unwrap;
    settings.pageSize = size;
    Result<UnwrappedScene> unwrapped = unwrap(std::move(scene), settings);
    if (!unwrapped) {
        std::fprintf(stderr, "%s\n", unwrapped.error().text().c_str());
        std::exit(1);
    }
    Prepared p;
    p.scene = std::move(unwrapped->scene);
    p.geometry = flattenGeometry(p.scene, unwrapped->pageSize, GeometryFilter::Static);
    p.map = rasterizeTexels(p.geometry, unwrapped->pageSize, unwrapped->pageCount);
    assignShadowmaskChannels(p.scene, MixedLightingMode::Shadowmask);
    return p;
}

inline Prepared prepare(const std::string& name, int size, bool bakeLights)
{
    return prepareScene(load(name, bakeLights), size, bakeLights);
}

} // namespace halflight::bench
