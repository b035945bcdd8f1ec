// A device that is lost while a bake traces: every stage returns its error, and the cache keeps nothing of what
// follows.

#include "bake/same_bakes.h"
#include "bake/test_room.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "base/temp_folder.h"
#include "transport/ray_integrator.h"

#include "halflight/bake/bake.h"
#include "halflight/bake/farm.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>

namespace halflight::test::device_loss_test {
namespace {

constexpr int kPage = 64;
constexpr int64_t kNever = std::numeric_limits<int64_t>::max() / 2;

/// Calls until the device is lost; it counts down.
using CallsLeft = std::shared_ptr<std::atomic<int64_t>>;

/// Embree, which fails from some call on.
class FailingKernels final : public RayKernels {
public:
    FailingKernels(std::unique_ptr<RayKernels> embree, CallsLeft left)
        : embree_(std::move(embree)), left_(std::move(left))
    {}
    Status nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use) const override
    {
        return works() ? embree_->nearest(rays, out, use) : lost();
    }
    Status occluded(std::span<const Ray> rays, std::span<bool> out) const override
    {
        return works() ? embree_->occluded(rays, out) : lost();
    }
    Status transmittance(std::span<const Ray> rays, std::span<vec3> out) const override
    {
        return works() ? embree_->transmittance(rays, out) : lost();
    }
    Status crossings(std::span<const Ray> rays, std::span<int> out) const override
    {
        return works() ? embree_->crossings(rays, out) : lost();
    }
    [[nodiscard]] std::string describe(const std::string& method) const override { return embree_->describe(method); }
    [[nodiscard]] std::size_t peakBytes() const override { return embree_->peakBytes(); }

private:
    [[nodiscard]] bool works() const { return left_->fetch_sub(1) > 0; }
    static Status lost() { return Error{ErrorCode::DeviceFailed, "the device was lost"}; }

    std::unique_ptr<RayKernels> embree_;
    CallsLeft left_;
};

MakeKernels failingKernels(const CallsLeft& left)
{
    return [left](const RayScene& scene) { return std::make_unique<FailingKernels>(embreeKernels()(scene), left); };
}

IntegratorFactory failingIntegrators(const CallsLeft& left)
{
    IntegratorFactory factory = embreeIntegrators();
    factory.make = [left](const Scene& scene, const BakeGeometry& geometry,
                          const IntegrationSettings& settings) -> Result<std::unique_ptr<Integrator>> {
        return makeRayIntegrator(scene, geometry, settings, failingKernels(left));
    };
    return factory;
}

/// A room with a sun, and a sheet in it.
Scene furnishedRoom()
{
    Scene scene = room(true, true, false);
    const int cloth = addMaterial(scene, vec3(0.5f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-0.9f, 0.3f, 0.5f), vec3(0.8f, 0, 0), vec3(0, 0.6f, 0)}, cloth, kPage);
    return scene;
}

/// One verb of an integrator, or a group of them that depend on one another.
struct Verb {
    const char* name;
    std::function<Status(Integrator&, TexelMap&)> call;
};

std::vector<Verb> verbs()
{
    static const std::vector<vec3> kPlaces = {vec3(0, 1.5f, 0), vec3(0.7f, 0.5f, 0.5f)};
    static const std::vector<SurfacePoint> kPoints = {
        {vec3(-0.6f, 1, -1), vec3(0, 0, 1), vec3(0, 0, 1), 4, vec2(0.2f)}};
    const auto lightmap = [](bool rough) {
        return [rough](Integrator& integrator, TexelMap& map) {
            std::vector<IrradianceEstimate> out(map.texels.size());
            const std::vector<uint32_t> all = allIndices(out.size());
            return integrator.prepare(map, nullptr)->irradiance({all, 16, 8, rough}, out, {});
        };
    };
    return {
        {"validity", [](Integrator& i, TexelMap& map) { return i.findValidPoints(map, nullptr, {}); }},
        {"validity of points",
         [](Integrator& i, TexelMap&) {
             std::vector<uint8_t> open(kPoints.size(), 1);
             return i.findValidPoints(kPoints, open);
         }},
        {"irradiance", lightmap(false)},
        {"rough irradiance", lightmap(true)},
        {"prepareAll", [](Integrator& i, TexelMap& map) { return i.prepare(map, nullptr)->prepareAll({}); }},
        {"shadowmask",
         [](Integrator& i, TexelMap& map) {
             std::vector<vec4> out(map.texels.size());
             return i.shadowmask(map, {allIndices(out.size())}, 0, out, {});
         }},
        {"probes",
         [](Integrator& i, TexelMap&) {
             std::vector<ProbeEstimate> out(kPlaces.size());
             return i.probes(kPlaces, allIndices(out.size()), 16, out, {});
         }},
        {"radianceAround",
         [](Integrator& i, TexelMap&) {
             const std::vector<ImageRgb32f> pages(1, ImageRgb32f(kPage, kPage));
             ImageRgb32f map(8, 8);
             return i.radianceAround(kPlaces[0], pages, 2, map, {});
         }},
        {"sides",
         [](Integrator& i, TexelMap&) {
             std::vector<SideEstimate> out(kPoints.size());
             return i.sides(kPoints, kPlaces, 4, 4, out, {});
         }},
        {"specularLight",
         [](Integrator& i, TexelMap&) {
             std::vector<SpecularEstimate> out(kPoints.size());
             const vec3 view(0, 0, 1);
             return i.specularLight(kPoints, {&view, 1}, out, {});
         }},
        {"surfacesAlong",
         [](Integrator& i, TexelMap&) {
             const Segment segment{kPlaces[0], vec3(0, -1, 0)};
             std::optional<vec2> out;
             return i.surfacesAlong({&segment, 1}, {&out, 1});
         }},
    };
}

/// Whichever of its calls is the first to fail, a verb returns the error, and so do all verbs after it.
TEST(DeviceLossS6, EachVerbReturnsTheError)
{
    Bench bench(furnishedRoom(), MixedLightingMode::Shadowmask, kPage, {});
    for (const Verb& verb : verbs()) {
        const auto left = std::make_shared<std::atomic<int64_t>>(kNever);
        const auto make = [&] { return makeRayIntegrator(bench.scene, bench.geometry, {}, failingKernels(left)); };
        TexelMap map = bench.map;
        ASSERT_TRUE(verb.call(*make(), map)) << verb.name;
        const int64_t calls = kNever - left->load();
        ASSERT_GT(calls, 0) << verb.name;
        for (const int64_t after : {int64_t(0), calls / 3, calls / 2, calls - 1}) {
            const std::unique_ptr<Integrator> integrator = make();
            *left = after;
            const Status status = verb.call(*integrator, map);
            ASSERT_FALSE(status) << verb.name << " after " << after << " of " << calls;
            EXPECT_EQ(status.error().code, ErrorCode::DeviceFailed) << verb.name;
            EXPECT_EQ(status.error().message, "the device was lost") << verb.name;
            *left = kNever;
            EXPECT_FALSE(integrator->findValidPoints(map, nullptr, {})) << verb.name << ": a lost device came back";
        }
    }
}

struct LostBakes : testing::Test {
    LostBakes()
    {
        settings.samples = 16;
        settings.shadowSamples = 8;
        settings.lightmapSize = 64;
        settings.bounces = 2;
        settings.probeSpacingMeters = 2.0f;
        settings.cacheDirectory = folder / "cache";
    }

    TempFolder folder;
    const CallsLeft left = std::make_shared<std::atomic<int64_t>>(kNever);
    BakeSettings settings;
};

/// The next bake with the same cache has the bytes of one without a loss.
TEST_F(LostBakes, LeaveNothingWrongInTheCacheS6)
{
    const IntegratorFactory failing = failingIntegrators(left);
    BakeSettings alone = settings;
    alone.cacheDirectory.clear();
    const Result<BakeResult> whole = bake(furnishedRoom(), alone, failing, {});
    ASSERT_TRUE(whole) << whole.error().text();
    const int64_t calls = kNever - left->load();
    constexpr int64_t kMoments = 6;
    for (int64_t moment = 0; moment <= kMoments; ++moment) {
        const int64_t after = std::min(calls * moment / kMoments, calls - 1);
        SCOPED_TRACE(std::to_string(after) + " of " + std::to_string(calls));
        std::filesystem::remove_all(settings.cacheDirectory);
        *left = after;
        const Result<BakeResult> lost = bake(furnishedRoom(), settings, failing, {});
        ASSERT_FALSE(lost);
        EXPECT_EQ(lost.error().code, ErrorCode::DeviceFailed) << lost.error().text();
        *left = kNever;
        const Result<BakeResult> again = bake(furnishedRoom(), settings, failing, {});
        ASSERT_TRUE(again) << again.error().text();
        expectSameBakes(whole->baked, again->baked);
    }
}

/// A worker of a farm ends with the error, and its stage does not count as complete.
TEST_F(LostBakes, EndAFarmsWorkerS6)
{
    const IntegratorFactory failing = failingIntegrators(left);
    const Result<FarmBake> planned = planFarm(furnishedRoom(), settings, failing, {});
    ASSERT_TRUE(planned) << planned.error().text();
    FarmWork work;
    work.stage = FarmStage::Cache;
    *left = kNever;
    const std::filesystem::path kept = folder / "kept";
    std::filesystem::copy(settings.cacheDirectory, kept, std::filesystem::copy_options::recursive);
    ASSERT_TRUE(workOnFarm(furnishedRoom(), settings, *planned, work, false, failing, {}));
    const int64_t calls = kNever - left->load();
    for (const int64_t after : {int64_t(0), calls / 8, calls / 4, calls / 2, calls - 1}) {
        std::filesystem::remove_all(settings.cacheDirectory);
        std::filesystem::copy(kept, settings.cacheDirectory, std::filesystem::copy_options::recursive);
        *left = after;
        const auto report = workOnFarm(furnishedRoom(), settings, *planned, work, false, failing, {});
        ASSERT_FALSE(report) << after << " of " << calls;
        EXPECT_EQ(report.error().code, ErrorCode::DeviceFailed) << report.error().text();
        EXPECT_FALSE(isFarmCacheComplete(settings.cacheDirectory, *planned));
    }
}

} // namespace
} // namespace halflight::test::device_loss_test
