#pragma once
// The local origin of a scene. Floats near 1e6 m are 6 cm apart, so positions are kept relative to a world position
// near the scene's middle: Scene::originMeters.

#include "halflight/scene/scene.h"

#include <span>

namespace halflight {

/// Axis-aligned box in double precision. A default-constructed one is empty.
struct WideBounds {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};

    void extend(const glm::dvec3& point)
    {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
    [[nodiscard]] bool empty() const { return !(min.x <= max.x); }
};

/// Bounds of a box in another space.
WideBounds transformedBounds(const Bounds& box, const glm::dmat4& transform);

/// The bounds of all vertices of a mesh in its own space.
Bounds boundsOf(const Mesh& mesh);

/// The local origin for objects with these bounds. It is `current`, unless the bulk of the objects lies so far from
/// `current` that floats lose more than kSpareBits of their bits there. It then is the median of the objects' centres,
/// rounded to a power of two near the bulk's size, so that small edits do not move it.
glm::dvec3 localOrigin(std::span<const WideBounds> boxes, const glm::dvec3& current);

/// Moves a mesh whose vertices lie far from its own origin to that origin. Returns what was taken off all positions:
/// objectFromCentred is a translation by it. Zero for other meshes.
glm::dvec3 centreMesh(Mesh& mesh);

/// A warning that the file's floats hold the vertices of a mesh coarsely, since they lie `offset` from its origin.
/// Empty when they do not.
std::string coarseVerticesWarning(const Mesh& mesh, const glm::dvec3& offset);

/// A warning that names small objects so far from the local origin that floats round their vertices coarsely. Empty
/// when there are none.
std::string coarseObjectsWarning(const Scene& scene);

// From the scene's local origin. Beyond it, floats no longer tell a metre from the next, and squares of lengths
// overflow soon after.
constexpr double kFarthestMeters = 1.0e7;
// From the world's origin: 2^24 m, beyond which the floats of a file's vertices are coarser than a metre.
constexpr double kFarthestFromWorldMeters = 16777216.0;

inline bool tooFar(glm::dvec3 p, double limit = kFarthestMeters)
{
    return !(std::abs(p.x) <= limit && std::abs(p.y) <= limit && std::abs(p.z) <= limit);
}

/// Transform with its translation moved from the world's origin to a local one, in double precision; and back.
inline mat4 localFromWorld(glm::dmat4 transform, const glm::dvec3& origin)
{
    transform[3] -= glm::dvec4(origin, 0.0);
    return mat4(transform);
}
inline glm::dmat4 worldFromLocal(const mat4& transform, const glm::dvec3& origin)
{
    glm::dmat4 wide(transform);
    wide[3] += glm::dvec4(origin, 0.0);
    return wide;
}

} // namespace halflight
