#pragma once
// Edges where charts meet, found, weighted and made equal.

#include "halflight/bake/integrator.h"

#include <span>
#include <vector>

namespace halflight {

/// A point on an edge where two charts or objects meet on one smooth surface.
struct SeamSample {
    int objectA = 0; ///< index into Scene::objects
    int pageA = 0;
    int pageB = 0;
    vec2 texelA{0.0f};   ///< position on page A, in texels
    vec2 texelB{0.0f};   ///< position on page B
    float texels = 1.0f; ///< length that the sample represents, on the longer side
    bool bent = false;   ///< the triangles of both sides face differently, though the shading normals agree
    vec2 outwardA{0.0f}; ///< unit, on page A: at a right angle to the edge in the world, away from side A
    /// Offsets on page B for offsets on page A, with side A unfolded into the plane of side B.
    mat2 acrossFromA{1.0f};
    Segment sight; ///< from a point above side A to one above side B, less than a texel apart
};
std::vector<SeamSample> findSeams(const BakeGeometry& geometry, int pageSize);

/// Weight of each seam sample, 0…1: 1 if both sides are similar, 0 if one side has several times the other's light.
/// Gathered light may differ more at bends; `direct` is the part of `light` that lights contribute directly, without
/// pages where they contribute none. Needs dilated pages, because filtering at an edge reads padding.
std::vector<float> lightSeamWeights(const std::vector<SeamSample>& seams, const std::vector<ImageRgb32f>& light,
                                    const std::vector<ImageRgb32f>& direct);
/// The same for masks: 1 if both sides differ by up to a half.
std::vector<float> maskSeamWeights(const std::vector<SeamSample>& seams, const std::vector<ImageRgba32f>& masks);
/// Minimizes the difference of the bilinear values on both sides of the seams. Needs dilated pages; padding changes
/// more readily than covered texels. `bounded`: padding stays within the range of the adjacent covered texels; off for
/// extrapolated padding.
template<typename T> void stitchSeams(const TexelMap& map, const std::vector<SeamSample>& seams,
                                      std::span<const float> weights, std::vector<Image<T>>& pages,
                                      bool bounded = true);

} // namespace halflight
