#include "bake_cpu/texels/sparse_grid.h"

#include <bit>

namespace halflight {
namespace {

constexpr float kCovered = 0.999f;
/// How far the surface may bend between two texels that another lies between: the angle of each to the one between
/// (cos 4 degrees), and how far that one is from the middle of the others, as a share of its distance to them.
constexpr float kCosBend = 0.9976f;
constexpr float kOffMiddle = 0.1f;

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
    // On the lattice twice as wide in x, in y or in none of them: two neighbours in a row, or four at the corners.
    return {{ivec2(-dx, -dy), ivec2(dx, dy), ivec2(dx, -dy), ivec2(-dx, dy)}, dx != 0 && dy != 0 ? 4 : 2};
}

bool SparseGrid::around(uint32_t texel, Around& out) const
{
    const Offsets offsets = offsetsOf(texel);
    if (offsets.count == 0) return false;
    out.count = 0;
    out.meters = 0.0f;
    forNeighbours(texel, [&](uint32_t other) { out.texels[std::size_t(out.count++)] = other; });
    if (out.count < offsets.count) return false;
    Middle here;
    if (!middleOf(texel, here)) return false;
    vec3 mean(0.0f);
    for (int i = 0; i < out.count; ++i) {
        Middle there;
        if (!middleOf(out.texels[std::size_t(i)], there) || glm::dot(there.normal, here.normal) < kCosBend)
            return false;
        out.meters = std::max(out.meters, glm::distance(there.position, here.position));
        mean += there.position / float(out.count);
    }
    return glm::distance(mean, here.position) <= kOffMiddle * out.meters;
}

bool SparseGrid::middleOf(uint32_t texel, Middle& out) const
{
    const Texel& t = map_.texels[texel];
    const vec2 middle = vec2(t.x, t.y) + 0.5f;
    float covered = 0.0f;
    bool found = false;
    for (uint32_t f = t.firstFragment; f < t.firstFragment + t.fragmentCount; ++f) {
        covered += map_.fragments[f].area;
        if (found) continue;
        const uint32_t triangle = map_.fragments[f].triangle;
        const uvec3 v = geometry_.triangles[triangle];
        const vec2 edge1 = geometry_.lightmapTexel[v.y] - geometry_.lightmapTexel[v.x];
        const vec2 edge2 = geometry_.lightmapTexel[v.z] - geometry_.lightmapTexel[v.x];
        const vec2 place = middle - geometry_.lightmapTexel[v.x];
        const vec2 w = vec2(cross2(place, edge2), cross2(edge1, place)) / cross2(edge1, edge2);
        constexpr float kSlack = 1.0e-4f; // on an edge between two triangles either will do
        found = w.x >= -kSlack && w.y >= -kSlack && w.x + w.y <= 1.0f + kSlack;
        if (!found) continue;
        const SurfacePoint point = surfacePoint(geometry_, triangle, w);
        out = {point.position, point.normal};
    }
    return found && covered >= kCovered;
}

} // namespace halflight
