#include "transport/texels/sparse_grid.h"

#include <bit>

namespace halflight {
namespace {

constexpr float kCovered = 0.999f;
/// Limits of a smooth surface. Cosine of the angle between the normals of a texel and an anchor: 4 degrees.
constexpr float kCosBend = 0.9976f;
/// Distance of a texel from the mean of its anchors, as a share of its distance to them.
constexpr float kOffCenter = 0.1f;

} // namespace

int SparseGrid::spacingOf(uint32_t texel) const
{
    const Texel& t = map_.texels[texel];
    return 1 << std::countr_zero(uint32_t(t.x) | uint32_t(t.y) | uint32_t(step_));
}

SparseGrid::Offsets SparseGrid::offsetsOf(uint32_t texel) const
{
    const int spacing = spacingOf(texel);
    if (spacing >= step_) return {};
    const int dx = map_.texels[texel].x & spacing;
    const int dy = map_.texels[texel].y & spacing;
    // Two neighbours along an axis if the texel is on the coarser grid in the other axis, else four at the corners.
    return {{ivec2(-dx, -dy), ivec2(dx, dy), ivec2(dx, -dy), ivec2(-dx, dy)}, dx != 0 && dy != 0 ? 4 : 2};
}

bool SparseGrid::anchorsOf(uint32_t texel, Anchors& out) const
{
    const Offsets offsets = offsetsOf(texel);
    if (offsets.count == 0) return false;
    out.count = 0;
    out.meters = 0.0f;
    forNeighbours(texel, [&](uint32_t other) { out.texels[std::size_t(out.count++)] = other; });
    if (out.count < offsets.count) return false;
    Center here;
    if (!centerOf(texel, here)) return false;
    vec3 mean(0.0f);
    for (int i = 0; i < out.count; ++i) {
        Center there;
        if (!centerOf(out.texels[std::size_t(i)], there) || glm::dot(there.normal, here.normal) < kCosBend)
            return false;
        out.meters = std::max(out.meters, glm::distance(there.position, here.position));
        mean += there.position / float(out.count);
    }
    return glm::distance(mean, here.position) <= kOffCenter * out.meters;
}

bool SparseGrid::centerOf(uint32_t texel, Center& out) const
{
    const Texel& t = map_.texels[texel];
    const vec2 center = vec2(t.x, t.y) + 0.5f;
    float covered = 0.0f;
    bool found = false;
    for (uint32_t f = t.firstFragment; f < t.firstFragment + t.fragmentCount; ++f) {
        covered += map_.fragments[f].area;
        if (found) continue;
        const uint32_t triangle = map_.fragments[f].triangle;
        const std::array<vec2, 3> v = geometry_.texelsOf(triangle);
        const vec2 edge1 = v[1] - v[0];
        const vec2 edge2 = v[2] - v[0];
        const vec2 place = center - v[0];
        const vec2 w = vec2(cross2(place, edge2), cross2(edge1, place)) / cross2(edge1, edge2);
        constexpr float kSlack = 1.0e-4f; // on an edge either of its triangles will do
        found = w.x >= -kSlack && w.y >= -kSlack && w.x + w.y <= 1.0f + kSlack;
        if (!found) continue;
        const SurfacePoint point = surfacePoint(geometry_, triangle, w);
        out = {point.position, point.normal};
    }
    return found && covered >= kCovered;
}

} // namespace halflight
