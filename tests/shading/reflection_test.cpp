// How a reflection probe is looked up, against geometry written out by hand.

#include "halflight/base/image.h"
#include "halflight/shading/reflection.h"
#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace halflight {
namespace {

using namespace shading;

/// Directions all over the sphere.
std::vector<vec3> directions()
{
    std::vector<vec3> result;
    for (int i = 0; i < 400; ++i)
        result.push_back(sampleSphere(vec2((float(i) + 0.5f) / 400.0f, std::fmod(float(i) * 0.618034f, 1.0f))));
    return result;
}

TEST(Reflection, OctahedronHoldsEveryDirectionOnce)
{
    EXPECT_EQ(octahedronFromDirection(vec3(0, 1, 0)), vec2(0.5f));
    for (const vec3 d : directions()) {
        const vec2 uv = octahedronFromDirection(d);
        EXPECT_TRUE(uv.x >= 0.0f && uv.x <= 1.0f && uv.y >= 0.0f && uv.y <= 1.0f);
        EXPECT_LT(glm::distance(directionFromOctahedron(uv), d), 1.0e-5f);
    }
}

TEST(Reflection, LevelsLieApartWithinTheTile)
{
    for (const int size : {16, 64, 128, 256}) {
        Image<int> owner(size, size + size / 2, -1);
        for (int level = 0; (size >> level) >= 8; ++level) {
            const ivec2 offset(reflectionLevelOffset(size, level));
            for (int y = 0; y < reflectionLevelSize(size, level); ++y) {
                for (int x = 0; x < reflectionLevelSize(size, level); ++x) {
                    ASSERT_LT(offset.x + x, owner.width());
                    ASSERT_LT(offset.y + y, owner.height());
                    EXPECT_EQ(owner(offset.x + x, offset.y + y), -1) << "level " << level << " of " << size;
                    owner(offset.x + x, offset.y + y) = level;
                }
            }
            // A bilinear filter reads half a texel around: never beyond the border.
            for (const vec3 d : directions()) {
                const vec2 texel = reflectionTexel(size, level, d) - vec2(offset);
                EXPECT_GE(std::min(texel.x, texel.y), 0.5f);
                EXPECT_LE(std::max(texel.x, texel.y), float(reflectionLevelSize(size, level)) - 0.5f);
            }
        }
    }
}

/// The looked-up direction points from the probe at the very point of the wall that the reflected ray meets.
TEST(Reflection, BoxCorrectsParallaxExactly)
{
    const vec3 low(-2.0f, 0.0f, -3.0f);
    const vec3 high(4.0f, 2.5f, 5.0f);
    const vec3 probe(1.0f, 1.6f, 0.5f);
    for (const vec3 position : {vec3(0.0f), vec3(3.5f, 0.2f, 4.0f), vec3(-1.9f, 2.4f, -2.9f)}) {
        for (const vec3 d : directions()) {
            // The wall by hand: the nearest of the planes that the ray goes towards.
            float distance = 1.0e9f;
            for (int axis = 0; axis < 3; ++axis) {
                if (d[axis] == 0.0f) continue;
                distance = std::min(distance, ((d[axis] > 0.0f ? high : low)[axis] - position[axis]) / d[axis]);
            }
            const vec3 wall = position + d * distance;
            const vec3 expected = glm::normalize(wall - probe);
            EXPECT_LT(glm::distance(lookUpReflection(position, d, 0.3f, probe, low, high).direction, expected),
                      2.0e-4f);
        }
    }
}

TEST(Reflection, BlurFollowsTheDistanceOfTheWall)
{
    const vec3 low(-2.0f);
    const vec3 high(2.0f);
    const vec3 x(1, 0, 0);
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        EXPECT_FLOAT_EQ(lookUpReflection(vec3(0.0f), x, roughness, vec3(0.0f), low, high).roughness, roughness);
        // Farther from the wall than the probe is: the lobe's foot is wider, but no wider than the lobe.
        EXPECT_FLOAT_EQ(lookUpReflection(-x, x, roughness, vec3(0.0f), low, high).roughness, roughness);
    }
    // Half as far from the wall: a narrow lobe is half as wide from the probe.
    EXPECT_NEAR(lookUpReflection(x, x, 0.01f, vec3(0.0f), low, high).roughness, 0.005f, 1.0e-4f);
    EXPECT_FLOAT_EQ(lookUpReflection(x, x, 1.0f, vec3(0.0f), low, high).roughness, 1.0f);
}

TEST(Reflection, CoverageFadesOutsideAndTheNearestProbeLeads)
{
    const vec3 low(0.0f);
    const vec3 high(2.0f);
    EXPECT_EQ(reflectionCoverage(vec3(1.9f, 0.1f, 1.0f), low, high, 0.5f), 1.0f);
    EXPECT_FLOAT_EQ(reflectionCoverage(vec3(2.25f, 1.0f, 1.0f), low, high, 0.5f), 0.5f);
    EXPECT_EQ(reflectionCoverage(vec3(1.0f, -0.6f, 1.0f), low, high, 0.5f), 0.0f);
    const float near = reflectionWeight(1.0f, vec3(0.0f), vec3(1, 0, 0));
    const float far = reflectionWeight(1.0f, vec3(0.0f), vec3(0, 3, 0));
    EXPECT_FLOAT_EQ(near / far, 81.0f);
    EXPECT_EQ(keptReflectionWeight(far, near + far), 0.0f) << "1/82 of the blend";
    EXPECT_GT(keptReflectionWeight(near, near + far), 0.9f * near);
}

TEST(Reflection, IrradianceAtTheProbeOfEvenLight)
{
    // Radiance 3 from all sides: the constant coefficient is 3 sqrt(4 pi), the irradiance 3 pi.
    const vec4 c(3.0f * std::sqrt(4.0f * kShadingPi), 0, 0, 0);
    for (const vec3 n : directions())
        EXPECT_NEAR(reflectionIrradiance(c, vec4(0.0f), 0.0f, n), 3.0f * kShadingPi, 1e-3f);
}

TEST(Reflection, FollowsLocalDarkness)
{
    const vec3 color(2.0f, 1.0f, 0.5f);
    for (const float roughness : {0.0f, 0.4f, 1.0f}) {
        EXPECT_EQ(normalizedReflection(color, 5.0f, 5.0f, vec3(5.0f), roughness), color);
        // Half the light: a mirror sees the same, the roughest lobe half.
        EXPECT_LT(glm::distance(normalizedReflection(color, 5.0f, 2.5f, vec3(2.5f), roughness),
                                (1.0f - 0.5f * roughness) * color),
                  1.0e-6f);
        EXPECT_LT(
            glm::distance(normalizedReflection(color, 5.0f, 0.0f, vec3(0.0f), roughness), (1.0f - roughness) * color),
            1.0e-6f);
    }
    // Twice the probe's light, from no known direction: a mirror misses the other half, the roughest lobe meets its
    // mean.
    EXPECT_EQ(normalizedReflection(color, 5.0f, 10.0f, vec3(10.0f), 0.0f), color);
    EXPECT_LT(
        glm::distance(normalizedReflection(color, 5.0f, 10.0f, vec3(10.0f), 1.0f), color + vec3(5.0f / kShadingPi)),
        1.0e-5f);
    // Nothing known of the surroundings: as a lightmap without probes.
    EXPECT_LT(glm::distance(normalizedReflection(vec3(0.0f), 0.0f, 3.0f, vec3(3.0f), 1.0f), vec3(3.0f / kShadingPi)),
              1.0e-5f);
    EXPECT_EQ(normalizedReflection(vec3(0.0f), 0.0f, 0.0f, vec3(0.0f), 1.0f), vec3(0.0f));
}

} // namespace
} // namespace halflight
