#include "view/gizmo.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace halflight::view {
namespace {

/// Length of an arrow over the picture's height.
constexpr float kLength = 0.15f;
/// Points from an arrow within which the mouse takes hold of it.
constexpr float kReach = 7.0f;
/// Rays nearer to an arrow's direction than this sine (2 degrees) say nothing of a place on it.
constexpr float kAlong = 0.035f;

vec3 axis(int arrow)
{
    vec3 direction(0.0f);
    direction[arrow] = 1.0f;
    return direction;
}

float distanceToSegment(vec2 p, vec2 a, vec2 b)
{
    const vec2 ab = b - a;
    const float squared = glm::dot(ab, ab);
    const float t = squared > 0.0f ? std::clamp(glm::dot(p - a, ab) / squared, 0.0f, 1.0f) : 0.0f;
    return glm::distance(p, a + t * ab);
}

} // namespace

std::optional<Gizmo::Shape> Gizmo::shapeOf(const Camera& camera, vec3 place, vec2 size)
{
    const float aspect = size.x / size.y;
    const std::optional<vec2> center = pointOf(camera, place, aspect);
    if (!center) return std::nullopt;
    const float ahead = -glm::dot(place - vec3(camera.worldFromCamera[3]), vec3(camera.worldFromCamera[2]));
    const float height = camera.orthographic ? camera.orthographicHeightMeters
                                             : 2.0f * ahead * std::tan(0.5f * camera.verticalFovRadians);
    Shape shape{*center * size, {}};
    for (int arrow = 0; arrow < 3; ++arrow) {
        const std::optional<vec2> tip = pointOf(camera, place + kLength * height * axis(arrow), aspect);
        if (!tip) return std::nullopt;
        shape.tips[std::size_t(arrow)] = *tip * size;
    }
    return shape;
}

int Gizmo::arrowAt(const Shape& shape, vec2 mouse)
{
    int nearest = -1;
    float least = kReach;
    for (int arrow = 0; arrow < 3; ++arrow) {
        const float distance = distanceToSegment(mouse, shape.center, shape.tips[std::size_t(arrow)]);
        if (distance > least) continue;
        least = distance;
        nearest = arrow;
    }
    return nearest;
}

/// The place on the arrow's line that is nearest to the mouse's ray, in metres from place_.
std::optional<float> Gizmo::along(const Camera& camera, vec2 mouse, vec2 size) const
{
    const Ray ray = rayThrough(camera, mouse / size, size.x / size.y);
    const vec3 direction = glm::normalize(ray.direction);
    const vec3 line = axis(arrow_);
    const float cosine = glm::dot(direction, line);
    const float sine2 = 1.0f - cosine * cosine;
    if (sine2 < kAlong * kAlong) return std::nullopt;
    const vec3 between = ray.origin - place_;
    return (glm::dot(between, line) - cosine * glm::dot(between, direction)) / sine2;
}

void Gizmo::draw(const Camera& camera, vec3 place) const
{
    const vec2 size(ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
    const std::optional<Shape> shape = shapeOf(camera, place, size);
    if (!shape) return;
    const vec2 mouse(ImGui::GetIO().MousePos.x, ImGui::GetIO().MousePos.y);
    const int under = arrow_ >= 0 ? arrow_ : arrowAt(*shape, mouse);
    constexpr std::array kColors = {IM_COL32(235, 70, 60, 255), IM_COL32(90, 200, 70, 255),
                                    IM_COL32(70, 120, 240, 255)};
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    for (int arrow = 0; arrow < 3; ++arrow) {
        const vec2 tip = shape->tips[std::size_t(arrow)];
        const ImU32 color = arrow == under ? IM_COL32(255, 220, 60, 255) : kColors[std::size_t(arrow)];
        list->AddLine(ImVec2(shape->center.x, shape->center.y), ImVec2(tip.x, tip.y), color, 3.0f);
        list->AddCircleFilled(ImVec2(tip.x, tip.y), 5.0f, color);
    }
}

void Gizmo::grab(const Camera& camera, vec3 place, int arrow, vec2 mouse, vec2 size)
{
    place_ = place;
    arrow_ = arrow;
    grabbedAt_ = along(camera, mouse, size).value_or(0.0f);
}

vec3 Gizmo::dragged(const Camera& camera, vec2 mouse, vec2 size) const
{
    if (arrow_ < 0) return place_;
    return place_ + (along(camera, mouse, size).value_or(grabbedAt_) - grabbedAt_) * axis(arrow_);
}

void drawBounds(const Camera& camera, const Bounds& bounds)
{
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    if (bounds.empty() || !(size.x > 0.0f && size.y > 0.0f)) return;
    const auto place = [&](int corner) {
        vec3 p = bounds.min;
        for (int axis = 0; axis < 3; ++axis)
            if ((corner >> axis & 1) != 0) p[axis] = bounds.max[axis];
        return pointOf(camera, p, size.x / size.y);
    };
    for (int corner = 0; corner < 8; ++corner) {
        for (int axis = 0; axis < 3; ++axis) {
            if ((corner >> axis & 1) != 0) continue;
            const std::optional<vec2> a = place(corner);
            const std::optional<vec2> b = place(corner | 1 << axis);
            if (!a || !b) continue;
            ImGui::GetBackgroundDrawList()->AddLine(ImVec2(a->x * size.x, a->y * size.y),
                                                    ImVec2(b->x * size.x, b->y * size.y), IM_COL32(255, 200, 0, 160));
        }
    }
}

} // namespace halflight::view
