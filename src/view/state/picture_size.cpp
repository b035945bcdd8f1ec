#include "view/state/picture_size.h"

#include <algorithm>

namespace halflight::view {

ivec2 pictureSize(ivec2 window, PictureDetail detail)
{
    constexpr float kCoarseSide = 320.0f;
    const auto longer = float(std::max({window.x, window.y, 1}));
    const float share = detail == PictureDetail::Full   ? 1.0f
                        : detail == PictureDetail::Half ? 0.5f
                                                        : std::min(kCoarseSide / longer, 1.0f);
    return glm::max(ivec2(vec2(window) * share), ivec2(1));
}

RenderSettings settingsOf(RenderSettings settings, PictureDetail detail)
{
    if (detail != PictureDetail::Coarse) return settings;
    constexpr int kSmaller = 4; // times, of a shadow map's side
    settings.supersampling = 1;
    settings.shadows.cascades = 1;
    settings.shadows.directionalMapSize = std::max(settings.shadows.directionalMapSize / kSmaller, 128);
    settings.shadows.atlasSize = std::max(settings.shadows.atlasSize / kSmaller, 256);
    return settings;
}

ivec2 smallPicture(vec2 size)
{
    constexpr float kSide = 256.0f;
    return glm::max(ivec2(size * (kSide / std::max(size.x, size.y))), ivec2(1));
}

double PictureDetails::estimate(PictureDetail detail) const
{
    for (int i = int(detail); i >= 0; --i) {
        if (seconds_[std::size_t(i)] == 0.0) continue;
        const auto pixels = [&](PictureDetail of) {
            const ivec2 size = pictureSize(window_, of);
            return double(size.x) * double(size.y);
        };
        return seconds_[std::size_t(i)] * pixels(detail) / pixels(PictureDetail(i));
    }
    return 0.0;
}

PictureDetail PictureDetails::next(ivec2 window, Motion motion, PictureDetail finest)
{
    window_ = window;
    PictureDetail most = PictureDetail::Full;
    while (most > finest && estimate(most) > kSlow) most = PictureDetail(int(most) - 1);
    if (isFirst_) {
        detail_ = PictureDetail::Coarse;
    } else if (estimate(most) <= kSlow) {
        detail_ = most;
    } else if (motion == Motion::Moves) {
        detail_ = estimate(PictureDetail::Half) > kSlow ? PictureDetail::Coarse : PictureDetail::Half;
    } else {
        const auto finer = PictureDetail(std::min(int(detail_) + 1, int(PictureDetail::Full)));
        const bool waits = motion == Motion::Pauses && estimate(finer) > kSlow;
        detail_ = std::min(waits ? detail_ : finer, most);
    }
    isFirst_ = false;
    return detail_;
}

void PictureDetails::drew(double seconds)
{
    seconds_[std::size_t(detail_)] = seconds;
}

bool PictureDetails::wantsTime() const
{
    constexpr double kFast = 0.05;
    const double last = seconds_[std::size_t(detail_)];
    return last == 0.0 || last > kFast;
}

} // namespace halflight::view
