// From linear radiance to a displayed picture.
#include "halflight/shading/display.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace halflight {

static_assert(int(ToneMapping::Neutral) == shading::kToneMapNeutral &&
              int(ToneMapping::Aces) == shading::kToneMapAces && int(ToneMapping::Agx) == shading::kToneMapAgx &&
              int(ToneMapping::None) == shading::kToneMapNone);

ImageRgba8 displayedPicture(const ImageRgba32f& radiance, float exposureEv, ToneMapping toneMapping)
{
    const float factor = shading::exposureFactor(exposureEv);
    ImageRgba8 picture(radiance.width(), radiance.height());
    parallelFor(radiance.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const vec3 shown = shading::displayedColor(vec3(radiance.texels()[i]), factor, int(toneMapping));
            const vec3 encoded = shading::srgbFromLinear(shown);
            picture.texels()[i] = u8vec4(vec4(encoded, 1.0f) * 255.0f + 0.5f);
        }
    });
    return picture;
}

ImageRgba8 plainPicture(const ImageRgba32f& values)
{
    ImageRgba8 picture(values.width(), values.height());
    std::transform(values.texels().begin(), values.texels().end(), picture.texels().begin(),
                   [](vec4 value) { return u8vec4(glm::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f); });
    return picture;
}

/// EV from which on at most 2 % of the pixels have a channel above kBurnt.
static float exposureOfHighlights(const ImageRgba32f& radiance)
{
    constexpr float kBurnt = 4.0f; // is shown as 253 of 255 (toneMapNeutral())
    constexpr std::size_t kPart = 50;
    std::vector<float> brightest;
    for (const vec4& texel : radiance.texels()) {
        const float channel = std::max({texel.x, texel.y, texel.z});
        if (std::isfinite(channel)) brightest.push_back(channel);
    }
    if (brightest.empty()) return -kInfinity;
    const auto place = brightest.begin() + std::ptrdiff_t(brightest.size() / kPart);
    std::nth_element(brightest.begin(), place, brightest.end(), std::greater<>());
    return *place > 0.0f ? math::log2(*place / kBurnt) : -kInfinity;
}

float automaticExposure(const ImageRgba32f& radiance)
{
    // Pixels as black as nothing (no sky, no light) have no say: they would drag the average to the floor.
    double sum = 0.0;
    std::size_t count = 0;
    for (const vec4& texel : radiance.texels()) {
        const float l = luminance(vec3(texel));
        if (!(l > 1.0e-6f) || !std::isfinite(l)) continue;
        sum += math::log2(double(l));
        ++count;
    }
    if (count == 0) return 0.0f;
    const auto ev = float(sum / double(count) - math::log2(0.18));
    // A lamp that fills much of the picture is white however dark the rest is made.
    constexpr float kMostStops = 2.0f;
    return std::clamp(exposureOfHighlights(radiance), ev, ev + kMostStops);
}

} // namespace halflight
