// Directional lightmaps against integrals whose value is known.

#include "halflight/shading/directional.h"
#include "halflight/shading/indirect.h"
#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace halflight::directional_test {
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

/// Radiance of a white mirror of this roughness, towards `view`, of a lightmap of irradiance 1.
float specularOf(vec3 mean, vec3 normal, vec3 view, float roughness)
{
    const float nDotV = std::abs(glm::dot(normal, view));
    const float scale =
        directionalSpecularScale(mean, kUp, normal, view, specularLookup(view, normal, roughness), roughness);
    return environmentSpecular(vec3(1.0f), 1.0f, roughness, nDotV).x * scale / kPi;
}

TEST(BakedHighlightS32, DistantLightGivesTheHighlightOfALight)
{
    for (const float elevation : {0.0f, 30.0f, 60.0f}) {
        const vec3 toLight = tilted(elevation, 40.0f);
        for (const float roughness : {0.35f, 0.6f, 0.9f}) {
            // As rough as the sharpest direction that a texel holds makes it.
            const float alpha = std::sqrt(std::pow(roughness, 4.0f) + 0.01f);
            for (const float a : {0.0f, 25.0f}) {
                for (const float seen : {-70.0f, -30.0f, 0.0f, 45.0f}) {
                    const vec3 normal = tilted(a, 40.0f);
                    const vec3 view = tilted(std::abs(seen), seen < 0.0f ? 220.0f : 40.0f);
                    const vec3 expected = reflectLight(vec3(1), 1.0f, std::sqrt(alpha), 1.0f, normal, view, toLight,
                                                       vec3(1.0f / glm::dot(toLight, kUp)));
                    EXPECT_NEAR(specularOf(toLight, normal, view, roughness), expected.x, 2.0e-3f + 0.01f * expected.x)
                        << elevation << ' ' << roughness << ' ' << a << ' ' << seen;
                }
            }
        }
    }
}

TEST(BakedHighlightS32, EvenSkyGivesNone)
{
    for (const float roughness : {0.2f, 0.5f, 1.0f}) {
        for (const float seen : {0.0f, 40.0f, 75.0f}) {
            const vec3 view = tilted(seen);
            const vec3 lobe = specularLookup(view, kUp, roughness);
            EXPECT_NEAR(directionalSpecularScale((2.0f / 3.0f) * kUp, kUp, kUp, view, lobe, roughness),
                        0.5f + 0.5f * lobe.y, 1.0e-3f);
        }
    }
}

/// An even cone of light about a direction 40 degrees off the normal, summed over the cone. GGX is a bell where the
/// cone's reflection is a plateau, so that its flanks differ; the look-up of irradiance that it replaces errs far more.
TEST(BakedHighlightS32, ConesOfLightMakeHighlightsAsWide)
{
    const vec3 axis = tilted(40.0f);
    vec3 tangent;
    vec3 bitangent;
    orthonormalBasis(axis, tangent, bitangent);
    for (const float halfAngle : {10.0f, 25.0f, 40.0f}) {
        constexpr int kSteps = 48;
        std::vector<vec3> directions;
        float irradiance = 0.0f;
        vec3 mean(0.0f);
        const float low = std::cos(glm::radians(halfAngle));
        for (int i = 0; i < kSteps * kSteps; ++i) {
            const float z = glm::mix(low, 1.0f, (float(i % kSteps) + 0.5f) / kSteps);
            const float phi = 2.0f * kPi * (float(i / kSteps) + 0.5f) / kSteps;
            const float r = std::sqrt(1.0f - z * z);
            const vec3 d = r * std::cos(phi) * tangent + r * std::sin(phi) * bitangent + z * axis;
            directions.push_back(d);
            irradiance += d.y;
            mean += d.y * d;
        }
        mean /= irradiance;
        for (const float roughness : {0.3f, 0.5f}) {
            float brightest = 0.0f;
            float worst = 0.0f;
            float error = 0.0f;
            float errorBefore = 0.0f;
            for (float seen = -80.0f; seen <= 80.0f; seen += 5.0f) {
                const vec3 view = tilted(std::abs(seen), seen < 0.0f ? 180.0f : 0.0f);
                float sum = 0.0f;
                for (const vec3 d : directions)
                    sum += reflectLight(vec3(1), 1.0f, roughness, 1.0f, kUp, view, d, vec3(1.0f / irradiance)).x;
                brightest = std::max(brightest, sum);
                const float difference = std::abs(specularOf(mean, kUp, view, roughness) - sum);
                worst = std::max(worst, difference);
                error += difference;
                const vec3 lobe = specularLookup(view, kUp, roughness);
                const float before = environmentSpecular(vec3(1.0f), 1.0f, roughness, view.y).x *
                                     directionalIrradianceScale(mean, kUp, lobe) / kPi;
                errorBefore += std::abs(before - sum);
            }
            EXPECT_LT(worst, 0.5f * brightest) << halfAngle << ' ' << roughness;
            EXPECT_LT(error, 0.6f * errorBefore) << halfAngle << ' ' << roughness;
        }
    }
}

} // namespace
} // namespace halflight::directional_test
