#pragma once
// Ten balls of one mesh on a floor, and rays around them.

#include "bake/test_scene.h"
#include "transport/trace/ray.h"

#include "halflight/base/math.h"
#include "halflight/shading/random.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace halflight::test {
namespace balls {

inline constexpr int kPage = 256;
inline constexpr int kRows = 32;
inline constexpr int kColumns = 65;
inline constexpr uint32_t kBallTriangles = 2 * kColumns * (kRows - 1); // 4,030
inline constexpr int kBalls = 10;

/// A ball with bumps, lightmap coordinates included. `inward`: its front is inside.
inline MeshPart ball(int material, bool inward = false)
{
    MeshPart part;
    part.material = material;
    for (int j = 0; j <= kRows; ++j) {
        for (int i = 0; i <= kColumns; ++i) {
            const float theta = kPi * float(j) / float(kRows);
            const float phi = 2.0f * kPi * float(i) / float(kColumns);
            // The first and the last column, and each pole, are one place.
            const float round = i == kColumns ? 0.0f : phi;
            const float ring = j == 0 || j == kRows ? 0.0f : std::sin(theta);
            const vec3 n(ring * std::cos(round), std::cos(theta), -ring * std::sin(round));
            part.positions.push_back(vec3(3, 1, 2) + (0.4f + 0.05f * ring * ring * std::sin(5.0f * round)) * n);
            part.normals.push_back(inward ? -n : n);
            const vec2 uv(float(i) / float(kColumns), float(j) / float(kRows));
            part.uv[0].push_back(uv);
            part.lightmapUv.push_back(uv);
        }
    }
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
        if (inward) std::swap(b, c);
        part.indices.insert(part.indices.end(), {a, b, c});
    };
    for (uint32_t j = 0; j < kRows; ++j) {
        for (uint32_t i = 0; i < kColumns; ++i) {
            const uint32_t a = j * (kColumns + 1) + i;
            const uint32_t b = a + kColumns + 1;
            if (j + 1 < kRows) add(a, b, b + 1);
            if (j > 0) add(a, b + 1, a + 1);
        }
    }
    return part;
}

/// Balls in two rows on a floor: turned, of different sizes, two of them mirrored, one without a shadow.
inline Scene ballsOnFloor(Material::AlphaMode alpha = Material::AlphaMode::Opaque, bool inward = false)
{
    Scene scene;
    const int gray = addMaterial(scene, vec3(0.6f));
    int skin = addMaterial(scene, vec3(0.5f, 0.6f, 0.4f), vec3(0.0f), inward);
    if (alpha != Material::AlphaMode::Opaque) {
        ImageRgba8 leaf(8, 8, u8vec4(200, 200, 200, 255));
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 4; ++x) leaf(x, y).w = alpha == Material::AlphaMode::Mask ? 0 : 100;
        skin = addMaterialWithHoles(scene, vec3(0.5f), std::move(leaf), true);
        scene.materials.back().alphaMode = alpha;
    }
    addRectangle(scene, {vec3(-4, 0, 2), vec3(8, 0, 0), vec3(0, 0, -4)}, gray, kPage, {vec2(2, 150), vec2(250, 250)});
    const int mesh = addObject(scene, ball(skin, inward));
    scene.objects.pop_back();
    for (int i = 0; i < kBalls; ++i) {
        Object object;
        object.mesh = mesh;
        mat4 m = glm::translate(mat4(1.0f), vec3(-3.2f + 1.5f * float(i % 5), 0.7f, i < 5 ? -0.9f : 0.8f));
        m = glm::rotate(m, 0.7f * float(i), glm::normalize(vec3(1, 2, float(i) - 4.0f)));
        m = glm::scale(m, vec3(i % 4 == 3 ? -0.9f : 1.1f, 0.8f + 0.03f * float(i), 1.0f));
        object.worldFromObject = glm::translate(m, vec3(-3, -1, -2));
        object.castShadows = i != 6;
        object.lightmap.page = 0;
        object.lightmap.scale = vec2(46.0f, 66.0f) / float(kPage);
        object.lightmap.offset = vec2(2 + 50 * (i % 5), 2 + 70 * (i / 5)) / float(kPage);
        scene.objects.push_back(object);
    }
    scene.sky = {vec3(0.5f, 0.6f, 0.8f), vec3(0.4f), vec3(0.1f)};
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0.4f, -1, -0.3f), 3.0f, LightMode::Mixed));
    return scene;
}

/// The same scene with a mesh for each object.
inline Scene unshared(Scene scene)
{
    std::vector<Mesh> meshes;
    for (Object& object : scene.objects) {
        meshes.push_back(scene.meshes[std::size_t(object.mesh)]);
        object.mesh = int(meshes.size()) - 1;
    }
    scene.meshes = std::move(meshes);
    return scene;
}

inline Ray randomRay(uint32_t i)
{
    const auto number = [&](uint32_t k) { return unitFloat(hashCombine(i, k)); };
    const vec3 from = vec3(-5, -1, -3) + vec3(10, 4, 6) * vec3(number(1), number(2), number(3));
    const vec3 to = vec3(-4, 0, -2) + vec3(8, 1.5f, 4) * vec3(number(4), number(5), number(6));
    return {from, 0.0f, glm::normalize(to - from), kInfinity};
}

} // namespace balls
} // namespace halflight::test
