// A view of a scene that has no camera.
#include "camera.h"
#include "scene_caster.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace halflight::cli {

namespace {

// Fibonacci sphere: Hannay and Nye 2004, "Fibonacci Numerical Integration on a Sphere".
vec3 fibonacciDirection(int i, int count)
{
    const float z = 1.0f - (2.0f * float(i) + 1.0f) / float(count);
    const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
    const float phi = 2.39996323f * float(i);
    return {r * math::cos(phi), z, r * math::sin(phi)};
}

// The points of a scene that may be its outline: all vertices of triangles, or where these are many, of each mesh those
// that lie farthest in some direction.
class Outline {
public:
    explicit Outline(const Scene& scene) : scene_(scene)
    {
        std::vector<std::vector<vec3>> used(scene.meshes.size());
        std::size_t sum = 0;
        for (const Object& object : scene.objects) {
            if (object.mesh < 0) continue;
            std::vector<vec3>& points = used[std::size_t(object.mesh)];
            if (points.empty()) points = usedVertices(scene.meshes[std::size_t(object.mesh)]);
            sum += points.size();
        }
        constexpr std::size_t kMost = 1 << 20; // points of all objects: some 50 ms for all views
        points_ = std::move(used);
        if (sum > kMost) {
            for (std::vector<vec3>& points : points_) points = farthest(points);
        }
    }

    // Largest dot products of points with each of the directions.
    [[nodiscard]] std::array<float, 4> reach(const std::array<vec3, 4>& directions) const
    {
        std::array<float, 4> most{-kInfinity, -kInfinity, -kInfinity, -kInfinity};
        for (const Object& object : scene_.objects) {
            if (object.mesh < 0) continue;
            const mat4& m = object.worldFromObject;
            for (std::size_t i = 0; i < most.size(); ++i) {
                const vec3 local = glm::transpose(mat3(m)) * directions[i];
                float farthest = -kInfinity;
                for (const vec3& p : points_[std::size_t(object.mesh)])
                    farthest = std::max(farthest, glm::dot(local, p));
                most[i] = std::max(most[i], farthest + glm::dot(directions[i], vec3(m[3])));
            }
        }
        return most;
    }

private:
    static std::vector<vec3> usedVertices(const Mesh& mesh)
    {
        std::vector<vec3> points;
        for (const MeshPart& part : mesh.parts) {
            std::vector<uint8_t> isUsed(part.positions.size(), 0);
            for (const uint32_t i : part.indices) isUsed[i] = 1;
            for (std::size_t i = 0; i < isUsed.size(); ++i) {
                if (isUsed[i] != 0) points.push_back(part.positions[i]);
            }
        }
        return points;
    }
    // Of a ball, what lies between two of so many directions is within 1 % of the radius.
    static std::vector<vec3> farthest(const std::vector<vec3>& points)
    {
        constexpr int kDirections = 256;
        if (points.size() <= std::size_t(kDirections)) return points;
        std::vector<vec3> kept;
        for (int i = 0; i < kDirections; ++i) {
            const vec3 d = fibonacciDirection(i, kDirections);
            kept.push_back(*std::max_element(points.begin(), points.end(), [&](const vec3& a, const vec3& b) {
                return glm::dot(a, d) < glm::dot(b, d);
            }));
        }
        return kept;
    }

    const Scene& scene_;
    std::vector<std::vector<vec3>> points_; // by mesh, in its own space
};

// The camera of this turn and lens from which the outline reaches to the picture's edges, but for `margin` of half the
// picture. With t the tangent of half the field of view less the margin, |x - eye.x| <= t (eye.z - z) for all points;
// the nearest eye makes both sides of one axis equalities.
Camera fitted(const Outline& outline, Camera camera, float aspect, const Bounds& box)
{
    constexpr float kMargin = 0.05f;
    const mat3 axes(camera.worldFromCamera);
    const float ty = (1.0f - kMargin) * math::tan(0.5f * camera.verticalFovRadians);
    const float tx = aspect * ty;
    const std::array<float, 4> most = outline.reach({axes * vec3(1.0f, 0.0f, tx), axes * vec3(-1.0f, 0.0f, tx),
                                                     axes * vec3(0.0f, 1.0f, ty), axes * vec3(0.0f, -1.0f, ty)});
    const float z = std::max((most[0] + most[1]) / (2.0f * tx), (most[2] + most[3]) / (2.0f * ty));
    const vec3 eye = axes * vec3(0.5f * (most[0] - most[1]), 0.5f * (most[2] - most[3]), z);
    // The target only turns the camera, as it was turned before.
    const float ahead = std::max(glm::distance(eye, box.center()), glm::length(box.size()));
    return lookAt(eye, eye - ahead * axes[2], camera.verticalFovRadians, box);
}

// Whether a ray from either side of a surface point gets out of the scene.
bool seenFromOutside(const SceneCaster& caster, vec3 point, vec3 towards, float margin)
{
    constexpr int kRays = 8;
    for (const float side : {-1.0f, 1.0f}) {
        for (int i = 0; i < kRays; ++i) {
            if (!caster.cast(point + side * margin * towards, fibonacciDirection(i, kRays))) return true;
        }
    }
    return false;
}

// Whether the walls around a point hold things that nobody outside sees: a light, or surfaces with more behind them
// than the two sides of a wall.
bool holdsThings(const Scene& scene, const SceneCaster& caster, const Bounds& box, vec3 point)
{
    constexpr int kRays = 64;
    constexpr int kEnough = kRays / 8;
    const float margin = 1.0e-4f * glm::length(box.size());
    for (const Light& light : scene.lights) {
        const vec3 p = light.position();
        if (light.type == LightType::Directional || glm::any(glm::lessThan(p, box.min)) ||
            glm::any(glm::greaterThan(p, box.max)))
            continue;
        int hits = 0;
        for (int i = 0; i < kRays; ++i) hits += bool(caster.cast(p, fibonacciDirection(i, kRays)));
        if (hits > kRays * 9 / 10) return true; // a room without its front wall is seen from there
    }
    int things = 0;
    for (int i = 0; i < kRays && things < kEnough; ++i) {
        const vec3 direction = fibonacciDirection(i, kRays);
        vec3 at = point;
        vec3 first(0.0f);
        int surfaces = 0;
        while (surfaces < 3) {
            const SceneHit hit = caster.cast(at, direction);
            if (!hit) break;
            at += (hit.distance + margin) * direction;
            if (surfaces++ == 0) first = at - margin * direction;
        }
        things += surfaces == 3 && !seenFromOutside(caster, first, direction, margin);
    }
    return things >= kEnough;
}

// Whether walls that show their front stand on nearly all sides of most places in the scene: a single place may be in a
// cupboard.
bool isEnclosed(const SceneCaster& caster, const Bounds& box)
{
    constexpr int kRays = 32;
    constexpr int kPlaces = 9;
    int enclosed = 0;
    for (int place = 0; place < kPlaces; ++place) {
        const vec3 at = box.center() + 0.25f * box.size() * vec3(float(place % 3 - 1), 0.0f, float(place / 3 - 1));
        int fronts = 0;
        for (int i = 0; i < kRays; ++i) fronts += caster.cast(at, fibonacciDirection(i, kRays)).front;
        enclosed += fronts > kRays * 7 / 8; // a room without a roof or a front wall is seen from there
    }
    return enclosed > kPlaces / 2;
}

// What a view shows, over a grid of rays.
struct Seen {
    float frontShare = 0.0f; // of rays that meet something
    float depth = 0.0f; // mean of all rays: how far they go behind the bounds' near end on front faces, in diagonals
    float near = 0.0f;  // share of rays that meet something at arm's length
    [[nodiscard]] float score() const { return frontShare * frontShare * (1.0f - near) * (1.0f - near) * depth; }
};

Seen look(const SceneCaster& caster, const Camera& camera, float aspect, const Bounds& box)
{
    constexpr int kColumns = 11;
    constexpr int kRows = 7;
    constexpr float kArmsLength = 0.05f; // diagonals: 35 cm in a room of 5 x 3 x 4 m
    const vec3 eye = vec3(camera.worldFromCamera[3]);
    const float diagonal = glm::length(box.size());
    const float nearest = std::max(0.0f, glm::distance(eye, box.center()) - 0.5f * diagonal);
    const float tangent = math::tan(0.5f * camera.verticalFovRadians);
    std::array<SceneHit, kColumns * kRows> hits;
    parallelFor(hits.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const vec2 cell(float(i % kColumns) + 0.5f, float(i / kColumns) + 0.5f);
            const vec2 p = 2.0f * cell / vec2(kColumns, kRows) - 1.0f;
            hits[i] = caster.cast(eye, mat3(camera.worldFromCamera) *
                                           glm::normalize(vec3(p.x * tangent * aspect, p.y * tangent, -1.0f)));
        }
    });
    Seen seen;
    float met = 0.0f;
    for (const SceneHit& hit : hits) {
        if (!hit) continue;
        met += 1.0f;
        seen.frontShare += hit.front ? 1.0f : 0.0f;
        seen.near += hit.distance < kArmsLength * diagonal ? 1.0f / float(hits.size()) : 0.0f;
        if (hit.front) seen.depth += std::clamp((hit.distance - nearest) / diagonal, 0.0f, 1.0f) / float(hits.size());
    }
    if (met > 0.0f) seen.frontShare /= met;
    return seen;
}

std::vector<Camera> viewsFromInside(const Bounds& box)
{
    const vec3 center = box.center();
    const vec3 half = 0.5f * box.size();
    std::vector<Camera> views;
    for (const float reach : {0.85f, 0.7f, 0.5f}) {
        for (int i = 0; i < 8; ++i) {
            const float angle = (float(i) + 0.5f) * 0.25f * kPi; // corners come first
            const vec2 side{math::cos(angle), math::sin(angle)};
            const vec2 square = side / std::max(std::abs(side.x), std::abs(side.y));
            const vec3 eye = center + half * vec3(reach * square.x, 0.15f, reach * square.y);
            views.push_back(lookAt(eye, center - half * vec3(0.0f, 0.1f, 0.0f), kPi * 65.0f / 180.0f, box));
        }
    }
    return views;
}

std::vector<Camera> viewsFromOutside(const Scene& scene, const Bounds& box, float aspect)
{
    const Outline outline(scene);
    std::vector<Camera> views;
    for (const float height : {0.45f, 1.2f}) { // 24 and 50 degrees above the horizon: the latter see into open rooms
        for (int i = 0; i < 8; ++i) {
            const float angle = (0.35f + 0.5f * float(i)) * 0.5f * kPi;
            const vec3 direction(math::sin(angle), height, math::cos(angle));
            views.push_back(fitted(outline, lookAt(direction, vec3(0.0f), kPi * 45.0f / 180.0f, box), aspect, box));
        }
    }
    return views;
}

struct Choice {
    Camera camera;
    Seen seen;
};

Choice best(const SceneCaster& caster, const std::vector<Camera>& views, float aspect, const Bounds& box)
{
    Choice chosen{views.front(), {}};
    for (const Camera& view : views) {
        const Seen seen = look(caster, view, aspect, box);
        // A clear gain is needed to leave an earlier view: rounding must not choose.
        if (seen.score() > chosen.seen.score() + 0.01f) chosen = {view, seen};
    }
    return chosen;
}

} // namespace

Camera automaticCamera(const Scene& scene, float aspect)
{
    const Bounds box = scene.bounds();
    if (box.empty() || !(glm::length(box.size()) > 0.0f)) {
        return lookAt(vec3(0.0f, 0.0f, 5.0f), vec3(0.0f), kPi / 4.0f, box);
    }
    const SceneCaster caster(scene);
    const Choice outside = best(caster, viewsFromOutside(scene, box, aspect), aspect, box);
    constexpr float kMostlyFronts = 0.5f;
    const bool isRoom = isEnclosed(caster, box) &&
                        (outside.seen.frontShare < kMostlyFronts || holdsThings(scene, caster, box, box.center()));
    if (!isRoom) return outside.camera;
    const Choice inside = best(caster, viewsFromInside(box), aspect, box);
    return inside.seen.score() > 0.05f ? inside.camera : outside.camera;
}

} // namespace halflight::cli
