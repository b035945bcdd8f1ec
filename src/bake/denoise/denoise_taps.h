#pragma once
// What one level of the denoiser's filter reads around a texel: values at 5 × 5 taps, side by side for vector
// instructions.

#include "bake/denoise/denoise.h"
#include "bake/seams/surface_grid.h"
#include "bake/texels/texel_places.h"

#include <array>
#include <vector>

namespace halflight {

constexpr int kTaps = 25; ///< 5 × 5, row by row
constexpr int kMiddleTap = 12;
constexpr int kPaddedTaps = 28; ///< a multiple of the vectors' width; taps from kTaps on are not valid
constexpr int tapX(int tap)
{
    return tap % 5 - 2;
}
constexpr int tapY(int tap)
{
    return tap / 5 - 2;
}

using TapFloats = std::array<float, kPaddedTaps>; ///< a value of each tap

/// What the filter smooths, by texel.
struct Signals {
    std::vector<NoisyLight> gathered;
    std::vector<NoisyLight> direct; ///< empty where no light is fully baked
    std::vector<vec3> moments;      ///< first moments of all light, lux
};

struct Guide {
    TexelPlace place;
    bool valid = false;
    bool traced = false;
};

/// One level of the filter: its inputs, all indexed by texel.
struct Level {
    const SurfaceGrid& grid;
    const std::vector<Guide>& guides;
    const Signals& in;
    int number = 0; ///< taps are 2^number texels apart
    bool directions = false;

    [[nodiscard]] int step() const { return 1 << number; }
    /// Whether a texel counts for gathered light.
    [[nodiscard]] bool counts(uint32_t texel) const
    {
        return guides[texel].valid && (number > 0 || guides[texel].traced);
    }
};

/// What the filter reads at one tap: the values of a texel, or beyond a seam the bilinear mean of those around a place.
struct Tap {
    bool valid = false;  ///< on the surface, and outside geometry
    bool counts = false; ///< for gathered light
    vec3 position{0.0f};
    vec3 normal{0.0f}; ///< unit
    NoisyLight gathered;
    NoisyLight direct;
    vec3 moment{0.0f};
};

inline Tap tapOn(const Level& level, uint32_t j)
{
    const Guide& guide = level.guides[j];
    Tap tap{guide.valid, level.counts(j), guide.place.position, guide.place.normal, level.in.gathered[j], {}, {}};
    if (!level.in.direct.empty()) tap.direct = level.in.direct[j];
    if (level.directions) tap.moment = level.in.moments[j];
    return tap;
}

/// Nearest texels would lie up to 0.7 texels off, towards the light on one side of a seam and away from it on the
/// other.
inline Tap tapBeyond(const Level& level, const SurfaceGrid::Footprint& footprint)
{
    constexpr float kEnough = 0.5f; // of a footprint's weight; with less, its mean is that of other places
    Tap sum;
    float weight = 0.0f;
    for (std::size_t n = 0; n < footprint.count; ++n) {
        if (level.counts(footprint.texels[n])) weight += footprint.weights[n];
    }
    if (weight < kEnough) return sum;
    for (std::size_t n = 0; n < footprint.count; ++n) {
        if (!level.counts(footprint.texels[n])) continue;
        const float w = footprint.weights[n] / weight;
        const float ofVariance = level.number == 0 ? w * w : w; // values of later levels share texels
        const Tap tap = tapOn(level, footprint.texels[n]);
        sum.position += w * tap.position;
        sum.normal += w * tap.normal;
        sum.gathered.irradiance += w * tap.gathered.irradiance;
        sum.gathered.variance += ofVariance * tap.gathered.variance;
        sum.direct.irradiance += w * tap.direct.irradiance;
        sum.direct.variance += ofVariance * tap.direct.variance;
        sum.moment += w * tap.moment;
    }
    sum.valid = sum.counts = glm::length(sum.normal) > 0.0f;
    if (sum.valid) sum.normal = glm::normalize(sum.normal);
    return sum;
}

/// A colour of each tap.
struct TapColors {
    TapFloats r{};
    TapFloats g{};
    TapFloats b{};

    void set(std::size_t tap, vec3 color)
    {
        r[tap] = color.r;
        g[tap] = color.g;
        b[tap] = color.b;
    }
    [[nodiscard]] vec3 at(std::size_t tap) const { return {r[tap], g[tap], b[tap]}; }
};

/// Light of each tap.
struct TapLights {
    TapColors irradiance;
    TapFloats luminance{};
    TapFloats variance{};

    void set(std::size_t tap, const NoisyLight& light)
    {
        irradiance.set(tap, light.irradiance);
        luminance[tap] = halflight::luminance(light.irradiance);
        variance[tap] = light.variance;
    }
};

/// The taps around a texel.
struct Taps {
    TapFloats valid{};  ///< 1 = on the surface, and outside geometry; else 0
    TapFloats counts{}; ///< 1 = counts for gathered light
    TapColors position; ///< from the middle tap, metres
    TapColors normal;   ///< unit; 0 where the tap is not valid
    TapLights gathered;
    TapLights direct;
    TapColors moment;

    Taps(const Level& level, uint32_t texel)
    {
        const vec3 middle = level.guides[texel].place.position;
        for (int k = 0; k < kTaps; ++k) {
            const int dx = tapX(k) * level.step();
            const int dy = tapY(k) * level.step();
            const uint32_t other = level.grid.onChart(texel, dx, dy);
            const Tap tap =
                other != kNoTexel ? tapOn(level, other) : tapBeyond(level, level.grid.beyond(texel, dx, dy));
            if (tap.valid) set(std::size_t(k), tap, middle, level);
        }
    }

private:
    void set(std::size_t k, const Tap& tap, vec3 middle, const Level& level)
    {
        valid[k] = 1.0f;
        counts[k] = tap.counts ? 1.0f : 0.0f;
        position.set(k, tap.position - middle);
        normal.set(k, tap.normal);
        gathered.set(k, tap.gathered);
        if (!level.in.direct.empty()) direct.set(k, tap.direct);
        if (level.directions) moment.set(k, tap.moment);
    }
};

} // namespace halflight
