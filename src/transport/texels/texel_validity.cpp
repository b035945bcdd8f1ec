#include "transport/texels/texel_validity.h"

#include "halflight/shading/validity.h"

#include <algorithm>
#include <bit>

namespace halflight {
namespace {

using shading::kInsideSeed;
using shading::nthBit;
constexpr int kRaysOfTexel = shading::kValidityRays;
static_assert(shading::kShellRays == 2 * kMaxTexelPoints);

/// Whether mutually visible points may be behind a shell. Behind one, seven of eight of their rays hit hidden backs.
bool manyBacks(int backs, int rays)
{
    return 4 * backs >= rays;
}

} // namespace

TexelValidity::TexelValidity(const PathTracer& paths, bool leavesOpen) : paths_(paths), leavesOpen_(leavesOpen)
{
    const BakeGeometry& geometry = paths.surfaces().geometry();
    const std::vector<uint8_t>& solid = geometry.solid;
    anySolid_ = std::find(solid.begin(), solid.end(), uint8_t(1)) != solid.end();
    const Materials& materials = paths.surfaces().materials();
    const uint32_t count = geometry.triangleCount();
    for (uint32_t t = 0; t < count && !anyHiddenBack_; ++t) anyHiddenBack_ = materials.backIsHidden(t);
}

/// Origin of rays, at a height above the surface in metres.
vec3 TexelValidity::raised(const SurfacePoint& point, float lift) const
{
    return paths_.surfaces().rayOrigin(point) + lift * point.geometricNormal;
}

float TexelValidity::liftOf(const TexelPoints& points) const
{
    return kLineLift * paths_.surfaces().geometry().texelMeters(points[0].triangle);
}

/// Whether a group of mutually visible points is inside solids: most of up to 8 rays leave more solids than they enter.
bool TexelValidity::insideSolids(const TexelPoints& points, PointMask group, uint32_t id, uint64_t& rays) const
{
    const int count = std::popcount(group);
    int inside = 0;
    int rayCount = 0;
    while (rayCount < kRaysOfTexel) {
        const int s = rayCount++;
        const SurfacePoint& point = points[std::size_t(nthBit(group, s * count / kRaysOfTexel))];
        inside += solidsLeft(point, id, s, rays) > 0 ? 1 : 0;
        if (shading::solidIsFound(inside, rayCount)) break;
    }
    return 2 * inside > rayCount;
}

/// Points of `which` whose ray number `round` first hits a hidden back.
PointMask TexelValidity::hitBacks(const TexelPoints& points, PointMask which, uint32_t id, int round,
                                  uint64_t& rays) const
{
    const RayTracer& tracer = paths_.surfaces();
    std::array<Ray, kMaxTexelPoints> batch;
    std::array<RayHit, kMaxTexelPoints> found;
    std::array<int, kMaxTexelPoints> number{};
    std::size_t count = 0;
    for (; which != 0; which &= PointMask(which - 1u)) {
        const int p = std::countr_zero(which);
        const SurfacePoint& point = points[std::size_t(p)];
        Sampler sampler(kInsideSeed, hashCombine(id, uint32_t(p)), uint32_t(round));
        number[count] = p;
        batch[count++] = {paths_.surfaces().rayOrigin(point), 0.0f, gatherDirection(point, sampler.next2()), kInfinity};
    }
    rays += count;
    tracer.nearest({batch.data(), count}, {found.data(), count});
    PointMask hits = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (tracer.hitHiddenBack(found[i])) hits |= PointMask(1u << number[i]);
    }
    return hits;
}

/// Candidates whose rays, all but one at most, first hit hidden backs: points inside single-sided shells that are not
/// closed. A point outside, beside the shell's rim, hits such backs with some of its rays only.
PointMask TexelValidity::behindShells(const TexelPoints& points, PointMask candidates, uint32_t id,
                                      uint64_t& rays) const
{
    std::array<int, kMaxTexelPoints> backs{};
    PointMask open = candidates;
    for (int s = 0; s < kRaysOfTexel && open != 0; ++s) {
        const PointMask hit = hitBacks(points, open, id, s, rays);
        // One ray of a point may pass through a gap between surfaces.
        for (int p = 0; p < kMaxTexelPoints; ++p) {
            backs[std::size_t(p)] += (hit >> p) & 1;
            if (s - backs[std::size_t(p)] >= 1) open &= PointMask(~(1u << p));
        }
        if (shading::shellIsFound(s, hit == candidates, open == candidates, std::popcount(open))) break;
    }
    return open;
}

/// Candidates visible from the first one, which is among them.
PointMask TexelValidity::visibleFromFirst(const TexelPoints& points, PointMask candidates, uint64_t& rays) const
{
    return visibleFrom(points, std::countr_zero(candidates), candidates, 0.0f, rays);
}

PointMask TexelValidity::visibleFrom(const TexelPoints& points, int first, PointMask candidates, float lift,
                                     uint64_t& rays) const
{
    const auto above = [&](int p) { return raised(points[std::size_t(p)], lift); };
    const vec3 origin = above(first);
    auto visible = PointMask(1u << first);
    PointMask open = candidates & PointMask(~visible);
    std::array<Ray, kMaxTexelPoints> batch;
    std::array<bool, kMaxTexelPoints> hidden{};
    std::array<int, kMaxTexelPoints> number{};
    std::size_t count = 0;
    for (; open != 0; open &= PointMask(open - 1u)) {
        number[count] = std::countr_zero(open);
        // The direction is not normalized: 1 is the other point.
        batch[count] = {origin, 0.0f, above(number[count]) - origin, 1.0f};
        ++count;
    }
    rays += count;
    paths_.surfaces().occluded({batch.data(), count}, {hidden.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
        if (!hidden[i]) visible |= PointMask(1u << number[i]);
    }
    return visible;
}

int TexelValidity::solidsLeft(const SurfacePoint& point, uint32_t id, int sample, uint64_t& rays) const
{
    Sampler sampler(kInsideSeed, id, uint32_t(sample));
    ++rays;
    const Ray ray{paths_.surfaces().rayOrigin(point), 0.0f, gatherDirection(point, sampler.next2()), kInfinity};
    int left = 0;
    paths_.surfaces().crossings({&ray, 1}, {&left, 1});
    return left;
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
                                       uint32_t texelId, uint64_t& rays) const
{
    const auto all = PointMask((1u << pointCount) - 1u);
    PointMask mask = all & outsideSolids;
    mask &= PointMask(~behindShells(points, mask, texelId, rays));
    return mask == all ? kAllPoints : std::popcount(mask) * 8 < pointCount ? PointMask(0) : mask;
}

/// Tests texels whose points are all mutually visible, by points that are spread over them. False where these differ.
bool TexelValidity::testTogether(std::span<BlockTexel> texels, uint64_t& rays) const
{
    TexelPoints points;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const BlockTexel& texel = texels[k % texels.size()];
        points[k] = texel.points[k / texels.size() * std::size_t(texel.pointCount) / points.size()];
    }
    const uint32_t id = texels[0].id;
    bool inside = anySolid_ && insideSolids(points, kAllPoints, id, rays);
    if (!inside && manyBacks(std::popcount(hitBacks(points, kAllPoints, id, 0, rays)), kMaxTexelPoints)) {
        if (behindShells(points, kAllPoints, id, rays) != kAllPoints) return false;
        inside = true;
    }
    for (BlockTexel& t : texels) t.valid = inside ? PointMask(0) : kAllPoints;
    return true;
}

void TexelValidity::testBlock(std::span<BlockTexel> texels, uint64_t& rays) const
{
    if (!anyHiddenBack_) return;
    OrientedBox all = boxAlong(texels[0].points[0].geometricNormal);
    for (BlockTexel& t : texels) {
        t.box = boxAlong(texels[0].points[0].geometricNormal);
        for (int p = 0; p < t.pointCount; ++p) t.box.extend(raised(t.points[std::size_t(p)], liftOf(t.points)));
        all.bounds.extend(t.box.bounds);
    }
    const NearTriangles near(paths_.surfaces(), all);
    if (near.isEmpty(all) && testTogether(texels, rays)) return;
    for (BlockTexel& t : texels)
        if (t.wanted) testOne(t, near, rays);
}

void TexelValidity::testOne(BlockTexel& t, const NearTriangles& near, uint64_t& rays) const
{
    PointMask some = 0; // spread over the texel
    for (int k = 0; k < kRaysOfTexel; ++k) some |= PointMask(1u << (k * t.pointCount / kRaysOfTexel));
    const auto all = PointMask((1u << t.pointCount) - 1u);
    const bool nothingBetween = near.isEmpty(t.box);
    const int backs = std::popcount(hitBacks(t.points, some, t.id, 0, rays));
    const bool outsideShells = backs == 0 || (nothingBetween && !manyBacks(backs, kRaysOfTexel));
    if (outsideShells && (nothingBetween || visibleFrom(t.points, 0, all, liftOf(t.points), rays) == all))
        t.valid = anySolid_ && insideSolids(t.points, all, t.id, rays) ? PointMask(0) : kAllPoints;
    else if (leavesOpen_)
        t.open = true;
    else
        t.valid = validPoints(t.points, t.pointCount, t.id, rays);
}

PointMask TexelValidity::validPoints(const TexelPoints& points, int pointCount, uint32_t texelId, uint64_t& rays) const
{
    const PointMask mask = outsideSolids(points, pointCount, texelId, rays);
    return outsideShells(points, pointCount, mask, texelId, rays);
}

} // namespace halflight
