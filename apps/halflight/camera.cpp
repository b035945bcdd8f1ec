#include "camera.h"

#include "halflight/render/frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace halflight::cli {

namespace {

struct Hit {
    float distance = kInfinity;
    bool front = false;       ///< on a front face, or on a double-sided surface
    bool doubleSided = false; ///< on a double-sided surface

    explicit operator bool() const { return distance < kInfinity; }
};

// Few rays are cast here, about a thousand, so triangles are tried one by one behind each object's bounds. Panes of
// glass are left out: a view goes through them.
class Caster {
public:
    explicit Caster(const Scene& scene) : scene_(scene)
    {
        std::vector<std::vector<Bounds>> meshBounds;
        for (const Mesh& mesh : scene.meshes) {
            std::vector<Bounds>& parts = meshBounds.emplace_back();
            for (const MeshPart& part : mesh.parts) {
                Bounds& bounds = parts.emplace_back();
                for (const vec3 position : part.positions) bounds.extend(position);
            }
        }
        for (const Object& object : scene.objects) {
            if (object.mesh < 0) continue;
            const float determinant = glm::determinant(mat3(object.worldFromObject));
            if (!(std::abs(determinant) > std::numeric_limits<float>::min())) continue;
            const Mesh& mesh = scene.meshes[std::size_t(object.mesh)];
            for (std::size_t i = 0; i < mesh.parts.size(); ++i) {
                const Material& material = materialOf(scene, mesh.parts[i]);
                if (material.alphaMode == Material::AlphaMode::Blend && material.baseColor.w < 0.5f) continue;
                items_.push_back(
                    {&mesh.parts[i], meshBounds[std::size_t(object.mesh)][i], glm::inverse(object.worldFromObject)});
            }
        }
    }

    [[nodiscard]] Hit cast(vec3 origin, vec3 direction) const
    {
        Hit hit;
        for (const Item& item : items_) {
            // The direction is not normalized in object space, so that distances stay those of the world.
            const vec3 o = vec3(item.objectFromWorld * vec4(origin, 1.0f));
            const vec3 d = mat3(item.objectFromWorld) * direction;
            if (rayReaches(item.bounds, o, d, hit.distance)) castAtPart(item, o, d, hit);
        }
        return hit;
    }

private:
    struct Item {
        const MeshPart* part;
        Bounds bounds;
        mat4 objectFromWorld;
    };

    // Möller and Trumbore 1997, "Fast, Minimum Storage Ray-Triangle Intersection".
    void castAtPart(const Item& item, vec3 o, vec3 d, Hit& hit) const
    {
        const MeshPart& part = *item.part;
        const bool doubleSided = materialOf(scene_, part).doubleSided;
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            const vec3 a = part.positions[part.indices[i]];
            const vec3 ab = part.positions[part.indices[i + 1]] - a;
            const vec3 ac = part.positions[part.indices[i + 2]] - a;
            const vec3 p = glm::cross(d, ac);
            const float determinant = glm::dot(ab, p);
            if (determinant == 0.0f) continue;
            const vec3 ao = o - a;
            const float u = glm::dot(ao, p) / determinant;
            if (!(u >= 0.0f && u <= 1.0f)) continue;
            const vec3 q = glm::cross(ao, ab);
            const float v = glm::dot(d, q) / determinant;
            if (!(v >= 0.0f && u + v <= 1.0f)) continue;
            const float t = glm::dot(ac, q) / determinant;
            // Seen from object space the front is counter-clockwise, mirrored or not (glTF 2.0, section 3.7.4).
            if (t > 0.0f && t < hit.distance) hit = {t, doubleSided || determinant > 0.0f, doubleSided};
        }
    }

    const Scene& scene_;
    std::vector<Item> items_;
};

// Fibonacci sphere: Hannay and Nye 2004, "Fibonacci Numerical Integration on a Sphere".
vec3 fibonacciDirection(int i, int count)
{
    const float z = 1.0f - (2.0f * float(i) + 1.0f) / float(count);
    const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
    const float phi = 2.39996323f * float(i);
    return {r * std::cos(phi), z, r * std::sin(phi)};
}

// Whether a ray from either side of a surface point gets out of the scene.
bool seenFromOutside(const Caster& caster, vec3 point, vec3 towards, float margin)
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
bool holdsThings(const Scene& scene, const Caster& caster, const Bounds& box, vec3 point)
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
        if (hits > kRays * 3 / 4) return true;
    }
    int things = 0;
    for (int i = 0; i < kRays && things < kEnough; ++i) {
        const vec3 direction = fibonacciDirection(i, kRays);
        vec3 at = point;
        vec3 first(0.0f);
        int surfaces = 0;
        while (surfaces < 3) {
            const Hit hit = caster.cast(at, direction);
            if (!hit) break;
            at += (hit.distance + margin) * direction;
            if (surfaces++ == 0) first = at - margin * direction;
        }
        things += surfaces == 3 && !seenFromOutside(caster, first, direction, margin);
    }
    return things >= kEnough;
}

// Whether the scene is a room, to be seen from its middle: walls on nearly all sides that face inward. Walls with two
// sides may be an object's, too: those make a room when something is in it.
bool isRoom(const Scene& scene, const Caster& caster, const Bounds& box)
{
    constexpr int kRays = 64;
    int oneSided = 0;
    int doubleSided = 0;
    for (int i = 0; i < kRays; ++i) {
        const Hit hit = caster.cast(box.center(), fibonacciDirection(i, kRays));
        (hit.doubleSided ? doubleSided : oneSided) += hit.front;
    }
    if (oneSided + doubleSided <= kRays * 3 / 4) return false;
    return oneSided >= doubleSided || holdsThings(scene, caster, box, box.center());
}

// How much of the scene a view shows: the share of rays on front faces, times how deep into the bounds they go on
// average, in diagonals. Views with the nose on a wall, or that look through the back of one, score low.
float scoreView(const Caster& caster, const Camera& camera, float aspect, const Bounds& box)
{
    const vec3 eye = vec3(camera.worldFromCamera[3]);
    const float diagonal = glm::length(box.size());
    const float nearest = std::max(0.0f, glm::distance(eye, box.center()) - 0.5f * diagonal);
    constexpr int kGrid = 5;
    const float tangent = std::tan(0.5f * camera.verticalFovRadians);
    float sum = 0.0f;
    for (int y = 0; y < kGrid; ++y) {
        for (int x = 0; x < kGrid; ++x) {
            const vec2 p = 2.0f * (vec2(x, y) + 0.5f) / float(kGrid) - 1.0f;
            const vec3 d =
                mat3(camera.worldFromCamera) * glm::normalize(vec3(p.x * tangent * aspect, p.y * tangent, -1.0f));
            const Hit hit = caster.cast(eye, d);
            if (hit.front) sum += std::clamp((hit.distance - nearest) / diagonal, 0.0f, 1.0f);
        }
    }
    return sum / float(kGrid * kGrid);
}

// Distance from the centre at which a box's corners all fall into the picture.
float fittingDistance(const Bounds& box, const Camera& camera, float aspect)
{
    const mat3 cameraFromWorld = glm::transpose(mat3(camera.worldFromCamera));
    const float tangent = std::tan(0.5f * camera.verticalFovRadians);
    float distance = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const vec3 corner{i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z};
        const vec3 p = cameraFromWorld * (corner - box.center());
        distance = std::max(distance, p.z + std::max(std::abs(p.x) / (tangent * aspect), std::abs(p.y) / tangent));
    }
    return distance;
}

std::vector<Camera> viewsFromInside(const Bounds& box)
{
    const vec3 center = box.center();
    const vec3 half = 0.5f * box.size();
    std::vector<Camera> views;
    for (const float reach : {0.85f, 0.7f, 0.5f}) {
        for (int i = 0; i < 8; ++i) {
            const float angle = (float(i) + 0.5f) * 0.25f * kPi; // corners come first
            const vec2 side{std::cos(angle), std::sin(angle)};
            const vec2 square = side / std::max(std::abs(side.x), std::abs(side.y));
            const vec3 eye = center + half * vec3(reach * square.x, 0.15f, reach * square.y);
            views.push_back(lookAt(eye, center - half * vec3(0.0f, 0.1f, 0.0f), kPi * 65.0f / 180.0f, box));
        }
    }
    return views;
}

std::vector<Camera> viewsFromOutside(const Bounds& box, float aspect)
{
    std::vector<Camera> views;
    for (int i = 0; i < 8; ++i) {
        const float angle = (0.35f + 0.5f * float(i)) * 0.5f * kPi;
        const vec3 direction = glm::normalize(vec3(std::sin(angle), 0.45f, std::cos(angle)));
        const Camera camera = lookAt(direction, vec3(0.0f), kPi * 45.0f / 180.0f, box); // its turn is what counts
        const float distance = 1.05f * fittingDistance(box, camera, aspect);
        views.push_back(lookAt(box.center() + distance * direction, box.center(), camera.verticalFovRadians, box));
    }
    return views;
}

} // namespace

Camera lookAt(vec3 eye, vec3 target, float verticalFovRadians, const Bounds& bounds)
{
    const vec3 back = glm::normalize(eye - target);
    const vec3 up = std::abs(back.y) < 0.999f ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, -1.0f);
    const vec3 right = glm::normalize(glm::cross(up, back));
    Camera camera;
    camera.worldFromCamera =
        mat4(vec4(right, 0.0f), vec4(glm::cross(back, right), 0.0f), vec4(back, 0.0f), vec4(eye, 1.0f));
    camera.verticalFovRadians = verticalFovRadians;
    return withPlanesFor(bounds, camera);
}

Camera automaticCamera(const Scene& scene, float aspect)
{
    const Bounds box = scene.bounds();
    if (box.empty() || !(glm::length(box.size()) > 0.0f)) {
        return lookAt(vec3(0.0f, 0.0f, 5.0f), vec3(0.0f), kPi / 4.0f, box);
    }
    const Caster caster(scene);
    const auto best = [&](const std::vector<Camera>& views, float& bestScore) {
        const Camera* chosen = &views.front();
        for (const Camera& view : views) {
            const float score = scoreView(caster, view, aspect, box);
            // A clear gain is needed to leave an earlier view: rounding must not choose.
            if (score > bestScore + 0.01f) {
                bestScore = score;
                chosen = &view;
            }
        }
        return *chosen;
    };
    float score = 0.0f;
    if (isRoom(scene, caster, box)) {
        const Camera camera = best(viewsFromInside(box), score);
        if (score > 0.1f) return camera;
    }
    score = 0.0f;
    return best(viewsFromOutside(box, aspect), score);
}

Result<Camera> chooseCamera(const Scene& scene, const CameraChoice& choice, float aspect)
{
    Camera camera;
    if (choice.eye) {
        camera = lookAt(vec3(*choice.eye - scene.originMeters), vec3(choice.target - scene.originMeters), kPi / 3.0f,
                        scene.bounds());
    } else if (!choice.name.empty()) {
        const auto named = [&](const Camera& candidate) { return candidate.name == choice.name; };
        const auto found = std::find_if(scene.cameras.begin(), scene.cameras.end(), named);
        if (found == scene.cameras.end()) {
            std::string names;
            for (const Camera& candidate : scene.cameras) {
                names += (names.empty() ? "its cameras are '" : "', '") + candidate.name;
            }
            return Error{ErrorCode::InvalidArgument, "has no camera '" + choice.name + "'; " +
                                                         (names.empty() ? "it has no camera at all" : names + "'")};
        }
        camera = *found;
    } else if (!scene.cameras.empty()) {
        camera = scene.cameras.front();
    } else {
        camera = automaticCamera(scene, aspect);
    }
    if (choice.verticalFovRadians > 0.0f) camera.verticalFovRadians = choice.verticalFovRadians;
    return camera;
}

} // namespace halflight::cli
