// S35. A red pane under a white mixed sun, baked and drawn: how the floor's colours stand to one another, against the
// closed form. As a quad, a box and a volume.
#include "floor.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

namespace halflight::test::colored_masks_test {
namespace {

const vec3 kRed(0.9f, 0.3f, 0.1f);
const vec3 kLeft(0.8f, 0.4f, 0.2f); // of white light after kDistance
constexpr float kDistance = 0.4f;   // metres
constexpr float kThick = 0.2f;
constexpr float kHeight = 2.0f;
constexpr float kAlpha = 0.25f;
constexpr ivec2 kSize(96, 64);
const vec3 kSun = glm::normalize(vec3(0.3f, 1.0f, 0.2f)); // towards it

enum class Pane { Quad, Box, Volume };

/// What passes the pane of the sun's light.
vec3 passedBy(Pane pane)
{
    vec3 passed;
    for (int c = 0; c < 3; ++c) {
        const float face = 0.96f * kRed[c]; // Fresnel, at normal incidence
        const float way = kThick / kSun.y / kDistance;
        passed[c] = pane == Pane::Quad  ? (1.0f - kAlpha) * kRed[c]
                    : pane == Pane::Box ? face * face
                                        : face * face * std::pow(kLeft[c], way);
    }
    return passed;
}

void addPane(Scene& scene, Pane pane)
{
    Material& material = scene.materials.emplace_back();
    material.name = "pane";
    material.metallic = 0.0f;
    material.specular = 0.0f;
    material.baseColor = vec4(kRed, 1.0f);
    if (pane == Pane::Quad) {
        material.alphaMode = Material::AlphaMode::Blend;
        material.baseColor.w = kAlpha;
        material.tinted = true;
    } else {
        material.transmission = 1.0f;
    }
    if (pane == Pane::Volume) {
        material.thickness = kThick;
        material.attenuationColor = kLeft;
        material.attenuationMeters = kDistance;
    }
    MeshPart part;
    const auto face = [&](vec3 origin, vec3 u, vec3 v) {
        const auto first = uint32_t(part.positions.size());
        for (const vec3 corner : {origin, origin + u, origin + u + v, origin + v}) {
            part.positions.push_back(corner);
            part.normals.push_back(glm::normalize(glm::cross(u, v)));
        }
        for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + i);
    };
    // Above x < 0, and far over the floor's edge, so that all of the sun's light comes through its middle.
    const vec3 low(-9, kHeight, -9);
    const vec3 x(9, 0, 0), y(0, kThick, 0), z(0, 0, 18);
    face(low + (pane == Pane::Quad ? vec3(0) : y), z, x);
    if (pane != Pane::Quad) {
        face(low, x, z);
        face(low, z, y);
        face(low + x, y, z);
        face(low, y, x);
        face(low + z, x, y);
    }
    part.material = int(scene.materials.size()) - 1;
    Mesh& mesh = scene.meshes.emplace_back();
    mesh.parts.push_back(std::move(part));
    Object& object = scene.objects.emplace_back();
    object.name = "pane";
    object.mesh = int(scene.meshes.size()) - 1;
    object.lightmapScale = 0.0f; // it casts, and has no texels
}

BakeResult bakedFloor(Pane pane, MaskEncoding encoding)
{
    Scene scene;
    Material& floor = scene.materials.emplace_back();
    floor.metallic = 0.0f;
    floor.specular = 0.0f;
    floor.baseColor = vec4(0.5f, 0.5f, 0.5f, 1.0f);
    addFloor(scene, 4.0f);
    addPane(scene, pane);
    Light sun;
    sun.name = "sun";
    sun.type = LightType::Directional;
    sun.mode = LightMode::Mixed;
    sun.worldFromLight = glm::inverse(glm::lookAt(vec3(0), -kSun, vec3(0, 0, 1)));
    sun.intensity = 10.0f;
    scene.lights = {sun};
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 64;
    settings.samples = 16;
    settings.bounces = 0;
    settings.probeSpacingMeters = 4.0f;
    settings.probeLayout = ProbeLayout::Grid;
    settings.reflectionProbes = false;
    settings.maskEncoding = encoding;
    auto result = bake(scene, settings, embreeIntegrators());
    EXPECT_TRUE(result) << result.error().text();
    return std::move(*result);
}

/// Radiance of the floor beneath the pane, and beside it.
struct Shown {
    vec3 beneath;
    vec3 beside;
};
Shown draw(Renderer& renderer, RenderPath path, RunMode mode, float shadowDistance)
{
    Camera camera; // below the pane, and looks down
    camera.worldFromCamera = glm::inverse(glm::lookAt(vec3(0, 1.8f, 0.0f), vec3(0), vec3(0, 0, -1)));
    camera.verticalFovRadians = 1.2f;
    RenderSettings settings;
    settings.path = path;
    settings.mode = mode;
    settings.size = kSize;
    settings.shadows.distanceMeters = shadowDistance;
    settings.shadows.fadeRangeMeters = 0.1f;
    const auto frame = renderer.render(camera, settings);
    EXPECT_TRUE(frame) << frame.error().text();
    Shown shown{};
    for (int y = 24; y < 40; ++y)
        for (int x = 4; x < 20; ++x) {
            shown.beneath += vec3(frame->radiance(x, y)) / 256.0f;
            shown.beside += vec3(frame->radiance(kSize.x - 1 - x, y)) / 256.0f;
        }
    return shown;
}

class ColoredPaneS35 : public testing::TestWithParam<Pane> {};
std::string paneName(const testing::TestParamInfo<Pane>& info)
{
    const char* names[] = {"Quad", "Box", "Volume"};
    return names[int(info.param)];
}
INSTANTIATE_TEST_SUITE_P(, ColoredPaneS35, testing::Values(Pane::Quad, Pane::Box, Pane::Volume), paneName);

TEST_P(ColoredPaneS35, TheFloorHasTheColorThatPasses)
{
    const auto renderer = Renderer::create({.validation = true});
    ASSERT_TRUE(renderer) << renderer.error().text();
    const vec3 passed = passedBy(GetParam());
    for (const MaskEncoding encoding : {MaskEncoding::Attenuation, MaskEncoding::Distance}) {
        const BakeResult result = bakedFloor(GetParam(), encoding);
        ASSERT_TRUE(result.baked.scene.lights[0].baking.coloredMask);
        ASSERT_TRUE((*renderer)->load(result.baked));
        for (const RenderPath path : {RenderPath::Forward, RenderPath::Deferred})
            for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
                // In distance shadowmask all is beyond the distance; within it realtime shadows are grey.
                const Shown shown = draw(**renderer, path, mode, mode == RunMode::Shadowmask ? 60.0f : 0.2f);
                for (int c = 0; c < 3; ++c) {
                    const float share = shown.beneath[c] / shown.beside[c];
                    EXPECT_NEAR(shown.beside[c], 0.5f / kPi * 10.0f * kSun.y, 0.01f) << "nothing is before the sun";
                    // A mask has steps of 1/255, of which a half is 0.7 % of the least share here.
                    EXPECT_NEAR(share / passed[c], 1.0f, 0.01f + 0.5f / 255.0f / passed[c]) << "channel " << c;
                }
                EXPECT_NEAR(shown.beneath.g / shown.beneath.r / (passed.g / passed.r), 1.0f, 0.01f);
            }
    }
    for (const std::string& message : (*renderer)->validationMessages()) ADD_FAILURE() << message;
}

/// Within the shadow distance the realtime map's shadow is grey.
TEST_P(ColoredPaneS35, RealtimeShadowsAreGrey)
{
    const auto renderer = Renderer::create({.validation = true});
    ASSERT_TRUE(renderer) << renderer.error().text();
    const BakeResult result = bakedFloor(GetParam(), MaskEncoding::Attenuation);
    ASSERT_TRUE((*renderer)->load(result.baked));
    const Shown shown = draw(**renderer, RenderPath::Forward, RunMode::DistanceShadowmask, 60.0f);
    EXPECT_NEAR(shown.beneath.r, shown.beneath.b, 1.0e-3f);
}

} // namespace
} // namespace halflight::test::colored_masks_test
