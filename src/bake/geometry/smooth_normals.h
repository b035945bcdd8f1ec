#pragma once
// When two normals are on one surface.

namespace halflight {

/// Smallest cosine between normals on one side of a surface; below it there is a corner between them: 60 degrees.
constexpr float kSameSideCosine = 0.5f;
/// Smallest cosine between normals on a smooth surface, where light does not differ: 18 degrees.
constexpr float kSmoothCosine = 0.95f;

} // namespace halflight
