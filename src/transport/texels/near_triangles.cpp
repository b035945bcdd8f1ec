#include "transport/texels/near_triangles.h"

#include "halflight/shading/sampling.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

/// Triangles that a box is tested against at most: about as long as the rays take that the test spares.
constexpr std::size_t kMostNearTriangles = 64;

/// Separating axes: the box's own and the triangle's normal. Edges are left out, so that triangles near a box's edge
/// may count as within it.
bool mayReachInto(const OrientedBox& box, const std::array<vec3, 3>& corners)
{
    const vec3 center = box.bounds.center();
    const vec3 half = 0.5f * box.bounds.size();
    std::array<vec3, 3> c;
    Bounds triangle;
    for (std::size_t i = 0; i < 3; ++i) {
        c[i] = corners[i] * box.worldFromBox - center;
        triangle.extend(c[i]);
    }
    for (int axis = 0; axis < 3; ++axis)
        if (triangle.min[axis] > half[axis] || triangle.max[axis] < -half[axis]) return false;
    const vec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
    return std::abs(glm::dot(normal, c[0])) <= glm::dot(glm::abs(normal), half);
}

} // namespace

OrientedBox boxAlong(vec3 normal)
{
    OrientedBox box;
    box.worldFromBox[2] = normal;
    shading::orthonormalBasis(normal, box.worldFromBox[0], box.worldFromBox[1]);
    return box;
}

NearTriangles::NearTriangles(const RayTracer& tracer, const OrientedBox& box) : geometry_(tracer.geometry())
{
    const vec3 center = box.worldFromBox * box.bounds.center();
    const float radius = 0.5f * glm::length(box.bounds.size()) + tracer.epsilonAt(center);
    known_ = tracer.kernels().trianglesNear(center, radius, kMostNearTriangles, triangles_);
}

bool NearTriangles::isEmpty(const OrientedBox& box) const
{
    return known_ && std::none_of(triangles_.begin(), triangles_.end(),
                                  [&](uint32_t triangle) { return mayReachInto(box, geometry_.cornersOf(triangle)); });
}

} // namespace halflight
