#pragma once
// Writes Radiance pictures, for tests of the reader.

#include "halflight/base/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <string>
#include <vector>

namespace halflight {

// Rounded to the nearest representable colour, not down, so that the picture is not darker on average.
inline std::array<uint8_t, 4> rgbeOf(vec3 color)
{
    const float largest = std::max({color.x, color.y, color.z});
    if (!(largest > 1.0e-32f)) return {0, 0, 0, 0};
    int exponent = 0;
    std::frexp(largest, &exponent);
    if (std::ldexp(largest, 8 - exponent) >= 255.5f) ++exponent; // would round up to 256
    std::array<uint8_t, 4> rgbe{};
    for (int c = 0; c < 3; ++c) {
        rgbe[std::size_t(c)] = uint8_t(std::clamp(std::lround(std::ldexp(color[c], 8 - exponent)), 0L, 255L));
    }
    rgbe[3] = uint8_t(exponent + 128);
    return rgbe;
}

// One channel of a scanline as runs (128 + length, value) and literals (length, values…).
inline void writeRuns(const std::vector<uint8_t>& row, std::vector<std::byte>& out)
{
    constexpr std::size_t kMinRun = 4;
    std::size_t i = 0;
    while (i < row.size()) {
        const auto runLength = [&](std::size_t start) {
            std::size_t n = 1;
            while (start + n < row.size() && n < 127 && row[start + n] == row[start]) ++n;
            return n;
        };
        std::size_t literal = 0;
        while (i + literal < row.size() && literal < 128 && runLength(i + literal) < kMinRun) ++literal;
        if (literal > 0) {
            out.push_back(std::byte(literal));
            for (std::size_t k = 0; k < literal; ++k) out.push_back(std::byte(row[i + k]));
            i += literal;
            continue;
        }
        const std::size_t run = runLength(i);
        out.push_back(std::byte(128 + run));
        out.push_back(std::byte(row[i]));
        i += run;
    }
}

/// An RGB9E5 image as a Radiance picture, top row first. Both formats share one exponent; the 9-bit mantissas lose a
/// bit.
inline std::vector<std::byte> encodeRgbe(const Image<uint32_t>& image)
{
    const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height()) + " +X " +
                               std::to_string(image.width()) + "\n";
    std::vector<std::byte> out;
    for (const char c : header) out.push_back(std::byte(c));
    const bool runs = image.width() >= 8 && image.width() < 32768; // what the encoding allows
    std::array<std::vector<uint8_t>, 4> channels;
    for (int y = 0; y < image.height(); ++y) {
        for (auto& channel : channels) channel.assign(std::size_t(image.width()), 0);
        for (int x = 0; x < image.width(); ++x) {
            const auto texel = rgbeOf(glm::unpackF3x9_E1x5(image(x, y)));
            for (std::size_t c = 0; c < 4; ++c) {
                if (runs) {
                    channels[c][std::size_t(x)] = texel[c];
                } else {
                    out.push_back(std::byte(texel[c]));
                }
            }
        }
        if (!runs) continue;
        for (const int b : {2, 2, image.width() >> 8, image.width() & 255}) out.push_back(std::byte(b));
        for (const auto& channel : channels) writeRuns(channel, out);
    }
    return out;
}

} // namespace halflight
