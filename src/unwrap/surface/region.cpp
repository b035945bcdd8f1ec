#include "unwrap/surface/region.h"

#include "halflight/base/mathematics.h"

#include <algorithm>

namespace halflight::charts {

NormalCone merged(const NormalCone& a, const NormalCone& b)
{
    const double between = math::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0));
    if (between + b.angle <= a.angle) return a;
    if (between + a.angle <= b.angle) return b;
    const double angle = 0.5 * (a.angle + b.angle + between);
    const dvec3 aside = b.axis - glm::dot(a.axis, b.axis) * a.axis;
    const double asideLength = glm::length(aside);
    if (angle >= 3.1 || asideLength < 1e-12) return {a.axis, std::max(angle, a.angle)};
    const double turn = angle - a.angle;
    return {math::cos(turn) * a.axis + math::sin(turn) / asideLength * aside, angle};
}

void RegionMeasure::join(const RegionMeasure& other, double shared)
{
    vectorArea += other.vectorArea;
    area += other.area;
    perimeter = std::max(perimeter + other.perimeter - 2.0 * shared, 0.0);
    cone = merged(cone, other.cone);
}

double JoinRules::cost(const RegionMeasure& a, const RegionMeasure& b, const Border& border) const
{
    const double bend = border.length > 0.0 ? border.bend / border.length : 0.0;
    if (bend > mostBend) return kForbidden;
    const double flatnessLost = 1.0 - glm::length(a.vectorArea + b.vectorArea) / (a.area + b.area);
    if (flatnessLost > mostFlatnessLost) return kForbidden;
    if (widestCone < kAnyCone && merged(a.cone, b.cone).angle > widestCone) return kForbidden;
    const double ragged = 1.0 - border.length / std::max(std::min(a.perimeter, b.perimeter), 1e-300);
    double cost = flatnessLost + 0.3 * bend + raggedWeight * std::max(ragged, 0.0);
    if (longWeight > 0.0) {
        const double perimeter = a.perimeter + b.perimeter - 2.0 * border.length;
        cost += longWeight * perimeter * perimeter / (a.area + b.area);
    }
    return cost;
}

} // namespace halflight::charts
