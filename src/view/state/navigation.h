#pragma once
// A camera that orbits, flies and frames things.

#include "halflight/scene/scene.h"

#include <optional>
#include <span>

namespace halflight::view {

/// Yaw 0, pitch 0 looks along -Z; yaw turns left about +Y, pitch up. Angles in radians.
class Navigator {
public:
    Navigator() = default;
    /// Takes the pose of a camera; what lies `pivotMeters` before it is what it orbits. `scene`: the bounds of what it
    /// shows.
    Navigator(const Camera& camera, float pivotMeters, const Bounds& scene = {});

    /// A camera of the file, which has a name, as it is until it moves; else the camera as it stands, upright. A
    /// perspective one that has moved has the planes of `halflight render --eye`.
    [[nodiscard]] Camera camera() const;
    [[nodiscard]] vec3 pivot() const { return eye_ + pivotMeters_ * forward(); }
    /// A point one metre ahead.
    [[nodiscard]] vec3 target() const { return eye_ + forward(); }

    /// Turns about the pivot.
    void orbit(vec2 radians);
    /// Turns the head.
    void look(vec2 radians);
    /// Moves eye and pivot along the picture's axes, in metres at the pivot's distance: x right, y up.
    void pan(vec2 meters);
    /// Moves towards the pivot by this factor of the distance (0.9: a tenth nearer).
    void dolly(float factor);
    /// Moves along the own axes: x right, y up (the world's), z forward, in metres.
    void fly(vec3 meters);
    /// Steps back until the bounds fill the picture; they become the pivot.
    void frame(const Bounds& bounds, float aspect);

    /// Metres that a pixel is wide at the pivot.
    [[nodiscard]] float pixelMeters(int pictureHeight) const;
    [[nodiscard]] vec3 forward() const;
    [[nodiscard]] vec3 right() const;

private:
    void turn(vec2 radians);

    Camera base_; ///< name, field of view, planes until it moves
    Bounds scene_;
    bool hasMoved_ = false;
    float nearestShown_ = kInfinity; ///< what was framed is not cut off by the near plane
    vec3 eye_{0.0f};
    float yaw_ = 0.0f;
    float pitch_ = 0.0f;
    float pivotMeters_ = 1.0f;
};

struct Ray {
    vec3 origin{0.0f};
    vec3 direction{0.0f}; ///< along its camera's axis as long as 1
};
/// From the camera through a point of the picture (0, 0 its top left, 1, 1 its bottom right).
Ray rayThrough(const Camera& camera, vec2 point, float aspect);
/// Where a place is in the picture, in the same coordinates; nothing behind the camera.
std::optional<vec2> pointOf(const Camera& camera, vec3 place, float aspect);

/// The nearest object that is drawn where a ray from the camera through a point of the picture meets its triangles (0,
/// 0 the picture's top left, 1, 1 its bottom right); -1 none. Single-sided surfaces are not drawn from behind.
/// `bounds` is objectBounds(scene), which saves time, or empty.
int objectAt(const Scene& scene, const Camera& camera, vec2 point, float aspect, std::span<const Bounds> bounds = {});
/// Along the camera's axis to the surface in the middle of the picture, by the same rules; nothing where there is none.
std::optional<float> metersAhead(const Scene& scene, const Camera& camera, std::span<const Bounds> bounds);

} // namespace halflight::view
