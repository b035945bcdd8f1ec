// The shadow distance that a view needs.
#include "render/frame/frame_internal.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <array>
#include <vector>

namespace halflight {
namespace {

/// A face of a box cut by six planes has at most ten corners.
using Corners = std::vector<vec3>;

/// The part of a convex polygon in front of a plane (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
Corners cut(const Corners& polygon, const vec4& plane)
{
    Corners result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const vec3 a = polygon[i];
        const vec3 b = polygon[(i + 1) % polygon.size()];
        const float da = glm::dot(vec3(plane), a) + plane.w;
        const float db = glm::dot(vec3(plane), b) + plane.w;
        if (da >= 0.0f) result.push_back(a);
        if ((da > 0.0f && db < 0.0f) || (da < 0.0f && db > 0.0f)) result.push_back(a + (b - a) * (da / (da - db)));
    }
    return result;
}

/// What a camera sees.
struct Frustum {
    vec3 eye;
    Planes planes;
    std::array<vec3, 4> farCorners; ///< not finite where the camera has no far plane
};

Frustum frustumOf(const FrameView& view)
{
    const mat4 clipFromWorld = view.clipFromView() * view.viewFromWorld();
    Frustum frustum{vec3(view.camera.worldFromCamera[3]), planesOf(clipFromWorld), {}};
    const glm::dmat4 worldFromClip = glm::inverse(glm::dmat4(clipFromWorld));
    for (int i = 0; i < 4; ++i) { // z is 0 on the far plane
        const glm::dvec4 corner = worldFromClip * glm::dvec4(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, 0.0, 1.0);
        frustum.farCorners[std::size_t(i)] = vec3(glm::dvec3(corner) / corner.w);
    }
    return frustum;
}

/// Largest distance from the eye to a point of the box in the frustum, 0 where there is none. Distance is convex, so a
/// corner of what both share has it: one on a face of the box, or a corner of the frustum inside the box.
float farthestInside(const Bounds& box, const Frustum& frustum)
{
    float farthest = 0.0f;
    for (const vec3& corner : frustum.farCorners) {
        if (isFinite(corner) && distanceTo(box, corner) == 0.0f)
            farthest = std::max(farthest, glm::distance(corner, frustum.eye));
    }
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {box.min[axis], box.max[axis]}) {
            Corners face(4);
            for (int i = 0; i < 4; ++i) {
                vec3& corner = face[std::size_t(i)];
                corner[axis] = side;
                corner[(axis + 1) % 3] = i == 0 || i == 3 ? box.min[(axis + 1) % 3] : box.max[(axis + 1) % 3];
                corner[(axis + 2) % 3] = i < 2 ? box.min[(axis + 2) % 3] : box.max[(axis + 2) % 3];
            }
            for (const vec4& plane : frustum.planes) face = cut(face, plane);
            for (const vec3& corner : face) farthest = std::max(farthest, glm::distance(corner, frustum.eye));
        }
    }
    return farthest;
}

} // namespace

float farthestInView(const FrameView& view, std::span<const Bounds> bounds)
{
    const Frustum frustum = frustumOf(view);
    float farthest = 0.0f;
    for (const Bounds& box : bounds) {
        if (farthestIn(box, frustum.eye) > farthest && meets(frustum.planes, box))
            farthest = std::max(farthest, farthestInside(box, frustum));
    }
    return farthest;
}

bool reachesBeyond(const FrameView& view, std::span<const Bounds> bounds, float distanceMeters)
{
    const Frustum frustum = frustumOf(view);
    return std::any_of(bounds.begin(), bounds.end(), [&](const Bounds& box) {
        return farthestIn(box, frustum.eye) > distanceMeters && meets(frustum.planes, box) &&
               farthestInside(box, frustum) > distanceMeters;
    });
}

ShadowSettings shadowsReaching(float farthestMeters, ShadowSettings settings)
{
    const ShadowSettings usual;
    if (!(farthestMeters > 0.0f)) return settings; // nothing in view
    settings.distanceMeters = std::min(1.001f * farthestMeters + settings.fadeRangeMeters, kLongestShadowDistance);
    // Beyond the usual distance the uniform part of the splits would move the first cascade away from the camera.
    const float share = std::min(usual.distanceMeters / settings.distanceMeters, 1.0f);
    settings.cascadeSplitLambda = 1.0f - (1.0f - settings.cascadeSplitLambda) * share;
    return settings;
}

} // namespace halflight
