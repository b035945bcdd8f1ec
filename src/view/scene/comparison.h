#pragma once
// What is right of the window's line.

#include "view/scene/edited_scene.h"
#include "view/scene/reference_picture.h"
#include "view/state/shown.h"
#include "view/window/ui_renderer.h"

#include <future>
#include <memory>
#include <optional>

namespace halflight::view {

/// Another mode, the light before the last bake, or the path-traced view, as ViewState chooses. What it needs for that
/// is made when it is first compared with, on other threads.
class Comparison {
public:
    explicit Comparison(ViewState& state) : state_(state) {}

    [[nodiscard]] const CompareReport& report() const { return report_; }
    /// What was shown before the bake that has just ended; nothing: there is none.
    void keepEarlier(std::optional<BakedScene> earlier);
    /// The light of that bake is shown.
    void offerEarlier() { report_.hasEarlier = true; }
    /// The light before a bake of another file.
    void forget();
    /// Waits for what is made on a device that has failed, and drops it.
    void leaveDevice();

    /// Makes the renderer of the light before the bake, if that is compared with. `size`: of the window, pixels.
    Status followEarlier(const Renderer& renderer, const EditedScene& edited, ivec2 size);
    /// Traces the view while it rests, if it is compared with, and hands its picture to `ui`.
    void followReference(EditedScene& edited, ivec2 size, UiRenderer& ui);
    [[nodiscard]] bool isMakingEarlier() const { return earlierLoading_.valid(); }
    /// Whether another thread works.
    [[nodiscard]] bool works() const { return isMakingEarlier() || (reference_ && reference_->works()); }

    /// What a renderer draws there: `renderer` in another mode, or the light before the bake. Nothing where that is
    /// not ready, and of the reference, which is a picture.
    struct Side {
        Renderer* renderer = nullptr;
        RunMode mode = RunMode::Realtime;
    };
    [[nodiscard]] std::optional<Side> rightSide(Renderer& renderer) const;
    /// The line, what is on both sides of it, and the path-traced picture, in this frame of the panels.
    void drawLine() const;

private:
    [[nodiscard]] bool wantsEarlier() const;
    [[nodiscard]] RunMode earlierMode() const;

    ViewState& state_;
    CompareReport report_;
    std::optional<BakedScene> earlier_;
    std::optional<ReferencePicture::Picture> pathTraced_; ///< the last one of this view
    float pathTracedEv_ = 0.0f;                           ///< its exposure on the screen
    ToneMapping pathTracedTone_ = ToneMapping::Neutral;
    std::unique_ptr<Renderer> earlierRenderer_; ///< draws earlier_ on the window's device
    // These go first, the last one before the others, and wait for their threads' ends.
    std::future<Result<std::unique_ptr<Renderer>>> earlierLoading_; ///< makes it
    std::optional<ReferencePicture> reference_;
};

} // namespace halflight::view
