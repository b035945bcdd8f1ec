#pragma once
// What one level of the denoiser's filter reads around a texel: values at 5 × 5 taps, side by side for vector
// instructions.

#include "bake/denoise/denoise.h"
#include "bake/denoise/tap.h"
#include "bake/seams/surface_grid.h"
#include "bake/texels/texel_places.h"

#include <array>
#include <vector>

namespace halflight {

using shading::kMiddleTap;
using shading::kTaps;
using shading::tapX;
using shading::tapY;

constexpr int kPaddedTaps = 28; ///< a multiple of the vectors' width; taps from kTaps on are not valid

using TapFloats = std::array<float, kPaddedTaps>; ///< a value of each tap

struct Guide {
    TexelPlace place;
    bool valid = false;
};

/// One level of the filter: its inputs, all indexed by texel.
struct Level {
    const SurfaceGrid& grid;
    const std::vector<Guide>& guides;
    const Signals& in;
    int number = 0; ///< taps are 2^number texels apart
    bool directions = false;

    [[nodiscard]] int step() const { return 1 << number; }
};

inline bool isValid(const Level& level, uint32_t texel)
{
    return level.guides[texel].valid;
}

inline shading::Tap tapOn(const Level& level, uint32_t texel)
{
    const Guide& guide = level.guides[texel];
    shading::Tap tap = shading::noTap();
    tap.valid = guide.valid;
    tap.position = guide.place.position;
    tap.normal = guide.place.normal;
    tap.gathered = level.in.gathered[texel];
    if (!level.in.direct.empty()) tap.direct = level.in.direct[texel];
    if (level.directions) tap.moment = level.in.moments[texel];
    return tap;
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

    [[nodiscard]] NoisyLight middle() const { return {irradiance.at(kMiddleTap), variance[kMiddleTap]}; }
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
    TapColors position; ///< from the middle tap, metres
    TapColors normal;   ///< unit; 0 where the tap is not valid
    TapLights gathered;
    TapLights direct;
    TapColors moment;

    Taps(const Level& level, uint32_t texel)
    {
        const vec3 middle = level.guides[texel].place.position;
        for (int k = 0; k < kTaps; ++k) {
            const shading::Tap tap = shading::tapAt(level, texel, ivec2(tapX(k), tapY(k)) * level.step());
            if (tap.valid) set(std::size_t(k), tap, middle, level);
        }
    }

private:
    void set(std::size_t k, const shading::Tap& tap, vec3 middle, const Level& level)
    {
        valid[k] = 1.0f;
        position.set(k, tap.position - middle);
        normal.set(k, tap.normal);
        gathered.set(k, tap.gathered);
        if (!level.in.direct.empty()) direct.set(k, tap.direct);
        if (level.directions) moment.set(k, tap.moment);
    }
};

} // namespace halflight
