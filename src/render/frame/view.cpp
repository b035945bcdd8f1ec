// Camera matrices, and what is inside what.
#include "render/frame/frame_internal.h"

#include "halflight/base/cone.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>

namespace halflight {

mat4 FrameView::viewFromWorld() const
{
    return glm::inverse(camera.worldFromCamera);
}

// Reversed z: near maps to 1 and far to 0, so that floating-point depth is as fine far away as it is near (Reed 2015,
// "Depth Precision Visualized"). An infinite far plane is the limit of the same formula.
mat4 FrameView::clipFromView() const
{
    const float aspect = float(std::max(size.x, 1)) / float(std::max(size.y, 1));
    const float farMeters = camera.farMeters;
    mat4 m(0.0f);
    if (camera.orthographic) {
        const float halfHeight = 0.5f * camera.orthographicHeightMeters;
        const float nearMeters = camera.nearMeters;
        m[0][0] = 1.0f / (halfHeight * aspect);
        m[1][1] = -1.0f / halfHeight;
        m[2][2] = 1.0f / (farMeters - nearMeters);
        m[3][2] = farMeters / (farMeters - nearMeters);
        m[3][3] = 1.0f;
        return m;
    }
    const float nearMeters = std::max(camera.nearMeters, 1.0e-4f);
    const float tanHalf = math::tan(0.5f * camera.verticalFovRadians);
    m[0][0] = 1.0f / (tanHalf * aspect);
    m[1][1] = -1.0f / tanHalf;
    m[2][3] = -1.0f;
    if (std::isfinite(farMeters)) {
        m[2][2] = nearMeters / (farMeters - nearMeters);
        m[3][2] = nearMeters * farMeters / (farMeters - nearMeters);
    } else {
        m[3][2] = nearMeters;
    }
    return m;
}

// The transform of a box by its centre and half extents: Arvo 1990, "Transforming Axis-Aligned Bounding Boxes".
Bounds worldBounds(const Bounds& box, const mat4& worldFromObject)
{
    if (box.empty()) return {};
    const mat4& m = worldFromObject;
    const vec3 center = vec3(m * vec4(box.center(), 1.0f));
    const vec3 half = 0.5f * box.size();
    const vec3 worldHalf =
        glm::abs(vec3(m[0])) * half.x + glm::abs(vec3(m[1])) * half.y + glm::abs(vec3(m[2])) * half.z;
    Bounds result;
    result.extend(center - worldHalf);
    result.extend(center + worldHalf);
    return result;
}

std::vector<Bounds> objectBounds(const Scene& scene)
{
    std::vector<Bounds> ofMesh(scene.meshes.size());
    for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
        for (const MeshPart& part : scene.meshes[i].parts) {
            for (const vec3& position : part.positions) ofMesh[i].extend(position);
        }
    }
    std::vector<Bounds> result(scene.objects.size());
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (object.mesh >= 0) result[i] = worldBounds(ofMesh[std::size_t(object.mesh)], object.worldFromObject);
    }
    return result;
}

Camera withPlanesFor(const Bounds& scene, Camera camera)
{
    if (scene.empty()) return camera;
    const float diagonal = glm::length(scene.size());
    // As near as the smallest scene needs: reversed depth in floats resolves all beyond it alike.
    camera.nearMeters = std::clamp(0.001f * diagonal, 1.0e-7f, 0.05f);
    camera.farMeters =
        std::max(100.0f, 2.0f * (diagonal + glm::distance(vec3(camera.worldFromCamera[3]), scene.center())));
    return camera;
}

bool rayReaches(const Bounds& bounds, vec3 origin, vec3 direction, float limit)
{
    float near = 0.0f;
    float far = limit;
    for (int axis = 0; axis < 3; ++axis) {
        const float a = (bounds.min[axis] - origin[axis]) / direction[axis];
        const float b = (bounds.max[axis] - origin[axis]) / direction[axis];
        // A direction along the slab gives NaN on its planes; the comparisons then keep the interval as it is.
        if (std::min(a, b) > near) near = std::min(a, b);
        if (std::max(a, b) < far) far = std::max(a, b);
    }
    return near <= far * 1.0001f + 1.0e-6f;
}

// Gribb and Hartmann 2001, "Fast Extraction of Viewing Frustum Planes from the World-View-Projection Matrix".
Planes planesOf(const mat4& clipFromWorld)
{
    const mat4 rows = glm::transpose(clipFromWorld);
    Planes planes = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                     rows[3] - rows[1], rows[2],           rows[3] - rows[2]};
    for (vec4& plane : planes) {
        const float length = glm::length(vec3(plane));
        plane = length > 1.0e-12f ? plane / length : vec4(0, 0, 0, 1);
    }
    return planes;
}

bool meets(const Planes& planes, const Bounds& box)
{
    if (box.empty()) return false;
    const vec3 center = box.center();
    const vec3 half = 0.5f * box.size();
    for (const vec4& plane : planes) {
        const vec3 n = vec3(plane);
        const float reach = glm::dot(glm::abs(n), half);
        const float slack = 1.0e-5f * (std::abs(plane.w) + glm::dot(glm::abs(n), glm::abs(center)) + reach);
        if (glm::dot(n, center) + plane.w + reach < -slack) return false;
    }
    return true;
}

LightVolume volumeOf(const Light& light)
{
    LightVolume volume;
    if (light.type == LightType::Directional) {
        volume.everywhere = true;
        return volume;
    }
    volume.center = light.position();
    if (light.rangeMeters > 0.0f) volume.radius = light.rangeMeters;
    if (light.type == LightType::Spot) {
        volume.axis = light.direction();
        volume.halfAngle = light.outerConeRadians;
    } else if (isAreaLight(light.type)) { // its front
        volume.axis = light.direction();
        volume.halfAngle = kPi / 2.0f;
    } else {
        volume.everywhere = light.rangeMeters <= 0.0f;
    }
    return volume;
}

bool meets(const LightVolume& volume, const Planes& planes)
{
    if (volume.everywhere) return true;
    for (const vec4& plane : planes) {
        // How far a ball's sector reaches along the plane's normal from its apex: exact for one plane.
        const vec3 n = vec3(plane);
        const float angle = math::acos(glm::clamp(glm::dot(n, volume.axis), -1.0f, 1.0f));
        const float alongNormal = math::cos(std::max(0.0f, angle - volume.halfAngle));
        const float reach = alongNormal > 0.0f ? alongNormal * volume.radius : 0.0f;
        const float slack = 1.0e-4f * (1.0f + glm::length(volume.center) + std::abs(plane.w));
        if (glm::dot(n, volume.center) + plane.w + reach < -slack) return false;
    }
    return true;
}

bool meets(const LightVolume& volume, const Bounds& box)
{
    if (box.empty()) return false;
    if (volume.everywhere) return true;
    if (distanceTo(box, volume.center) > volume.radius * 1.0001f) return false;
    return coneMeetsBall(volume.center, volume.axis, volume.halfAngle, box.center(), 0.5f * glm::length(box.size()));
}

float distanceTo(const Bounds& box, vec3 point)
{
    return glm::length(glm::max(glm::max(box.min - point, point - box.max), vec3(0.0f)));
}

float farthestIn(const Bounds& box, vec3 point)
{
    return box.empty() ? 0.0f : glm::length(glm::max(glm::abs(box.min - point), glm::abs(box.max - point)));
}

std::string nameOf(const Scene& scene, int light)
{
    const std::string& name = scene.lights[std::size_t(light)].name;
    return name.empty() ? "light " + std::to_string(light) : "light \"" + name + "\"";
}

} // namespace halflight
