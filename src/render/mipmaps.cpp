#include "render/mipmaps.h"

#include "shading/srgb_table.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

struct Taps {
    std::array<int, 3> index{};
    std::array<float, 3> weight{};
};

/// Source texels under each texel of the next level: two, or three when the size is odd.
std::vector<Taps> boxTaps(int from, int to)
{
    std::vector<Taps> result(static_cast<std::size_t>(to));
    const float scale = float(from) / float(to);
    for (int i = 0; i < to; ++i) {
        const float begin = float(i) * scale;
        const float end = float(i + 1) * scale;
        Taps& taps = result[std::size_t(i)];
        int n = 0;
        for (int j = int(begin); j < from && float(j) < end && n < 3; ++j, ++n) {
            taps.index[std::size_t(n)] = j;
            taps.weight[std::size_t(n)] = (std::min(end, float(j + 1)) - std::max(begin, float(j))) / scale;
        }
    }
    return result;
}

ImageRgba8 nextLevel(const ImageRgba8& image, bool srgb)
{
    const ivec2 size = glm::max(image.size() / 2, ivec2(1));
    const std::vector<Taps> columns = boxTaps(image.width(), size.x);
    const std::vector<Taps> rows = boxTaps(image.height(), size.y);
    const auto color = [srgb](uint8_t value) {
        return srgb ? shading::kLinearFromSrgb8[value] : float(value) / 255.0f;
    };
    ImageRgba8 result(size.x, size.y);
    parallelFor(std::size_t(size.y), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            for (int x = 0; x < size.x; ++x) {
                vec4 sum(0.0f);
                for (int j = 0; j < 3; ++j) {
                    for (int i = 0; i < 3; ++i) {
                        const float weight =
                            rows[y].weight[std::size_t(j)] * columns[std::size_t(x)].weight[std::size_t(i)];
                        if (weight == 0.0f) continue;
                        const u8vec4 texel =
                            image(columns[std::size_t(x)].index[std::size_t(i)], rows[y].index[std::size_t(j)]);
                        sum += weight * vec4(color(texel.r), color(texel.g), color(texel.b), float(texel.a) / 255.0f);
                    }
                }
                if (srgb) sum = vec4(shading::srgbFromLinear(vec3(sum)), sum.a);
                result(x, int(y)) = u8vec4(glm::clamp(sum, 0.0f, 1.0f) * 255.0f + 0.5f);
            }
        }
    });
    return result;
}

} // namespace

std::vector<ImageRgba8> mipLevels(const ImageRgba8& image, bool srgb)
{
    std::vector<ImageRgba8> levels;
    for (ivec2 size = image.size(); size.x > 1 || size.y > 1; size = levels.back().size())
        levels.push_back(nextLevel(levels.empty() ? image : levels.back(), srgb));
    return levels;
}

} // namespace halflight
