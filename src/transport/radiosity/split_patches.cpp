#include "transport/radiosity/split_patches.h"

#include "halflight/base/mathematics.h"
#include "halflight/shading/form_factors.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

RimPoints makeRimPoints()
{
    RimPoints rim{};
    for (int k = 0; k < 7; ++k) {
        const float angle = 2.0f * kPi * float(k) / 7.0f;
        float farthest = -1.0f;
        for (int i = 1; i < kMaxTexelPoints; ++i) {
            const vec2 place = r2Point(i) - 0.5f;
            const float out = glm::dot(place, vec2(math::cos(angle), math::sin(angle)));
            if (out <= farthest) continue;
            farthest = out;
            rim[std::size_t(k)] = {i, 0.5f / std::max(std::abs(place.x), std::abs(place.y))};
        }
    }
    return rim;
}

} // namespace

const RimPoints& rimPoints()
{
    static const RimPoints rim = makeRimPoints();
    return rim;
}

void OccluderSearch::search(std::span<const uint32_t> items)
{
    pass_.forGroups(items, [&](const TexelGroup& group) {
        for (int lane = 0; lane < group.lanes(); ++lane) {
            if (!group.active(lane)) continue;
            pass_.ofElements() ? searchElements(group, lane) : searchPatch(group, lane);
        }
    });
}

/// Rays from above a texel's first point to the border of the texel, and to the previous texel of the same patch.
void OccluderSearch::searchPatch(const TexelGroup& group, int lane)
{
    const TexelPoints& points = group.points(lane);
    const PatchId patch = pass_.sourceOf(group, lane, points[0]);
    if (patch == kNoPatch) return;
    const int count = group.pointCount(lane);
    const float lift = kLineLift * pass_.widthOf(patch, points[0].triangle);
    const auto abovePoint = [&](int number) {
        const SurfacePoint& p = points[std::size_t(std::min(number, count - 1))];
        return p.position + lift * p.geometricNormal;
    };
    const vec3 above = abovePoint(0);
    Targets targets;
    targets[0] = previousPatch_ == patch ? previous_ : above;
    const TexelMap& map = pass_.input().map;
    const bool whole =
        count == kMaxTexelPoints && coveredArea(map, map.texels[group.texel(lane)]) > shading::kWholeTexel;
    for (int i = 1; i < int(kTargets); ++i) {
        // The targets of partly covered texels are their sample points.
        const RimPoint& rim = rimPoints()[std::size_t(i - 1)];
        targets[std::size_t(i)] = whole ? above + rim.toBorder * (abovePoint(rim.point) - above) : abovePoint(i);
    }
    bool occluder = between(above, targets);
    if (!whole && count > int(kTargets)) {
        for (int i = 0; i < int(kTargets); ++i) targets[std::size_t(i)] = abovePoint(int(kTargets) + i);
        occluder = between(above, targets) || occluder;
    }
    if (occluder) occluded_.push_back(patch);
    previousPatch_ = patch;
    previous_ = above;
}

/// Rays from one point of each element to the element's border, or to its other points in partly covered texels.
void OccluderSearch::searchElements(const TexelGroup& group, int lane)
{
    std::array<PatchId, kMaxTexelPoints> elements;
    for (int p = 0; p < group.pointCount(lane); ++p) {
        const SurfacePoint& point = group.points(lane)[std::size_t(p)];
        elements[std::size_t(p)] = pass_.sourceOf(group, lane, point);
    }
    const auto end = elements.begin() + group.pointCount(lane);
    for (auto element = elements.begin(); element != end; ++element) {
        if (*element == kNoPatch || std::find(elements.begin(), element, *element) != element) continue;
        const SurfacePoint& point = group.points(lane)[std::size_t(element - elements.begin())];
        const float lift = kLineLift * pass_.widthOf(*element, point.triangle);
        const vec3 above = point.position + lift * point.geometricNormal;
        Targets targets;
        targets.fill(above);
        if (group.pointCount(lane) < kMaxTexelPoints || !borderOfElement(group, lane, point, above, targets)) {
            std::size_t count = 0;
            for (auto other = element + 1; other != end && count < targets.size(); ++other) {
                if (*other != *element) continue;
                const SurfacePoint& p = group.points(lane)[std::size_t(other - elements.begin())];
                targets[count++] = p.position + lift * p.geometricNormal;
            }
        }
        if (between(above, targets)) occluded_.push_back(*element);
    }
}

/// Corners and edge midpoints of a point's element, at the height of `above`. False for degenerate lightmap triangles.
bool OccluderSearch::borderOfElement(const TexelGroup& group, int lane, const SurfacePoint& point, vec3 above,
                                     Targets& targets) const
{
    FaceId face;
    if (!pass_.layout().faceOf(point.triangle, group.onBack(lane), face)) return false;
    const PatchLayout::Surface& surface = pass_.layout().surface(face);
    const PatchId patch = pass_.layout().patchAt(face, point.barycentric);
    const float size = 1.0f / float(1 << pass_.layout().elementShift(patch)); // in patches
    const vec2 at = surface.origin + point.barycentric.x * surface.edgeU + point.barycentric.y * surface.edgeV;
    if (std::abs(shading::areaOfEdges(surface.edgeU, surface.edgeV)) < 1.0e-12f) return false;
    const BakeGeometry& geometry = tracer_.geometry();
    const auto [a, b, c] = geometry.cornersOf(point.triangle);
    const vec3 edge1 = b - a;
    const vec3 edge2 = c - a;
    for (std::size_t i = 0; i < targets.size(); ++i) {
        const vec2 way = shading::wayToBorder(at, size, int(i));
        targets[i] = above + shading::wayOnTriangle(way, surface.edgeU, surface.edgeV, edge1, edge2);
    }
    return true;
}

/// Whether an occluder is between a point and a target. A blocked ray is traced in reverse too: if that ray leaves a
/// hidden back, the target is inside a solid or behind a shell, and the surface between is no occluder.
bool OccluderSearch::between(vec3 from, const Targets& targets)
{
    std::array<Ray, kTargets> batch;
    std::array<RayHit, kTargets> hits;
    for (std::size_t i = 0; i < kTargets; ++i) {
        const float length = glm::distance(from, targets[i]);
        if (!(length > 0.0f)) continue;
        batch[i] = {from, 0.0f, (targets[i] - from) / length, shading::kShortOfTarget * length};
        ++rays_;
    }
    tracer_.nearest(batch, hits);
    std::array<Ray, kTargets> reversed;
    bool any = false;
    for (std::size_t i = 0; i < kTargets; ++i) {
        if (!hits[i].found()) continue;
        any = true;
        const Ray& ray = batch[i];
        reversed[i] = {from + ray.tMax * ray.direction, 0.0f, -ray.direction, ray.tMax};
        ++rays_;
    }
    if (!any) return false;
    std::array<RayHit, kTargets> back;
    tracer_.nearest(reversed, back);
    for (std::size_t i = 0; i < kTargets; ++i) {
        if (hits[i].found() && !tracer_.hitHiddenBack(back[i])) return true;
    }
    return false;
}

} // namespace halflight
