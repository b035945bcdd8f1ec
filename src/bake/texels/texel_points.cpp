// Sample points of texels, and their world-space places.
#include "bake/geometry/triangle_frame.h"
#include "bake/texels/texel_places.h"

#include "halflight/shading/texel_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

namespace halflight {
namespace {

static_assert(kMaxTexelPoints == shading::kTexelCandidates);

/// Points of a triangle, a little off its edges.
class InsetPoints {
public:
    InsetPoints(const BakeGeometry& geometry, uint32_t triangle) : frame_(geometry, triangle)
    {
        const std::array<vec2, 3> corners = geometry.texelsOf(triangle);
        least_ = shading::leastWeights(corners[0], corners[1], corners[2]);
    }
    void put(vec2 barycentric, SurfacePoint& out) const { frame_.put(shading::insetWeights(barycentric, least_), out); }

private:
    TriangleFrame frame_;
    vec3 least_{0.0f};
};

constexpr uint32_t kAllCandidates = (1u << kMaxTexelPoints) - 1u;

using PointArray = std::span<SurfacePoint, kMaxTexelPoints>;

struct Rectangle {
    vec2 min{0.0f};
    vec2 size{1.0f};
};

/// Intersection of a texel's square and the bounds of its triangles.
Rectangle coveredRectangle(const BakeGeometry& geometry, std::span<const TexelFragment> fragments, const Rectangle& in)
{
    vec2 min = in.min + in.size;
    vec2 max = in.min;
    for (const TexelFragment& fragment : fragments) {
        const std::array<vec2, 3> t = geometry.texelsOf(fragment.triangle);
        for (const vec2 corner : t) {
            min = glm::min(min, corner);
            max = glm::max(max, corner);
        }
    }
    min = glm::max(min, in.min);
    return {min, glm::max(glm::min(max, in.min + in.size) - min, vec2(0.0f))};
}

/// Candidates for a texel's points: kMaxTexelPoints points of the R2 sequence over a rectangle, from number `first` on.
/// Writes the candidates that a triangle covers to `out` and returns their bits. The first triangle that covers a
/// candidate counts.
uint32_t coveredPoints(const BakeGeometry& geometry, std::span<const TexelFragment> fragments, const Rectangle& in,
                       int first, PointArray out)
{
    std::array<float, kMaxTexelPoints> x;
    std::array<float, kMaxTexelPoints> y;
    for (int i = 0; i < kMaxTexelPoints; ++i) {
        const vec2 place = shading::texelCandidate(in.min, in.size, first + i);
        x[std::size_t(i)] = place.x;
        y[std::size_t(i)] = place.y;
    }
    uint32_t found = 0;
    for (const TexelFragment& fragment : fragments) {
        const std::array<vec2, 3> t = geometry.texelsOf(fragment.triangle);
        const vec2 corner = t[0];
        const vec2 edge1 = t[1] - corner;
        const vec2 edge2 = t[2] - corner;
        const float area = cross2(edge1, edge2);
        if (std::abs(area) < 1.0e-20f) continue;
        const float inverse = 1.0f / area;
        // A loop of its own, which compilers vectorize.
        std::array<float, kMaxTexelPoints> u;
        std::array<float, kMaxTexelPoints> v;
        for (std::size_t i = 0; i < kMaxTexelPoints; ++i) {
            const vec2 weights = shading::weightsInTriangle({x[i] - corner.x, y[i] - corner.y}, edge1, edge2, inverse);
            u[i] = weights.x;
            v[i] = weights.y;
        }
        uint32_t covered = 0;
        for (std::size_t i = 0; i < kMaxTexelPoints; ++i) covered |= shading::isInTriangle({u[i], v[i]}) ? 1u << i : 0u;
        covered &= ~found;
        if (covered == 0) continue;
        found |= covered;
        const InsetPoints points(geometry, fragment.triangle);
        for (uint32_t rest = covered; rest != 0; rest &= rest - 1u) {
            const auto i = std::size_t(std::countr_zero(rest));
            points.put({u[i], v[i]}, out[i]);
        }
        if (found == kAllCandidates) break;
    }
    return found;
}

} // namespace

float coveredArea(const TexelMap& map, const Texel& texel)
{
    float covered = 0.0f;
    for (uint32_t f = 0; f < texel.fragmentCount; ++f) covered += map.fragments[texel.firstFragment + f].area;
    return covered;
}

int texelPoints(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel, PointArray out, int batch)
{
    const std::span fragments(map.fragments.data() + texel.firstFragment, texel.fragmentCount);
    const float covered = coveredArea(map, texel);
    // Partly covered texels get as many points as others.
    Rectangle candidates{vec2(texel.x, texel.y)};
    int rounds = 1;
    if (covered < kMostlyCovered) {
        candidates = coveredRectangle(geometry, fragments, candidates);
        rounds = shading::candidateRounds(candidates.size, covered);
    }
    const auto findRound = [&](int round, PointArray points) {
        return coveredPoints(geometry, fragments, candidates, (batch * rounds + round) * kMaxTexelPoints, points);
    };
    int count = 0;
    const auto keep = [&](uint32_t found, PointArray points) {
        for (int i = 0; i < kMaxTexelPoints && count < kMaxTexelPoints; ++i) {
            if (((found >> i) & 1u) != 0) out[std::size_t(count++)] = points[std::size_t(i)];
        }
    };
    const uint32_t found = findRound(0, out);
    if (found == kAllCandidates) return kMaxTexelPoints;
    keep(found, out);
    if (rounds > 1) {
        std::array<SurfacePoint, kMaxTexelPoints> more;
        for (int round = 1; round < rounds && count < kMaxTexelPoints; ++round) keep(findRound(round, more), more);
    }
    if (count > 0) return count;
    // A sliver between all candidates: the centroid of the largest fragment.
    InsetPoints(geometry, fragments.front().triangle).put(fragments.front().barycentric, out[0]);
    return 1;
}

TexelPlace placeOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel)
{
    const TexelFragment& largest = map.fragments[texel.firstFragment];
    const SurfacePoint point = surfacePoint(geometry, largest.triangle, largest.barycentric);
    return {point.position, point.normal, geometry.texelMeters(largest.triangle)};
}

} // namespace halflight
