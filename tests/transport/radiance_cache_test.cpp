// The radiance cache against path tracing (spec S6).

#include "bake/seeds.h"
#include "bake/test_room.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "transport/sample/path_tracer.h"
#include "transport/texels/texel_validity.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace halflight::test::radiance_cache_test {
namespace {

constexpr int kPage = 64;

SameBake bakeOf(Scene scene, IntegratorKind kind, int samples, int bounces)
{
    IntegrationSettings settings;
    settings.integrator = kind;
    settings.samples = samples;
    settings.shadowSamples = 64;
    settings.bounces = bounces;
    return {std::move(scene), settings};
}

/// The mean is path tracing's, and no texel differs by more than the noise of both.
TEST(RadianceCacheS6, AgreesWithPathTracing)
{
    for (const auto& [lamp, sun, sky, bounces] : {std::array{1, 0, 0, 4}, {0, 1, 0, 1}, {0, 0, 1, 2}, {1, 1, 1, 4}}) {
        const auto reference = bakedBySeeds(bakeOf(room(lamp, sun, sky), IntegratorKind::Path, 24, bounces));
        const auto cached = bakedBySeeds(bakeOf(room(lamp, sun, sky), IntegratorKind::Cache, 32, bounces));
        SCOPED_TRACE(testing::Message() << "lamp " << lamp << " sun " << sun << " sky " << sky << " bounces "
                                        << bounces);
        expectSameMean(meanIrradiance(cached), meanIrradiance(reference), {.resolved = 0.01});
        const Difference d = difference(meanOverSeeds(cached), meanOverSeeds(reference));
        const double noise = std::sqrt(squaredNoise(cached) + squaredNoise(reference));
        const double mean = meanLuminance(meanOverSeeds(reference));
        EXPECT_LT(d.rmse, 1.25 * noise / mean);
        EXPECT_LT(std::abs(d.momentBias), 0.02);
    }
}

/// A white hallway with a lamp at one end: light reaches the other by many bounces. The mean is the same for few and
/// for many samples, and is path tracing's; four bounces lose a third of it.
TEST(RadianceCacheS6, LightHasConvergedWhateverTheEffort)
{
    const auto hallway = [] {
        Scene scene;
        addBox(scene, vec3(-1, 0, 0), vec3(1, 2.2f, 4), addMaterial(scene, vec3(0.88f)), true, kPage);
        const int glow = addMaterial(scene, vec3(0.0f), vec3(12.0f));
        addRectangle(scene, {vec3(-0.3f, 2.1f, 0.5f), vec3(0.6f, 0, 0), vec3(0, 0, 0.6f)}, glow, kPage);
        return scene;
    };
    const auto meanOf = [&](IntegratorKind kind, int samples, int bounces) {
        return meanIrradiance(bakedBySeeds(bakeOf(hallway(), kind, samples, bounces)));
    };
    const SeedMean reference = meanOf(IntegratorKind::Path, 32, kAllBounces);
    const SeedMean few = meanOf(IntegratorKind::Cache, 16, kAllBounces);
    const SeedMean many = meanOf(IntegratorKind::Cache, 64, kAllBounces);
    // The cache's solution ends where 0.2 % of the light is left.
    expectSameMean(few, reference, {.resolved = 0.015, .bias = 0.002});
    expectSameMean(many, reference, {.resolved = 0.015, .bias = 0.002});
    expectSameMean(few, many, {.resolved = 0.015});
    EXPECT_LT(meanOf(IntegratorKind::Cache, 16, 4).mean, 0.75 * reference.mean);
}

/// A floor continues under a thin wall from daylight into a closed, dark room. No patch carries light through the wall.
TEST(RadianceCacheS6, NoLightUnderThinWalls)
{
    Scene scene;
    scene.sky = {vec3(1000), vec3(1000), vec3(1000)};
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, kPage, {vec2(1), vec2(32)});
    // Walls and a lid of zero thickness, inside texels of the floor.
    const vec3 lower(-1.03f, -0.1f, -1.07f);
    const vec3 upper(1.09f, 1.5f, 1.01f);
    const vec3 s = upper - lower;
    addRectangle(scene, {lower, vec3(s.x, 0, 0), vec3(0, s.y, 0)}, white, kPage, {vec2(34, 1), vec2(48, 15)});
    addRectangle(scene, {lower + vec3(0, 0, s.z), vec3(s.x, 0, 0), vec3(0, s.y, 0)}, white, kPage,
                 {vec2(34, 17), vec2(48, 31)});
    addRectangle(scene, {lower, vec3(0, 0, s.z), vec3(0, s.y, 0)}, white, kPage, {vec2(34, 33), vec2(48, 47)});
    addRectangle(scene, {lower + vec3(s.x, 0, 0), vec3(0, 0, s.z), vec3(0, s.y, 0)}, white, kPage,
                 {vec2(49, 1), vec2(63, 15)});
    addRectangle(scene, {lower + vec3(0, s.y, 0), vec3(s.x, 0, 0), vec3(0, 0, s.z)}, white, kPage,
                 {vec2(49, 17), vec2(63, 31)});
    IntegrationSettings settings;
    settings.samples = 128;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const auto estimates = bench.irradiance();
    double inside = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = bench.positionOf(bench.map.texels[i]);
        if (p.y != 0.0f || glm::max(std::abs(p.x), std::abs(p.z)) > 0.8f) continue;
        inside += double(estimates[i].irradiance.y);
        ++count;
    }
    ASSERT_GT(count, 20);
    EXPECT_LT(inside / count, 0.001 * 1000.0 * kPi);
}

/// Backs of a cloth, leaves without a lightmap and both sides of a thin wall have patches. The light is right, and few
/// rays continue as paths.
TEST(RadianceCacheS6, HasPatchesForBacksLeavesAndBothSidesOfAWall)
{
    Scene scene;
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    scene.lights.push_back(
        makeLight(LightType::Directional, vec3(0), vec3(-0.6f, -0.8f, -0.3f), 6.0f, LightMode::Mixed));
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    const int red = addMaterial(scene, vec3(0.7f, 0.2f, 0.1f), vec3(0.0f), true);
    const int green = addMaterial(scene, vec3(0.2f, 0.6f, 0.1f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, white, kPage, {vec2(1), vec2(33)});
    // The cloth's texels are on top; the floor receives light from its back.
    addRectangle(scene, {vec3(-1.9f, 1.2f, 1.9f), vec3(1.6f, 0, 0), vec3(0, 0.3f, -3.8f)}, red, kPage,
                 {vec2(35, 1), vec2(49, 31)});
    addRectangle(scene, {vec3(0.07f, -0.1f, -1.5f), vec3(0, 0, 3.0f), vec3(0, 0.9f, 0)}, white, kPage,
                 {vec2(1, 35), vec2(25, 43)});
    for (int i = 0; i < 150; ++i) {
        const auto random = [&](int k) { return unitFloat(hashCombine(uint32_t(i), uint32_t(k))); };
        const vec3 corner(0.6f + random(0), 0.1f + 0.8f * random(1), -0.8f + 1.6f * random(2));
        const vec3 along = 0.12f * glm::normalize(vec3(random(3), random(4), random(5)) - 0.5f);
        const vec3 across = 0.12f * glm::normalize(glm::cross(along, vec3(random(6), random(7), random(8))));
        addRectangle(scene, {corner, along, across}, green, kPage);
    }
    IntegrationSettings settings;
    settings.bounces = 3;
    settings.samples = 128;
    settings.shadowSamples = 16;
    Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settings);
    const auto cached = bench.irradiance();
    const uint64_t first = bench.integrator->raysTraced();
    bench.irradiance(); // with the cache as it is
    const double perSample =
        double(bench.integrator->raysTraced() - first) / (double(cached.size()) * double(settings.samples));
    EXPECT_LT(perSample, 1.1);
    const auto reference = bakeWith(scene, IntegratorKind::Path, 512, settings.bounces);
    const Difference d = difference(cached, reference);
    EXPECT_LT(std::abs(d.bias), 0.01);
    EXPECT_LT(d.rmse, 0.06);
}

/// A floor with boxes sunk into it. A board inside each, just above the floor, occludes the box's faces from the floor.
Bench solidsOnFloor(int page, Place place, std::span<const Bounds> boxes)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, page, place);
    for (const Bounds& box : boxes) {
        addBox(scene, box.min, box.max, white, false);
        const vec3 s = 0.98f * box.size();
        addRectangle(scene,
                     {vec3(box.min.x + 0.01f * s.x, 0.01f, box.min.z + 0.01f * s.z), vec3(s.x, 0, 0), vec3(0, 0, s.z)},
                     white, page);
    }
    return {std::move(scene), MixedLightingMode::Shadowmask, page, {}};
}

/// Points inside a solid are invalid, even where a surface inside occludes the solid's faces.
TEST(RadianceCacheS6, LeavesOutPointsInsideSolidsThatAreNotEmpty)
{
    const Bounds box{vec3(-1.03f, -0.5f, -1.07f), vec3(1.09f, 1.5f, 1.01f)};
    const Bench bench = solidsOnFloor(kPage, {vec2(1), vec2(33)}, std::span(&box, 1));
    int across = 0;
    for (const Texel& texel : bench.map.texels) {
        std::array<SurfacePoint, kMaxTexelPoints> points;
        const int count = texelPoints(bench.geometry, bench.map, texel, points);
        uint32_t outside = 0;
        for (int p = 0; p < count; ++p) {
            const vec3 at = points[std::size_t(p)].position;
            const bool inside = at.x > box.min.x && at.x < box.max.x && at.z > box.min.z && at.z < box.max.z;
            outside |= inside ? 0u : 1u << p;
        }
        const int left = std::popcount(outside);
        if (left == count || left * 8 < count) continue;
        ++across;
        EXPECT_EQ(texel.validPoints, outside) << "texel " << texel.x << ", " << texel.y;
    }
    EXPECT_GT(across, 12);
}

/// The stage finds the same valid points as the test of all points of all texels, in partly covered texels too.
void expectAllTested(const Bench& bench, int atLeast)
{
    const PathTracer paths(bench.scene, bench.geometry, LightUse::Bake, Bounces::Diffuse, embreeKernels());
    const TexelValidity validity(paths);
    int partly = 0;
    for (const Texel& texel : bench.map.texels) {
        TexelPoints points;
        const int count = texelPoints(bench.geometry, bench.map, texel, points);
        uint64_t rays = 0;
        const PointMask expected = validity.validPoints(points, count, texelId(bench.map, texel), rays);
        EXPECT_EQ(texel.validPoints, expected) << "texel " << texel.x << ", " << texel.y;
        partly += expected != kAllPoints ? 1 : 0;
    }
    EXPECT_GT(partly, atLeast);
}

TEST(TexelValidityS6, FindsPointsInsideSolidsAtTheRim)
{
    // Thin posts at the floor's rim, each at another place of its texel.
    constexpr float kTexel = 8.0f / 330.2f;
    std::vector<Bounds> boxes;
    for (int i = 0; i < 200; ++i) {
        const vec2 at(1.4f * float(i) + 10.0f, 330.2f - 0.6f + 0.04f * float(i % 11));
        const vec3 low(-4.0f + at.x * kTexel, -0.5f, -4.0f + at.y * kTexel);
        boxes.push_back({low, low + vec3(0.3f * kTexel, 2.0f, 0.3f * kTexel)});
    }
    expectAllTested(solidsOnFloor(512, {vec2(1.4f), vec2(331.6f)}, boxes), 100);
}

/// Thin posts without a bottom, with few points of a texel inside.
TEST(TexelValidityS6, FindsSinglePointsInsideShells)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int white = addMaterial(scene, vec3(0.8f));
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, 512, {vec2(4), vec2(340)});
    constexpr float kTexel = 8.0f / 336.0f;
    constexpr float kWidth = 0.3f * kTexel;
    for (int i = 0; i < 200; ++i) {
        const vec2 at(8.0f + 16.0f * float(i % 15) + 0.05f * float(i % 13), 8.0f + 16.0f * float(i / 15));
        const vec3 corner(-4.0f + at.x * kTexel, -0.1f, -4.0f + (at.y + 0.05f * float(i % 11)) * kTexel);
        const vec3 x(kWidth, 0, 0);
        const vec3 y(0, 1, 0);
        const vec3 z(0, 0, kWidth);
        for (const Rectangle& face : {Rectangle{corner, y, x}, Rectangle{corner + z, x, y}, Rectangle{corner, z, y},
                                      Rectangle{corner + x, y, z}, Rectangle{corner + y, z, x}}) {
            addRectangle(scene, face, white, 512);
        }
    }
    expectAllTested(Bench(std::move(scene), MixedLightingMode::Shadowmask, 512, {}), 100);
}

TEST(RadianceCacheS6, LargePatchesHaveTheirLight)
{
    // A floor with so many texels that patches are 4 x 4 texels wide, of which not all gather. A block stands on it,
    // and a wall beside it receives its light.
    constexpr int kSize = 704;
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10)}, grey, kSize, {vec2(2), vec2(662)});
    addRectangle(scene, {vec3(-5, 0, -5), vec3(10, 0, 0), vec3(0, 0.5f, 0)}, grey, kSize,
                 {vec2(2, 666), vec2(662, 699)});
    const std::size_t block = scene.meshes.size();
    addBox(scene, vec3(-2, -1, -2), vec3(1, 1, 2), grey, false);
    joinObjects(scene, block);
    IntegrationSettings settings;
    settings.samples = 16;
    settings.shadowSamples = 8;
    Bench bench(scene, MixedLightingMode::Shadowmask, kSize, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    settings.integrator = IntegratorKind::Path;
    settings.samples = 512;
    Bench truth(scene, MixedLightingMode::Shadowmask, kSize, settings);
    std::vector<uint32_t> chosen; // on the wall
    for (uint32_t i = 0; i < uint32_t(estimates.size()); ++i) {
        const vec3 at = bench.positionOf(bench.map.texels[i]);
        if (at.y > 0.01f && i % 64 == 0) chosen.push_back(i);
        // A texel is 15 mm wide.
        const float depth = std::min(1.5f - std::abs(at.x + 0.5f), 2.0f - std::abs(at.z));
        if (at.y > 0.01f || std::abs(depth) < 0.02f) continue;
        ASSERT_EQ(estimates[i].valid, depth < 0.0f) << at.x << ", " << at.z;
    }
    ASSERT_GT(chosen.size(), 200u);
    std::vector<IrradianceEstimate> traced(chosen.size());
    ASSERT_TRUE(truth.irradiance({chosen}, traced));
    double sum = 0.0;
    double expected = 0.0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        sum += double(estimates[chosen[i]].irradiance.y);
        expected += double(traced[i].irradiance.y);
    }
    EXPECT_NEAR(sum, expected, 0.01 * expected);
}

/// Processors without AVX have no instructions for packets. Rays that meet nothing must not be traced there, whatever
/// they contain, and the others of their batch have the same hits.
TEST(RaysS6, RaysOutOfUseAreLeftAloneOnAllProcessors)
{
    const Scene scene = room(true, true, true);
    const Bench bench(scene, MixedLightingMode::Shadowmask, kPage, {});
    const RayTracer tracer(bench.scene, bench.geometry, embreeKernels());
    const RayTracer old(bench.scene, bench.geometry, embreeKernels(InstructionSet::Sse2));
    ASSERT_TRUE(tracer.ok() && old.ok());
    int hits = 0;
    int blocked = 0;
    for (uint32_t batch = 0; batch < 64; ++batch) {
        constexpr vec3 kNoNumbers(std::numeric_limits<float>::quiet_NaN());
        std::array<Ray, 11> rays; // more than a packet
        rays.fill({kNoNumbers, 0.0f, kNoNumbers, -1.0f});
        for (uint32_t i = 0; i < rays.size(); ++i) {
            Sampler sampler(1, batch, i);
            if (sampler.next1() >= 0.6f) continue;
            rays[i] = {bench.positionOf(bench.map.texels[batch * 7]) + vec3(0, 0.5f, 0), 0.0f,
                       shading::sampleSphere(sampler.next2()), kInfinity};
        }
        std::array<RayHit, 11> found;
        std::array<RayHit, 11> same;
        ASSERT_TRUE(tracer.kernels().nearest(rays, found) && old.kernels().nearest(rays, same));
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (found[i].found()) rays[i].tMax = 1.5f * found[i].distance;
        }
        std::array<bool, 11> shadows{};
        std::array<bool, 11> sameShadows{};
        ASSERT_TRUE(tracer.kernels().occluded(rays, shadows) && old.kernels().occluded(rays, sameShadows));
        EXPECT_EQ(shadows, sameShadows);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(found[i].found(), same[i].found());
            EXPECT_EQ(found[i].found(), shadows[i]);
            blocked += shadows[i] ? 1 : 0;
            if (!found[i].found()) continue;
            ++hits;
            EXPECT_TRUE(rays[i].tMax > 0.0f) << "a ray out of use was traced";
            EXPECT_EQ(found[i].face.hitIndex, same[i].face.hitIndex);
            EXPECT_NEAR(found[i].distance, same[i].distance, 1.0e-4f);
        }
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(blocked, 100);
}

TEST(RadianceCacheS6, ThreadsChangeNoBit)
{
    std::vector<IrradianceEstimate> first;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        const auto estimates = bakeWith(room(true, true, true), IntegratorKind::Cache, 64, 3, 0.05f);
        if (first.empty()) first = estimates;
        for (std::size_t i = 0; i < first.size(); ++i) {
            ASSERT_EQ(std::memcmp(&first[i].irradiance, &estimates[i].irradiance, sizeof(vec3)), 0) << i;
            ASSERT_EQ(first[i].samples, estimates[i].samples);
        }
    }
}

} // namespace
} // namespace halflight::test::radiance_cache_test
