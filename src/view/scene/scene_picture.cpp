#include "view/scene/scene_picture.h"

#include <cmath>
#include <utility>

namespace halflight::view {

void ScenePicture::beginFile(std::optional<double> coarseSeconds)
{
    details_.forget();
    if (coarseSeconds) details_.drew(*coarseSeconds);
}

/// Coarse while the view changes and soon after, where frames take long.
PictureDetail ScenePicture::chooseDetail(ivec2 size, Clock::time_point lastChange, const DetailHint& hint)
{
    const Drawn now{state_.navigator.camera(), state_.settings, lastChange};
    const bool moves = last_ && *last_ != now;
    last_ = now;
    if (state_.settings.timings) return PictureDetail::Full; // what is measured is a whole frame
    return details_.next(size, moves ? Motion::Moves : hint.pauses ? Motion::Pauses : Motion::Rests, hint.finest);
}

Result<RenderedFrame> ScenePicture::record(const Swapchain::Frame& frame, const VulkanTarget& target,
                                           Renderer& renderer, const RenderSettings& settings)
{
    Result<RenderedFrame> drawn = renderer.record(frame.commands, target, state_.navigator.camera(), settings,
                                                  state_.exposureEv, state_.toneMapping);
    if (drawn && !drawn->isKept) isNew_ = true;
    return drawn;
}

Status ScenePicture::draw(const Swapchain::Frame& frame, WindowDevice& device, const EditedScene& edited,
                          const Comparison& comparison, const DetailHint& hint)
{
    const PictureDetail detail = chooseDetail(frame.size, edited.lastChange(), hint);
    RenderSettings settings =
        settingsOf(settingsOfFrame(state_, edited.bounds(), pictureSize(frame.size, detail)), detail);
    settings.keepsPicture = !settings.timings;
    report_.shadowDistanceMeters = settings.shadows.distanceMeters;
    isNew_ = false;
    VulkanTarget target{frame.view, device.swapchain.format(), frame.size};
    const int line = int(std::lround(state_.split * float(frame.size.x)));
    const std::optional<Comparison::Side> right = comparison.rightSide(*device.renderer);
    // Frames that compare modes record twice, and record() wants all but the last recording done.
    const bool twice = right && right->renderer == device.renderer.get();
    if (twice || drewTwice_) device.swapchain.waitIdle();
    drewTwice_ = twice;
    if (right) {
        RenderSettings other = settings;
        other.mode = right->mode;
        target.begin = ivec2(line, 0);
        if (const auto drawn = record(frame, target, *right->renderer, other); !drawn) return drawn.error();
        target.begin = ivec2(0);
        target.end = ivec2(line, frame.size.y);
    }
    if (right && line <= 0) return {};
    Result<RenderedFrame> drawn = record(frame, target, *device.renderer, settings);
    if (!drawn) return drawn.error();
    report_.passes = std::move(drawn->passes);
    report_.timed = drawn->timed;
    if (drawn->timed) addFrame(report_.passesOfFrames, report_.passes);
    if (!settings.timings) report_.passesOfFrames.clear();
    notices_.setWarnings(Notices::About::Frame, std::move(drawn->plan.warnings));
    return {};
}

void ScenePicture::measure(const Swapchain& swapchain, Clock::time_point start)
{
    if (!isNew_ || !details_.wantsTime()) return;
    swapchain.waitIdle();
    details_.drew(std::chrono::duration<double>(Clock::now() - start).count());
}

std::string ScenePicture::detailText() const
{
    if (details_.last() == PictureDetail::Full || state_.settings.timings) return "";
    return details_.last() == PictureDetail::Coarse ? "coarse picture" : "picture of half the resolution";
}

} // namespace halflight::view
