#include "bake_cpu/texels/texel_validity.h"

#include <algorithm>
#include <bit>

namespace halflight {
namespace {

constexpr uint32_t kInsideSeed = 0x5eed0004u;
/// Rays per group of points in solids, and per point behind shells.
constexpr int kRays = 8;
constexpr int kFewRays = 3;           ///< enough if all of them agree
constexpr int kEnoughBacks = 5;       ///< hidden backs hit by all rays of one point
constexpr int kManyBacks = 32;        ///< hidden backs hit by all rays of all points together
constexpr int kManyMoreBacks = 16;    ///< the same after earlier rays that hit nothing else
constexpr int kEnoughInSolids = 8;    ///< backs of solids hit by all rays of a texel
constexpr int kUntestedRound = kRays; ///< number of the ray of points that no ray has left yet

/// Index of the n-th bit that is set.
int nthBit(PointMask mask, int n)
{
    for (; n > 0; --n) mask &= PointMask(mask - 1u);
    return std::countr_zero(mask);
}

} // namespace

TexelValidity::TexelValidity(const PathTracer& paths) : paths_(paths)
{
    const std::vector<uint8_t>& solid = paths.surfaces().geometry().solid;
    anySolid_ = std::find(solid.begin(), solid.end(), uint8_t(1)) != solid.end();
}

/// Whether a group of mutually visible points is inside solids: most of up to 8 rays leave more solids than they enter.
/// Inside a closed solid all rays do, so the first ray that does not ends the test.
bool TexelValidity::insideSolids(const TexelPoints& points, PointMask group, uint32_t id, uint64_t& rays) const
{
    const int count = std::popcount(group);
    int inside = 0;
    int rayCount = 0;
    while (rayCount < kRays) {
        const int s = rayCount++;
        const SurfacePoint& point = points[std::size_t(nthBit(group, s * count / kRays))];
        inside += crossingsFrom(point, id, s, rays).solidsLeft > 0 ? 1 : 0;
        if (inside == 0) return false;
        if (rayCount == kFewRays && inside == kFewRays) break;
    }
    return 2 * inside > rayCount;
}

/// Points of `which` whose ray number `round` first hits a hidden back, or the back of a solid.
TexelValidity::BackHits TexelValidity::hitBacks(const TexelPoints& points, PointMask which, bool ofSolids, uint32_t id,
                                                int round, uint64_t& rays) const
{
    const RayTracer& tracer = paths_.surfaces();
    RTCRayHit8 packet;
    alignas(32) embree::LaneMask valid;
    BackHits hits;
    while (which != 0) {
        std::array<int, embree::kPacket> number{};
        embree::clear(packet.ray);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            valid.lane[lane] = which != 0 ? -1 : 0;
            if (which == 0) continue;
            const int p = std::countr_zero(which);
            which &= PointMask(which - 1u);
            number[std::size_t(lane)] = p;
            const SurfacePoint& point = points[std::size_t(p)];
            Sampler sampler(kInsideSeed, hashCombine(id, uint32_t(p)), uint32_t(round));
            embree::setRay(packet.ray, lane, paths_.rayOrigin(point),
                           PathTracer::gatherDirection(point, sampler.next2()));
            ++rays;
        }
        tracer.intersect(valid, packet);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            if (valid.lane[lane] == 0 || !embree::found(packet, lane)) continue;
            if (!embree::hitBack(packet, lane)) continue;
            const uint32_t triangle = tracer.triangleOf(packet.hit.geomID[lane], packet.hit.primID[lane]);
            const bool counts =
                ofSolids ? tracer.geometry().solid[triangle] != 0 : tracer.materials().backIsHidden(triangle);
            if (!counts) continue;
            hits.points |= PointMask(1u << number[std::size_t(lane)]);
            hits.nearest = std::min(hits.nearest, packet.ray.tfar[lane]);
        }
    }
    return hits;
}

/// Candidates whose rays, all but one at most, first hit hidden backs: points inside single-sided shells that are not
/// closed. A point outside, beside the shell's rim, hits such backs with some of its rays only.
PointMask TexelValidity::behindShells(const TexelPoints& points, PointMask candidates, bool allHidden, uint32_t id,
                                      uint64_t& rays) const
{
    std::array<int, kMaxTexelPoints> backs{};
    PointMask open = candidates;
    PointMask behind = 0;
    const int enough = allHidden ? kManyMoreBacks : kManyBacks;
    for (int s = 0; s < kRays && open != 0; ++s) {
        const PointMask hit = hitBacks(points, open, false, id, s, rays).points;
        // One ray of a point may pass through a gap between surfaces.
        for (int p = 0; p < kMaxTexelPoints; ++p) {
            backs[std::size_t(p)] += (hit >> p) & 1;
            if (s - backs[std::size_t(p)] >= 1) open &= PointMask(~(1u << p));
            if (s + 1 != kEnoughBacks || backs[std::size_t(p)] != kEnoughBacks) continue;
            behind |= open & PointMask(1u << p);
            open &= PointMask(~(1u << p));
        }
        // The test ends early if all rays of many points hit hidden backs.
        const bool allHit = s == 0 ? hit == candidates : open == candidates;
        if (allHit && std::popcount(open) * (s + 1) >= enough) break;
    }
    return behind | open;
}

/// Candidates visible from the first one, which is among them.
PointMask TexelValidity::visibleFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const
{
    const int first = std::countr_zero(candidates);
    const vec3 origin = paths_.rayOrigin(points[std::size_t(first)]);
    auto visible = PointMask(1u << first);
    PointMask open = candidates & PointMask(~visible);
    RTCRay8 packet;
    alignas(32) embree::LaneMask valid;
    while (open != 0) {
        std::array<int, embree::kPacket> point{};
        embree::clear(packet);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            valid.lane[lane] = open != 0 ? -1 : 0;
            if (open == 0) continue;
            point[std::size_t(lane)] = std::countr_zero(open);
            open &= PointMask(open - 1u);
            // The direction is not normalized: tfar 1 is the other point.
            const vec3 way = paths_.rayOrigin(points[std::size_t(point[std::size_t(lane)])]) - origin;
            embree::setRay(packet, lane, origin, way);
            packet.tfar[lane] = 1.0f;
            ++rays;
        }
        paths_.surfaces().occluded(valid, packet);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            if (valid.lane[lane] != 0 && packet.tfar[lane] >= 0.0f) {
                visible |= PointMask(1u << point[std::size_t(lane)]);
            }
        }
    }
    return visible;
}

RayTracer::Crossings TexelValidity::crossingsFrom(const SurfacePoint& point, uint32_t id, int sample,
                                                  uint64_t& rays) const
{
    Sampler sampler(kInsideSeed, id, uint32_t(sample));
    const RayTracer::Crossings crossings =
        paths_.surfaces().crossings(paths_.rayOrigin(point), PathTracer::gatherDirection(point, sampler.next2()));
    rays += uint64_t(crossings.rays);
    return crossings;
}

PointMask TexelValidity::outsideSolids(const TexelPoints& points, int pointCount, uint32_t texelId,
                                       uint64_t& rays) const
{
    if (!anySolid_) return kAllPoints;
    const auto all = PointMask((1u << pointCount) - 1u);
    PointMask open = all;
    PointMask mask = 0;
    // Mutually visible points are inside the same solids.
    while (open != 0) {
        const PointMask group = visibleFromFirst(points, open, rays);
        const uint32_t id = hashCombine(texelId, uint32_t(std::countr_zero(open)));
        if (!insideSolids(points, group, id, rays)) mask |= group;
        open &= PointMask(~group);
    }
    return mask == all ? kAllPoints : mask;
}

PointMask TexelValidity::outsideShells(const TexelPoints& points, int pointCount, PointMask outsideSolids,
                                       bool allHidden, uint32_t texelId, uint64_t& rays) const
{
    const auto all = PointMask((1u << pointCount) - 1u);
    PointMask mask = all & outsideSolids;
    mask &= PointMask(~behindShells(points, mask, allHidden, texelId, rays));
    return mask == all ? kAllPoints : std::popcount(mask) * 8 < pointCount ? PointMask(0) : mask;
}

/// Whether mutually visible points, all far from geometry, are outside it; nothing if the points have to be tested one
/// by one. A surface that lies low above some of the points is between none of them, but it is near.
std::optional<bool> TexelValidity::validTogether(const TexelPoints& points, int pointCount, const FirstHits& hits,
                                                 uint32_t id, uint64_t& rays) const
{
    constexpr float kNearInTexels = 2.0f;
    const float near = kNearInTexels * paths_.surfaces().geometry().texelMeters(points[0].triangle);
    if (!hits.mutuallyVisible || hits.backs.nearest < near) return std::nullopt;
    const auto all = PointMask((1u << pointCount) - 1u);
    if (hits.backs.solids > 0 && insideSolids(points, all, id, rays)) return false;
    // Sequential test of the share of rays that hit anything but hidden backs. It ends early above a quarter and below
    // a twelfth; after 40 rays a fifth decides.
    constexpr int kEnoughOthers = 4;
    constexpr int kBacksForOneOther = 12;
    constexpr int kMostRays = 40;
    int rayCount = hits.rays;
    int others = hits.rays - hits.backs.hidden;
    for (int round = 0;; ++round) {
        if (others >= kEnoughOthers && 4 * others >= rayCount) return true;
        if (rayCount >= kBacksForOneOther * (others + 1)) return false;
        if (rayCount >= kMostRays) return 5 * others >= rayCount;
        // Even points and odd points alternate.
        const auto some = PointMask(all & (round % 2 == 0 ? 0x5555u : 0xaaaau));
        const PointMask which = some != 0 ? some : all;
        const BackHits found = hitBacks(points, which, false, id, round / 2, rays);
        if (found.nearest < near) return std::nullopt;
        rayCount += std::popcount(which);
        others += std::popcount(which) - std::popcount(found.points);
    }
}

PointMask TexelValidity::validPoints(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const
{
    const PointMask mask = outsideSolids(points, pointCount, texelId, rays);
    return outsideShells(points, pointCount, mask, false, texelId, rays);
}

PointMask TexelValidity::validPoints(const TexelPoints& points, int pointCount, FirstHits hits, uint32_t texelId,
                                     uint64_t& rays) const
{
    // If the rays of all points hit backs of solids, the texel is invalid. Untested points trace one ray each.
    if (hits.backs.solids == hits.rays && pointCount == kMaxTexelPoints) {
        if (hits.rays >= kEnoughInSolids) return 0;
        while (std::popcount(hits.untested) > embree::kPacket) hits.untested &= PointMask(hits.untested - 1u);
        if (hitBacks(points, hits.untested, true, texelId, kUntestedRound, rays).points == hits.untested) return 0;
    }
    if (const auto all = validTogether(points, pointCount, hits, texelId, rays)) return *all ? kAllPoints : 0;
    const PointMask mask = hits.backs.solids > 0 ? outsideSolids(points, pointCount, texelId, rays) : kAllPoints;
    return outsideShells(points, pointCount, mask, hits.backs.hidden == hits.rays, texelId, rays);
}

} // namespace halflight
