// Probe occlusion at the default density: what an object gets that moves through the shadow of a wall, against the
// shadow that geometry says (spec S14).
#include "bake/cache/cached_integrator.h"
#include "bake/probes/probes.h"
#include "bake/test_scene.h"

#include "halflight/render/probes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace halflight::probe_shadows_test {
namespace {

using namespace test;

constexpr int kPage = 64;

/// A floor, things that stand on it, and a sun.
struct Yard {
    const char* name;
    float width; ///< metres, of the floor
    std::vector<Bounds> boxes;
    vec3 toSun;

    [[nodiscard]] Scene scene() const
    {
        Scene s;
        const int grey = addMaterial(s, vec3(0.5f));
        addRectangle(s, {vec3(-0.5f * width, 0, 0.5f * width), vec3(width, 0, 0), vec3(0, 0, -width)}, grey, kPage,
                     {vec2(1), vec2(40)});
        for (const Bounds& box : boxes) addBox(s, box.min, box.max, grey, false);
        s.lights = {makeLight(LightType::Directional, vec3(0), -toSun, 3.0f, LightMode::Mixed)};
        s.sky = {vec3(1.0f), vec3(1.0f), vec3(0.2f)};
        return s;
    }
    /// Whether a box hides the sun from a point.
    [[nodiscard]] bool inShadow(vec3 point) const
    {
        return std::any_of(boxes.begin(), boxes.end(), [&](const Bounds& box) {
            const vec3 a = (box.min - point) / toSun;
            const vec3 b = (box.max - point) / toSun;
            const vec3 enter = glm::min(a, b);
            const vec3 leave = glm::max(a, b);
            const float last = std::min({leave.x, leave.y, leave.z});
            return last > 0.0f && std::max({enter.x, enter.y, enter.z}) < last;
        });
    }
    [[nodiscard]] bool inside(vec3 point) const
    {
        return std::any_of(boxes.begin(), boxes.end(), [&](const Bounds& box) {
            return glm::all(glm::lessThan(box.min - 0.3f, point)) && glm::all(glm::lessThan(point, box.max + 0.3f));
        });
    }
    /// 1 or 0 where all around a point, as far as that, the sun is seen or hidden; else 0.5.
    [[nodiscard]] float deep(vec3 point, float around) const
    {
        int hidden = 0;
        for (int i = 0; i < 26; ++i) {
            const int k = i < 13 ? i : i + 1;
            const vec3 way(float(k % 3 - 1), float(k / 3 % 3 - 1), float(k / 9 - 1));
            hidden += inShadow(point + around * glm::normalize(way)) ? 1 : 0;
        }
        return hidden == 0 ? 1.0f : hidden == 26 ? 0.0f : 0.5f;
    }
};

/// The yard's probes at the default density.
BakedScene bakedProbes(const Yard& yard, std::vector<std::string>& warnings)
{
    IntegrationSettings settings;
    settings.samples = 16;
    settings.bounces = 1;
    settings.probeSamples = 128;
    Bench bench(yard.scene(), MixedLightingMode::Shadowmask, kPage, settings);
    const CachedIntegrator cached{*bench.integrator, bench.geometry, bench.map, settings};
    BakedScene baked;
    baked.probes = bakeProbes(bench.scene, 0.0f, ProbeLayout::Refined, true, cached, warnings, {})->set;
    return baked;
}

class YardShadowsS14 : public testing::TestWithParam<Yard> {};

/// An object that is swept through the yard: where all within three quarters of a metre lies in the shadow, or in the
/// sun, its occlusion says so.
TEST_P(YardShadowsS14, DeepInTheShadowAndInTheSunProbesSaySo)
{
    const Yard& yard = GetParam();
    std::vector<std::string> warnings;
    const BakedScene baked = bakedProbes(yard, warnings);
    const ProbeInterpolator probes(baked, {});
    double error = 0.0;
    int count = 0;
    int deep = 0;
    int wrong = 0;
    float worst = 0.0f;
    vec3 worstPlace(0.0f);
    for (float x = -9.9f; x < 10.0f; x += 0.25f) {
        for (float z = -9.9f; z < 10.0f; z += 0.25f) {
            for (const float y : {0.4f, 1.0f}) {
                const vec3 p(x, y, z);
                if (yard.inside(p)) continue;
                const float truth = yard.inShadow(p) ? 0.0f : 1.0f;
                const float found = probes.sample(p).occlusion[0];
                error += double(std::abs(found - truth));
                ++count;
                if (yard.deep(p, 0.75f) == 0.5f) continue;
                ++deep;
                wrong += std::abs(found - truth) > 0.1f ? 1 : 0;
                if (std::abs(found - truth) <= worst) continue;
                worst = std::abs(found - truth);
                worstPlace = p;
            }
        }
    }
    EXPECT_LT(error / count, 0.025);
    EXPECT_LT(double(wrong), 0.01 * deep);
    EXPECT_LT(worst, 0.2f) << worstPlace.x << ' ' << worstPlace.y << ' ' << worstPlace.z;
    EXPECT_TRUE(warnings.empty());
}

/// More edges than probes: the bake says so.
TEST(ProbeShadowsS14, EdgesWithoutProbesAreReported)
{
    Yard yard{"", 40.0f, {}, glm::normalize(vec3(0.3f, 1, 0.2f))};
    for (int i = 0; i < 144; ++i) {
        const vec3 foot(3.0f * float(i % 12) - 18.0f, 0, 3.0f * float(i / 12) - 18.0f);
        yard.boxes.push_back({foot, foot + vec3(1, 4, 1)});
    }
    std::vector<std::string> warnings;
    bakedProbes(yard, warnings);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("--probe-spacing"), std::string::npos) << warnings[0];
}

INSTANTIATE_TEST_SUITE_P(
    Yards, YardShadowsS14,
    testing::Values(
        Yard{"Wall", 40.0f, {{vec3(-5, 0, -0.15f), vec3(5, 3, 0.15f)}}, glm::normalize(vec3(0.1f, 1, -1))},
        Yard{"Pillars",
             30.0f,
             {{vec3(-4, 0, -1), vec3(-3, 4, 0)}, {vec3(0, 0, 1), vec3(1, 3, 2)}, {vec3(4, 0, -2), vec3(6, 2, 0)}},
             glm::normalize(vec3(-0.7f, 1, 0.4f))},
        Yard{"Roof", 40.0f, {{vec3(-3, 2.4f, -3), vec3(3, 2.6f, 3)}}, glm::normalize(vec3(0.2f, 1, 0.3f))}),
    [](const auto& info) { return info.param.name; });

} // namespace
} // namespace halflight::probe_shadows_test
