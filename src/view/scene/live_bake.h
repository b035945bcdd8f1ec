#pragma once
// A bake in the background, whose light the window shows as it comes.

#include "view/scene/comparison.h"
#include "view/scene/shown_scene.h"
#include "view/state/notices.h"

#include "halflight/base/files_in_use.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace halflight::view {

/// One bake at a time, and what the last one left. While it runs, what was shown before it is kept. A step waits until
/// nothing is being uploaded, so that the next scene to be shown is that step's.
class LiveBake {
public:
    LiveBake(ViewState& state, ShownScene& shown, Comparison& comparison, Notices& notices)
        : state_(state), shown_(shown), comparison_(comparison), notices_(notices)
    {}

    [[nodiscard]] const BakeStatus& status() const { return status_; }

    /// Bakes; where that fails or is cancelled, what is shown now is shown again.
    void start(std::unique_ptr<BakeSession> session);
    [[nodiscard]] bool runs() const { return session_ != nullptr; }
    /// BakeSession::goOn() of a session that waits.
    void goOn();
    void cancel();
    /// Ends what runs and forgets what ended: of the file before.
    void forget();

    /// Takes what the bake has made, and uploads it. `aspect`: of the window; `pictureSeconds`: a picture's time.
    Status poll(Renderer& renderer, float aspect, double pictureSeconds);
    /// What poll() uploaded is shown.
    void uploadIsShown();
    /// Light of the bake that runs is shown.
    void lightIsShown(const char* name);
    /// Writes the finished bake that is shown.
    /// `files`: what the window reads; none of it is replaced.
    void save(FilesInUse files);
    /// Lights or objects changed since the bake that is shown.
    void sceneChanged() { status_.outOfDate = true; }
    /// What was done with the bake or for the next one, for people.
    void report(const std::string& outcome);
    /// Whether a finished bake is shown that was not written.
    [[nodiscard]] bool hasUnsaved() const { return status_.hasResult && savedAs_.empty(); }
    /// That the finished bake was or will be written to.
    [[nodiscard]] const std::string& file() const { return savedAs_.empty() ? state_.bakeOutput : savedAs_; }

private:
    using Clock = std::chrono::steady_clock;

    Status showProgress(Renderer& renderer, double pictureSeconds);
    void end(Renderer& renderer, Result<BakeResult> result, double seconds);
    void endIsShown();
    std::string write(FilesInUse files);

    ViewState& state_;
    ShownScene& shown_;
    Comparison& comparison_;
    Notices& notices_;
    BakeStatus status_;
    std::optional<BakedScene> before_;       ///< shown before the bake that runs
    Clock::time_point beforeTime_;           ///< when that was made
    Clock::time_point time_;                 ///< when the bake that runs was begun
    RunMode modeBefore_ = RunMode::Realtime; ///< in which it was shown
    bool resultBefore_ = false;              ///< it was a finished bake
    const char* uploadedLight_ = nullptr;    ///< name of what is being uploaded, if it is light
    struct End {
        bool hasResult = false; ///< else what was shown before comes back
        RunMode mode = RunMode::Realtime;
        std::string outcome;
    };
    std::optional<End> end_;              ///< what is being uploaded, if it is a bake's end
    Clock::time_point lastTiles_;         ///< when some were shown
    std::vector<ImageRgb32f> irradiance_; ///< of the finished bake
    std::vector<std::vector<ImageRgb32f>> groupIrradiance_;
    std::string savedAs_;                  ///< its file; empty: not saved
    std::unique_ptr<BakeSession> session_; ///< goes first: waits for its threads' ends
};

} // namespace halflight::view
