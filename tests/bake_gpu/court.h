#pragma once
// A court whose surfaces differ in all that paths meet, for tests of paths on a device.

#include "bake/test_scene.h"

#include <cmath>

namespace halflight::test {

constexpr int kCourtPage = 32; ///< texels

/// Shades that differ from texel to texel, and channels by channel.
inline Texture colors(int size)
{
    Texture texture;
    ImageRgba8 pixels(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            pixels(x, y) = u8vec4(60 + 190 * x / size, 60 + 190 * y / size, (x + y) % 2 == 0 ? 240 : 90, 255);
    texture.pixels = std::move(pixels);
    return texture;
}

/// A floor with a lightmap; around it walls with a picture, gloss and colours of vertices, and a smooth column.
inline Scene court()
{
    Scene scene;
    scene.textures = {colors(8), colors(600)};
    scene.textures[0].wrapU = Texture::Wrap::MirroredRepeat;
    const int gray = addMaterial(scene, vec3(0.6f));
    const int painted = addMaterial(scene, vec3(0.9f));
    const int metal = addMaterial(scene, vec3(0.8f, 0.6f, 0.3f));
    Material& paint = scene.materials[std::size_t(painted)];
    paint.baseColorTexture = {.texture = 0, .offset = vec2(0.1f), .scale = vec2(3.0f), .rotationRadians = 0.4f};
    Material& brass = scene.materials[std::size_t(metal)];
    brass.metallic = 1.0f;
    brass.roughness = 0.6f;
    brass.specular = 1.0f;
    brass.metallicRoughnessTexture = {.texture = 1, .texCoord = 0};
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, gray, kCourtPage, {vec2(2), vec2(30)});
    addRectangle(scene, {vec3(-2, 0, -2), vec3(4, 0, 0), vec3(0, 3, 0)}, painted, kCourtPage);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(0, 0, -4), vec3(0, 3, 0)}, metal, kCourtPage);
    addRectangle(scene, {vec3(2, 0, -2), vec3(0, 0, 4), vec3(0, 3, 0)}, gray, kCourtPage);
    MeshPart& wall = scene.meshes.back().parts[0];
    for (std::size_t i = 0; i < wall.positions.size(); ++i)
        wall.colors.emplace_back(0.3f + 0.2f * float(i), 0.9f, 0.5f, 1.0f);
    MeshPart column;
    column.material = gray;
    constexpr uint32_t kSides = 12;
    for (uint32_t i = 0; i <= kSides; ++i) {
        const float angle = 2.0f * kPi * float(i) / float(kSides);
        const vec3 out(std::cos(angle), 0.0f, -std::sin(angle));
        for (const float y : {0.0f, 2.5f}) {
            column.positions.push_back(0.4f * out + vec3(0, y, 0));
            column.normals.push_back(out);
            column.uv[0].emplace_back(float(i), y);
        }
        const uint32_t a = 2 * i;
        if (i < kSides) column.indices.insert(column.indices.end(), {a, a + 2, a + 1, a + 1, a + 2, a + 3});
    }
    addObject(scene, std::move(column));
    return scene;
}

/// Plates that emit: one that faces down, one with two sides and a picture, and such a one that casts no shadow.
inline void addPlates(Scene& scene, int picture)
{
    const int plain = addMaterial(scene, vec3(0.2f), vec3(9.0f, 8.0f, 6.0f));
    addRectangle(scene, {vec3(-0.8f, 2.9f, -1), vec3(1.6f, 0, 0), vec3(0, 0, 1)}, plain, kCourtPage, {}, 3);
    addRectangle(scene, {vec3(1.2f, 0.4f, -1), vec3(0, 0, 1), vec3(0.3f, 1, 0)}, picture, kCourtPage, {}, 2);
    addRectangle(scene, {vec3(-1.5f, 0.4f, -1), vec3(0, 0, 1), vec3(0.3f, 1, 0)}, picture, kCourtPage);
    scene.objects.back().castShadows = false;
}

inline Light bakedLight(LightType type, vec3 position, vec3 direction, float intensity)
{
    return makeLight(type, position, direction, intensity, LightMode::Mixed);
}

} // namespace halflight::test
