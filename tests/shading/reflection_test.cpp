// How a reflection probe is looked up, against geometry written out by hand.

#include "halflight/base/image.h"
#include "halflight/shading/reflection.h"
#include "halflight/shading/sampling.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace halflight::reflection_test {
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
    for (const int size : {32, 64, 128, 256}) {
        Image<int> owner(size, reflectionTileHeight(size), -1);
        for (int level = 0; level < kReflectionLevels; ++level) {
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
    EXPECT_EQ(reflectionRoughness(0), 0.0f);
    EXPECT_EQ(reflectionRoughness(kReflectionLevels - 1), 1.0f);
    EXPECT_EQ(reflectionLevel(0.5f), 2.0f);
}

/// A box about (1, 1.25, 1), 6 x 2.5 x 8 m, turned by 30 degrees about the vertical.
struct TurnedBox {
    mat4 worldFromBox = glm::translate(mat4(1.0f), vec3(1.0f, 1.25f, 1.0f)) *
                        glm::rotate(mat4(1.0f), kShadingPi / 6.0f, vec3(0, 1, 0)) *
                        glm::scale(mat4(1.0f), vec3(3.0f, 1.25f, 4.0f));
    mat4 boxFromWorld = glm::inverse(worldFromBox);

    [[nodiscard]] vec4 lookUp(vec3 position, vec3 direction, vec3 probe, float roughness) const
    {
        return lookUpReflection(position, direction, vec3(boxFromWorld * vec4(position, 1.0f)),
                                mat3(boxFromWorld) * direction, probe, roughness);
    }
};

/// The looked-up direction points from the probe at the very point of the wall that the reflected ray meets.
TEST(Reflection, BoxCorrectsParallaxExactly)
{
    const TurnedBox box;
    const vec3 probe(1.5f, 1.6f, 0.5f);
    for (const vec3 position : {vec3(0.0f, 0.1f, 0.0f), vec3(2.5f, 0.2f, 2.0f), vec3(-0.9f, 2.4f, -0.9f)}) {
        for (const vec3 d : directions()) {
            // The wall by hand: the nearest of the box's six planes that the ray goes towards.
            float distance = 1.0e9f;
            for (int axis = 0; axis < 3; ++axis) {
                for (const float side : {-1.0f, 1.0f}) {
                    const vec3 normal = side * glm::normalize(vec3(box.worldFromBox[axis]));
                    const vec3 onPlane = vec3(box.worldFromBox[3]) + side * vec3(box.worldFromBox[axis]);
                    if (glm::dot(d, normal) <= 0.0f) continue;
                    distance = std::min(distance, glm::dot(onPlane - position, normal) / glm::dot(d, normal));
                }
            }
            const vec3 expected = glm::normalize(position + d * distance - probe);
            EXPECT_LT(glm::distance(vec3(box.lookUp(position, d, probe, 0.3f)), expected), 2.0e-4f);
        }
    }
}

TEST(Reflection, BlurFollowsTheDistanceOfTheWall)
{
    const auto roughnessAt = [](vec3 position, float roughness) {
        const mat4 box = glm::scale(mat4(1.0f), vec3(0.5f)); // the world's cube of 4 m
        return lookUpReflection(position, vec3(1, 0, 0), vec3(box * vec4(position, 1.0f)), mat3(box) * vec3(1, 0, 0),
                                vec3(0.0f), roughness)
            .w;
    };
    for (const float roughness : {0.0f, 0.3f, 1.0f}) EXPECT_FLOAT_EQ(roughnessAt(vec3(0.0f), roughness), roughness);
    // Half as far from the wall as the probe: the lobe's foot is half as wide, and alpha is its width.
    EXPECT_FLOAT_EQ(roughnessAt(vec3(1, 0, 0), 0.4f), 0.4f * std::sqrt(0.5f));
    EXPECT_FLOAT_EQ(roughnessAt(vec3(-2, 0, 0), 0.4f), 0.4f * std::sqrt(2.0f));
    EXPECT_EQ(roughnessAt(vec3(-2, 0, 0), 1.0f), 1.0f);
    // Close to the wall alpha is halved, and no more.
    EXPECT_FLOAT_EQ(roughnessAt(vec3(1.9f, 0, 0), 0.4f), 0.4f * std::sqrt(0.5f));
}

// Beyond a face, no direction's picture jumps as the mirrored ray turns away from the box.
TEST(Reflection, NothingJumpsBeyondABox)
{
    const TurnedBox box;
    const vec3 probe(1.0f, 1.25f, 1.0f);
    const vec3 up(0.0f, 1.0f, 0.0f);
    const vec3 along = glm::normalize(vec3(box.worldFromBox[2]));
    for (const float height : {2.6f, 3.0f, 4.0f, -0.1f, -1.0f}) {
        const vec3 position(1.0f, height, 1.0f);
        const auto at = [&](float angle) {
            return vec3(box.lookUp(position, std::cos(angle) * along + std::sin(angle) * up, probe, 0.3f));
        };
        constexpr float kStep = 1.0e-4f;
        for (float angle = -1.5f; angle < 1.5f; angle += kStep)
            ASSERT_LT(glm::distance(at(angle), at(angle + kStep)), 0.01f) << height << " m, " << angle;
    }
}

TEST(Reflection, CoverageIsAQuarterAtTheFadesDistance)
{
    const vec3 halfSize(2.0f, 1.0f, 4.0f);
    EXPECT_EQ(reflectionCoverage(vec3(0.9f, -1.0f, 0.0f), halfSize, 0.1f), 1.0f);
    EXPECT_NEAR(reflectionCoverage(vec3(1.05f, 0.0f, 0.0f), halfSize, 0.1f), 0.25f, 0.015f);
    EXPECT_NEAR(reflectionCoverage(vec3(0.0f, 0.0f, -1.025f), halfSize, 0.1f), 0.25f, 0.015f);
    EXPECT_EQ(reflectionCoverage(vec3(0.0f, 1.2001f, 0.0f), halfSize, 0.1f), 0.0f);
    EXPECT_EQ(reflectionCoverage(vec3(0.0f, 20.0f, 0.0f), halfSize, 0.1f), 0.0f);
}

// Neither a step nor a kink at the box and where coverage ends: both would be seen as lines.
TEST(Reflection, CoverageFadesWithoutAnEdge)
{
    const auto at = [](float metres) { return reflectionCoverage(vec3(1.0f + metres, 0.0f, 0.0f), vec3(1.0f), 0.25f); };
    constexpr float kStep = 0.002f;
    for (float metres = -0.05f; metres < 0.6f; metres += kStep) {
        const float slope = (at(metres + kStep) - at(metres)) / kStep;
        const float next = (at(metres + 2.0f * kStep) - at(metres + kStep)) / kStep;
        EXPECT_LE(slope, 0.0f);
        EXPECT_GT(slope, -1.05f / 0.25f) << "about as steep as a ramp over one fade";
        EXPECT_LT(std::abs(next - slope), 50.0f * kStep) << metres;
    }
}

TEST(Reflection, FollowsLocalDarkness)
{
    const vec3 color(2.0f, 1.0f, 0.5f);
    const vec3 own(0.3f, 0.2f, 0.1f);
    for (const float roughness : {0.0f, 0.4f, 1.0f}) {
        const float share = 1.0f - roughness * roughness;
        const auto reflected = [&](vec3 expected, vec3 local, float coverage, float trust = 1.0f) {
            return reflectedSurroundings(color, expected, coverage, trust, own, local, roughness);
        };
        // As far as it is trusted.
        EXPECT_EQ(reflected(vec3(5.0f), vec3(5.0f), 1.0f, 0.0f), own);
        EXPECT_LT(glm::distance(reflected(vec3(5.0f), vec3(5.0f), 1.0f, 0.3f), glm::mix(own, color, 0.3f * share)),
                  1e-6f);
        // As much light as expected, or more: the picture as it is, and a rough lobe's own surroundings.
        EXPECT_LT(glm::distance(reflected(vec3(5.0f), vec3(5.0f), 1.0f), glm::mix(own, color, share)), 1e-6f);
        EXPECT_LT(glm::distance(reflected(vec3(5.0f), vec3(9.0f), 1.0f), glm::mix(own, color, share)), 1e-6f);
        // A quarter of it: a mirror shows the same.
        const vec3 darker = color * std::pow(0.25f, roughness);
        EXPECT_LT(glm::distance(reflected(vec3(4.0f), vec3(1.0f), 1.0f), glm::mix(own, darker, share)), 1e-6f);
        // Far outside of all boxes the pictures do not count.
        EXPECT_EQ(reflected(vec3(5.0f), vec3(5.0f), 0.0f), own);
        EXPECT_LT(glm::distance(reflected(vec3(5.0f), vec3(5.0f), 0.5f), glm::mix(own, color, 0.9375f * share)), 1e-6f);
        // A black probe divides by nothing.
        EXPECT_LT(glm::distance(reflected(vec3(0.0f), vec3(0.0f), 1.0f),
                                glm::mix(own, roughness > 0.0f ? vec3(0.0f) : color, share)),
                  1e-6f);
    }
}

} // namespace
} // namespace halflight::reflection_test
