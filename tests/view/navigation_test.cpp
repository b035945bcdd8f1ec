// The window's camera, and what a click meets.
#include "view/state/navigation.h"

#include "halflight/render/frame.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace halflight::view::navigation_test {
namespace {

Camera lookingAt(vec3 eye, vec3 target)
{
    Camera camera;
    camera.worldFromCamera = glm::inverse(glm::lookAt(eye, target, vec3(0, 1, 0)));
    return camera;
}

vec3 eyeOf(const Camera& camera)
{
    return vec3(camera.worldFromCamera[3]);
}

void expectSame(const mat4& a, const mat4& b)
{
    for (int i = 0; i < 16; ++i) EXPECT_NEAR(a[i / 4][i % 4], b[i / 4][i % 4], 1.0e-5f) << i;
}

TEST(Navigator, TakesACamerasPose)
{
    for (const vec3 target : {vec3(1, 1, 1), vec3(-3, 0.5f, 2), vec3(0, 4, -1), vec3(2, -5, -2)}) {
        const Camera camera = lookingAt(vec3(0.5f, 1.0f, -0.2f), target);
        expectSame(Navigator(camera, 2.0f).camera().worldFromCamera, camera.worldFromCamera);
    }
}

TEST(Navigator, HasTheFilesCameraUntilItMoves)
{
    Camera camera = lookingAt(vec3(0.5f, 1.0f, -0.2f), vec3(1, 0.3f, 2));
    camera.worldFromCamera = camera.worldFromCamera * glm::rotate(mat4(1.0f), 0.4f, vec3(0, 0, 1)); // rolled
    camera.name = "tilted";
    Navigator navigator(camera, 2.0f);
    EXPECT_EQ(navigator.camera(), camera) << "as `halflight render --camera` has it, to the bit";
    navigator.look(vec2(0.0f));
    EXPECT_NEAR(navigator.camera().worldFromCamera[0].y, 0.0f, 1.0e-6f) << "upright";
}

TEST(Navigator, LooksStraightDown)
{
    Camera camera; // a plan: down, with -Z at the picture's upper edge
    camera.worldFromCamera = glm::rotate(mat4(1.0f), -0.5f * kPi, vec3(1, 0, 0));
    const mat4 pose = Navigator(camera, 1.0f).camera().worldFromCamera;
    EXPECT_LT(glm::distance(vec3(pose[2]), vec3(0, 1, 0)), 0.01f);
    EXPECT_LT(glm::distance(vec3(pose[1]), vec3(0, 0, -1)), 0.01f);
}

TEST(Navigator, OrbitsAboutThePivot)
{
    Navigator navigator(lookingAt(vec3(0, 1, 5), vec3(0, 1, 0)), 5.0f);
    navigator.orbit(vec2(0.5f * kPi, 0.0f));
    EXPECT_LT(glm::distance(navigator.pivot(), vec3(0, 1, 0)), 1.0e-4f);
    EXPECT_LT(glm::distance(eyeOf(navigator.camera()), vec3(5, 1, 0)), 1.0e-4f);
    navigator.orbit(vec2(0.0f, -10.0f)); // stops short of straight down
    EXPECT_LT(glm::distance(navigator.pivot(), vec3(0, 1, 0)), 1.0e-4f);
    EXPECT_GT(eyeOf(navigator.camera()).y, 5.9f);
    EXPECT_GT(navigator.camera().worldFromCamera[1].y, 0.0f) << "upright";
}

TEST(Navigator, MovesAsItsNamesSay)
{
    const Navigator start(lookingAt(vec3(0, 0, 4), vec3(0)), 4.0f);
    Navigator navigator = start;
    navigator.look(vec2(0.5f * kPi, 0.0f)); // to the left
    EXPECT_LT(glm::distance(navigator.forward(), vec3(-1, 0, 0)), 1.0e-5f);
    EXPECT_EQ(eyeOf(navigator.camera()), vec3(0, 0, 4));

    navigator = start;
    navigator.pan(vec2(1.0f, 2.0f));
    EXPECT_LT(glm::distance(eyeOf(navigator.camera()), vec3(1, 2, 4)), 1.0e-5f);
    navigator = start;
    navigator.dolly(0.5f);
    EXPECT_LT(glm::distance(eyeOf(navigator.camera()), vec3(0, 0, 2)), 1.0e-5f);
    navigator = start;
    navigator.fly(vec3(1, 2, 3));
    EXPECT_LT(glm::distance(eyeOf(navigator.camera()), vec3(1, 2, 1)), 1.0e-5f);
    // A pixel at the pivot: the picture is 2 * 4 * tan(30 degrees) high.
    EXPECT_NEAR(start.pixelMeters(100), 8.0f * std::tan(kPi / 6.0f) / 100.0f, 1.0e-6f);
}

TEST(Navigator, FramesBounds)
{
    Bounds box;
    box.extend(vec3(10, 0, 0));
    box.extend(vec3(12, 2, 2));
    for (const float aspect : {0.5f, 1.0f, 2.0f}) {
        Navigator navigator(lookingAt(vec3(0, 1, 5), vec3(0)), 5.0f);
        navigator.frame(box, aspect);
        const Camera camera = navigator.camera();
        const mat4 view = glm::inverse(camera.worldFromCamera);
        float most = 0.0f;
        const float tangent = std::tan(0.5f * camera.verticalFovRadians);
        for (int i = 0; i < 8; ++i) {
            const vec3 corner(i & 1 ? 12 : 10, i & 2 ? 2 : 0, i & 4 ? 2 : 0);
            const vec3 p = vec3(view * vec4(corner, 1.0f));
            most = std::max({most, std::abs(p.x / (p.z * tangent * aspect)), std::abs(p.y / (p.z * tangent))});
        }
        EXPECT_LE(most, 1.0f);
        EXPECT_GT(most, 0.5f) << "not far off either";
    }
}

/// The near plane has a say in where cascades end, so a picture is that of `halflight render --eye` with its planes
/// only.
TEST(Navigator, HasThePlanesOfTheCommandLineOnceItMoves)
{
    Camera camera = lookingAt(vec3(0, 0, 100), vec3(0));
    camera.nearMeters = 0.2f;
    camera.farMeters = 5000.0f;
    Bounds scene; // its diagonal is 13 m
    scene.extend(vec3(-1.5f, -2, -6));
    scene.extend(vec3(1.5f, 2, 6));
    const Navigator start(camera, 10.0f, scene);
    EXPECT_EQ(start.camera().nearMeters, 0.2f) << "the file's";
    EXPECT_EQ(start.camera().farMeters, 5000.0f);
    const auto expectPlanes = [&](auto move) {
        Navigator navigator = start;
        move(navigator);
        const Camera moved = navigator.camera();
        EXPECT_NEAR(moved.nearMeters, 0.013f, 1.0e-6f);
        EXPECT_NEAR(moved.farMeters, std::max(100.0f, 2.0f * (13.0f + glm::length(eyeOf(moved)))), 1.0e-3f);
    };
    expectPlanes([](Navigator& n) { n.orbit(vec2(0.1f)); });
    expectPlanes([](Navigator& n) { n.look(vec2(0.1f)); });
    expectPlanes([](Navigator& n) { n.pan(vec2(0.1f)); });
    expectPlanes([](Navigator& n) { n.dolly(0.5f); });
    expectPlanes([](Navigator& n) { n.fly(vec3(0, 0, 60)); });
    expectPlanes([&](Navigator& n) { n.frame(scene, 1.5f); });

    Bounds grain; // nearer than that
    grain.extend(vec3(0.0f));
    grain.extend(vec3(0.001f));
    Navigator navigator = start;
    navigator.frame(grain, 1.5f);
    EXPECT_LT(navigator.camera().nearMeters, glm::distance(eyeOf(navigator.camera()), vec3(0.0005f)) - 0.0009f);
    EXPECT_GT(navigator.camera().nearMeters, 0.0f);
    navigator.frame(scene, 1.5f);
    EXPECT_NEAR(navigator.camera().nearMeters, 0.013f, 1.0e-6f) << "not for ever";

    camera.orthographic = true; // has no such command
    navigator = Navigator(camera, 10.0f, scene);
    navigator.pan(vec2(0.1f));
    EXPECT_EQ(navigator.camera().nearMeters, 0.2f);
}

/// Squares two metres wide that face +Z, one for each place.
Scene squaresAt(std::initializer_list<mat4> places)
{
    Scene scene;
    MeshPart& part = scene.meshes.emplace_back().parts.emplace_back();
    part.positions = {vec3(-1, -1, 0), vec3(1, -1, 0), vec3(1, 1, 0), vec3(-1, 1, 0)};
    part.indices = {0, 1, 2, 0, 2, 3};
    part.material = 0;
    scene.materials.emplace_back();
    for (const mat4& place : places) {
        Object& object = scene.objects.emplace_back();
        object.mesh = 0;
        object.worldFromObject = place;
    }
    return scene;
}

mat4 placed(vec3 at, vec3 scale)
{
    return glm::scale(glm::translate(mat4(1.0f), at), scale);
}

TEST(ObjectAt, IsTheNearestThatTheRayMeets)
{
    const Scene scene = squaresAt({placed(vec3(0, 0, -4), vec3(0.5f)), placed(vec3(0.9f, 0, -2), vec3(0.5f)),
                                   placed(vec3(0, 0, 3), vec3(0.5f))}); // the last is behind the camera
    const Camera camera = lookingAt(vec3(0, 0, 0), vec3(0, 0, -1));
    EXPECT_EQ(objectAt(scene, camera, vec2(0.5f), 1.0f), 0);
    // 0.45 m to the right at 2 m: the nearer one covers it, and the farther one ends at 0.25 m there.
    const float x = 0.5f + 0.5f * (0.45f / 2.0f) / std::tan(kPi / 6.0f);
    EXPECT_EQ(objectAt(scene, camera, vec2(x, 0.5f), 1.0f), 1);
    EXPECT_EQ(objectAt(scene, camera, vec2(0.02f, 0.02f), 1.0f), -1);
}

/// As the renderer draws: a wall between the camera and a room is not there from outside.
TEST(ObjectAt, SeesThroughBackFaces)
{
    const Camera camera = lookingAt(vec3(0, 0, 0), vec3(0, 0, -1));
    const mat4 wall = placed(vec3(0, 0, -4), vec3(1));
    for (const vec3 mirrored : {vec3(1, 1, 1), vec3(-1, 1, 1), vec3(-1, -1, 1)}) {
        // A mirrored square still faces +Z, and one that is mirrored along Z faces -Z.
        Scene scene = squaresAt({wall, placed(vec3(0, 0, -2), mirrored * vec3(1, 1, -1))});
        EXPECT_EQ(objectAt(scene, camera, vec2(0.5f), 1.0f), 0) << mirrored.x << mirrored.y;
        scene.materials[0].doubleSided = true;
        EXPECT_EQ(objectAt(scene, camera, vec2(0.5f), 1.0f), 1);
        scene = squaresAt({wall, placed(vec3(0, 0, -2), mirrored)});
        EXPECT_EQ(objectAt(scene, camera, vec2(0.5f), 1.0f), 1) << mirrored.x << mirrored.y;
    }
}

/// In a room the camera orbits about what it looks at, not through the walls.
TEST(MetersAhead, IsToTheVisibleSurfaceInTheMiddle)
{
    const Scene scene = squaresAt({placed(vec3(0, 0, -4), vec3(1)), placed(vec3(0.9f, 0, -1), vec3(0.5f)),
                                   placed(vec3(0, 0, -3), vec3(2, 2, -1)), placed(vec3(0, 0, 3), vec3(-1, 1, -1))});
    const std::vector<Bounds> bounds = objectBounds(scene);
    const auto ahead = [&](vec3 target) {
        return metersAhead(scene, lookingAt(vec3(0), target), bounds).value_or(-1.0f);
    };
    EXPECT_NEAR(ahead(vec3(0, 0, -1)), 4.0f, 1.0e-5f) << "behind the back of another one";
    EXPECT_NEAR(ahead(vec3(0.9f, 0, -1)), glm::length(vec2(0.9f, 1.0f)), 1.0e-5f) << "not along Z";
    EXPECT_NEAR(ahead(vec3(0, 0, 1)), 3.0f, 1.0e-5f);
    EXPECT_EQ(ahead(vec3(0, 1, 0)), -1.0f);
    Camera plan = lookingAt(vec3(0), vec3(0, 0, -1));
    plan.orthographic = true;
    EXPECT_NEAR(metersAhead(scene, plan, bounds).value_or(-1.0f), 4.0f, 1.0e-5f);
}

/// Objects whose bounds the ray misses are not looked at.
TEST(MetersAhead, TakesTheBoundsItIsGiven)
{
    const Scene scene = squaresAt({placed(vec3(0, 0, -4), vec3(1)), placed(vec3(0, 0, -2), vec3(1))});
    std::vector<Bounds> bounds = objectBounds(scene);
    const Camera camera = lookingAt(vec3(0), vec3(0, 0, -1));
    EXPECT_EQ(objectAt(scene, camera, vec2(0.5f), 1.0f, bounds), 1);
    bounds[1].min.x = 0.5f;
    EXPECT_EQ(objectAt(scene, camera, vec2(0.5f), 1.0f, bounds), 0);
    EXPECT_EQ(metersAhead(scene, camera, bounds), 4.0f);
    EXPECT_EQ(metersAhead(scene, camera, {}), 2.0f);
}

} // namespace
} // namespace halflight::view::navigation_test
