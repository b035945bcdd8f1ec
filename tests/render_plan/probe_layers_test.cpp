// Probes in a plane, on a line or at one place, as a bake writes them: with copies one layer up (spec S14).
#include "halflight/scene/probe_cells.h"
#include "probe_sets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace halflight::probe_layers_test {
namespace {

using namespace test;

/// Any field, to see which probes are read.
float field(vec3 p)
{
    return 0.5f + 0.5f * std::sin(3.0f * p.x + 5.0f * p.y + 2.0f * p.z);
}

std::vector<std::vector<vec3>> flatSets()
{
    const vec3 x = glm::normalize(vec3(1, 2, -0.5f));
    const vec3 y = glm::normalize(glm::cross(x, vec3(0.3f, 1, 1)));
    Random random(51);
    std::vector<vec3> plane;
    std::vector<vec3> line;
    std::vector<vec3> level;
    for (int i = 0; i < 60; ++i) {
        plane.push_back(vec3(5, 1, -3) + random.in(-6, 6) * x + random.in(-2, 9) * y);
        line.push_back(vec3(5, 1, -3) + random.in(-6, 6) * x);
        level.emplace_back(random.in(-6, 6), 2.0f, random.in(-6, 6));
    }
    return {{{3, 1, 2}}, {{0, 0, 0}, {4, 0, 0}, {1, 0, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, line, plane, level};
}

/// Other readers than ours need tetrahedra. The copies have their probes' light, so it is the same everywhere.
TEST(ProbesS14, CopiesOneLayerUpMakeTetrahedraAndChangeNoLight)
{
    Random random(52);
    for (const std::vector<vec3>& set : flatSets()) {
        SCOPED_TRACE(set.size());
        const BakedScene flat = probeList(set, field);
        ASSERT_TRUE(fileTetrahedra(probeCells(flat.probes)).empty());
        BakedScene layered = flat;
        ASSERT_TRUE(addProbeLayers(layered.probes));
        const std::vector<Probe>& probes = layered.probes.probes;
        const std::vector<Tetrahedron> cells = fileTetrahedra(probeCells(layered.probes));
        ASSERT_FALSE(cells.empty());
        for (const Tetrahedron& cell : cells) {
            std::array<glm::dvec3, 4> v;
            for (std::size_t i = 0; i < 4; ++i) v[i] = probes[cell.vertex[i]].position;
            EXPECT_GT(glm::dot(v[1] - v[0], glm::cross(v[2] - v[0], v[3] - v[0])), 0.0);
        }
        const ProbeInterpolator before = rawProbes(flat);
        const ProbeInterpolator after = rawProbes(layered);
        for (int n = 0; n < 200; ++n) {
            const vec3 p = random.in(vec3(-12), vec3(12));
            EXPECT_NEAR(after.sample(p).radiance[0].x, before.sample(p).radiance[0].x, 1.0e-3f)
                << "positions are floats";
        }
    }
}

/// Probes that fill space stay as they are.
TEST(ProbesS14, SetsWithAnExtentAlongEveryAxisGetNoCopies)
{
    BakedScene baked = probeList({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}, field);
    EXPECT_FALSE(addProbeLayers(baked.probes));
    EXPECT_EQ(baked.probes.probes.size(), 4u);
}

} // namespace
} // namespace halflight::probe_layers_test
