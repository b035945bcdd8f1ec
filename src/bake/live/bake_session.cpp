#include "halflight/bake/bake_session.h"

#include "bake/live/live_light.h"

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

} // namespace

struct BakeSession::Impl {
    void run(Scene scene, const BakeSettings& settings, const ChooseIntegrators& choose)
    {
        Progress progress;
        progress.cancel = &cancelled;
        progress.report = [this](std::string_view stage, double fraction) {
            const std::lock_guard lock(mutex);
            if (stage != state.stage) stageStart = Clock::now();
            state.stage = stage;
            state.fraction = fraction;
        };
        const Result<IntegratorFactory> factory = choose(scene, settings);
        Result<BakeResult> baked =
            factory ? bake(std::move(scene), settings, *factory, progress, &live) : factory.error();
        const std::lock_guard lock(mutex);
        result = std::move(baked);
        state.finished = true;
        state.seconds = secondsSince(start);
    }

    const Clock::time_point start = Clock::now();
    std::atomic<bool> cancelled = false;
    LiveLight live;
    mutable std::mutex mutex; ///< guards what follows
    Clock::time_point stageStart = start;
    BakeSessionState state;
    std::optional<Result<BakeResult>> result;
    std::thread thread; ///< not guarded
};

BakeSession::BakeSession(Scene scene, BakeSettings settings, IntegratorFactory integratorFactory, bool waits)
    : BakeSession(
          std::move(scene), std::move(settings),
          [factory = std::move(integratorFactory)](const Scene&, const BakeSettings&) {
              return Result<IntegratorFactory>(factory);
          },
          waits)
{}

BakeSession::BakeSession(Scene scene, BakeSettings settings, ChooseIntegrators choose, bool waits)
    : impl_(std::make_unique<Impl>())
{
    impl_->live.setWaits(waits);
    impl_->thread =
        std::thread([impl = impl_.get(), scene = std::move(scene), settings = std::move(settings),
                     choose = std::move(choose)]() mutable { impl->run(std::move(scene), settings, choose); });
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

void BakeSession::setView(const Camera& camera, float aspect)
{
    impl_->live.setView({camera, aspect});
}

std::optional<BakedScene> BakeSession::takeProbeLight()
{
    return impl_->live.takeProbeLight();
}

std::optional<BakedScene> BakeSession::takeLight()
{
    return impl_->live.takeLight();
}

std::vector<LightTile> BakeSession::takeTiles()
{
    return impl_->live.takeTiles();
}

void BakeSession::goOn()
{
    impl_->live.setWaits(false);
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
