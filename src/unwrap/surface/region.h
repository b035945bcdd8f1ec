#pragma once
// What is known of a set of triangles without looking at them, and what it costs to join two.

#include "unwrap/surface/surface.h"

namespace halflight::charts {

struct Border {
    double length = 0.0;
    double bend = 0.0; ///< integral of 1 - cos(angle between the normals) along it
};

struct NormalCone {
    dvec3 axis{0.0};
    double angle = 0.0;
};

/// Smallest cone around two cones.
NormalCone merged(const NormalCone& a, const NormalCone& b);

struct RegionMeasure {
    dvec3 vectorArea{0.0};
    double area = 0.0;
    double perimeter = 0.0;
    NormalCone cone;

    /// Takes in a region along a border of that length.
    void join(const RegionMeasure& other, double shared);
};

inline constexpr double kForbidden = 1e30;
inline constexpr double kAnyCone = 4.0;

struct JoinRules {
    double mostFlatnessLost; ///< share of its area that a region may lose when projected along its mean normal
    double mostBend;         ///< mean bend along a border that may be merged away
    double widestCone;       ///< radians; no normal leaves a region's mean normal by more
    double raggedWeight;     ///< what a border costs that is but a small part of the outlines
    double longWeight = 0.0; ///< what an outline costs that is long for its area

    /// Cost of joining two regions, or kForbidden.
    [[nodiscard]] double cost(const RegionMeasure& a, const RegionMeasure& b, const Border& border) const;
};

} // namespace halflight::charts
