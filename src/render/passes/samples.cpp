#include "render/passes/samples.h"

#include "halflight/shading/display.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace halflight {
namespace {

/// The mean of the eight neighbours; alpha 0 where they are no surface around a crack.
vec4 meanAround(const ImageRgba32f& samples, int x, int y)
{
    vec4 sum(0.0f);
    float darkest = kInfinity;
    float brightest = 0.0f;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            if (dx == 0 && dy == 0) continue;
            const vec4 neighbour = samples(x + dx, y + dy);
            if (!(neighbour.w > 0.0f)) return vec4(0.0f);
            const float level = luminance(vec3(neighbour));
            darkest = std::min(darkest, level);
            brightest = std::max(brightest, level);
            sum += neighbour;
        }
    }
    return shading::isCrack(darkest, brightest) ? vec4(vec3(sum) / 8.0f, 1.0f) : vec4(0.0f);
}

} // namespace

ImageRgba32f withoutCracks(ImageRgba32f samples)
{
    std::vector<std::pair<ivec2, vec4>> filled;
    for (int y = 1; y + 1 < samples.height(); ++y) {
        for (int x = 1; x + 1 < samples.width(); ++x) {
            if (samples(x, y).w > 0.0f) continue;
            const vec4 mean = meanAround(samples, x, y);
            if (mean.w > 0.0f) filled.emplace_back(ivec2(x, y), mean);
        }
    }
    for (const auto& [place, mean] : filled) samples(place.x, place.y) = mean;
    for (vec4& sample : samples.texels()) sample.w = 1.0f;
    return samples;
}

ImageRgba32f downsampled(const ImageRgba32f& samples, int factor)
{
    if (factor == 1) return samples;
    ImageRgba32f result(samples.width() / factor, samples.height() / factor, vec4(0.0f));
    const float weight = 1.0f / float(factor * factor);
    for (int y = 0; y < samples.height(); ++y)
        for (int x = 0; x < samples.width(); ++x) result(x / factor, y / factor) += weight * samples(x, y);
    return result;
}

} // namespace halflight
