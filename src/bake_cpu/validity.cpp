#include "bake_cpu/validity.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr uint32_t kInsideSeed = 0x5eed0004u;
constexpr int kInsideRays = 4;

} // namespace

PointValidity::PointValidity(const PathTracer& paths, uint32_t seed) : paths_(paths), seed_(seed ^ kInsideSeed)
{
    const std::vector<uint8_t>& solid = paths.surfaces().geometry().solid;
    anySolid_ = std::find(solid.begin(), solid.end(), uint8_t(1)) != solid.end();
}

/// Whether a point lies inside geometry: most of a few rays leave more closed objects than they enter, or all of
/// them meet back faces first (single-sided shells that are not closed).
bool PointValidity::inside(const SurfacePoint& point, uint32_t id, uint64_t& rays) const
{
    const vec3 origin = paths_.rayOrigin(point);
    int insideSolids = 0;
    int backFaces = 0;
    for (int s = 0; s < kInsideRays; ++s) {
        const SurfaceTracer::Crossings crossings = crossingsFrom(point, origin, id, s, rays);
        insideSolids += crossings.solidsLeft > 0 ? 1 : 0;
        backFaces += crossings.backFaceFirst ? 1 : 0;
        // Two rays that agree are enough.
        if (s == 1 && insideSolids == 2) return true;
        if (s == 1 && insideSolids == 0 && backFaces < 2) return false;
    }
    return 2 * insideSolids > kInsideRays || backFaces == kInsideRays;
}

SurfaceTracer::Crossings PointValidity::crossingsFrom(const SurfacePoint& point, vec3 origin, uint32_t id, int sample,
                                                      uint64_t& rays) const
{
    Sampler sampler(seed_, id, uint32_t(sample));
    const SurfaceTracer::Crossings crossings =
        paths_.surfaces().crossings(origin, PathTracer::gatherDirection(point, sampler.next2()));
    rays += uint64_t(crossings.rays);
    return crossings;
}

bool PointValidity::maybeInside(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const
{
    if (!anySolid_) return false;
    for (int i = 0; i < std::min(pointCount, 4); ++i) {
        const SurfacePoint& point = points[std::size_t(i * pointCount / std::min(pointCount, 4))];
        const SurfaceTracer::Crossings c = crossingsFrom(point, paths_.rayOrigin(point), texelId, i, rays);
        if (c.solidsLeft > 0 || c.backFaceFirst) return true;
    }
    return false;
}

PointMask PointValidity::outside(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const
{
    PointMask mask = 0;
    int kept = 0;
    for (int p = 0; p < pointCount; ++p) {
        if (inside(points[std::size_t(p)], hashCombine(texelId, uint32_t(p)), rays)) continue;
        mask = PointMask(mask | (1u << p));
        ++kept;
    }
    return kept * 8 < pointCount ? PointMask(0) : mask;
}

void PointValidity::keep(PointMask mask, TexelPoints& points, int& pointCount)
{
    int kept = 0;
    for (int p = 0; p < pointCount; ++p) {
        if (mask & (1u << p)) points[std::size_t(kept++)] = points[std::size_t(p)];
    }
    pointCount = kept;
}

} // namespace halflight
