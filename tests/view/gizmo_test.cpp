// Dragging along an axis: the arrow stays under the mouse.
#include "view/gizmo.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace halflight::view::gizmo_test {
namespace {

constexpr vec2 kSize{640.0f, 360.0f};
constexpr float kAspect = 640.0f / 360.0f;

Camera cameraAt(vec3 eye, vec3 target, bool orthographic)
{
    Camera camera;
    camera.worldFromCamera = glm::inverse(glm::lookAt(eye, target, vec3(0, 1, 0)));
    camera.orthographic = orthographic;
    camera.orthographicHeightMeters = 6.0f;
    return camera;
}

TEST(PictureRay, MeetsThePlaceThatItIsDrawnAt)
{
    for (const bool orthographic : {false, true}) {
        const Camera camera = cameraAt(vec3(3, 2, 5), vec3(0), orthographic);
        const vec3 place(0.5f, -0.25f, 0.75f);
        const std::optional<vec2> point = pointOf(camera, place, kAspect);
        ASSERT_TRUE(point);
        const Ray ray = rayThrough(camera, *point, kAspect);
        const vec3 toPlace = place - ray.origin;
        EXPECT_LT(glm::length(glm::cross(toPlace, glm::normalize(ray.direction))), 1.0e-4f);
        EXPECT_FALSE(pointOf(cameraAt(vec3(0, 0, -5), vec3(0, 0, -9), false), place, kAspect)) << "behind it";
    }
}

TEST(Gizmo, DraggedPlacesAreUnderTheMouse)
{
    const vec3 place(0.5f, 0.25f, -0.5f);
    for (const bool orthographic : {false, true}) {
        const Camera camera = cameraAt(vec3(4, 3, 5), vec3(0), orthographic);
        const std::optional<Gizmo::Shape> shape = Gizmo::shapeOf(camera, place, kSize);
        ASSERT_TRUE(shape);
        for (int arrow = 0; arrow < 3; ++arrow) {
            const vec2 tip = shape->tips[std::size_t(arrow)];
            const vec2 grip = glm::mix(shape->center, tip, 0.7f);
            EXPECT_EQ(Gizmo::arrowAt(*shape, grip), arrow);
            vec3 target = place; // 1.5 m along the axis; the grip moves as much
            target[arrow] += 1.5f;
            Gizmo gizmo;
            gizmo.grab(camera, place, arrow, shape->center, kSize);
            const vec3 dragged = gizmo.dragged(camera, *pointOf(camera, target, kAspect) * kSize, kSize);
            EXPECT_LT(glm::distance(dragged, target), 1.0e-3f) << arrow;
            EXPECT_LT(glm::distance(gizmo.dragged(camera, shape->center, kSize), place), 1.0e-4f) << "not moved";
        }
        EXPECT_EQ(Gizmo::arrowAt(*shape, shape->center + vec2(-200, 150)), -1);
    }
}

TEST(Gizmo, GoesNowhereAlongTheLineOfSight)
{
    const Camera camera = cameraAt(vec3(0, 0, 8), vec3(0), false);
    Gizmo gizmo;
    gizmo.grab(camera, vec3(0), 2, 0.5f * kSize, kSize);
    EXPECT_EQ(gizmo.dragged(camera, 0.5f * kSize + vec2(3, 0), kSize), vec3(0));
    gizmo.release();
    EXPECT_EQ(gizmo.dragged(camera, vec2(0), kSize), vec3(0));
}

} // namespace
} // namespace halflight::view::gizmo_test
