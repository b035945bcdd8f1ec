#pragma once

#include "halflight/base/image.h"

#include <vector>

namespace halflight {

/// Levels 1, 2, … down to 1 × 1 of an image by an area-weighted box filter; colours of sRGB images are averaged as
/// light.
std::vector<ImageRgba8> mipLevels(const ImageRgba8& image, bool srgb);

} // namespace halflight
