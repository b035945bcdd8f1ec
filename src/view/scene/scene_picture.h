#pragma once
// The picture of the scene in the window's frames.

#include "halflight/render/vulkan_target.h"
#include "view/scene/comparison.h"
#include "view/scene/edited_scene.h"
#include "view/state/notices.h"
#include "view/state/picture_size.h"
#include "view/state/shown.h"
#include "view/window/desktop.h"

#include <chrono>
#include <optional>
#include <string>

namespace halflight::view {

/// Chooses how coarse each picture is, by the times of those before. The report and the frame's warnings are those of
/// the last picture.
class ScenePicture {
public:
    using Clock = std::chrono::steady_clock;

    ScenePicture(const ViewState& state, Notices& notices) : state_(state), notices_(notices) {}

    [[nodiscard]] const PictureReport& report() const { return report_; }

    /// Another file is shown. `coarseSeconds`: time of its coarse picture, if there was one.
    void beginFile(std::optional<double> coarseSeconds);
    struct DetailHint {
        bool pauses = false;                        ///< the user does nothing, but may go on at once
        PictureDetail finest = PictureDetail::Full; ///< no finer one where that is slow
    };
    /// Records the picture.
    Status draw(const Swapchain::Frame& frame, WindowDevice& device, const EditedScene& edited,
                const Comparison& comparison, const DetailHint& hint);
    /// The frame was begun at `start` and is submitted. Waits for its end where its time says what to draw next.
    void measure(const Swapchain& swapchain, Clock::time_point start);
    /// Whether the last picture was drawn, and not the one before shown once more.
    [[nodiscard]] bool isNew() const { return isNew_; }
    /// Time that a picture of the last one's detail takes, as far as it was measured, else 0.
    [[nodiscard]] double seconds() const { return details_.seconds(); }
    /// What a picture that is not the whole one is.
    [[nodiscard]] std::string detailText() const;

private:
    PictureDetail chooseDetail(ivec2 size, Clock::time_point lastChange, const DetailHint& hint);
    Result<RenderedFrame> record(const Swapchain::Frame& frame, const VulkanTarget& target, Renderer& renderer,
                                 const RenderSettings& settings);

    struct Drawn {
        Camera camera;
        RenderSettings settings;      ///< as panels have them
        Clock::time_point lastChange; ///< of the scene
        bool operator==(const Drawn&) const = default;
    };

    const ViewState& state_;
    Notices& notices_;
    PictureReport report_;
    PictureDetails details_;
    std::optional<Drawn> last_;
    bool isNew_ = false;
    bool drewTwice_ = false; ///< the last frame, in two modes
};

} // namespace halflight::view
