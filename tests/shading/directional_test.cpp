// Directional lightmaps against integrals whose value is known.

#include "halflight/shading/directional.h"
#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

namespace halflight {
namespace {

using namespace shading;

const vec3 kUp(0.0f, 1.0f, 0.0f);

vec3 tilted(float degrees, float azimuthDegrees = 0.0f)
{
    const float t = glm::radians(degrees);
    const float a = glm::radians(azimuthDegrees);
    return {std::sin(t) * std::cos(a), std::cos(t), std::sin(t) * std::sin(a)};
}

/// Mean direction of an even sky of irradiance `sky` and a distant light of irradiance `light`, both on the baked
/// normal.
vec3 meanDirection(float sky, float light, vec3 toLight)
{
    return (sky * (2.0f / 3.0f) * kUp + light * toLight) / (sky + light);
}

TEST(DirectionalS32, BakedNormalKeepsTheLightmapsValue)
{
    for (const float elevation : {0.0f, 30.0f, 60.0f, 85.0f})
        for (const float share : {0.0f, 0.3f, 1.0f})
            EXPECT_NEAR(directionalIrradianceScale(meanDirection(1.0f - share, share, tilted(elevation)), kUp, kUp),
                        1.0f, 1.0e-4f);
}

TEST(DirectionalS32, EvenSkyDimsATiltedSurfaceByTheSkyItSees)
{
    // A surface tilted by a sees (1 + cos a) / 2 of an even hemisphere's irradiance.
    for (const float a : {10.0f, 45.0f, 80.0f})
        EXPECT_NEAR(directionalIrradianceScale((2.0f / 3.0f) * kUp, kUp, tilted(a)),
                    0.5f + 0.5f * std::cos(glm::radians(a)), 1.0e-4f);
}

TEST(DirectionalS32, DistantLightFollowsTheCosineLaw)
{
    for (const float elevation : {0.0f, 20.0f, 50.0f, 70.0f}) {
        const vec3 toLight = tilted(elevation, 40.0f);
        for (const float a : {15.0f, 40.0f})
            for (const float azimuth : {0.0f, 40.0f, 130.0f, 220.0f}) {
                const vec3 normal = tilted(a, azimuth);
                const float expected = std::max(glm::dot(normal, toLight), 0.0f) / glm::dot(kUp, toLight);
                EXPECT_NEAR(directionalIrradianceScale(toLight, kUp, normal), expected, 2.0e-3f);
            }
    }
}

TEST(DirectionalS32, MixturesOfSkyAndLightAreExact)
{
    const vec3 toLight = tilted(55.0f, -20.0f);
    for (const float share : {0.1f, 0.5f, 0.9f})
        for (const float azimuth : {-20.0f, 60.0f, 160.0f}) {
            const vec3 normal = tilted(30.0f, azimuth);
            const float sky = 0.5f + 0.5f * normal.y;
            const float light = std::max(glm::dot(normal, toLight), 0.0f) / toLight.y;
            EXPECT_NEAR(directionalIrradianceScale(meanDirection(1.0f - share, share, toLight), kUp, normal),
                        (1.0f - share) * sky + share * light, 2.0e-3f);
        }
}

// Any radiance over the hemisphere: never negative, finite, and 1 on the baked normal, also for moments that no light
// can have (8-bit storage and filtering make such).
TEST(DirectionalS32, NeverNegativeWhateverIsStored)
{
    for (uint32_t i = 0; i < 2000; ++i) {
        const vec3 d = sampleSphere(vec2(float(i % 50) / 50.0f, float(i / 50) / 40.0f)) * (float(i % 7) / 5.0f);
        const float scale = directionalIrradianceScale(d, kUp, tilted(float(i % 90), float(i)));
        EXPECT_TRUE(std::isfinite(scale));
        EXPECT_GE(scale, 0.0f);
        EXPECT_NEAR(directionalIrradianceScale(d, kUp, kUp), 1.0f, 1.0e-3f);
    }
    EXPECT_NEAR(directionalIrradianceScale(vec3(0.0f), kUp, kUp), 1.0f, 1.0e-3f);
}

TEST(DirectionalS32, EightBitsKeepTheDirection)
{
    for (const vec3 d : {tilted(30.0f, 10.0f), 0.7f * tilted(60.0f, 200.0f), vec3(0.0f)}) {
        const vec3 stored = glm::floor(encodeMeanDirection(d) * 255.0f + 0.5f) / 255.0f;
        EXPECT_LT(glm::distance(decodeMeanDirection(stored), d), 0.01f);
    }
}

} // namespace
} // namespace halflight
