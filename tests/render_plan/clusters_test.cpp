#include "plan_scene.h"

#include <gtest/gtest.h>

namespace halflight::clusters_test {
namespace {

using namespace test;

bool lights(const Light& light, vec3 p)
{
    if (light.type == LightType::Directional) return true;
    const vec3 d = p - light.position();
    if (light.rangeMeters > 0.0f && glm::length(d) >= light.rangeMeters) return false;
    return light.type == LightType::Point ||
           glm::dot(d, light.direction()) >= glm::length(d) * std::cos(light.outerConeRadians);
}

// Brute force: whatever light reaches a visible point is in the point's cluster.
TEST(Clusters, NeverMissALight)
{
    Random random(21);
    long pairs = 0;
    for (int n = 0; n < 24; ++n) {
        BakedScene baked = emptyScene();
        addBox(baked, {0, 0, 0}, {60, 5, 60}, true);
        for (int i = 0; i < 60; ++i) {
            Light light = bakedLight("l" + std::to_string(i), LightType(i % 3), random.in({-30, -5, -30}, {30, 5, 30}),
                                     random.direction(), LightMode::Realtime, -1);
            light.castShadows = false;
            light.rangeMeters = i % 7 == 0 ? 0.0f : random.in(0.3f, 12.0f);
            light.outerConeRadians = random.in(0.03f, kPi / 2);
            baked.scene.lights.push_back(light);
        }
        FrameView view =
            lookFrom(random.in(vec3(-10), vec3(10)), random.direction(), n % 2 ? ivec2(333, 777) : ivec2(1280, 720));
        view.camera.verticalFovRadians = random.in(0.3f, 2.2f);
        view.camera.orthographic = n % 4 == 3;
        view.camera.orthographicHeightMeters = random.in(1.0f, 40.0f);
        view.camera.nearMeters = n % 3 == 0 ? 0.01f : 0.5f;
        view.camera.farMeters = n % 5 == 0 ? kInfinity : 150.0f;
        if (view.camera.orthographic) view.camera.farMeters = 150.0f;
        const FramePlan frame = plan(baked, view, RunMode::Realtime);
        ASSERT_EQ(frame.clusters.words.size(), std::size_t(frame.clusters.size.x) * std::size_t(frame.clusters.size.y) *
                                                   std::size_t(frame.clusters.size.z) * LightClusters::kWords);
        for (int i = 0; i < 4000; ++i) {
            const vec2 uv(random.unit(), random.unit());
            const float depth = view.camera.nearMeters + 100.0f * std::pow(random.unit(), 3.0f);
            const vec3 p = pointInView(view, uv, depth);
            const ivec3 cluster = frame.clusters.clusterAt(uv, depth);
            std::vector<bool> inFrame(baked.scene.lights.size(), false);
            for (std::size_t l = 0; l < frame.lights.size(); ++l) {
                const Light& light = baked.scene.lights[std::size_t(frame.lights[l].light)];
                inFrame[std::size_t(frame.lights[l].light)] = true;
                if (!lights(light, p)) continue;
                ++pairs;
                ASSERT_TRUE(frame.clusters.reaches(cluster, int(l)))
                    << "case " << n << ", light " << light.name << ", cluster " << cluster.x << " " << cluster.y << " "
                    << cluster.z;
            }
            for (std::size_t l = 0; l < inFrame.size(); ++l) {
                ASSERT_FALSE(!inFrame[l] && lights(baked.scene.lights[l], p)) << "culled light " << l << " is seen";
            }
        }
    }
    EXPECT_GT(pairs, 100000) << "the test must have something to miss";
}

// The first slice begins at the camera, nearer than its nominal near distance.
TEST(Clusters, LightsRightBeforeTheCamera)
{
    BakedScene baked = emptyScene();
    addBox(baked, {0, 0, -10}, {5, 5, 5}, true);
    Light spark = bakedLight("spark", LightType::Point, {0, 0, -0.03f}, {0, -1, 0}, LightMode::Realtime, -1);
    spark.rangeMeters = 0.02f;
    baked.scene.lights = {spark};
    FrameView view = lookFrom({0, 0, 0}, {0, 0, -1});
    view.camera.nearMeters = 0.005f;
    const FramePlan frame = plan(baked, view, RunMode::Realtime);
    ASSERT_EQ(frame.lights.size(), 1u);
    ASSERT_GT(frame.clusters.nearMeters, 0.05f);
    EXPECT_TRUE(frame.clusters.reaches(frame.clusters.clusterAt({0.5f, 0.5f}, 0.03f), 0));
}

// Conservative must not mean everywhere.
TEST(Clusters, SmallLightsTouchFewClusters)
{
    BakedScene baked = emptyScene();
    addBox(baked, {0, 0, -30}, {40, 5, 40}, true);
    Light bulb = bakedLight("bulb", LightType::Point, {0, 1, -20}, {0, -1, 0}, LightMode::Realtime, -1);
    bulb.rangeMeters = 1.0f;
    Light spot = bakedLight("spot", LightType::Spot, {-15, 1, -20}, {1, 0, 0}, LightMode::Realtime, -1);
    spot.rangeMeters = 30.0f; // a pencil across the picture
    spot.outerConeRadians = 0.03f;
    baked.scene.lights = {bulb, spot,
                          bakedLight("sun", LightType::Directional, {}, {0, -1, 0}, LightMode::Realtime, -1)};
    const FramePlan frame = plan(baked, lookFrom({0, 1, 0}, {0, 0, -1}), RunMode::Realtime);
    const auto share = [&](const char* name) {
        const int index = int(find(baked, frame, name) - frame.lights.data());
        long count = 0;
        const ivec3 size = frame.clusters.size;
        for (int z = 0; z < size.z; ++z) {
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) count += frame.clusters.reaches({x, y, z}, index) ? 1 : 0;
            }
        }
        return double(count) / double(size.x * size.y * size.z);
    };
    EXPECT_EQ(share("sun"), 1.0);
    EXPECT_GT(share("bulb"), 0.0);
    EXPECT_LT(share("bulb"), 0.01);
    EXPECT_GT(share("spot"), 0.003);
    EXPECT_LT(share("spot"), 0.06);
}

TEST(Clusters, SlicesGrowExponentially)
{
    LightClusters clusters;
    clusters.size = {16, 9, 24};
    clusters.nearMeters = 0.5f;
    clusters.farMeters = 128.0f; // 2^8 times as far: three slices per doubling
    EXPECT_EQ(clusters.clusterAt({0, 0}, 0.1f), ivec3(0, 0, 0));
    EXPECT_EQ(clusters.clusterAt({0.999f, 0.999f}, 0.51f), ivec3(15, 8, 0));
    EXPECT_EQ(clusters.clusterAt({1.0f, 1.0f}, 1.01f), ivec3(15, 8, 3));
    EXPECT_EQ(clusters.clusterAt({0.5f, 0.5f}, 8.01f), ivec3(8, 4, 12));
    EXPECT_EQ(clusters.clusterAt({0.5f, 0.5f}, 1000.0f).z, 23);
}

} // namespace
} // namespace halflight::clusters_test
