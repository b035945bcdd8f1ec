// Octahedral maps of nearness, and the weight of a probe by them (spec S14).
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"
#include "halflight/shading/sight.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace halflight::shading::sight_test {
namespace {

vec3 directionOf(uint32_t i)
{
    return sampleSphere(vec2(float(hashCombine(i, 1u) % 4096u) + 0.5f, float(hashCombine(i, 2u) % 4096u) + 0.5f) /
                        4096.0f);
}

TEST(SightS14, OctahedralMapGoesThereAndBack)
{
    for (uint32_t i = 0; i < 2000; ++i) {
        const vec3 d = directionOf(i);
        const vec3 back = octahedralDirection(octahedralX(3.0f * d), octahedralY(3.0f * d));
        EXPECT_NEAR(std::abs(back.x) + std::abs(back.y) + std::abs(back.z), 1.0f, 1.0e-5f);
        EXPECT_LT(glm::distance(glm::normalize(back), d), 1.0e-4f) << i;
    }
}

// A plane's nearness in the octahedron's norm, interpolated between corners, is exact in all directions that meet it.
TEST(SightS14, NearnessOfAPlaneIsLinearBetweenCorners)
{
    const vec3 normal = glm::normalize(vec3(3, -2, 1.5f));
    constexpr float kMeters = 0.4f;
    const auto nearnessOf = [&](vec3 d) {
        return glm::dot(normal, d) / (kMeters * (std::abs(d.x) + std::abs(d.y) + std::abs(d.z)));
    };
    for (const int cells : {2, 4, 8}) {
        for (uint32_t i = 0; i < 2000; ++i) {
            const vec3 d = directionOf(i);
            const vec2 at = (vec2(octahedralX(d), octahedralY(d)) * 0.5f + 0.5f) * float(cells);
            const ivec2 cell = glm::clamp(ivec2(at), 0, cells - 1);
            const bool mirrored = (2 * cell.x < cells) != (2 * cell.y < cells);
            float sum = 0.0f;
            float shares = 0.0f;
            for (int k = 0; k < 4; ++k) {
                const ivec2 corner = cell + ivec2(k % 2, k / 2);
                const float share = octahedralShare(k % 2, k / 2, at.x - float(cell.x), at.y - float(cell.y), mirrored);
                const vec2 place = vec2(corner) * (2.0f / float(cells)) - 1.0f;
                EXPECT_GE(share, 0.0f);
                shares += share;
                sum += share * nearnessOf(octahedralDirection(place.x, place.y));
            }
            EXPECT_NEAR(shares, 1.0f, 1.0e-5f);
            EXPECT_NEAR(sum, nearnessOf(d), 2.0e-4f) << cells << ' ' << i;
        }
    }
}

TEST(SightS14, WeightIsOneInSightAndFallsWithTheDistanceBehind)
{
    EXPECT_EQ(probeSight(2.0f, 0.0f, 2.0f), 1.0f);
    EXPECT_EQ(probeSight(2.0f, 0.3f, 5.0f), 1.0f) << "nearer than the surface";
    // As far behind as the deviation: half by Chebyshev's inequality, cubed.
    EXPECT_FLOAT_EQ(probeSight(2.0f, 0.25f, 1.5f), 0.125f);
    EXPECT_FLOAT_EQ(probeSight(2.0f, 0.0f, 1.9f), kLeastSight) << "a plane: 5 % behind it is out of sight";
    float last = 1.0f;
    for (float point = 3.0f; point > 0.9f; point -= 0.05f) {
        const float weight = probeSight(2.0f, 0.04f, point);
        EXPECT_LE(weight, last);
        last = weight;
    }
    EXPECT_GE(last, kLeastSight);
}

} // namespace
} // namespace halflight::shading::sight_test
