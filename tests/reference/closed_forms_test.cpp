// The reference's reflection against integrals that are found another way (spec S6).
#include "reference/traced.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::closed_forms_test {
namespace {

const vec3 kUp(0, 1, 0);

vec3 viewAt(float cosine)
{
    return {std::sqrt(1.0f - cosine * cosine), cosine, 0.0f};
}

/// Albedo of a view by a grid over the hemisphere, fine about the mirrored view.
double albedoByGrid(const Finish& f, vec3 view)
{
    constexpr int kRings = 400;
    constexpr int kSectors = 400;
    const vec3 axis(-view.x, view.y, -view.z);
    vec3 t;
    vec3 b;
    shading::orthonormalBasis(axis, t, b);
    double sum = 0.0;
    double above = 1.0;
    for (int i = 0; i < kRings; ++i) {
        const auto angleAt = [](double x) { return double(kPi) * std::pow(x / kRings, 4.0); };
        const double below = std::cos(angleAt(i + 1));
        const double angle = angleAt(i + 0.5);
        for (int j = 0; j < kSectors; ++j) {
            const double phi = 2.0 * double(kPi) * (j + 0.5) / kSectors;
            const vec3 l = float(std::sin(angle) * std::cos(phi)) * t + float(std::sin(angle) * std::sin(phi)) * b +
                           float(std::cos(angle)) * axis;
            sum += double(reflectedBy(f, kUp, view, l, vec3(1.0f)).x) * (above - below) * 2.0 * double(kPi) / kSectors;
        }
        above = below;
    }
    return sum;
}

// White furnace: under a sky of radiance 1 a surface has the radiance of its albedo. Metals never more than 1.
TEST(ReferenceS6, WhiteFurnace)
{
    for (const float metallic : {0.0f, 1.0f}) {
        for (const float roughness : {0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
            const Finish f{vec3(1.0f), metallic, roughness, 1.0f};
            Scene scene;
            addFloor(scene, addFinish(scene, f));
            scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
            const Traced traced(std::move(scene));
            for (const float cosine : {0.15f, 0.4f, 0.8f, 1.0f}) {
                const double expected = albedoByGrid(f, viewAt(cosine));
                const double found = double(traced.atOrigin(viewAt(cosine), 4096).x);
                EXPECT_NEAR(found, expected, 0.006 * expected) << metallic << ' ' << roughness << ' ' << cosine;
                if (metallic == 1.0f) EXPECT_LE(found, 1.0 + 1e-3) << roughness << ' ' << cosine;
            }
        }
    }
}

// Rough metal as closed form: alpha 1 seen from above reflects 1 - ln 2.
TEST(ReferenceS6, RoughMetalFromAboveIsOneMinusLog2)
{
    Scene scene;
    addFloor(scene, addFinish(scene, {vec3(1.0f), 1.0f, 1.0f, 1.0f}));
    scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    EXPECT_NEAR(Traced(std::move(scene)).atOrigin(kUp, 4096).x, 1.0f - std::log(2.0f), 2e-3f);
}

// Light goes on between metals: a groove of two mirrors at right angles under an even sky is as bright as two
// reflections leave it, and never brighter than the sky.
TEST(ReferenceS6, MirrorsReflectEachOther)
{
    for (const int bounces : {0, 1}) {
        Scene scene;
        const int gold = addFinish(scene, {vec3(0.9f, 0.6f, 0.2f), 1.0f, 0.0f, 1.0f});
        addRectangle(scene, {vec3(0, 0, 1), vec3(1, 1, 0), vec3(0, 0, -2)}, gold, 1);
        addRectangle(scene, {vec3(-1, 1, 1), vec3(1, -1, 0), vec3(0, 0, -2)}, gold, 1);
        scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
        const vec3 found = Traced(std::move(scene)).radiance(vec3(0.5f, 2.0f, 0.0f), -kUp, 1024, bounces);
        // Both mirrors are met at 45 degrees: Schlick with 1 - cos 45.
        const float grazing = std::pow(1.0f - std::sqrt(0.5f), 5.0f);
        const vec3 once = vec3(0.9f, 0.6f, 0.2f) + (1.0f - vec3(0.9f, 0.6f, 0.2f)) * grazing;
        const vec3 expected = bounces == 0 ? vec3(0.0f) : once * once;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.01f) << bounces << ' ' << c;
    }
}

/// A floor under a bright panel 1 m up, 0.8 m by 0.6 m, its middle at x = 0.5.
Scene makePanel(const Finish& f, bool textured, float alpha)
{
    Scene scene;
    addFloor(scene, addFinish(scene, f));
    const int panel = addMaterial(scene, vec3(0.0f), vec3(5.0f, 3.0f, 1.0f), true);
    scene.materials.back().specular = 0.0f;
    if (textured) {
        Texture texture;
        texture.pixels = ImageRgba8(2, 1, u8vec4(255));
        texture.pixels.edit()(1, 0) = u8vec4(0, 0, 0, 255);
        texture.nearest = true;
        scene.textures.push_back(texture);
        scene.materials.back().emissiveTexture.texture = 0;
    }
    if (alpha < 1.0f) {
        scene.materials.back().alphaMode = Material::AlphaMode::Blend;
        scene.materials.back().baseColor.w = alpha;
    }
    addRectangle(scene, {vec3(0.1f, 1, -0.3f), vec3(0.8f, 0, 0), vec3(0, 0, 0.6f)}, panel, 1);
    return scene;
}

/// What the origin reflects of the panel, by a sum over the panel's points.
vec3 panelByGrid(const Finish& f, vec3 view, bool textured, float alpha)
{
    constexpr int kSide = 600;
    glm::dvec3 sum(0.0);
    for (int i = 0; i < kSide; ++i) {
        if (textured && i >= kSide / 2) break; // the half at larger x is dark
        for (int j = 0; j < kSide; ++j) {
            const vec3 p(0.1f + 0.8f * (float(i) + 0.5f) / kSide, 1.0f, -0.3f + 0.6f * (float(j) + 0.5f) / kSide);
            const float distance2 = glm::dot(p, p);
            const vec3 l = p / std::sqrt(distance2);
            sum += glm::dvec3(reflectedBy(f, kUp, view, l, vec3(5, 3, 1) * (alpha * l.y / distance2)));
        }
    }
    return vec3(sum * (0.8 * 0.6 / (double(kSide) * kSide)));
}

// Light of an emissive surface by sampled directions, by sampled points of the surface, and by both with MIS: each is
// the integral.
TEST(ReferenceS6, EmittersByDirectionsBySurfacesAndByBoth)
{
    const vec3 view = glm::normalize(vec3(-0.5f, 0.9f, 0.1f));
    for (const Finish& f : {Finish{vec3(0.9f), 1.0f, 0.3f, 1.0f}, Finish{vec3(0.5f), 0.0f, 0.2f, 1.0f},
                            Finish{vec3(0.7f), 0.0f, 1.0f, 0.0f}}) {
        for (const bool textured : {false, true}) {
            for (const float alpha : {1.0f, 0.4f}) {
                const vec3 expected = panelByGrid(f, view, textured, alpha);
                for (const EmitterSampling way :
                     {EmitterSampling::Both, EmitterSampling::Directions, EmitterSampling::Surfaces}) {
                    const Traced traced(makePanel(f, textured, alpha), {ReferenceSurfaces::Full, 0.0f, way});
                    const vec3 found = traced.atOrigin(view, way == EmitterSampling::Directions ? 131072 : 16384);
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(found[c], expected[c], 0.015f * expected[c])
                            << f.metallic << ' ' << f.roughness << ' ' << textured << ' ' << alpha << ' ' << int(way);
                }
            }
        }
    }
}

// The mirror image of an emissive rectangle in a floor of smooth metal: rays that mirror into it have its radiance
// times Schlick's reflectance; others are dark.
TEST(ReferenceS6, MirrorShowsAnEmissiveRectangle)
{
    Scene scene;
    addFloor(scene, addFinish(scene, {vec3(0.8f, 0.6f, 0.4f), 1.0f, 0.0f, 1.0f}), 10.0f);
    const int lamp = addMaterial(scene, vec3(0.0f), vec3(4.0f));
    scene.materials.back().specular = 0.0f;
    addRectangle(scene, {vec3(-1, 1, -3), vec3(2, 0, 0), vec3(0, 2, 0)}, lamp, 1); // faces +z, 1 m to 3 m up
    const Traced traced(std::move(scene));
    const vec3 eye(0, 2, 3);
    for (const vec2 image :
         {vec2(0, -2), vec2(-0.8f, -1.3f), vec2(0.8f, -2.7f), vec2(0, -0.7f), vec2(1.3f, -2), vec2(-0.5f, -3.4f)}) {
        const vec3 toImage = glm::normalize(vec3(image, -3) - eye); // the mirrored lamp is 1 m to 3 m below the floor
        const bool within = std::abs(image.x) < 1.0f && image.y < -1.0f && image.y > -3.0f;
        const float grazing = std::pow(1.0f + toImage.y, 5.0f);
        const vec3 found = traced.radiance(eye, toImage, 2048);
        for (int c = 0; c < 3; ++c) {
            const float f0 = vec3(0.8f, 0.6f, 0.4f)[c];
            const float expected = within ? 4.0f * (f0 + (1.0f - f0) * grazing) : 0.0f;
            EXPECT_NEAR(found[c], expected, 0.03f) << image.x << ' ' << image.y;
        }
    }
}

// A sun with a size: its highlight on a glossy floor is that of light from all of its disc.
TEST(ReferenceS6, SunsHighlightHasTheSunsSize)
{
    const Finish f{vec3(0.9f), 1.0f, 0.25f, 1.0f};
    const vec3 toSun = glm::normalize(vec3(0.6f, 0.8f, 0.0f));
    Scene scene;
    addFloor(scene, addFinish(scene, f));
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -toSun, 10.0f, LightMode::Realtime));
    scene.lights[0].angularRadiusRadians = 0.2f;
    const Traced traced(std::move(scene));
    vec3 t;
    vec3 b;
    shading::orthonormalBasis(toSun, t, b);
    for (const float off : {0.0f, 0.15f, 0.4f}) { // radians from the mirrored sun
        const float angle = std::asin(0.6f) + off;
        const vec3 view(-std::sin(angle), std::cos(angle), 0.0f);
        constexpr int kSide = 400;
        double expected = 0.0;
        for (int i = 0; i < kSide * kSide; ++i) {
            const vec2 u((float(i % kSide) + 0.5f) / kSide, (float(i / kSide) + 0.5f) / kSide);
            const vec2 disc = std::tan(0.2f) * shading::sampleDisc(u);
            const vec3 l = glm::normalize(toSun + disc.x * t + disc.y * b);
            expected += double(reflectedBy(f, kUp, view, l, vec3(10.0f)).x) / (kSide * kSide);
        }
        EXPECT_NEAR(double(traced.atOrigin(view, 4096).x), expected, 0.01 * expected) << off;
    }
}

// Many lights of all kinds: the mean of single chosen lights is the sum over all.
TEST(ReferenceS6, ManyLightsAddUp)
{
    const Finish f{vec3(0.6f, 0.5f, 0.4f), 0.3f, 0.4f, 1.0f};
    const vec3 view = glm::normalize(vec3(0.3f, 0.7f, 0.4f));
    Scene scene;
    addFloor(scene, addFinish(scene, f));
    vec3 expected(0.0f);
    for (int i = 0; i < 12; ++i) {
        const float angle = 2.0f * kPi * float(i) / 12.0f;
        const vec3 position(std::cos(angle), 0.5f + 0.1f * float(i), std::sin(angle));
        const LightType type =
            std::array{LightType::Point, LightType::Spot, LightType::Directional}[std::size_t(i % 3)];
        scene.lights.push_back(makeLight(type, position, -position, 1.0f + float(i % 5), LightMode::Mixed));
        scene.lights.back().rangeMeters = i % 2 == 0 ? 4.0f : 0.0f;
        const PunctualLight light = punctualLights(scene, LightUse::Reference).back();
        const shading::LightSample s = light.at(vec3(0.0f));
        expected += reflectedBy(f, kUp, view, s.direction, s.illuminance);
    }
    const vec3 found = Traced(std::move(scene)).atOrigin(view, 16384);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.01f * expected[c]) << c;
}

} // namespace
} // namespace halflight::test::closed_forms_test
