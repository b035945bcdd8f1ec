#include "probe_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace halflight::probes_test {
namespace {

using namespace test;

/// The point that the weights stand for.
glm::dvec3 meant(const BakedScene& baked, const ProbeWeights& weights)
{
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < 4; ++i)
        sum += double(weights.weights[i]) * glm::dvec3(baked.probes.probes[weights.probes[i]].position);
    return sum;
}

/// Weights are shares of distinct valid probes; the point they stand for is the nearest of the valid probes' hull. A
/// point q of a convex hull is nearest to p exactly if no probe lies beyond the plane through q across q → p (so q = p
/// inside). Returns q.
glm::dvec3 expectNearest(const BakedScene& baked, const ProbeInterpolator& probes, vec3 p, double tolerance)
{
    const ProbeWeights weights = probes.weights(p);
    float sum = 0.0f;
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_GE(weights.weights[i], 0.0f);
        sum += weights.weights[i];
        EXPECT_TRUE(baked.probes.probes[weights.probes[i]].valid);
        if (i > 0) EXPECT_LE(weights.probes[i - 1], weights.probes[i]);
    }
    EXPECT_NEAR(sum, 1.0f, 1.0e-6f);
    const glm::dvec3 q = meant(baked, weights);
    const glm::dvec3 out = glm::dvec3(p) - q;
    const double distance = glm::length(out);
    if (distance <= tolerance) return q;
    for (const Probe& probe : baked.probes.probes) {
        if (!probe.valid) continue;
        // q itself is rounded, by a few millionths; the nearer p, the more that turns the plane.
        const glm::dvec3 d = glm::dvec3(probe.position) - q;
        EXPECT_LE(glm::dot(d, out), tolerance * distance + 4.0e-6 * glm::length(d)) << distance;
    }
    return q;
}

TEST(ProbesS14, ConstantAndLinearFieldsAreReproduced)
{
    const BakedScene constant = probeGrid({4, 3, 5}, [](vec3) { return 0.37f; });
    const BakedScene sloped = probeGrid({4, 3, 5}, linear);
    const ProbeInterpolator ofConstant = rawProbes(constant);
    const ProbeInterpolator ofSloped = rawProbes(sloped);
    EXPECT_EQ(ofSloped.probeCount(), 60u);
    EXPECT_EQ(ofSloped.tetrahedronCount(), 6u * 3 * 2 * 4);
    Random random(4);
    for (int n = 0; n < 300; ++n) {
        const vec3 inside = random.in({-2, 1, 5}, {2.5f, 5, 8});
        expectSample(ofConstant.sample(inside), 0.37f);
        expectSample(ofSloped.sample(inside), linear(inside));
        const vec3 anywhere = random.in(vec3(-30), vec3(30));
        expectSample(ofConstant.sample(anywhere), 0.37f);
        // Outside: the value at the hull's nearest point.
        expectSample(ofSloped.sample(anywhere), linear(glm::clamp(anywhere, vec3(-2, 1, 5), vec3(2.5f, 5, 8))));
    }
}

TEST(ProbesS14, AtAProbeItsOwnValue)
{
    const BakedScene scenes[] = {probeGrid({5, 4, 3}, rough),
                                 probeList(randomPoints(12, 80, vec3(-4), vec3(9, 3, 5)), rough)};
    for (const BakedScene& baked : scenes) {
        const ProbeInterpolator probes = rawProbes(baked);
        for (const Probe& probe : baked.probes.probes)
            expectSample(probes.sample(probe.position), probe.occlusion[0], 1.0e-4f);
    }
}

TEST(ProbesS14, FreeListsReproduceLinearFieldsInsideAndProjectOutside)
{
    for (uint32_t seed = 1; seed <= 5; ++seed) {
        const BakedScene baked = probeList(randomPoints(seed, 20 + 30 * int(seed), vec3(-4), vec3(9, 3, 5)), linear);
        const ProbeInterpolator probes = rawProbes(baked);
        EXPECT_EQ(probes.probeCount(), baked.probes.probes.size());
        Random random(seed + 100);
        int inside = 0;
        for (int n = 0; n < 400; ++n) {
            const vec3 p = n % 2 == 0 ? random.in(vec3(-4), vec3(9, 3, 5)) : random.in(vec3(-40), vec3(40));
            const glm::dvec3 q = expectNearest(baked, probes, p, 1.0e-4);
            inside += glm::distance(q, glm::dvec3(p)) < 1.0e-4;
            expectSample(probes.sample(p), linear(vec3(q)));
        }
        EXPECT_GT(inside, 80);
    }
}

// The four probes of a point inside are a Delaunay cell: no other probe in the sphere through them.
TEST(ProbesS14, NeighborsAreDelaunay)
{
    const BakedScene baked = probeList(randomPoints(21, 120, vec3(0), vec3(10)), rough);
    const ProbeInterpolator probes = rawProbes(baked);
    Random random(5);
    int checked = 0;
    for (int n = 0; n < 300; ++n) {
        const ProbeWeights weights = probes.weights(random.in(vec3(2), vec3(8)));
        if (*std::min_element(weights.weights.begin(), weights.weights.end()) < 1.0e-3f) continue;
        glm::dvec3 v[4];
        for (std::size_t i = 0; i < 4; ++i) v[i] = baked.probes.probes[weights.probes[i]].position;
        const glm::dmat3 edges = glm::transpose(glm::dmat3(v[1] - v[0], v[2] - v[0], v[3] - v[0]));
        const glm::dvec3 lengths(glm::dot(v[1] - v[0], v[1] - v[0]), glm::dot(v[2] - v[0], v[2] - v[0]),
                                 glm::dot(v[3] - v[0], v[3] - v[0]));
        const glm::dvec3 center = v[0] + glm::inverse(edges) * lengths * 0.5;
        const double radius = glm::distance(center, v[0]);
        for (const Probe& probe : baked.probes.probes)
            EXPECT_GE(glm::distance(center, glm::dvec3(probe.position)), radius * (1.0 - 1.0e-5));
        ++checked;
    }
    EXPECT_GT(checked, 200);
}

// Along lines through everything: halving the largest jump's interval again and again makes it vanish.
TEST(ProbesS14, ContinuousEverywhere)
{
    BakedScene holes = probeGrid({6, 5, 6}, rough);
    Random knock(9);
    for (Probe& probe : holes.probes.probes) probe.valid = knock.unit() < 0.6f;
    const BakedScene scenes[] = {probeGrid({6, 5, 6}, rough), holes,
                                 probeList(randomPoints(31, 100, {-2, 1, 5}, {6, 9, 9}), rough)};
    for (const BakedScene& baked : scenes) {
        const ProbeInterpolator probes = rawProbes(baked);
        const auto at = [&](vec3 p) { return probes.sample(p).occlusion[0]; };
        Random random(17);
        for (int line = 0; line < 40; ++line) {
            const vec3 from = random.in({-5, -2, 2}, {9, 12, 12});
            const vec3 to = random.in({-5, -2, 2}, {9, 12, 12});
            const int steps = 500;
            vec3 low(0.0f);
            vec3 high(0.0f);
            float largest = -1.0f;
            for (int i = 0; i < steps; ++i) {
                const vec3 a = glm::mix(from, to, float(i) / steps);
                const vec3 b = glm::mix(from, to, float(i + 1) / steps);
                const float jump = std::abs(at(a) - at(b));
                if (jump > largest) {
                    largest = jump;
                    low = a;
                    high = b;
                }
            }
            for (int i = 0; i < 24; ++i) {
                const vec3 middle = 0.5f * (low + high);
                (std::abs(at(low) - at(middle)) > std::abs(at(middle) - at(high)) ? high : low) = middle;
            }
            EXPECT_LT(std::abs(at(low) - at(high)), 2.0e-3f) << "of " << largest;
        }
    }
}

TEST(ProbesS14, SameAnswerWhateverWasAskedBefore)
{
    const BakedScene baked = probeList(randomPoints(41, 200, vec3(0), vec3(10)), rough);
    const std::vector<vec3> places = randomPoints(42, 500, vec3(-3), vec3(13));
    const ProbeInterpolator probes(baked);
    std::vector<ProbeSample> forward;
    for (const vec3 p : places) forward.push_back(probes.sample(p));
    const ProbeInterpolator again(baked);
    for (std::size_t i = places.size(); i-- > 0;) {
        const ProbeSample sample = again.sample(places[i]);
        EXPECT_EQ(sample.occlusion, forward[i].occlusion);
        EXPECT_EQ(sample.radiance, forward[i].radiance);
    }
    const ProbeSample single = sampleProbes(baked, places[7]);
    EXPECT_EQ(single.occlusion, forward[7].occlusion);
    EXPECT_EQ(single.radiance, forward[7].radiance);
}

TEST(ProbesS14, InvalidProbesAreLeftOut)
{
    // A field with poisoned probes: constant elsewhere.
    BakedScene baked = probeGrid({4, 3, 5}, [](vec3) { return 0.25f; });
    for (const std::size_t poisoned : {(2 * 3 + 1) * 4 + 1, 0, 59, 17}) {
        Probe& probe = baked.probes.probes[poisoned];
        probe.valid = false;
        probe.occlusion.layers[0] = vec4(std::nanf(""));
        probe.radiance.fill(vec3(kInfinity));
    }
    for (const bool grid : {true, false}) {
        if (!grid) baked.probes.size = ivec3(0);
        const ProbeInterpolator probes = rawProbes(baked);
        EXPECT_EQ(probes.probeCount(), 56u);
        Random random(6);
        for (const Probe& probe : baked.probes.probes) expectSample(probes.sample(probe.position), 0.25f);
        for (int n = 0; n < 300; ++n) {
            const vec3 p = random.in({-4, -1, 3}, {5, 7, 10});
            expectSample(probes.sample(p), 0.25f);
            expectNearest(baked, probes, p, 1.0e-4);
        }
    }
}

// Across a hole the tetrahedra reach the probes around it: a linear field is whole in it.
TEST(ProbesS14, HolesAreSpannedByTheProbesAroundThem)
{
    BakedScene baked = probeGrid({7, 7, 7}, linear);
    for (int i = 0; i < 343; ++i) {
        const ivec3 place(i % 7, i / 7 % 7, i / 49);
        const ivec3 off = glm::abs(place - 3);
        if (std::max({off.x, off.y, off.z}) <= 1) baked.probes.probes[std::size_t(i)].valid = false;
    }
    const ProbeInterpolator probes = rawProbes(baked);
    Random random(8);
    for (int n = 0; n < 300; ++n) {
        const vec3 p = kGridOrigin + kGridSpacing * random.in(vec3(1.5f), vec3(4.5f));
        expectSample(probes.sample(p), linear(p));
        const ProbeWeights weights = probes.weights(p);
        for (std::size_t i = 0; i < 4; ++i) {
            if (weights.weights[i] == 0.0f) continue;
            const vec3 steps = (baked.probes.probes[weights.probes[i]].position - p) / kGridSpacing;
            EXPECT_LT(glm::length(steps), 5.3f) << "a probe from beyond the hole's other side"; // the hole's diameter
        }
    }
}

TEST(ProbesS14, PlanesLinesAndPoints)
{
    expectSample(rawProbes(probeGrid({4, 1, 5}, linear)).sample({0.3f, 99, 6.1f}), linear({0.3f, 1, 6.1f}));
    expectSample(rawProbes(probeGrid({2, 1, 1}, linear)).sample({-1.2f, -7, 99}), linear({-1.2f, 1, 5}));
    expectSample(rawProbes(probeGrid({1, 1, 1}, linear)).sample({9, 9, 9}), linear({-2, 1, 5}));

    const vec3 x = glm::normalize(vec3(1, 2, -0.5f));
    const vec3 y = glm::normalize(glm::cross(x, vec3(0.3f, 1, 1)));
    Random random(51);
    std::vector<vec3> plane;
    std::vector<vec3> line;
    for (int i = 0; i < 60; ++i) {
        plane.push_back(vec3(5, 1, -3) + random.in(-6, 6) * x + random.in(-2, 9) * y);
        line.push_back(vec3(5, 1, -3) + random.in(-6, 6) * x);
    }
    const std::vector<std::vector<vec3>> sets = {{{0, 0, 0}},
                                                 {{3, 1, 2}, {3, 1, 2}, {3, 1, 2}},
                                                 {{0, 0, 0}, {1, 2, 3}},
                                                 {{0, 0, 0}, {4, 0, 0}, {1, 0, 0}},
                                                 {{0, 0, 0}, {4, 0, 0}, {1, 3, 0}},
                                                 {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                 {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}},
                                                 {{0, 5, 0}, {1, 5, 0}, {1, 5, 1}, {0, 5, 1}, {0.5f, 5, 0.5f}},
                                                 line,
                                                 plane};
    for (std::size_t k = 0; k < sets.size(); ++k) {
        SCOPED_TRACE(k);
        const BakedScene baked = probeList(sets[k], linear);
        const ProbeInterpolator probes = rawProbes(baked);
        for (int n = 0; n < 200; ++n) {
            const vec3 p = random.in(vec3(-12), vec3(12));
            const glm::dvec3 q = expectNearest(baked, probes, p, 2.0e-4);
            expectSample(probes.sample(p), linear(vec3(q)), 2.0e-5f);
        }
    }
    // Valid probes on a grid's diagonal only: a line as well.
    BakedScene diagonal = probeGrid({5, 5, 5}, linear);
    for (int i = 0; i < 125; ++i) diagonal.probes.probes[std::size_t(i)].valid = i % 31 == 0;
    const ProbeInterpolator probes = rawProbes(diagonal);
    EXPECT_EQ(probes.probeCount(), 5u);
    for (int n = 0; n < 100; ++n) expectNearest(diagonal, probes, random.in(vec3(-12), vec3(12)), 2.0e-4);
}

TEST(ProbesS14, OfProbesAtOnePlaceTheFirstCounts)
{
    std::vector<vec3> points = randomPoints(61, 40, vec3(0), vec3(5));
    BakedScene baked = probeList(points, linear);
    for (const vec3 p : points) baked.probes.probes.push_back(probeOf(p, 0.9f));
    const ProbeInterpolator probes = rawProbes(baked);
    EXPECT_EQ(probes.probeCount(), 40u);
    for (const vec3 p : points) expectSample(probes.sample(p), linear(p));
}

// A grid turned in space, given as a list: floats put its outer probes a little off its faces, so that the exact hull
// is covered with flat cells between far probes. The probes read on a face must still be those around the point.
TEST(ProbesS14, TurnedGridsReadNeighborsOnTheirFaces)
{
    const mat4 turn = pose({31, -7, 12}, {0.3f, -0.6f, 0.7f});
    std::vector<vec3> points;
    for (int i = 0; i < 512; ++i) points.push_back(vec3(turn * vec4(i % 8, i / 8 % 8, i / 64, 1)));
    const BakedScene baked = probeList(points, rough);
    const ProbeInterpolator probes = rawProbes(baked);
    EXPECT_EQ(probes.probeCount(), 512u);
    Random random(71);
    for (int n = 0; n < 600; ++n) {
        const vec3 local = random.in(vec3(-4), vec3(11));
        const vec3 nearest = vec3(turn * vec4(glm::clamp(local, vec3(0), vec3(7)), 1));
        const ProbeWeights weights = probes.weights(vec3(turn * vec4(local, 1)));
        EXPECT_LT(glm::distance(vec3(meant(baked, weights)), nearest), 1.0e-3f);
        for (std::size_t i = 0; i < 4; ++i) {
            if (weights.weights[i] > 1.0e-3f) EXPECT_LT(glm::distance(points[weights.probes[i]], nearest), 1.75f);
        }
    }
}

TEST(ProbesS14, BadSetsDoNoHarm)
{
    // A probe at no place, a grid without spacing, a grid at no place: what is left is used.
    BakedScene baked = probeList(randomPoints(81, 20, vec3(0), vec3(5)), linear);
    baked.probes.probes[3].position.y = std::nanf("");
    baked.probes.probes[4].position.x = kInfinity;
    EXPECT_EQ(rawProbes(baked).probeCount(), 18u);
    const vec3 center(2.5f);
    EXPECT_NEAR(rawProbes(baked).sample(center).occlusion[0], linear(center), 1.0e-5f);
    EXPECT_TRUE(std::isfinite(rawProbes(baked).sample(vec3(std::nanf(""))).occlusion[0]));
    EXPECT_TRUE(std::isfinite(rawProbes(baked).sample(vec3(3.0e38f, -3.0e38f, 0)).occlusion[0]));

    BakedScene grid = probeGrid({3, 3, 3}, linear);
    grid.probes.spacingMeters.y = 0.0f;
    expectSample(rawProbes(grid).sample({0, 2, 6}), linear({0, 2, 6})); // by the probes' own positions
    grid.probes.spacingMeters.y = 2.0f;
    grid.probes.origin.x = std::nanf("");
    expectSample(rawProbes(grid).sample({0, 2, 6}), linear({0, 2, 6}));
    // Far from the origin and large: as exact as floats are.
    BakedScene far = probeGrid({3, 3, 3}, [](vec3) { return 0.5f; });
    far.probes.origin = vec3(1.0e6f);
    far.probes.spacingMeters = vec3(1.0e4f);
    expectSample(rawProbes(far).sample(vec3(1.01e6f)), 0.5f);
}

} // namespace
} // namespace halflight::probes_test
