#pragma once
// When a texel takes more points.

namespace halflight {

/// Irradiance is even over a texel if that of its points varies by no more than this share of the largest. Other texels
/// take further batches of points, because lightmaps and masks hold the mean.
constexpr float kEvenIrradiance = 0.05f;
/// Most batches of such texels: 1,024 points, whose mean is within 1/255 of a step's.
constexpr int kMostBatches = 64;

} // namespace halflight
