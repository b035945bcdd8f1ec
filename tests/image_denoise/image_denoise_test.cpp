// Open Image Denoise (S6): what is handed to the library and what becomes of its answer, with a stand-in in its place
// (oidn_stand_in/), as few distributions' machines have it.

#include "bake/denoise/denoise.h"
#include "halflight/bake/bake.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/scene/gltf.h"

#include <OpenImageDenoise/oidn.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

namespace halflight {
namespace {

/// Rectangles of texels, each a chart of its own, and estimates of them.
class ImageDenoiseS6 : public testing::Test {
protected:
    void SetUp() override
    {
        oidn::standIn = {};
        map_.pageSize = 128;
        map_.pageCount = 1;
    }
    template<typename Light> void addChart(ivec2 corner, ivec2 size, const Light& light)
    {
        for (int y = corner.y; y < corner.y + size.y; ++y) {
            for (int x = corner.x; x < corner.x + size.x; ++x) {
                map_.texels.push_back({.x = uint16_t(x), .y = uint16_t(y), .chart = map_.chartCount});
                gathered_.push_back(light(x, y));
                IrradianceEstimate e;
                e.valid = true;
                e.direct = vec3(2.0f);
                e.irradiance = e.direct + vec3(5.0f);
                e.moment = vec3(1.0f, 2.0f, 3.0f);
                estimates_.push_back(e);
            }
        }
        ++map_.chartCount;
    }
    Status denoiseAll() { return imageDenoise(map_, gathered_, estimates_, {}); }
    [[nodiscard]] vec3 gatheredOf(std::size_t i) const { return estimates_[i].irradiance - estimates_[i].direct; }

    TexelMap map_;
    std::vector<vec3> gathered_;
    std::vector<IrradianceEstimate> estimates_;
};

float checkers(int x, int y)
{
    return (x + y) % 2 == 0 ? 9.0f : 11.0f;
}

TEST_F(ImageDenoiseS6, ReplacesWhatIsGatheredAndKeepsDirectLightAndDirections)
{
    addChart({20, 30}, {24, 12}, [](int x, int y) { return vec3(checkers(x, y)); });
    ASSERT_TRUE(denoiseAll());
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
        const IrradianceEstimate& e = estimates_[i];
        ASSERT_EQ(e.direct, vec3(2.0f));
        // The mean of 3 x 3 checkers is a ninth off; at the rim extended texels take part.
        ASSERT_NEAR(gatheredOf(i).x, 10.0f, 0.45f);
        const vec3 direction = glm::normalize(e.moment);
        ASSERT_NEAR(glm::dot(direction, glm::normalize(vec3(1.0f, 2.0f, 3.0f))), 1.0f, 1.0e-5f);
        ASSERT_NEAR(glm::length(e.moment) / luminance(e.irradiance), std::sqrt(14.0f) / 7.0f, 1.0e-4f);
    }
}

TEST_F(ImageDenoiseS6, ChartsSideBySideDoNotMix)
{
    addChart({10, 10}, {16, 16}, [](int, int) { return vec3(1.0f); });
    addChart({26, 10}, {16, 16}, [](int, int) { return vec3(1000.0f); });
    ASSERT_TRUE(denoiseAll());
    EXPECT_EQ(oidn::standIn.executions.size(), 2u);
    for (std::size_t i = 0; i < estimates_.size(); ++i)
        ASSERT_NEAR(gatheredOf(i).x / (i < 256 ? 1.0f : 1000.0f), 1.0f, 1.0e-4f) << i;
}

TEST_F(ImageDenoiseS6, TexelsInsideGeometryDoNotCount)
{
    addChart({0, 0}, {16, 16}, [](int, int) { return vec3(1.0f); });
    for (const std::size_t inside : {0u, 17u, 100u, 101u, 255u}) {
        estimates_[inside].valid = false;
        gathered_[inside] = vec3(1.0e6f);
    }
    ASSERT_TRUE(denoiseAll());
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
        ASSERT_NEAR(gatheredOf(i).x, estimates_[i].valid ? 1.0f : 5.0f, 1.0e-4f) << i;
    }
}

TEST_F(ImageDenoiseS6, ChartsOfAllSizesAreSeenAtOneScaleWithRoomAroundThem)
{
    addChart({0, 0}, {16, 16}, [](int, int) { return vec3(0.5f); });
    addChart({20, 0}, {100, 40}, [](int, int) { return vec3(8.0f); });
    addChart({0, 100}, {5, 20}, [](int x, int y) { return vec3(checkers(x, y)); }); // too narrow
    ASSERT_TRUE(denoiseAll());
    ASSERT_EQ(oidn::standIn.executions.size(), 2u);
    double mean = 0.0;
    for (const vec3 g : gathered_) mean += double(luminance(g)) / double(gathered_.size());
    for (const oidn::StandIn::Execution& e : oidn::standIn.executions)
        EXPECT_NEAR(double(e.scale) * mean, 0.18, 1.0e-5);
    EXPECT_GE(oidn::standIn.executions[0].width, 16u + 32u);
    EXPECT_GE(oidn::standIn.executions[1].width, 100u + 32u);
    EXPECT_GE(oidn::standIn.executions[1].height, 40u + 32u);
    EXPECT_EQ(gatheredOf(estimates_.size() - 1).x, 5.0f) << "what the built-in denoiser made of it";
}

TEST_F(ImageDenoiseS6, WhatTheLibraryCannotDoIsSaid)
{
    addChart({0, 0}, {16, 16}, [](int, int) { return vec3(1.0f); });
    oidn::standIn.fails = true;
    const Status failed = denoiseAll();
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().message, "Open Image Denoise: out of luck");
    oidn::standIn = {.hasDevice = false};
    const Status none = denoiseAll();
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, ErrorCode::DeviceFailed);
    oidn::standIn = {.hasFilter = false};
    const Status other = denoiseAll();
    ASSERT_FALSE(other);
    EXPECT_THAT(other.error().message, testing::HasSubstr("no filter for lightmaps"));
    oidn::standIn = {};
    const std::atomic<bool> cancel = true;
    Progress cancelled;
    cancelled.cancel = &cancel;
    const Status stopped = imageDenoise(map_, gathered_, estimates_, cancelled);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, ErrorCode::Cancelled);
    for (std::size_t i = 0; i < estimates_.size(); ++i) ASSERT_EQ(gatheredOf(i).x, 5.0f);
}

TEST_F(ImageDenoiseS6, ABakeUsesItWhereAsked)
{
    Result<Scene> scene = readScene(HALFLIGHT_SOURCE_DIR "/assets/tests/sphere_on_floor.glb");
    ASSERT_TRUE(scene);
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 64;
    settings.samples = 4;
    const Result<BakeResult> usual = bake(*scene, settings, makeEmbreeIntegrator);
    ASSERT_TRUE(usual);
    EXPECT_TRUE(oidn::standIn.executions.empty());
    settings.denoiser = Denoiser::OpenImage;
    const Result<BakeResult> other = bake(*scene, settings, makeEmbreeIntegrator);
    ASSERT_TRUE(other);
    EXPECT_FALSE(oidn::standIn.executions.empty());
    EXPECT_NE(usual->baked.lightmaps[0].texels(), other->baked.lightmaps[0].texels());
    oidn::standIn = {.fails = true};
    const Result<BakeResult> failed = bake(*scene, settings, makeEmbreeIntegrator);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::DeviceFailed);
}

} // namespace
} // namespace halflight
