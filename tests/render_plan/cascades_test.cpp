#include "plan_scene.h"

#include <gtest/gtest.h>

namespace halflight::cascades_test {
namespace {

using namespace test;

/// A wide scene with dynamic boxes all over, under one sun.
BakedScene plain()
{
    BakedScene baked = emptyScene();
    addBox(baked, {0, -1, 0}, {200, 1, 200}, true);
    for (int i = 0; i < 5; ++i) addBox(baked, {float(i * 30 - 60), 5, float(i % 2)}, {1, 5, 1}, false);
    baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0.4f, -1, 0.3f}, LightMode::Realtime, -1)};
    return baked;
}

vec3 texelOf(const ShadowTile& tile, vec3 world)
{
    const vec4 clip = tile.clipFromWorld * vec4(world, 1.0f);
    return {(0.5f * clip.x / clip.w + 0.5f) * float(tile.size), (0.5f * clip.y / clip.w + 0.5f) * float(tile.size),
            clip.z / clip.w};
}

TEST(CascadesS2, SplitsGrowToTheShadowDistance)
{
    for (int cascades = 1; cascades <= 4; ++cascades) {
        for (const float lambda : {0.0f, 0.5f, 1.0f}) {
            ShadowSettings settings;
            settings.cascades = cascades;
            settings.cascadeSplitLambda = lambda;
            const FramePlan frame = plan(plain(), lookFrom({0, 3, 0}, {0, 0, -1}), RunMode::Realtime, settings);
            EXPECT_EQ(frame.lights[0].tileCount, cascades);
            EXPECT_EQ(frame.directionalLayers, cascades);
            for (int i = 1; i < cascades; ++i)
                EXPECT_GT(frame.cascadeFar[std::size_t(i)], frame.cascadeFar[std::size_t(i - 1)]);
            for (int i = cascades - 1; i < 4; ++i) EXPECT_EQ(frame.cascadeFar[std::size_t(i)], settings.distanceMeters);
            const float first = frame.cascadeFar[0];
            if (cascades > 1 && lambda == 0.0f) {
                const float nearest = std::max(0.05f, 1e-3f * settings.distanceMeters);
                EXPECT_NEAR(first, nearest + (settings.distanceMeters - nearest) / float(cascades), 1e-3f) << "uniform";
            }
            if (cascades == 2 && lambda == 1.0f) {
                EXPECT_NEAR(first, std::sqrt(0.06f * 60.0f), 1e-3f) << "logarithmic: geometric mean of near and far";
            }
        }
    }
}

TEST(CascadesS2, EndWhereTheCameraSeesNoFarther)
{
    FrameView view = lookFrom({0, 3, 0}, {0, 0, -1});
    view.camera.farMeters = 10.0f;
    const FramePlan frame = plan(plain(), view, RunMode::Realtime);
    EXPECT_LT(frame.cascadeFar[3], 20.0f);
    EXPECT_GE(frame.cascadeFar[3], glm::distance(pointInView(view, {0, 0}, 10.0f), vec3(0, 3, 0)));
}

// Brute force: every point in view up to the shadow distance is inside the cascade that its distance chooses, away from
// the border by the filter's reach; and inside the next one in the band where the two blend.
TEST(CascadesS2, CoverEveryPointInView)
{
    Random random(3);
    for (int n = 0; n < 60; ++n) {
        BakedScene baked = plain();
        baked.scene.lights[0].worldFromLight = pose({}, random.direction());
        FrameView view = lookFrom(random.in({-20, 1, -20}, {20, 8, 20}), random.direction(),
                                  n % 3 == 0 ? ivec2(600, 1000) : ivec2(1920, 1080));
        view.camera.verticalFovRadians = random.in(0.3f, 2.0f);
        view.camera.orthographic = n % 6 == 5;
        view.camera.orthographicHeightMeters = random.in(2.0f, 100.0f);
        ShadowSettings settings;
        settings.cascades = 1 + n % 4;
        settings.cascadeSplitLambda = random.unit();
        settings.distanceMeters = random.in(10.0f, 120.0f);
        settings.filter = ShadowFilter(n % 3);
        settings.directionalMapSize = 512;
        const FramePlan frame = plan(baked, view, RunMode::Realtime, settings);
        ASSERT_TRUE(frame.lights[0].hasRealtimeShadow);
        Bounds scene;
        for (const Bounds& box : objectBounds(baked.scene)) scene.extend(box);
        const vec3 eye = vec3(view.camera.worldFromCamera[3]);
        const auto border = float(filterReachTexels(settings.filter));
        for (int i = 0; i < 3000; ++i) {
            // Corners and edges of the picture more often than chance would.
            vec2 uv(random.unit(), random.unit());
            if (i % 3 == 0) uv = glm::round(uv);
            const float depth = settings.distanceMeters * std::pow(random.unit(), 2.0f) + view.camera.nearMeters;
            const vec3 p = pointInView(view, uv, depth);
            const float distance = glm::distance(p, eye);
            if (distance > frame.cascadeFar[3]) continue;
            int cascade = 0;
            while (distance > frame.cascadeFar[std::size_t(cascade)]) ++cascade;
            const bool blends =
                cascade + 1 < settings.cascades &&
                distance >= (1.0f - settings.cascadeBlendFraction) * frame.cascadeFar[std::size_t(cascade)];
            for (int c = cascade; c <= cascade + (blends ? 1 : 0); ++c) {
                const vec3 t = texelOf(frame.tiles[std::size_t(c)], p);
                ASSERT_GE(std::min(t.x, t.y), border) << "case " << n << " cascade " << c;
                ASSERT_LE(std::max(t.x, t.y), float(settings.directionalMapSize) - border)
                    << "case " << n << " cascade " << c;
                const bool inScene =
                    glm::all(glm::greaterThanEqual(p, scene.min)) && glm::all(glm::lessThanEqual(p, scene.max));
                if (inScene) {
                    ASSERT_GE(t.z, 0.0f);
                    ASSERT_LE(t.z, 1.0f);
                }
            }
        }
    }
}

// Every caster on the light's way to a visible point is between the planes and in the list.
TEST(CascadesS2, ReachCastersOutsideTheView)
{
    BakedScene baked = emptyScene();
    addBox(baked, {0, -1, 0}, {50, 1, 50}, true);
    addBox(baked, {0, 90, 0}, {2, 1, 2}, false);  // far above the picture, right above what it shows
    addBox(baked, {40, 90, 0}, {2, 1, 2}, false); // its shadow falls far from it
    baked.scene.lights = {bakedLight("sun", LightType::Directional, {}, {0, -1, 0}, LightMode::Mixed, 0)};
    ShadowSettings settings;
    settings.distanceMeters = 15.0f;
    const FramePlan frame = plan(baked, lookFrom({0, 2, 5}, {0, -0.3f, -1}), RunMode::Shadowmask, settings);
    ASSERT_TRUE(frame.lights[0].hasRealtimeShadow);
    bool above = false;
    for (int tile = 0; tile < frame.lights[0].tileCount; ++tile) {
        for (const uint32_t object : frame.castersOf(tile)) {
            EXPECT_NE(object, 0u) << "static";
            EXPECT_NE(object, 2u) << "outside all cascades";
            above = above || object == 1;
            const vec3 t = texelOf(frame.tiles[std::size_t(tile)], {0, 91, 0});
            EXPECT_GE(t.z, 0.0f);
        }
    }
    EXPECT_TRUE(above);
}

// Valient 2008: while the camera moves and turns, a point of the world keeps its place within its texel and a texel its
// size.
TEST(CascadesS2, TexelsStayPutWhileTheCameraMoves)
{
    const BakedScene baked = plain();
    Random random(5);
    const vec3 point(3.3f, 0.7f, -12.1f);
    for (int cascade = 0; cascade < 4; ++cascade) {
        float texel = 0.0f;
        vec2 fraction(0.0f);
        for (int n = 0; n < 100; ++n) {
            const vec3 eye =
                vec3(0, 3, 0) + (n < 50 ? 0.013f * float(n) * vec3(1, 0.2f, -0.5f) : random.in(vec3(-9), vec3(9)));
            const FrameView view = lookFrom(eye, n < 25 ? vec3(0, 0, -1) : random.direction());
            const FramePlan frame = plan(baked, view, RunMode::Realtime);
            const ShadowTile& tile = frame.tiles[std::size_t(cascade)];
            const vec2 at = vec2(texelOf(tile, point));
            const vec2 f = at - glm::floor(at);
            if (n == 0) {
                texel = tile.texelMeters;
                fraction = f;
                continue;
            }
            ASSERT_EQ(tile.texelMeters, texel);
            // Distance on the circle of fractions.
            const vec2 d = glm::abs(f - fraction);
            ASSERT_LT(std::max(std::min(d.x, 1 - d.x), std::min(d.y, 1 - d.y)), 0.03f)
                << "cascade " << cascade << " step " << n;
        }
    }
}

TEST(CascadesS2, TexelMetersIsTheSizeOfATexel)
{
    const FramePlan frame = plan(plain(), lookFrom({0, 3, 0}, {0, 0, -1}), RunMode::Realtime);
    const vec3 d = plain().scene.lights[0].direction();
    const vec3 across = glm::normalize(glm::cross(d, vec3(1, 0, 0)));
    for (int i = 0; i < 4; ++i) {
        const ShadowTile& tile = frame.tiles[std::size_t(i)];
        const vec2 moved = vec2(texelOf(tile, across)) - vec2(texelOf(tile, vec3(0)));
        EXPECT_NEAR(glm::length(moved) * tile.texelMeters, 1.0f, 1e-3f);
        EXPECT_NEAR(texelOf(tile, d * tile.nearMeters).z, 0.0f, 1e-4f);
        EXPECT_NEAR(texelOf(tile, d * tile.farMeters).z, 1.0f, 1e-4f);
        EXPECT_GT(glm::determinant(mat3(tile.clipFromWorld)) *
                      glm::determinant(mat3(lookFrom({}, {0, 0, -1}).clipFromView() * mat4(1.0f))) *
                      -1.0f, // the camera's z is reversed, the tile's is not
                  0.0f)
            << "triangles wind the same way in shadow maps and pictures";
    }
}

TEST(CascadesS28, EveryDirectionalLightHasItsLayers)
{
    BakedScene baked = plain();
    for (int i = 0; i < 5; ++i) {
        baked.scene.lights.push_back(bakedLight("sun " + std::to_string(i), LightType::Directional, {},
                                                {0.1f * float(i + 1), -1, 0.2f}, LightMode::Realtime, -1));
        baked.scene.lights.back().intensity = float(50 - i);
    }
    ShadowSettings settings;
    settings.cascades = 3;
    const FramePlan frame = plan(baked, lookFrom({0, 3, 0}, {0, 0, -1}), RunMode::Realtime, settings);
    EXPECT_EQ(frame.directionalLayers, kMaxDirectionalShadows * 3);
    std::vector<int> used(std::size_t(frame.directionalLayers), 0);
    int shadowed = 0;
    for (const FrameLight& light : frame.lights) {
        shadowed += light.hasRealtimeShadow ? 1 : 0;
        for (int i = 0; i < light.tileCount; ++i)
            used.at(std::size_t(frame.tiles[std::size_t(light.firstTile + i)].layer))++;
    }
    EXPECT_EQ(shadowed, kMaxDirectionalShadows);
    for (const int count : used) EXPECT_EQ(count, 1);
    EXPECT_TRUE(anyWarning(frame, "light \"sun 3\" gets no realtime shadow")) << "a dimmer one";
    EXPECT_TRUE(anyWarning(frame, "light \"sun 4\" gets no realtime shadow"));
    EXPECT_EQ(frame.warnings.size(), 2u);
}

} // namespace
} // namespace halflight::cascades_test
