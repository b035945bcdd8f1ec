#include "view/state/navigation.h"

#include "halflight/render/frame.h"

#include <algorithm>
#include <cmath>

namespace halflight::view {
namespace {

/// Straight up and down have no yaw.
constexpr float kSteepest = 0.5f * kPi - 0.001f;
/// The pivot never comes so near that a dolly has no effect any more.
constexpr float kNearestPivotMeters = 1.0e-4f;

/// Möller and Trumbore 1997, "Fast, Minimum Storage Ray-Triangle Intersection". Distance, or infinity; from behind too
/// where the triangle has two sides.
float hitDistance(vec3 origin, vec3 direction, vec3 a, vec3 b, vec3 c, bool doubleSided)
{
    const vec3 ab = b - a;
    const vec3 ac = c - a;
    const vec3 p = glm::cross(direction, ac);
    const float determinant = glm::dot(ab, p);
    // In object space the front is counter-clockwise, mirrored or not (glTF 2.0, section 3.7.4).
    if (determinant == 0.0f || (determinant < 0.0f && !doubleSided)) return kInfinity;
    const vec3 ao = origin - a;
    const float u = glm::dot(ao, p) / determinant;
    const vec3 q = glm::cross(ao, ab);
    const float v = glm::dot(direction, q) / determinant;
    if (!(u >= 0.0f && v >= 0.0f && u + v <= 1.0f)) return kInfinity;
    const float t = glm::dot(ac, q) / determinant;
    return t > 0.0f ? t : kInfinity;
}

} // namespace

Navigator::Navigator(const Camera& camera, float pivotMeters, const Bounds& scene)
    : base_(camera), scene_(scene), eye_(vec3(camera.worldFromCamera[3])),
      pivotMeters_(std::max(pivotMeters, kNearestPivotMeters))
{
    const vec3 ahead = -glm::normalize(vec3(camera.worldFromCamera[2]));
    pitch_ = std::clamp(std::asin(std::clamp(ahead.y, -1.0f, 1.0f)), -kSteepest, kSteepest);
    // Straight up or down: the picture's upper edge says where "ahead" is.
    const vec3 flat = std::abs(ahead.y) < std::sin(kSteepest)
                          ? ahead
                          : vec3(camera.worldFromCamera[1]) * (ahead.y > 0.0f ? -1.0f : 1.0f);
    yaw_ = std::atan2(-flat.x, -flat.z);
}

vec3 Navigator::forward() const
{
    return {-std::sin(yaw_) * std::cos(pitch_), std::sin(pitch_), -std::cos(yaw_) * std::cos(pitch_)};
}

vec3 Navigator::right() const
{
    return {std::cos(yaw_), 0.0f, -std::sin(yaw_)};
}

Camera Navigator::camera() const
{
    if (!hasMoved_ && !base_.name.empty()) return base_; // that of `halflight render --camera`
    // The rounding of `halflight render --eye --target`, so that pictures are the same to the bit.
    const vec3 back = glm::normalize(eye_ - target());
    Camera camera = base_;
    const vec3 side = glm::normalize(glm::cross(vec3(0.0f, 1.0f, 0.0f), back));
    camera.worldFromCamera =
        mat4(vec4(side, 0.0f), vec4(glm::cross(back, side), 0.0f), vec4(back, 0.0f), vec4(eye_, 1.0f));
    if (hasMoved_ && !camera.orthographic) camera = withPlanesFor(scene_, camera);
    camera.nearMeters = std::min(camera.nearMeters, nearestShown_);
    return camera;
}

void Navigator::turn(vec2 radians)
{
    hasMoved_ = true;
    yaw_ = std::remainder(yaw_ + radians.x, 2.0f * kPi);
    pitch_ = std::clamp(pitch_ + radians.y, -kSteepest, kSteepest);
}

void Navigator::orbit(vec2 radians)
{
    const vec3 center = pivot();
    turn(radians);
    eye_ = center - pivotMeters_ * forward();
}

void Navigator::look(vec2 radians)
{
    turn(radians);
}

void Navigator::pan(vec2 meters)
{
    hasMoved_ = true;
    eye_ += meters.x * right() + meters.y * glm::cross(right(), forward());
}

void Navigator::dolly(float factor)
{
    hasMoved_ = true;
    const vec3 center = pivot();
    pivotMeters_ = std::max(pivotMeters_ * factor, kNearestPivotMeters);
    eye_ = center - pivotMeters_ * forward();
    base_.orthographicHeightMeters = std::max(base_.orthographicHeightMeters * factor, kNearestPivotMeters);
}

void Navigator::fly(vec3 meters)
{
    hasMoved_ = true;
    eye_ += meters.x * right() + vec3(0.0f, meters.y, 0.0f) + meters.z * forward();
}

void Navigator::frame(const Bounds& bounds, float aspect)
{
    if (bounds.empty()) return;
    hasMoved_ = true;
    const float radius = std::max(0.5f * glm::length(bounds.size()), kNearestPivotMeters);
    const float vertical = std::tan(0.5f * base_.verticalFovRadians);
    const float narrow = std::atan(std::min(vertical, vertical * aspect));
    pivotMeters_ = radius / std::sin(narrow);
    eye_ = bounds.center() - pivotMeters_ * forward();
    base_.farMeters = std::max(base_.farMeters, pivotMeters_ + 2.0f * radius);
    nearestShown_ = 0.5f * (pivotMeters_ - radius);
    base_.orthographicHeightMeters = 2.0f * radius;
}

float Navigator::pixelMeters(int pictureHeight) const
{
    const float height = base_.orthographic ? base_.orthographicHeightMeters
                                            : 2.0f * pivotMeters_ * std::tan(0.5f * base_.verticalFovRadians);
    return height / float(std::max(pictureHeight, 1));
}

namespace {

/// Half the picture's height: in metres of an orthographic camera, else a metre ahead.
float halfHeight(const Camera& camera)
{
    return camera.orthographic ? 0.5f * camera.orthographicHeightMeters : std::tan(0.5f * camera.verticalFovRadians);
}

} // namespace

Ray rayThrough(const Camera& camera, vec2 point, float aspect)
{
    const vec2 ndc(2.0f * point.x - 1.0f, 1.0f - 2.0f * point.y);
    const mat3 axes(camera.worldFromCamera);
    Ray ray{vec3(camera.worldFromCamera[3]), -axes[2]};
    const float half = halfHeight(camera);
    const vec3 offset = axes * vec3(ndc.x * half * aspect, ndc.y * half, 0.0f);
    (camera.orthographic ? ray.origin : ray.direction) += offset;
    return ray;
}

std::optional<vec2> pointOf(const Camera& camera, vec3 place, float aspect)
{
    const vec3 p = vec3(glm::inverse(camera.worldFromCamera) * vec4(place, 1.0f));
    if (!camera.orthographic && p.z >= -camera.nearMeters) return std::nullopt;
    const float half = halfHeight(camera) * (camera.orthographic ? 1.0f : -p.z);
    return vec2(0.5f + 0.5f * p.x / (half * aspect), 0.5f - 0.5f * p.y / half);
}

namespace {

struct Hit {
    int object = -1;
    float distance = kInfinity; ///< in lengths of the ray's direction
};

/// Of what the renderer draws. `bounds` may be empty.
Hit nearestHit(const Scene& scene, std::span<const Bounds> bounds, const Ray& ray)
{
    Hit nearest;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (object.mesh < 0 || glm::determinant(mat3(object.worldFromObject)) == 0.0f) continue;
        if (!bounds.empty() && !rayReaches(bounds[i], ray.origin, ray.direction, nearest.distance)) continue;
        // The direction is not normalized in object space, so that distances stay those of the world.
        const mat4 objectFromWorld = glm::inverse(object.worldFromObject);
        const vec3 o = vec3(objectFromWorld * vec4(ray.origin, 1.0f));
        const vec3 d = mat3(objectFromWorld) * ray.direction;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            const bool doubleSided = isDoubleSided(scene, part);
            for (std::size_t t = 0; t + 2 < part.indices.size(); t += 3) {
                const float hit =
                    hitDistance(o, d, part.positions[part.indices[t]], part.positions[part.indices[t + 1]],
                                part.positions[part.indices[t + 2]], doubleSided);
                if (hit < nearest.distance) nearest = {int(i), hit};
            }
        }
    }
    return nearest;
}

} // namespace

int objectAt(const Scene& scene, const Camera& camera, vec2 point, float aspect, std::span<const Bounds> bounds)
{
    return nearestHit(scene, bounds, rayThrough(camera, point, aspect)).object;
}

std::optional<float> metersAhead(const Scene& scene, const Camera& camera, std::span<const Bounds> bounds)
{
    const Hit hit = nearestHit(scene, bounds, rayThrough(camera, vec2(0.5f), 1.0f));
    return hit.object < 0 ? std::nullopt : std::optional(hit.distance);
}

} // namespace halflight::view
