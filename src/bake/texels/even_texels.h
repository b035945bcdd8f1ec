#pragma once
// When a texel takes more points.

namespace halflight {

/// Irradiance is even over a texel if that of its points varies by no more than this share of the largest. Other texels
/// take further batches of points, because lightmaps and masks hold the mean.
constexpr float kEvenIrradiance = 0.05f;
/// The same of points with one normal and a light without edges. Sixteen points whose mean is the texel's middle have
/// no error of first order; that of second order is below 0.2 % then.
constexpr float kEvenOnAPlane = 0.5f;
/// Most batches of such texels: 1,024 points, whose mean is within 1/255 of a step's.
constexpr int kMostBatches = 64;

} // namespace halflight
