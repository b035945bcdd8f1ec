// Texels by themselves (spec S6): requests for some of a map, and validity of their sample points.

#include "bake/geometry/flatten.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"

#include "bake_cpu/trace/embree_kernels.h"
#include "transport/lightmap/cached_lightmap.h"
#include "transport/texels/texel_validity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <utility>

namespace halflight::test::single_texels_test {
namespace {

constexpr int kPage = 64;
constexpr float kMeters = 4.0f; ///< width of the floor, on which a texel is 1/15 m wide

/// A floor with a box on it, under a sky. A blade halfway up shades a part of it from a small lamp.
Scene floorWithBox()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.6f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(kMeters, 0, 0), vec3(0, 0, -kMeters)}, grey, kPage, {vec2(2), vec2(62)});
    addBox(scene, vec3(-1.5f, 0.0f, -1.5f), vec3(-0.9f, 0.6f, -0.9f), grey, false);
    const int glow = addMaterial(scene, vec3(0.0f), vec3(20000.0f));
    addRectangle(scene, {vec3(0.98f, 2.4f, 0.98f), vec3(0.04f, 0, 0), vec3(0, 0, 0.04f)}, glow, kPage);
    addRectangle(scene, {vec3(0.85f, 1.6f, 1.15f), vec3(0.3f, 0, 0), vec3(0, 0, -0.3f)}, grey, kPage);
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    return scene;
}

/// A texel's estimate does not depend on the other texels of the request.
TEST(TexelRequestS6, PartsAreLikeTheWhole)
{
    for (const float noise : {0.0f, 0.03f}) {
        IntegrationSettings settings;
        settings.samples = noise > 0.0f ? 256 : 32;
        settings.bounces = 2;
        settings.cache.noiseTarget = noise;
        Bench bench(floorWithBox(), MixedLightingMode::Shadowmask, kPage, settings);
        const auto whole = bench.irradiance();
        for (const uint32_t first : {0u, 100u, 1000u, 1777u, 3001u}) {
            std::vector<uint32_t> texels;
            for (uint32_t i = 0; i < 7; ++i) texels.push_back(first + i * 3);
            std::vector<IrradianceEstimate> part(texels.size());
            ASSERT_TRUE(bench.irradiance({texels}, part));
            for (std::size_t i = 0; i < texels.size(); ++i) {
                const IrradianceEstimate& w = whole[texels[i]];
                EXPECT_EQ(std::memcmp(&part[i].irradiance, &w.irradiance, sizeof(vec3)), 0) << texels[i];
                EXPECT_EQ(part[i].samples, w.samples) << texels[i];
                EXPECT_EQ(part[i].varianceOfMean, w.varianceOfMean) << texels[i];
            }
        }
    }
}

/// Points of a texel are tested one by one, under a closed box and under a single-sided shell without a bottom that
/// does not touch the floor.
TEST(TexelValidityS6, EachPointOfATexelByItself)
{
    for (const bool closed : {true, false}) {
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, grey, kPage, {vec2(2), vec2(22)});
        const float lift = closed ? 0.0f : 0.001f;
        addBox(scene, vec3(-0.43f, lift, -0.37f), vec3(0.36f, 0.8f, 0.44f), grey, false);
        if (!closed) scene.objects.erase(scene.objects.end() - 2); // the face at the bottom
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
        const PathTracer paths(bench.scene, bench.geometry, LightUse::Bake, Bounces::Diffuse, embreeKernels());
        const TexelValidity validity(paths);
        int under = 0;
        int mixed = 0;
        for (const Texel& texel : bench.map.texels) {
            TexelPoints points;
            const int count = texelPoints(bench.geometry, bench.map, texel, points);
            uint64_t rays = 0;
            const PointMask mask = validity.validPoints(points, count, texelId(bench.map, texel), rays);
            int outside = 0;
            PointMask expected = 0;
            for (int p = 0; p < count; ++p) {
                const vec3 at = points[std::size_t(p)].position;
                const bool inside = at.x > -0.43f && at.x < 0.36f && at.z > -0.37f && at.z < 0.44f;
                if (!inside) expected = PointMask(expected | (1u << p));
                outside += inside ? 0 : 1;
            }
            if (outside * 8 < count) expected = 0;
            EXPECT_EQ(mask, expected) << (closed ? "box" : "shell") << " at texel " << texel.x << ", " << texel.y;
            under += outside == 0 ? 1 : 0;
            mixed += outside > 0 && outside < count ? 1 : 0;
        }
        EXPECT_GT(under, 40);
        EXPECT_GT(mixed, 20);
    }
}

/// A strip one texel wide, whose middle lies in the plane of a box's bottom: half of each texel is inside the box. In
/// that plane a ray can miss the bottom, so that points on both sides of it would seem to be together.
TEST(TexelValidityS6, PlanesThroughTheMiddleOfAStrip)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-2, -0.1f, 0), vec3(4, 0, 0), vec3(0, 0.2f, 0)}, grey, kPage,
                 {vec2(2.0f), vec2(22.0f, 2.95f)});
    addBox(scene, vec3(-3, 0, -0.1f), vec3(3, 1, 0.1f), grey, false);
    joinObjects(scene, 1);
    const Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    ASSERT_GE(bench.map.texels.size(), 20u);
    for (const Texel& texel : bench.map.texels) {
        TexelPoints points;
        const int count = texelPoints(bench.geometry, bench.map, texel, points);
        PointMask expected = 0;
        for (int p = 0; p < count; ++p)
            if (points[std::size_t(p)].position.y < 0.0f) expected = PointMask(expected | (1u << p));
        EXPECT_EQ(texel.validPoints, expected) << "texel " << texel.x << ", " << texel.y;
    }
}

} // namespace
} // namespace halflight::test::single_texels_test
