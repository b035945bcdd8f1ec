// The shadow distance that a view needs: farthestInView(), shadowsReaching().

#include "plan_scene.h"

#include <gtest/gtest.h>
#include <random>

namespace halflight::shadow_distance_test {
namespace {

using namespace test;

Bounds box(vec3 center, vec3 half)
{
    return {center - half, center + half};
}

TEST(ShadowDistance, ReachesTheFarCornersInView)
{
    FrameView view = lookFrom({0, 0, 0}, {0, 0, -1});
    view.camera.farMeters = 1000.0f;
    // A small box in the middle of the picture is seen as a whole; what is behind the camera does not count.
    const std::vector<Bounds> small{box({0, 0, -20}, {1, 2, 3}), box({0, 0, 500}, {1, 1, 1}), Bounds()};
    EXPECT_NEAR(farthestInView(view, small), glm::length(vec3(1, 2, 23)), 1e-4f);
    // Of a wall as wide as the world only what the picture's corners show.
    const vec3 corner = glm::normalize(pointInView(view, {1, 1}, 1.0f));
    const std::vector<Bounds> wall{box({0, 0, -50}, {1000, 1000, 0})};
    EXPECT_NEAR(farthestInView(view, wall), 50.0f / -corner.z, 0.01f);
    // Nor what is beyond the far plane.
    view.camera.farMeters = 30.0f;
    EXPECT_EQ(farthestInView(view, wall), 0.0f);
    const std::vector<Bounds> tunnel{box({0, 0, -500}, {0.5f, 0.5f, 500})};
    EXPECT_NEAR(farthestInView(view, tunnel), glm::length(vec3(0.5f, 0.5f, 30.0f)), 0.01f);
}

// Against the farthest of many points of boxes that the camera sees.
TEST(ShadowDistance, IsThatOfTheFarthestPoint)
{
    std::mt19937 random(7);
    const auto next = [&] { return float(random() % 65536u) / 65535.0f; };
    const auto between = [&](float low, float high) { return glm::mix(low, high, next()); };
    const auto point = [&](float low, float high) {
        const float x = between(low, high);
        const float y = between(low, high);
        return vec3(x, y, between(low, high));
    };
    for (int n = 0; n < 60; ++n) {
        FrameView view = lookFrom(point(-5, 5), point(-1, 1));
        view.camera.farMeters = between(5, 40);
        const mat4 clipFromWorld = view.clipFromView() * view.viewFromWorld();
        const Bounds bounds = box(point(-10, 10), point(0.5f, 12));
        float farthest = 0.0f;
        for (int i = 0; i < 40000; ++i) {
            const float x = next();
            const float y = next();
            const vec3 p = bounds.min + vec3(x, y, next()) * bounds.size();
            const vec4 clip = clipFromWorld * vec4(p, 1.0f);
            const bool inside = clip.w > 0.0f && std::abs(clip.x) <= clip.w && std::abs(clip.y) <= clip.w &&
                                clip.z >= 0.0f && clip.z <= clip.w;
            if (inside) farthest = std::max(farthest, glm::distance(p, vec3(view.camera.worldFromCamera[3])));
        }
        const float found = farthestInView(view, std::span(&bounds, 1));
        EXPECT_GE(found, farthest * 0.9999f) << n;
        if (farthest > 0.0f) EXPECT_LE(found, farthest + 0.25f * glm::length(bounds.size())) << n;
    }
}

TEST(ShadowDistance, HoldsTheSceneAndKeepsNearCascadesNear)
{
    const FrameView view = lookFrom({0, 0, 0}, {0, 0, -1});
    ShadowSettings given;
    given.fadeRangeMeters = 2.0f;
    float before = 0.0f;
    for (const float distance : {3.0f, 30.0f, 300.0f, 900.0f}) {
        const std::vector<Bounds> scene{box({0, 0, -distance}, {1, 1, 0})};
        const ShadowSettings fitted = shadowsReaching(farthestInView(view, scene), given);
        EXPECT_GE(fitted.distanceMeters, farthestInView(view, scene) + 2.0f) << "nothing in view fades";
        EXPECT_LE(fitted.distanceMeters, 1.1f * distance + 3.0f);
        EXPECT_TRUE(checkShadowSettings(fitted));
        BakedScene baked = emptyScene();
        addBox(baked, {0, 0, -distance}, {1, 1, 0.1f}, false);
        baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0.4f, -1, 0.3f}, LightMode::Realtime, -1)};
        const FramePlan frame = plan(baked, view, RunMode::Realtime, fitted);
        EXPECT_GT(frame.cascadeFar[0], before) << "grows with the scene";
        EXPECT_LT(frame.cascadeFar[0], 12.0f) << "stays near the camera";
        before = frame.cascadeFar[0];
    }
    const std::vector<Bounds> huge{box({0, 0, -9000}, {1, 1, 0})};
    FrameView far = view;
    far.camera.farMeters = 1.0e5f;
    EXPECT_EQ(shadowsReaching(farthestInView(far, huge), given).distanceMeters, kLongestShadowDistance);
    EXPECT_EQ(shadowsReaching(farthestInView(view, {}), given).distanceMeters, given.distanceMeters)
        << "nothing in view";
}

} // namespace
} // namespace halflight::shadow_distance_test
