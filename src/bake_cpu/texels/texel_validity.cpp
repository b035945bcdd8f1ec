#include "bake_cpu/texels/texel_validity.h"

#include <algorithm>
#include <bit>

namespace halflight {
namespace {

constexpr uint32_t kInsideSeed = 0x5eed0004u;
constexpr int kRays = 8;
constexpr int kFewRays = 3;
constexpr int kEnoughBacks = 5;
constexpr int kManyBacks = 32;
constexpr int kManyMoreBacks = 16; ///< where some rays met nothing else before
constexpr int kEnoughInSolids = 8;
constexpr int kOtherRay = kRays; ///< number of a ray that is none of the others

/// Number of the n-th bit that is set.
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

/// Whether points that see one another lie inside solids: whether most of a few rays leave more of them than they
/// enter. From inside of something that is closed all do: the first one that does not settles it.
bool TexelValidity::insideSolids(const TexelPoints& points, PointMask together, uint32_t id, uint64_t& rays) const
{
    const int count = std::popcount(together);
    int inside = 0;
    int rayCount = 0;
    while (rayCount < kRays) {
        const int s = rayCount++;
        const SurfacePoint& point = points[std::size_t(nthBit(together, s * count / kRays))];
        inside += crossingsFrom(point, id, s, rays).solidsLeft > 0 ? 1 : 0;
        if (inside == 0) return false;
        // A few rays that agree are enough.
        if (rayCount == kFewRays && inside == kFewRays) break;
    }
    return 2 * inside > rayCount;
}

/// Those of some points of which a ray meets the hidden back of a surface first, or the inside of a solid; `round`
/// numbers a point's rays.
TexelValidity::MetPoints TexelValidity::meetBacks(const TexelPoints& points, PointMask which, bool ofSolids,
                                                  uint32_t id, int round, uint64_t& rays) const
{
    const RayTracer& tracer = paths_.surfaces();
    RTCRayHit8 packet;
    alignas(32) embree::LaneMask valid;
    MetPoints met;
    while (which != 0) {
        std::array<int, embree::kPacket> number{};
        RayTracer::clear(packet.ray);
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
            if (valid.lane[lane] == 0 || packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
            if (!embree::behind(packet, lane)) continue;
            const uint32_t triangle = tracer.triangleOf(packet.hit.geomID[lane], packet.hit.primID[lane]);
            const bool counts = ofSolids ? tracer.geometry().solid[triangle] != 0 : tracer.backIsHidden(triangle);
            if (!counts) continue;
            met.points |= PointMask(1u << number[std::size_t(lane)]);
            met.nearest = std::min(met.nearest, packet.ray.tfar[lane]);
        }
    }
    return met;
}

/// Those of `candidates` whose rays meet the hidden backs of surfaces first, (nearly) all of them: points inside
/// single-sided shells that are not closed. A point beside the rim of one sees those inside.
PointMask TexelValidity::behindSurfaces(const TexelPoints& points, PointMask candidates, bool allHidden, uint32_t id,
                                        uint64_t& rays) const
{
    std::array<int, kMaxTexelPoints> backs{};
    PointMask open = candidates;
    PointMask behind = 0;
    const int enough = allHidden ? kManyMoreBacks : kManyBacks;
    for (int s = 0; s < kRays && open != 0; ++s) {
        const PointMask met = meetBacks(points, open, false, id, s, rays).points;
        // One ray may slip through between surfaces.
        for (int p = 0; p < kMaxTexelPoints; ++p) {
            backs[std::size_t(p)] += (met >> p) & 1;
            if (s - backs[std::size_t(p)] >= 1) open &= PointMask(~(1u << p));
            if (s + 1 != kEnoughBacks || backs[std::size_t(p)] != kEnoughBacks) continue;
            behind |= open & PointMask(1u << p);
            open &= PointMask(~(1u << p));
        }
        // Many points of which no ray has seen anything else.
        const bool allMet = s == 0 ? met == candidates : open == candidates;
        if (allMet && std::popcount(open) * (s + 1) >= enough) break;
    }
    return behind | open;
}

/// Those of `candidates` that nothing hides from the first of them, which is one of the answer.
PointMask TexelValidity::seenFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const
{
    const int first = std::countr_zero(candidates);
    const vec3 origin = paths_.rayOrigin(points[std::size_t(first)]);
    auto seen = PointMask(1u << first);
    PointMask open = candidates & PointMask(~seen);
    RTCRay8 packet;
    alignas(32) embree::LaneMask valid;
    while (open != 0) {
        std::array<int, embree::kPacket> point{};
        RayTracer::clear(packet);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            valid.lane[lane] = open != 0 ? -1 : 0;
            if (open == 0) continue;
            point[std::size_t(lane)] = std::countr_zero(open);
            open &= PointMask(open - 1u);
            // As long as the way is, the direction is.
            const vec3 way = paths_.rayOrigin(points[std::size_t(point[std::size_t(lane)])]) - origin;
            embree::setRay(packet, lane, origin, way);
            packet.tfar[lane] = 1.0f;
            ++rays;
        }
        paths_.surfaces().occluded(valid, packet);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            if (valid.lane[lane] != 0 && packet.tfar[lane] >= 0.0f) {
                seen |= PointMask(1u << point[std::size_t(lane)]);
            }
        }
    }
    return seen;
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
    // Points that see one another are in the same solids.
    while (open != 0) {
        const PointMask together = seenFromFirst(points, open, rays);
        const uint32_t id = hashCombine(texelId, uint32_t(std::countr_zero(open)));
        if (!insideSolids(points, together, id, rays)) mask |= together;
        open &= PointMask(~together);
    }
    return mask == all ? kAllPoints : mask;
}

PointMask TexelValidity::outsideShells(const TexelPoints& points, int pointCount, PointMask outsideSolids,
                                       bool allHidden, uint32_t texelId, uint64_t& rays) const
{
    const auto all = PointMask((1u << pointCount) - 1u);
    PointMask mask = all & outsideSolids;
    mask &= PointMask(~behindSurfaces(points, mask, allHidden, texelId, rays));
    return mask == all ? kAllPoints : std::popcount(mask) * 8 < pointCount ? PointMask(0) : mask;
}

/// Whether points lie outside of geometry that see one another, and that all geometry is so far away from that they see
/// the same of it; nothing where they are to be looked at one by one. Something low on the surface may hide some of
/// them and stand between none, but is near.
std::optional<bool> TexelValidity::outsideTogether(const TexelPoints& points, int pointCount, const Met& met,
                                                   uint32_t id, uint64_t& rays) const
{
    constexpr float kNearInTexels = 2.0f;
    const float near = kNearInTexels * paths_.surfaces().geometry().texelMeters(points[0].triangle);
    if (!met.together || met.backs.nearest < near) return std::nullopt;
    const auto all = PointMask((1u << pointCount) - 1u);
    if (met.backs.solids > 0 && insideSolids(points, all, id, rays)) return false;
    // Few rays tell where most meet one thing; where they do not, a fifth has to meet something else than backs.
    constexpr int kEnoughOthers = 4;
    constexpr int kBacksForOneOther = 12;
    constexpr int kMostRays = 40;
    int rayCount = met.rays;
    int others = met.rays - met.backs.hidden;
    for (int round = 0;; ++round) {
        if (others >= kEnoughOthers && 4 * others >= rayCount) return true;
        if (rayCount >= kBacksForOneOther * (others + 1)) return false;
        if (rayCount >= kMostRays) return 5 * others >= rayCount;
        // Every other point, then the rest.
        const auto some = PointMask(all & (round % 2 == 0 ? 0x5555u : 0xaaaau));
        const PointMask which = some != 0 ? some : all;
        const MetPoints found = meetBacks(points, which, false, id, round / 2, rays);
        if (found.nearest < near) return std::nullopt;
        rayCount += std::popcount(which);
        others += std::popcount(which) - std::popcount(found.points);
    }
}

PointMask TexelValidity::outside(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const
{
    const PointMask mask = outsideSolids(points, pointCount, texelId, rays);
    return outsideShells(points, pointCount, mask, false, texelId, rays);
}

PointMask TexelValidity::outside(const TexelPoints& points, int pointCount, Met met, uint32_t texelId,
                                 uint64_t& rays) const
{
    // Where all rays, from as many points, met the inside of solids, there is nothing to look for.
    if (met.backs.solids == met.rays && pointCount == kMaxTexelPoints) {
        if (met.rays >= kEnoughInSolids) return 0;
        while (std::popcount(met.others) > embree::kPacket) met.others &= PointMask(met.others - 1u);
        if (meetBacks(points, met.others, true, texelId, kOtherRay, rays).points == met.others) return 0;
    }
    if (const auto all = outsideTogether(points, pointCount, met, texelId, rays)) return *all ? kAllPoints : 0;
    const PointMask mask = met.backs.solids > 0 ? outsideSolids(points, pointCount, texelId, rays) : kAllPoints;
    return outsideShells(points, pointCount, mask, met.backs.hidden == met.rays, texelId, rays);
}

void TexelValidity::keep(PointMask mask, TexelPoints& points, int& pointCount)
{
    int kept = 0;
    for (int p = 0; p < pointCount; ++p) {
        if (mask & (1u << p)) points[std::size_t(kept++)] = points[std::size_t(p)];
    }
    pointCount = kept;
}

} // namespace halflight
