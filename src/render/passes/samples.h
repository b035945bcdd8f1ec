#pragma once
// From the samples of a frame to its pixels.

#include "halflight/base/image.h"

namespace halflight {

/// Samples whose alpha is 0 show the sky. One of them alone among eight that show surfaces of about the same brightness
/// is a crack between triangles that do not share an edge (a T-junction), or a hole too small for the picture: it takes
/// their mean. Alpha is 1 everywhere in the result.
ImageRgba32f withoutCracks(ImageRgba32f samples);

/// Means of factor x factor blocks.
ImageRgba32f downsampled(const ImageRgba32f& samples, int factor);

} // namespace halflight
