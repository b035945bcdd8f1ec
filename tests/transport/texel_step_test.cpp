// Interpolated texels: which they are, and their error (spec S6). Validity of sample points.

#include "bake/geometry/flatten.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"

#include "bake_cpu/trace/embree_kernels.h"
#include "transport/lightmap/cached_lightmap.h"
#include "transport/texels/sparse_grid.h"
#include "transport/texels/texel_validity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <utility>

namespace halflight::test::texel_step_test {
namespace {

constexpr int kPage = 64;
constexpr float kMeters = 4.0f; ///< width of the floor, on which a texel is 1/15 m wide

/// A floor with a box on it, under a sky. Optionally a blade halfway up shades a part of it from a small lamp.
Scene floorWithBox(bool lamp)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.6f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(kMeters, 0, 0), vec3(0, 0, -kMeters)}, grey, kPage, {vec2(2), vec2(62)});
    addBox(scene, vec3(-1.5f, 0.0f, -1.5f), vec3(-0.9f, 0.6f, -0.9f), grey, false);
    if (lamp) {
        const int glow = addMaterial(scene, vec3(0.0f), vec3(20000.0f));
        addRectangle(scene, {vec3(0.98f, 2.4f, 0.98f), vec3(0.04f, 0, 0), vec3(0, 0, 0.04f)}, glow, kPage);
        addRectangle(scene, {vec3(0.85f, 1.6f, 1.15f), vec3(0.3f, 0, 0), vec3(0, 0, -0.3f)}, grey, kPage);
    }
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    return scene;
}

IntegrationSettings settingsWith(int step, int samples, float noise = 0.0f)
{
    IntegrationSettings settings;
    settings.samples = samples;
    settings.bounces = 2;
    settings.cache.texelStep = step;
    settings.cache.noiseTarget = noise;
    return settings;
}

struct Comparison {
    double error = 0.0; ///< root mean square, over the truth's mean
    double largest = 0.0;
    int count = 0;
};
/// Error of traced or of interpolated texels.
Comparison compare(const std::vector<IrradianceEstimate>& estimates, const std::vector<IrradianceEstimate>& truth,
                   bool traced)
{
    Comparison c;
    double mean = 0.0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        if (!estimates[i].valid || (estimates[i].samples > 0) != traced) continue;
        const auto t = double(luminance(truth[i].irradiance));
        const double difference = double(luminance(estimates[i].irradiance)) - t;
        c.error += difference * difference;
        c.largest = std::max(c.largest, std::abs(difference) / t);
        mean += t;
        ++c.count;
    }
    c.error = std::sqrt(c.error / c.count) / (mean / c.count);
    return c;
}

TEST(TexelStepS6, OpenFloorIsInterpolatedAndRight)
{
    const auto truth =
        Bench(floorWithBox(false), MixedLightingMode::Shadowmask, kPage, settingsWith(1, 4096)).irradiance();
    EXPECT_EQ(compare(truth, truth, false).count, 0);
    int before = 0;
    for (const int step : {2, 4}) {
        Bench bench(floorWithBox(false), MixedLightingMode::Shadowmask, kPage, settingsWith(step, 1024));
        const auto estimates = bench.irradiance();
        const Comparison traced = compare(estimates, truth, true);
        const Comparison between = compare(estimates, truth, false);
        EXPECT_GT(between.count, before + 200) << "step " << step;
        before = between.count;
        // The mean of two or four anchors has about the noise of a traced texel, which takes more samples where noise
        // is large.
        EXPECT_LT(between.error, 1.2 * traced.error) << "step " << step;
        EXPECT_LT(between.error, 0.005) << "step " << step;
        EXPECT_LT(between.largest, 0.025) << "step " << step; // the truth has noise of 0.005
        // Beside the box irradiance is not linear, so all texels are traced. Texels under the box are invalid.
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const vec3 p = bench.positionOf(bench.map.texels[i]);
            const vec2 beyond = glm::max(glm::abs(vec2(p.x, p.z) + 1.2f) - 0.3f, vec2(0.0f));
            if (glm::length(beyond) < 1.5f * kMeters / 60.0f && estimates[i].valid) EXPECT_GT(estimates[i].samples, 0u);
        }
    }
}

/// The edges of a small lamp's shadow are sharp, although the texels there are interpolated.
TEST(TexelStepS6, ShadowsOfEmittersStaySharp)
{
    const auto truth =
        Bench(floorWithBox(true), MixedLightingMode::Shadowmask, kPage, settingsWith(1, 1024)).irradiance();
    const auto estimates =
        Bench(floorWithBox(true), MixedLightingMode::Shadowmask, kPage, settingsWith(2, 256)).irradiance();
    double darkest = 1.0e9;
    double brightest = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const auto t = double(luminance(truth[i].irradiance));
        darkest = std::min(darkest, t);
        brightest = std::max(brightest, t);
        if (!estimates[i].valid || estimates[i].samples > 0) continue;
        ++count;
        EXPECT_NEAR(double(luminance(estimates[i].irradiance)), t, 0.1 * t) << i;
    }
    EXPECT_GT(count, 500);
    EXPECT_GT(brightest, 2.0 * darkest);
}

/// A texel's estimate does not depend on the other texels of the request.
TEST(TexelStepS6, PartsAreLikeTheWhole)
{
    for (const float noise : {0.0f, 0.03f}) {
        Bench bench(floorWithBox(true), MixedLightingMode::Shadowmask, kPage,
                    settingsWith(4, noise > 0.0f ? 256 : 32, noise));
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

/// Two halves of a strip that meet at an angle, on one chart.
Scene bentStrip(float degrees)
{
    Scene scene;
    const float angle = glm::radians(degrees);
    MeshPart part;
    const vec3 far(1.0f + std::cos(angle), std::sin(angle), 0.0f);
    part.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {0, 0, -1}, far, far + vec3(0, 0, -1)};
    part.normals = {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}};
    part.normals[4] = part.normals[5] = vec3(-std::sin(angle), std::cos(angle), 0.0f);
    part.normals[1] = part.normals[2] = glm::normalize(part.normals[0] + part.normals[4]);
    part.uv[0].assign(6, vec2(0.0f));
    part.indices = {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2};
    part.material = addMaterial(scene, vec3(0.5f));
    for (const vec2 t : {vec2(4, 4), vec2(20, 4), vec2(20, 20), vec2(4, 20), vec2(36, 4), vec2(36, 20)})
        part.lightmapUv.push_back(t / float(kPage));
    Object object;
    object.mesh = 0;
    object.lightmap.page = 0;
    scene.meshes.emplace_back();
    scene.meshes.back().parts.push_back(part);
    scene.objects.push_back(object);
    return scene;
}

TEST(TexelStepS6, InterpolatesOnSmoothSurfacesOfOneChartAlone)
{
    const auto anchorsAt = [](float degrees, int x, int y, int step) {
        const Scene scene = bentStrip(degrees);
        const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        const TexelMap map = rasterizeTexels(geometry, kPage, 1);
        const TexelGrid grid(map);
        const SparseGrid sparse(geometry, map, grid, step);
        for (uint32_t i = 0; i < map.texels.size(); ++i) {
            if (map.texels[i].x != x || map.texels[i].y != y) continue;
            SparseGrid::Anchors anchors;
            if (!sparse.anchorsOf(i, anchors)) return 0;
            for (int k = 0; k < anchors.count; ++k) {
                const Texel& t = map.texels[anchors.texels[std::size_t(k)]];
                EXPECT_EQ(std::max(std::abs(int(t.x) - x), std::abs(int(t.y) - y)), sparse.spacingOf(i));
                EXPECT_GT(sparse.spacingOf(anchors.texels[std::size_t(k)]), sparse.spacingOf(i));
            }
            return anchors.count;
        }
        ADD_FAILURE() << "no texel at " << x << ", " << y;
        return -1;
    };
    EXPECT_EQ(anchorsAt(0.0f, 10, 10, 2), 0); // on the sparse grid
    EXPECT_EQ(anchorsAt(0.0f, 11, 10, 2), 2);
    EXPECT_EQ(anchorsAt(0.0f, 10, 11, 2), 2);
    EXPECT_EQ(anchorsAt(0.0f, 11, 11, 2), 4);
    EXPECT_EQ(anchorsAt(0.0f, 10, 10, 4), 4);
    EXPECT_EQ(anchorsAt(0.0f, 11, 11, 1), 0);
    EXPECT_EQ(anchorsAt(0.0f, 35, 10, 2), 0); // its neighbour would be beyond the chart
    // Across the fold, whose normals are interpolated: 20 degrees are smooth, 90 degrees are a corner.
    EXPECT_EQ(anchorsAt(20.0f, 19, 10, 2), 2);
    EXPECT_EQ(anchorsAt(90.0f, 19, 10, 2), 0);
    EXPECT_EQ(anchorsAt(90.0f, 21, 10, 2), 2);
}

TEST(TexelStepS6, LargeMapsHaveOneOfTheirOwn)
{
    TexelMap map;
    map.texels.resize(400'000);
    EXPECT_EQ(texelStepOf({}, map), 1);
    map.texels.emplace_back();
    EXPECT_EQ(texelStepOf({}, map), 2);
    for (const int step : {1, 2, 4}) EXPECT_EQ(texelStepOf(settingsWith(step, 16), map), step);
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

} // namespace
} // namespace halflight::test::texel_step_test
