#include "scene/model/origin.h"

#include "halflight/base/text.h"
#include "scene/model/gltf_error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace halflight {

namespace {

/// Distance from the origin over size, from which on coordinates are made relative: 6 of a float's 24 bits are lost
/// there, and the 18 that remain resolve 4 micrometres of a metre.
constexpr double kFarOverSize = 64.0;

/// The median of values, the upper one of an even number.
double median(std::vector<double>& values)
{
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double largest(const glm::dvec3& v)
{
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

glm::dvec3 centerOf(const WideBounds& box)
{
    return 0.5 * (box.min + box.max);
}

/// `center` rounded to a power of two between one and two times the diameter.
glm::dvec3 rounded(const glm::dvec3& center, double radius)
{
    int exponent = 0;
    std::frexp(2.0 * radius, &exponent);
    const double unit = std::ldexp(1.0, exponent);
    return glm::round(center / unit) * unit;
}

/// Distance between neighbouring floats, at most.
double floatStep(double distance)
{
    return distance * double(std::numeric_limits<float>::epsilon());
}

/// Whether floats round a thing of this size, this far out, so that it shows: by more than a millimetre and more than a
/// thousandth of it.
bool coarse(double distance, double size)
{
    return floatStep(distance) > 1.0e-3 && floatStep(distance) > 1.0e-3 * size;
}

} // namespace

WideBounds transformedBounds(const Bounds& box, const glm::dmat4& transform)
{
    WideBounds result;
    if (box.empty()) return result;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p((corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                           (corner & 4 ? box.max : box.min).z);
        result.extend(glm::dvec3(transform * glm::dvec4(p, 1.0)));
    }
    return result;
}

Bounds boundsOf(const Mesh& mesh)
{
    Bounds bounds;
    for (const MeshPart& part : mesh.parts) {
        for (const vec3& p : part.positions) bounds.extend(p);
    }
    return bounds;
}

glm::dvec3 localOrigin(std::span<const WideBounds> boxes, const glm::dvec3& current)
{
    std::vector<double> values;
    glm::dvec3 center(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        values.clear();
        for (const WideBounds& box : boxes) {
            if (!box.empty()) values.push_back(centerOf(box)[axis]);
        }
        if (values.empty()) return current;
        center[axis] = median(values);
    }
    // The radius around the median that holds half of the objects: a few that have strayed do not count.
    values.clear();
    for (const WideBounds& box : boxes) {
        if (!box.empty()) values.push_back(glm::length(glm::max(box.max - center, center - box.min)));
    }
    const double radius = median(values);
    if (!(radius > 0.0) || !std::isfinite(radius) || largest(center - current) <= kFarOverSize * radius) return current;
    return rounded(center, radius);
}

glm::dvec3 centreMesh(Mesh& mesh)
{
    const Bounds bounds = boundsOf(mesh);
    if (bounds.empty()) return glm::dvec3(0.0);
    const glm::dvec3 center = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
    const double radius = 0.5 * glm::length(glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
    if (!(radius > 0.0) || largest(center) <= kFarOverSize * radius) return glm::dvec3(0.0);
    const glm::dvec3 offset = rounded(center, radius);
    for (MeshPart& part : mesh.parts) {
        for (vec3& p : part.positions) p = vec3(glm::dvec3(p) - offset);
    }
    return offset;
}

std::string coarseVerticesWarning(const Mesh& mesh, const glm::dvec3& offset)
{
    const Bounds bounds = boundsOf(mesh);
    if (bounds.empty() || !coarse(largest(offset), glm::length(glm::dvec3(bounds.size())))) return {};
    char text[160];
    std::snprintf(text, sizeof(text),
                  "lie %.3g m from its origin, where floats are %.2g mm apart: put that distance into the node",
                  largest(offset), 1.0e3 * floatStep(largest(offset)));
    return pathOf("meshes", std::size_t(std::max(mesh.sourceMesh, 0))) + ": the vertices of mesh \"" + mesh.name +
           "\" " + text;
}

std::string coarseObjectsWarning(const Scene& scene)
{
    std::vector<Bounds> boundsOfMesh;
    for (const Mesh& mesh : scene.meshes) boundsOfMesh.push_back(boundsOf(mesh));
    std::vector<std::string> names;
    double farthest = 0.0;
    for (const Object& object : scene.objects) {
        if (object.mesh < 0) continue;
        const WideBounds box =
            transformedBounds(boundsOfMesh[std::size_t(object.mesh)], glm::dmat4(object.worldFromObject));
        if (box.empty()) continue;
        const double distance = std::max(largest(box.min), largest(box.max));
        if (!coarse(distance, glm::length(box.max - box.min))) continue;
        names.push_back(object.name);
        farthest = std::max(farthest, distance);
    }
    if (names.empty()) return {};
    char numbers[96];
    std::snprintf(numbers, sizeof(numbers),
                  "up to %.3g km from the scene's middle, where positions are rounded to %.2g mm", 1.0e-3 * farthest,
                  1.0e3 * floatStep(farthest));
    return "objects " + listOf(names) + " lie " + numbers +
           ": their light and shadows are coarse; keep them in a file of their own";
}

bool farFromOrigin(const Scene& scene)
{
    std::vector<Bounds> boundsOfMesh;
    for (const Mesh& mesh : scene.meshes) boundsOfMesh.push_back(boundsOf(mesh));
    std::vector<WideBounds> boxes;
    for (const Object& object : scene.objects) {
        if (object.mesh < 0) continue;
        boxes.push_back(transformedBounds(boundsOfMesh[std::size_t(object.mesh)], glm::dmat4(object.worldFromObject)));
    }
    return localOrigin(boxes, glm::dvec3(0.0)) != glm::dvec3(0.0);
}

bool recenter(Scene& scene)
{
    std::vector<glm::dvec3> offsets;
    std::vector<Bounds> bounds;
    bool changed = false;
    for (Mesh& mesh : scene.meshes) {
        offsets.push_back(centreMesh(mesh));
        bounds.push_back(boundsOf(mesh));
        changed = changed || offsets.back() != glm::dvec3(0.0);
    }
    std::vector<glm::dmat4> transforms;
    std::vector<WideBounds> boxes;
    for (const Object& object : scene.objects) {
        glm::dmat4& transform = transforms.emplace_back(object.worldFromObject);
        if (object.mesh < 0) continue;
        transform = transform * glm::translate(glm::dmat4(1.0), offsets[std::size_t(object.mesh)]);
        boxes.push_back(transformedBounds(bounds[std::size_t(object.mesh)], transform));
    }
    const glm::dvec3 shift = localOrigin(boxes, glm::dvec3(0.0));
    changed = changed || shift != glm::dvec3(0.0);
    if (!changed) return false;
    scene.originMeters += shift;
    for (std::size_t i = 0; i < transforms.size(); ++i)
        scene.objects[i].worldFromObject = localFromWorld(transforms[i], shift);
    for (Light& light : scene.lights) {
        light.worldFromLight = localFromWorld(glm::dmat4(light.worldFromLight), shift);
        light.baking.worldFromLight = localFromWorld(glm::dmat4(light.baking.worldFromLight), shift);
    }
    for (Camera& camera : scene.cameras)
        camera.worldFromCamera = localFromWorld(glm::dmat4(camera.worldFromCamera), shift);
    for (vec3& p : scene.probePositions) p = vec3(glm::dvec3(p) - shift);
    for (mat4& box : scene.reflectionBoxes) box = localFromWorld(glm::dmat4(box), shift);
    return true;
}

} // namespace halflight
