// How far probes see (spec S14), against the distance of a plane.
#include "bake/probes/probes.h"
#include "bake/test_scene.h"

#include "halflight/shading/sight.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::probe_sight_test {
namespace {

/// Eight probes at the corners of a box about the origin.
ProbeSet boxOfProbes(vec3 half)
{
    ProbeSet set;
    for (int i = 0; i < 8; ++i) {
        Probe probe;
        probe.position = half * (2.0f * vec3(i & 1, i >> 1 & 1, i >> 2 & 1) - 1.0f);
        set.probes.push_back(probe);
    }
    return set;
}

ProbeSight sightIn(Scene scene, const ProbeSet& set)
{
    const Bench bench(std::move(scene), MixedLightingMode::Shadowmask, 64, {});
    return *findProbeSight(set, *bench.integrator, {});
}

TEST(ProbeSightS14, WithoutWallsThereAreNoMaps)
{
    Scene scene;
    addRectangle(scene, {vec3(-9, -3, 9), vec3(18, 0, 0), vec3(0, 0, -18)}, addMaterial(scene, vec3(0.5f)), 64);
    const ProbeSight sight = sightIn(std::move(scene), boxOfProbes(vec3(1)));
    EXPECT_EQ(sight.size, 0);
    EXPECT_TRUE(sight.rangeMeters.empty() && sight.corners.empty());
}

// A wall at x = 0.25 between probes at x = -1 and 1: each corner's distance is the plane's, and nothing deviates, but
// where directions begin to miss it.
TEST(ProbeSightS14, MapsHoldTheDistanceOfAWall)
{
    Scene scene;
    addRectangle(scene, {vec3(0.25f, -9, -9), vec3(0, 18, 0), vec3(0, 0, 18)},
                 addMaterial(scene, vec3(0.5f), vec3(0), true), 64);
    const ProbeSet set = boxOfProbes(vec3(1, 0.8f, 0.6f));
    const ProbeSight sight = sightIn(std::move(scene), set);
    ASSERT_EQ(sight.rangeMeters.size(), 8u);
    const int last = sight.size - 1;
    ASSERT_EQ(sight.corners.size(), std::size_t(8 * sight.size * sight.size));
    int flat = 0;
    for (std::size_t i = 0; i < sight.corners.size(); ++i) {
        const std::size_t probe = i / std::size_t(sight.size * sight.size);
        const int corner = int(i) % (sight.size * sight.size);
        const float range = sight.rangeMeters[probe];
        EXPECT_GE(range, 2.0f + 0.8f - 1.0e-4f) << "an edge to the other side, in the octahedron's norm";
        EXPECT_LE(range, 2.0f + 1.6f + 1.2f + 1.0e-4f) << "the diagonal of all";
        const vec2 place = vec2(corner % sight.size, corner / sight.size) * (2.0f / float(last)) - 1.0f;
        const float across =
            shading::octahedralDirection(place.x, place.y).x * (set.probes[probe].position.x < 0 ? 1 : -1);
        const float toWall = std::abs(0.25f - set.probes[probe].position.x);
        const float expected = across > 0.0f ? std::min(toWall / across / range, 1.0f) : 1.0f;
        EXPECT_NEAR(float(sight.corners[i].distance) / 65535.0f, expected, 1.0e-3f) << i;
        if (across < 0.9f * toWall / range - 0.25f || across > toWall / range + 0.25f) {
            EXPECT_LT(sight.corners[i].deviation, 66) << i << ": a thousandth";
            ++flat;
        }
    }
    EXPECT_GT(flat, 200);
}

// In front of the wall's edge a probe sees past it in some directions of a cell: there it deviates.
TEST(ProbeSightS14, EdgesDeviate)
{
    Scene scene;
    addRectangle(scene, {vec3(0, -9, 0.1f), vec3(0, 18, 0), vec3(0, 0, 9)},
                 addMaterial(scene, vec3(0.5f), vec3(0), true), 64);
    const ProbeSight sight = sightIn(std::move(scene), boxOfProbes(vec3(1)));
    int large = 0;
    for (const ProbeSight::Corner& corner : sight.corners) large += corner.deviation > 6553 ? 1 : 0;
    EXPECT_GT(large, 8);
}

} // namespace
} // namespace halflight::test::probe_sight_test
