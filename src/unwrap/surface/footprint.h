#pragma once
// Which texels a chart takes.

#include "unwrap/surface/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <vector>

namespace halflight::charts {

/// Triangles are rasterized this much larger (texels) all round, so that rounding UVs to float at 8192 texels a page,
/// and scale and offset of an object, never reach a texel that was not reserved.
inline constexpr double kRasterMargin = 1.0 / 64.0;

/// Calls span(y, first, last) for each row of unit squares that the triangle, grown by `margin`, touches: a triangle is
/// convex, so the squares of a row are one run.
template<typename SpanFunction> void forTouchedTexels(const dvec2 (&corners)[3], double margin, SpanFunction span)
{
    const double lowY = std::min({corners[0].y, corners[1].y, corners[2].y}) - margin;
    const double highY = std::max({corners[0].y, corners[1].y, corners[2].y}) + margin;
    for (int y = int(std::floor(lowY)), last = int(std::floor(highY)); y <= last; ++y) {
        const double bottom = double(y) - margin, top = double(y) + 1.0 + margin;
        double least = 1e300, most = -1e300;
        const auto extend = [&](double x) {
            least = std::min(least, x);
            most = std::max(most, x);
        };
        for (int k = 0; k < 3; ++k) {
            const dvec2 a = corners[k], b = corners[(k + 1) % 3];
            if (a.y >= bottom && a.y <= top) extend(a.x);
            for (const double line : {bottom, top}) {
                if ((a.y < line) != (b.y < line))
                    extend(a.x + (b.x - a.x) * std::clamp((line - a.y) / (b.y - a.y), 0.0, 1.0));
            }
        }
        if (least <= most) span(y, int(std::floor(least - margin)), int(std::floor(most + margin)));
    }
}

/// A bit per texel of a chart's rectangle.
class Footprint {
public:
    Footprint() = default;
    Footprint(int width, int height)
        : width_(width), height_(height), words_((std::size_t(width) + 63) / 64), bits_(words_ * std::size_t(height))
    {}

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] bool at(int x, int y) const { return (row(y)[std::size_t(x) / 64] >> (x % 64)) & 1u; }
    void set(int x, int y) { bits_[std::size_t(y) * words_ + std::size_t(x) / 64] |= uint64_t(1) << (x % 64); }
    void setRun(int y, int first, int last); ///< inclusive, cut to the rectangle
    [[nodiscard]] std::size_t count() const;
    [[nodiscard]] std::span<const uint64_t> row(int y) const
    {
        return {bits_.data() + std::size_t(y) * words_, words_};
    }
    bool operator==(const Footprint&) const = default;

    /// One of the eight ways to lay it down: bit 0 mirrors x, bit 1 mirrors y, bit 2 then swaps x and y.
    [[nodiscard]] Footprint oriented(int orientation) const;
    /// Grown by `texels` on all sides, corners included; the rectangle grows too.
    [[nodiscard]] Footprint dilated(int texels) const;

    /// Calls visit(y, first, length) for each run of set bits.
    template<typename Visit> void forRuns(Visit visit) const
    {
        for (int y = 0; y < height_; ++y) {
            const std::span<const uint64_t> words = row(y);
            for (int x = nextOf(words, 0, 0); x < width_;) {
                const int end = std::min(nextOf(words, x, ~uint64_t(0)), width_);
                visit(y, x, end - x);
                x = nextOf(words, end, 0);
            }
        }
    }

private:
    /// The first bit from x on that differs from those of `same`, or one beyond the row.
    static int nextOf(std::span<const uint64_t> words, int x, uint64_t same)
    {
        auto w = std::size_t(x) / 64;
        if (w >= words.size()) return x;
        uint64_t differs = (words[w] ^ same) >> (x % 64) << (x % 64);
        while (differs == 0 && ++w < words.size()) differs = words[w] ^ same;
        return int(w) * 64 + (differs != 0 ? std::countr_zero(differs) : 0);
    }

    int width_ = 0, height_ = 0;
    std::size_t words_ = 0;
    std::vector<uint64_t> bits_;
};

/// Where a point of a footprint with the given size goes when it is laid down in an orientation.
dvec2 oriented(dvec2 point, ivec2 size, int orientation);

} // namespace halflight::charts
