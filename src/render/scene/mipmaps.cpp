#include "render/scene/mipmaps.h"

#include "shading/srgb_table.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/color.h"

#include <algorithm>
#include <array>
#include <bit>
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

/// srgbFromLinear(x) * 255, rounded: the same number without the power.
class SrgbEncoder {
public:
    SrgbEncoder()
    {
        int code = 0;
        for (int i = 0; i < kSteps; ++i) {
            code = byPower(float(i) / float(kSteps));
            first_[std::size_t(i)] = uint8_t(code);
        }
        for (int n = 1; n < 256; ++n) from_[std::size_t(n)] = smallestOf(n);
    }
    [[nodiscard]] uint8_t operator()(float linear) const
    {
        const float x = std::clamp(linear, 0.0f, 1.0f);
        int code = first_[std::size_t(std::min(int(x * float(kSteps)), kSteps - 1))];
        while (code < 255 && x >= from_[std::size_t(code) + 1]) ++code;
        return uint8_t(code);
    }

private:
    static constexpr int kSteps = 4096; ///< a step holds at most two changes of the code

    static int byPower(float linear)
    {
        return int(glm::clamp(shading::srgbFromLinear(linear), 0.0f, 1.0f) * 255.0f + 0.5f);
    }
    /// By bisection between neighbouring floats.
    static float smallestOf(int code)
    {
        uint32_t below = 0;
        uint32_t above = std::bit_cast<uint32_t>(1.0f);
        while (above - below > 1) {
            const uint32_t middle = below + (above - below) / 2;
            (byPower(std::bit_cast<float>(middle)) >= code ? above : below) = middle;
        }
        return std::bit_cast<float>(above);
    }

    std::array<uint8_t, kSteps> first_{};
    std::array<float, 256> from_{};
};

const std::array<float, 256> kUnorm8 = [] {
    std::array<float, 256> table{};
    for (int n = 0; n < 256; ++n) table[std::size_t(n)] = float(n) / 255.0f;
    return table;
}();

ImageRgba8 nextLevel(const ImageRgba8& image, bool srgb)
{
    static const SrgbEncoder kEncode;
    const ivec2 size = glm::max(image.size() / 2, ivec2(1));
    const std::vector<Taps> columns = boxTaps(image.width(), size.x);
    const std::vector<Taps> rows = boxTaps(image.height(), size.y);
    const std::array<float, 256>& linear = srgb ? shading::kLinearFromSrgb8 : kUnorm8;
    ImageRgba8 result(size.x, size.y);
    const auto texelAt = [&](const Taps& column, const Taps& row) {
        vec4 sum(0.0f);
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) {
                const float weight = row.weight[j] * column.weight[i];
                if (weight == 0.0f) continue;
                const u8vec4 texel = image(column.index[i], row.index[j]);
                sum += weight * vec4(linear[texel.r], linear[texel.g], linear[texel.b], kUnorm8[texel.a]);
            }
        }
        const u8vec4 plain(glm::clamp(sum, 0.0f, 1.0f) * 255.0f + 0.5f);
        return srgb ? u8vec4(kEncode(sum.r), kEncode(sum.g), kEncode(sum.b), plain.a) : plain;
    };
    parallelFor(std::size_t(size.y), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            for (int x = 0; x < size.x; ++x) result(x, int(y)) = texelAt(columns[std::size_t(x)], rows[y]);
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
