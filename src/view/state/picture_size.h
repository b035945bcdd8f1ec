#pragma once
// The resolution that the window's frames are drawn at: on devices that take long for a frame, a coarse picture comes
// first and while the view moves, and finer ones while it rests.

#include "halflight/base/math.h"
#include "halflight/render/renderer.h"

#include <array>

namespace halflight::view {

enum class PictureDetail { Coarse, Half, Full };

/// Pixels of a window's picture: the whole window, half its width and height, or so few that the longer side has 320.
ivec2 pictureSize(ivec2 window, PictureDetail detail);
/// What the coarse picture is drawn with: one sample, and one cascade in small shadow maps.
RenderSettings settingsOf(RenderSettings settings, PictureDetail detail);

/// Size of a picture as wide for its height as `size`, in which the longer side has so few pixels that the picture has
/// the mean of a large one soon.
ivec2 smallPicture(vec2 size);

/// Of camera, settings and objects since the last frame, and of the user: at pauses, they may go on at once.
enum class Motion { Moves, Pauses, Rests };

class PictureDetails {
public:
    /// A frame that takes longer is slow, seconds.
    static constexpr double kSlow = 0.3;

    /// Of the next frame. Pictures that are slow get finer at rest only, as the window waits for each. `finest`: no
    /// finer one is drawn where that is slow.
    PictureDetail next(ivec2 window, Motion motion, PictureDetail finest);
    /// Of the last frame.
    [[nodiscard]] PictureDetail last() const { return detail_; }
    /// The last frame was drawn, and not shown once more, in this time.
    void drew(double seconds);
    /// Whether drew() needs the time to the frame's end: not on fast devices, which draw two frames at one time.
    [[nodiscard]] bool wantsTime() const;
    /// Time that the last picture of this detail took, as far as drew() had it, else 0.
    [[nodiscard]] double seconds() const { return seconds_[std::size_t(detail_)]; }
    /// Another scene is drawn: the first picture of it is a coarse one where that may help.
    void forget() { *this = {}; }

private:
    /// Of a frame, by those drawn so far.
    [[nodiscard]] double estimate(PictureDetail detail) const;

    ivec2 window_{0};
    PictureDetail detail_ = PictureDetail::Coarse;
    bool isFirst_ = true;
    std::array<double, 3> seconds_{}; ///< by detail; 0: none was drawn
};

} // namespace halflight::view
