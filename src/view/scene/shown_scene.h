#pragma once
// The scene that the window shows, and the next one on its way to the device.

#include "view/state/shown.h"

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <optional>

namespace halflight::view {

/// Keeps what the renderer draws, to go back to, to save, and to upload to another device.
class ShownScene {
public:
    using Clock = std::chrono::steady_clock;

    /// `ends` is set when the window closes: uploads end soon.
    ShownScene(ViewState& state, const std::atomic<bool>& ends) : state_(state), ends_(ends) {}

    [[nodiscard]] bool any() const { return baked_.has_value(); }
    [[nodiscard]] const BakedScene& baked() const { return *baked_; }
    [[nodiscard]] const SceneReport& report() const { return report_; }
    [[nodiscard]] bool isCoarse() const { return textures_ == TextureDetail::Coarse; }
    /// When the scene was made: changes since then are not in it.
    [[nodiscard]] Clock::time_point time() const { return time_; }
    /// The renderer draws this scene now.
    void take(BakedScene baked, TextureDetail textures, Clock::time_point time);

    /// Uploads a scene on another thread; poll() shows it. One at a time.
    void showLater(Renderer& renderer, BakedScene baked, Clock::time_point time);
    [[nodiscard]] bool isUploading() const { return next_.has_value(); }
    /// Shows what has been uploaded; whether there was something.
    Result<bool> poll(Renderer& renderer);
    /// Waits for the upload; its scene is not shown.
    void dropUpload();

    /// Waits for the upload, whose device has failed.
    void leaveDevice() { uploading_ = {}; }
    /// Shows the same scene on another device, and uploads the next one to it.
    Status moveTo(Renderer& renderer);

private:
    void upload(Renderer& renderer);

    ViewState& state_;
    const std::atomic<bool>& ends_;
    std::optional<BakedScene> baked_;
    SceneReport report_;                           ///< of baked_
    TextureDetail textures_ = TextureDetail::Full; ///< on the device
    Clock::time_point time_;                       ///< of baked_
    std::optional<BakedScene> next_;               ///< that thread's
    Clock::time_point nextTime_;
    std::future<Result<std::shared_ptr<Renderer::Uploaded>>> uploading_; ///< goes first: waits for the thread's end
};

} // namespace halflight::view
