// Interpolation between probes that see walls (spec S14).
#include "probe_sets.h"

#include "halflight/shading/sight.h"

namespace halflight::test::probe_sight_test {
namespace {

constexpr int kSize = 9;
constexpr float kRange = 4.0f;

/// A map of walls at x = 0 alone, of a probe at this x.
void addMap(ProbeSight& sight, float x)
{
    sight.size = kSize;
    sight.rangeMeters.push_back(kRange);
    for (int i = 0; i < kSize * kSize; ++i) {
        const vec2 place = vec2(i % kSize, i / kSize) * (2.0f / float(kSize - 1)) - 1.0f;
        const vec3 d = shading::octahedralDirection(place.x, place.y);
        const float nearness = std::max(-d.x / x * kRange, 1.0f);
        sight.corners.push_back({uint16_t(std::lround(65535.0f / nearness)), 0});
    }
}

/// Probes with light 0 before a wall at x = 0 and 1 behind it, at x = -1, 1 and so on.
BakedScene twoSides(bool withMaps)
{
    std::vector<vec3> positions;
    for (const float x : {-1.0f, 1.0f})
        for (const float y : {0.0f, 1.0f})
            for (const float z : {0.0f, 1.0f}) positions.emplace_back(x, y, z);
    BakedScene baked = probeList(positions, [](vec3 p) { return p.x < 0.0f ? 0.0f : 1.0f; });
    if (!withMaps) return baked;
    for (const Probe& probe : baked.probes.probes) addMap(baked.probes.sight, probe.position.x);
    return baked;
}

TEST(ProbeSightS14, NothingComesThroughAWall)
{
    const ProbeInterpolator through = rawProbes(twoSides(false));
    const ProbeInterpolator seeing = rawProbes(twoSides(true));
    for (const vec3 p : randomPoints(3, 2000, vec3(0.02f, 0, 0), vec3(1))) {
        EXPECT_GE(seeing.sample(p).occlusion[0], 0.99f) << p.x << ' ' << p.y << ' ' << p.z;
        EXPECT_LE(seeing.sample(p * vec3(-1, 1, 1)).occlusion[0], 0.01f) << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_NEAR(through.sample({0.02f, 0.5f, 0.5f}).occlusion[0], 0.51f, 0.01f) << "without maps half of it did";
}

// As wide a step as the deviation makes it, but no jump: from cell to cell, and where a probe's share ends.
TEST(ProbeSightS14, ContinuousEverywhere)
{
    BakedScene baked = twoSides(true);
    for (ProbeSight::Corner& corner : baked.probes.sight.corners) corner.deviation = 13107; // a fifth
    const ProbeInterpolator probes = rawProbes(baked);
    const std::vector<vec3> from = randomPoints(5, 40, vec3(-1.3f, -0.3f, -0.3f), vec3(1.3f));
    const std::vector<vec3> to = randomPoints(6, 40, vec3(-1.3f, -0.3f, -0.3f), vec3(1.3f));
    constexpr int kSteps = 4000;
    for (std::size_t i = 0; i < from.size(); ++i) {
        float last = probes.sample(from[i]).occlusion[0];
        for (int step = 1; step <= kSteps; ++step) {
            const float next = probes.sample(glm::mix(from[i], to[i], float(step) / kSteps)).occlusion[0];
            EXPECT_NEAR(next, last, 0.02f) << i << ' ' << step;
            last = next;
        }
    }
}

// Probes that see all of their cells have no map, and their interpolation is linear.
TEST(ProbeSightS14, ProbesWithoutMapsAreAsBefore)
{
    const Field linear = [](vec3 p) { return 0.4f + 0.1f * p.x + 0.05f * p.y; };
    BakedScene baked = probeGrid(ivec3(4, 3, 3), linear);
    baked.probes.sight.size = kSize;
    baked.probes.sight.rangeMeters.assign(baked.probes.probes.size(), 0.0f);
    const ProbeInterpolator probes = rawProbes(baked);
    for (const vec3 p : randomPoints(7, 200, kGridOrigin, kGridOrigin + kGridSpacing * vec3(3, 2, 2)))
        expectSample(probes.sample(p), linear(p), 1.0e-4f);
}

// Where no probe sees a point, all count as without maps.
TEST(ProbeSightS14, PointsThatNobodySeesTakeTheMean)
{
    BakedScene baked = twoSides(true);
    for (ProbeSight::Corner& corner : baked.probes.sight.corners) corner.distance = 655; // a box of a hundredth
    const ProbeInterpolator seeing = rawProbes(baked);
    const ProbeInterpolator through = rawProbes(twoSides(false));
    for (const vec3 p : randomPoints(8, 100, vec3(-0.8f, 0.1f, 0.1f), vec3(0.8f, 0.9f, 0.9f)))
        EXPECT_NEAR(seeing.sample(p).occlusion[0], through.sample(p).occlusion[0], 1.0e-4f);
}

} // namespace
} // namespace halflight::test::probe_sight_test
