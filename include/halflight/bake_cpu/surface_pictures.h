#pragma once
// Pictures of lit surfaces for viewers that read no lightmap: the light that lightmapped surfaces send out, in the
// layout of the lightmap's pages.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <vector>

namespace halflight {

/// Radiance of each lightmapped surface in cd/m2, the same to all sides: diffuse reflection of its irradiance by
/// shading::transportAlbedo(), dimmed by its occlusion texture, and its emission. Alpha is opacity: the share of a
/// masked or blended surface that is there, 1 elsewhere, 0 where no surface is.
///
/// `irradiance`: BakeResult::irradiance, lux. `scale`: texels of a picture per lightmap texel and side, so that
/// textures finer than the lightmap show; light is interpolated. Surfaces without texels and unlit ones are left out.
/// Errors: Cancelled.
Result<std::vector<ImageRgba32f>> surfacePictures(const Scene& scene, const std::vector<ImageRgb32f>& irradiance,
                                                  int scale, const Progress& progress = {});

/// The EV at which one texel in twenty is brighter than white.
float surfaceExposure(const std::vector<ImageRgba32f>& pictures);

/// Pictures as sRGB in 8 bits.
struct DisplayedSurfaces {
    std::vector<ImageRgba8> pages;
    float strength = 1.0f; ///< what a texel of 1 stands for, in exposed light
    double clipped = 0.0;  ///< share of the surfaces' texels with a channel above `strength`
};

/// Exposes (radiance · 2^-ev) and clamps at `strength`; no tone mapping.
DisplayedSurfaces displayedSurfaces(const std::vector<ImageRgba32f>& pictures, float exposureEv, float strength = 1.0f);

/// The strength that clips at most one texel in a thousand, from 1 to 16.
float surfaceStrength(const std::vector<ImageRgba32f>& pictures, float exposureEv);

} // namespace halflight
