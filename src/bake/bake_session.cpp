#include "halflight/bake/bake_session.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

namespace halflight {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Texels of the coarse bake along a side for each of the finished one: a 64th of the texels.
constexpr int kCoarser = 8;
constexpr int kSmallestCoarsePage = 64;
/// The fewest that the denoiser makes a smooth picture of.
constexpr int kCoarseSamples = 16;
constexpr int kCoarseShadowSamples = 8;

} // namespace

BakeSettings coarseSettings(const BakeSettings& settings)
{
    BakeSettings coarse = settings;
    coarse.quality = Quality::Preview;
    coarse.samples = kCoarseSamples;
    coarse.shadowSamples = kCoarseShadowSamples;
    coarse.noiseTarget = 0.0f;
    coarse.denoiser = Denoiser::BuiltIn;
    coarse.lightmapSize = std::max(resolveQuality(settings).lightmapSize / kCoarser, kSmallestCoarsePage);
    coarse.texelsPerMeter = settings.texelsPerMeter / kCoarser;
    coarse.maskEncoding = MaskEncoding::Attenuation;
    coarse.probeLayout = ProbeLayout::Grid;
    coarse.reflectionProbes = false;
    coarse.imagesDirectory.clear();
    coarse.cacheDirectory.clear();
    return coarse;
}

struct BakeSession::Impl {
    void run(Scene scene, const BakeSettings& settings, const IntegratorFactory& factory)
    {
        Result<BakeResult> coarse = bake(scene, coarseSettings(settings), factory, progressOf("first light: "));
        // A coarse bake that fails says nothing new: the other one fails alike, or needs no first light.
        if (coarse && !cancelled) {
            const std::lock_guard lock(mutex);
            light = std::move(coarse->baked);
        }
        Result<BakeResult> baked = bake(std::move(scene), settings, factory, progressOf(""));
        const std::lock_guard lock(mutex);
        result = std::move(baked);
        state.finished = true;
        state.seconds = secondsSince(start);
    }

    Progress progressOf(std::string prefix)
    {
        Progress progress;
        progress.cancel = &cancelled;
        progress.report = [this, prefix = std::move(prefix)](std::string_view stage, double fraction) {
            const std::string name = prefix + std::string(stage);
            const std::lock_guard lock(mutex);
            if (name != state.stage) stageStart = Clock::now();
            state.stage = name;
            state.fraction = fraction;
        };
        return progress;
    }

    const Clock::time_point start = Clock::now();
    std::atomic<bool> cancelled = false;
    mutable std::mutex mutex; ///< guards what follows
    Clock::time_point stageStart = start;
    BakeSessionState state;
    std::optional<BakedScene> light;
    std::optional<Result<BakeResult>> result;
    std::thread thread; ///< not guarded
};

BakeSession::BakeSession(Scene scene, BakeSettings settings, IntegratorFactory integratorFactory)
    : impl_(std::make_unique<Impl>())
{
    impl_->thread = std::thread(
        [impl = impl_.get(), scene = std::move(scene), settings = std::move(settings),
         factory = std::move(integratorFactory)]() mutable { impl->run(std::move(scene), settings, factory); });
}

BakeSession::~BakeSession()
{
    cancel();
    if (impl_->thread.joinable()) impl_->thread.join();
}

BakeSessionState BakeSession::state() const
{
    const std::lock_guard lock(impl_->mutex);
    BakeSessionState state = impl_->state;
    if (state.finished) return state;
    state.seconds = secondsSince(impl_->start);
    constexpr double kEnough = 0.02; // of a stage, before its pace says anything
    if (state.fraction > kEnough)
        state.stageSecondsLeft = secondsSince(impl_->stageStart) * (1.0 - state.fraction) / state.fraction;
    return state;
}

std::optional<BakedScene> BakeSession::takeLight()
{
    const std::lock_guard lock(impl_->mutex);
    return std::exchange(impl_->light, std::nullopt);
}

void BakeSession::cancel()
{
    impl_->cancelled = true;
}

Result<BakeResult> BakeSession::takeResult()
{
    if (impl_->thread.joinable()) impl_->thread.join();
    const std::lock_guard lock(impl_->mutex);
    if (!impl_->result) return Error{ErrorCode::InvalidArgument, "the result was taken before", ""};
    Result<BakeResult> result = std::move(*impl_->result);
    impl_->result.reset();
    return result;
}

} // namespace halflight
