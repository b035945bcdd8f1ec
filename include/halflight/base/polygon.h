#pragma once
// Convex polygons in the plane: triangles cut by squares.

#include "halflight/base/math.h"

#include <array>
#include <cstddef>

namespace halflight {

/// At most 7 vertices: a triangle cut by a square.
struct Polygon {
    std::array<vec2, 8> points;
    int count = 0;
};

/// Keeps the part where dot(normal, p) >= bound (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
inline Polygon clip(const Polygon& in, vec2 normal, float bound)
{
    Polygon out;
    for (int i = 0; i < in.count; ++i) {
        const vec2 a = in.points[std::size_t(i)];
        const vec2 b = in.points[std::size_t((i + 1) % in.count)];
        const float da = glm::dot(normal, a) - bound;
        const float db = glm::dot(normal, b) - bound;
        if (da >= 0.0f) out.points[std::size_t(out.count++)] = a;
        if ((da > 0.0f && db < 0.0f) || (da < 0.0f && db > 0.0f)) {
            out.points[std::size_t(out.count++)] = a + (b - a) * (da / (da - db));
        }
        if (out.count >= 8) break;
    }
    return out;
}

} // namespace halflight
