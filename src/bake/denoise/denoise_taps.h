#pragma once
// What one level of the denoiser's filter reads around a texel: values at 5 × 5 taps, side by side for vector
// instructions.

#include "bake/denoise/denoise.h"
#include "bake/denoise/tap.h"
#include "bake/seams/surface_grid.h"
#include "bake/texels/texel_places.h"

#include <array>
#include <span>
#include <vector>

namespace halflight {

using shading::kMiddleTap;
using shading::kTaps;
using shading::tapX;
using shading::tapY;

constexpr int kPaddedTaps = 28; ///< a multiple of the vectors' width; taps from kTaps on are not valid

using TapFloats = std::array<float, kPaddedTaps>; ///< a value of each tap

struct DenoiseGuide {
    TexelPlace place;
    bool valid = false;
};

/// One level of the filter: the places of its taps, by texel.
struct Level {
    const SurfaceGrid& grid;
    std::span<const DenoiseGuide> guides;
    int number = 0; ///< taps are 2^number texels apart

    [[nodiscard]] int step() const { return 1 << number; }
};

inline bool isValid(const Level& level, uint32_t texel)
{
    return level.guides[texel].valid;
}
/// The place alone.
inline shading::Tap tapOn(const Level& level, uint32_t texel)
{
    const DenoiseGuide& guide = level.guides[texel];
    shading::Tap tap = shading::noTap();
    tap.valid = guide.valid;
    tap.position = guide.place.position;
    tap.normal = guide.place.normal;
    return tap;
}

/// The light that one level of the filter reads.
struct LightLevel {
    const Signals& in;
    int number = 0;
};

/// The light alone.
inline shading::Tap tapOn(const LightLevel& level, uint32_t texel)
{
    shading::Tap tap = shading::noTap();
    tap.gathered = level.in.gathered[texel];
    if (!level.in.direct.empty()) tap.direct = level.in.direct[texel];
    if (!level.in.moments.empty()) tap.moment = level.in.moments[texel];
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
    /// Of valid taps: the texel on the middle's chart; kNowhere beyond that.
    std::array<uint32_t, kTaps> texels;
    std::array<shading::Footprint, kTaps> beyond; ///< texels of the others

    Taps(const Level& level, uint32_t texel)
    {
        const vec3 middle = level.guides[texel].place.position;
        for (int i = 0; i < kTaps; ++i) {
            const auto k = std::size_t(i);
            const ivec2 offset = ivec2(tapX(i), tapY(i)) * level.step();
            shading::Tap tap = shading::noTap();
            texels[k] = shading::texelOnChart(level.grid, texel, offset);
            if (texels[k] != shading::kNowhere) {
                tap = tapOn(level, texels[k]);
            } else {
                beyond[k] = shading::partBeyond(level, texel, offset);
                shading::setPlace(level, beyond[k], tap);
            }
            if (!tap.valid) continue;
            valid[k] = 1.0f;
            position.set(k, tap.position - middle);
            normal.set(k, tap.normal);
        }
    }
};

/// The light of a texel's taps.
struct LightTaps {
    TapLights gathered;
    TapLights direct;
    TapColors moment;

    LightTaps(const LightLevel& level, const Taps& taps)
    {
        for (std::size_t k = 0; k < kTaps; ++k) {
            if (taps.valid[k] == 0.0f) continue;
            shading::Tap tap = shading::noTap();
            if (taps.texels[k] != shading::kNowhere)
                tap = tapOn(level, taps.texels[k]);
            else
                shading::setLight(level, taps.beyond[k], tap);
            gathered.set(k, tap.gathered);
            if (!level.in.direct.empty()) direct.set(k, tap.direct);
            if (!level.in.moments.empty()) moment.set(k, tap.moment);
        }
    }
};

} // namespace halflight
