// Direct light of point-like lights, pixel by pixel: the renderer without indirect light against the reference without
// bounces (spec S6, S7). The materials have all that glTF's metallic-roughness has.
#include "pipeline/pictures.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace halflight::reference_direct_test {
namespace {

constexpr ivec2 kSize(160, 120);

mat4 lookAt(vec3 eye, vec3 target)
{
    return glm::inverse(glm::lookAt(eye, target, vec3(0, 1, 0)));
}

Light makeLight(LightType type, vec3 position, vec3 target, float intensity, vec3 color)
{
    Light light;
    light.name = "light";
    light.type = type;
    light.worldFromLight = lookAt(position, target + vec3(1e-3f, 0, 0));
    light.intensity = intensity;
    light.color = color;
    light.mode = LightMode::Realtime;
    light.innerConeRadians = 0.3f;
    light.outerConeRadians = 0.7f;
    return light;
}

/// Waves of colour, data or normals; no texel is much smaller than a pixel of the picture.
Texture waves(int side, u8vec4 (*texel)(float x, float y))
{
    Texture texture;
    texture.pixels = ImageRgba8(side, side);
    const float step = 2.0f * kPi / float(side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) texture.pixels.edit()(x, y) = texel(float(x) * step, float(y) * step);
    return texture;
}

u8vec4 colorTexel(float x, float y)
{
    return {uint8_t(150 + 100 * std::sin(x)), uint8_t(150 + 100 * std::cos(y)), 120, 255};
}
u8vec4 dataTexel(float x, float y)
{
    return {0, uint8_t(140 + 100 * std::sin(2 * x + y)), uint8_t(127 + 120 * std::cos(x)), 255};
}
u8vec4 normalTexel(float x, float y)
{
    const vec3 n = glm::normalize(vec3(0.4f * std::sin(2 * x), 0.4f * std::cos(2 * y), 1.0f));
    return u8vec4(vec4(glm::floor((n * 0.5f + 0.5f) * 255.0f + 0.5f), 255.0f));
}

void addPart(Scene& scene, MeshPart part, const mat4& worldFromObject)
{
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    Object object;
    object.name = "object " + std::to_string(scene.objects.size());
    object.mesh = int(scene.meshes.size());
    object.isStatic = false;
    object.worldFromObject = worldFromObject;
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
}

/// A square of 2 m in the plane y = 0.
MeshPart makeSquare(int material)
{
    MeshPart part;
    part.positions = {vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1), vec3(-1, 0, -1)};
    part.normals.assign(4, vec3(0, 1, 0));
    part.tangents.assign(4, vec4(1, 0, 0, 1));
    part.uv[0] = {vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0)};
    part.colors = {vec4(1), vec4(1, 0.5f, 1, 1), vec4(1), vec4(0.5f, 1, 1, 1)};
    part.indices = {0, 1, 2, 0, 2, 3};
    part.material = material;
    return part;
}

/// A ball of radius 1, fine enough that its triangles hardly show.
MeshPart makeBall(int material)
{
    MeshPart part;
    constexpr int kRings = 48;
    constexpr int kSectors = 96;
    for (int i = 0; i <= kRings; ++i) {
        for (int j = 0; j <= kSectors; ++j) {
            const float theta = kPi * float(i) / kRings;
            const float phi = 2.0f * kPi * float(j) / kSectors;
            const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
            part.positions.push_back(n);
            part.normals.push_back(n);
            part.tangents.emplace_back(-std::sin(phi), 0.0f, std::cos(phi), 1.0f);
            part.uv[0].emplace_back(float(j) / kSectors, float(i) / kRings);
        }
    }
    constexpr uint32_t kLine = kSectors + 1;
    for (uint32_t i = 0; i < kRings; ++i) {
        for (uint32_t j = 0; j < kSectors; ++j) {
            const uint32_t a = i * kLine + j;
            part.indices.insert(part.indices.end(), {a, a + 1, a + kLine + 1, a, a + kLine + 1, a + kLine});
        }
    }
    part.material = material;
    return part;
}

Scene makeStage(bool shadows)
{
    Scene scene;
    scene.textures = {waves(64, colorTexel), waves(64, dataTexel), waves(64, normalTexel)};
    Material all;
    all.baseColorTexture.texture = 0;
    all.metallicRoughnessTexture.texture = 1;
    all.normalTexture.texture = 2;
    all.normalTexture.scale = vec2(2.0f);
    all.doubleSided = true;
    Material plain;
    plain.baseColor = vec4(0.8f, 0.7f, 0.5f, 1.0f);
    plain.metallic = 0.0f;
    plain.roughness = 0.35f;
    Material glass = plain;
    glass.baseColor = vec4(0.2f, 0.4f, 0.9f, 0.5f);
    glass.alphaMode = Material::AlphaMode::Blend;
    glass.doubleSided = true;
    scene.materials = {all, plain, glass};
    addPart(scene, makeSquare(0), glm::scale(mat4(1.0f), vec3(3, 1, 3)));
    addPart(scene, makeBall(1), glm::translate(mat4(1.0f), vec3(-1.2f, 0.8f, 0)) * glm::scale(mat4(1.0f), vec3(0.7f)));
    addPart(scene, makeBall(0),
            glm::translate(mat4(1.0f), vec3(0.9f, 0.8f, -0.3f)) * glm::scale(mat4(1.0f), vec3(-0.7f, 0.7f, 0.6f)));
    if (!shadows) { // the renderer's shadow of blended surfaces is a dither pattern
        addPart(scene, makeSquare(2),
                glm::translate(mat4(1.0f), vec3(0.2f, 0.5f, 1.6f)) *
                    glm::rotate(mat4(1.0f), 1.2f, glm::normalize(vec3(1, 0.2f, 0))) *
                    glm::scale(mat4(1.0f), vec3(0.6f)));
    }
    scene.lights = {makeLight(LightType::Directional, vec3(3, 4, 2), vec3(0), 2.0f, vec3(1, 0.9f, 0.8f)),
                    makeLight(LightType::Point, vec3(-0.5f, 2.2f, 2.0f), vec3(0), 5.0f, vec3(0.6f, 0.8f, 1)),
                    makeLight(LightType::Spot, vec3(2.0f, 2.5f, -2.0f), vec3(0.2f, 0, 0), 20.0f, vec3(1, 0.5f, 0.4f))};
    for (Light& light : scene.lights) light.castShadows = shadows;
    Camera camera;
    camera.worldFromCamera = lookAt(vec3(0.3f, 2.2f, 4.2f), vec3(0, 0.4f, 0));
    camera.verticalFovRadians = 0.9f;
    scene.cameras.push_back(camera);
    return scene;
}

/// Shares of pixels whose luminance is off by more than 2 % and by more than 10 % of the reference's.
struct Difference {
    double small = 0.0;
    double large = 0.0;
    double mean = 0.0; ///< relative, of all pixels together
};
Difference compare(const Scene& scene, int samples)
{
    BakedScene plain;
    plain.scene = scene;
    RenderSettings settings;
    settings.mode = RunMode::Realtime;
    settings.size = kSize;
    settings.supersampling = 4;
    auto renderer = Renderer::create({.validation = true});
    EXPECT_TRUE(renderer) << renderer.error().text();
    EXPECT_TRUE((*renderer)->load(plain));
    const auto frame = (*renderer)->render(scene.cameras[0], settings);
    EXPECT_TRUE(frame) << frame.error().text();
    const auto truth = renderReference(scene, scene.cameras[0], kSize, {samples, 0});
    EXPECT_TRUE(truth) << truth.error().text();
    Difference result;
    double sum = 0.0;
    double sumOfTruth = 0.0;
    int lit = 0;
    for (std::size_t i = 0; i < truth->texelCount(); ++i) {
        const auto expected = double(luminance(truth->texels()[i]));
        const auto found = double(luminance(vec3(frame->radiance.texels()[i])));
        sum += found;
        sumOfTruth += expected;
        if (expected <= 0.0 && found <= 0.0) continue;
        ++lit;
        const double off = std::abs(found - expected) / std::max(expected, 0.01);
        result.small += off > 0.02 ? 1.0 : 0.0;
        result.large += off > 0.1 ? 1.0 : 0.0;
    }
    result.small /= lit;
    result.large /= lit;
    result.mean = sum / sumOfTruth - 1.0;
    std::printf("more than 2 %% off: %.2f %% of the pixels, more than 10 %%: %.2f %%; mean %+.2f %%\n",
                100.0 * result.small, 100.0 * result.large, 100.0 * result.mean);
    return result;
}

// Without shadows nothing but silhouettes (16 samples in the renderer), highlights smaller than a pixel and the noise
// of the pane differ.
TEST(ReferenceDirectS6, SamePixelsWithoutShadows)
{
    const Difference d = compare(makeStage(false), 512);
    EXPECT_LT(d.small, 0.08);
    EXPECT_LT(d.large, 0.012);
    EXPECT_NEAR(d.mean, 0.0, 0.003);
}

// With shadows, their edges differ: shadow maps have texels.
TEST(ReferenceDirectS6, SamePixelsButForShadowEdges)
{
    const Difference d = compare(makeStage(true), 256);
    EXPECT_LT(d.small, 0.08);
    EXPECT_LT(d.large, 0.02);
    EXPECT_NEAR(d.mean, 0.0, 0.005);
}

} // namespace
} // namespace halflight::reference_direct_test
