#pragma once
// Equirectangular pictures of the sky.

#include "halflight/base/image.h"

#include <filesystem>
#include <string>
#include <vector>

namespace halflight {

/// The most texels of a picture that is read: 8192 x 4096.
constexpr int64_t kMostSkyPictureTexels = int64_t(1) << 25;

/// Reads a Radiance picture (.hdr) or an OpenEXR file, told apart by content, of at most kMostSkyPictureTexels.
/// Values are radiance. A negative one, or one that is not a number, is read as 0, an infinite one as the brightest
/// finite one, at least 65504; `warnings`, where given, says how many texels have some. A Radiance picture's EXPOSURE
/// and COLORCORR are taken out. A picture wider than kMostSkyTexels is reduced to that.
Result<ImageRgb32f> readSkyPicture(const std::filesystem::path& path, std::vector<std::string>* warnings = nullptr);

/// Widest picture that a scene has, in texels: 0.09 degrees each, a sixth of the sun.
constexpr int kMostSkyTexels = 4096;

/// The picture with at most `width` texels a row, and rows in proportion. A texel is the mean of what it covers by
/// solid angle, so that the picture's light stays the same.
ImageRgb32f reducedSkyPicture(const ImageRgb32f& picture, int width);
/// The same with a size, which is no larger than the picture's.
ImageRgb32f reducedSkyPicture(const ImageRgb32f& picture, ivec2 size);

/// The share of the sphere between two heights of a picture, 0 = top, 1 = bottom.
double skyShareBetween(double v0, double v1);

} // namespace halflight
