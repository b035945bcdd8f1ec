#include "camera.h"
#include "view_scenes.h"

#include <gtest/gtest.h>

using namespace halflight;
using namespace halflight::cli;

TEST(CommandLineCamera, LookAtIsRigidAndPointsAtItsTarget)
{
    for (const vec3 target : {vec3(0, 0, 0), vec3(1, 9, 3), vec3(1, -9, 3), vec3(-4, 2, 3)}) {
        const vec3 eye(1, 2, 3);
        const Camera camera = lookAt(eye, target, 1.0f, {});
        const mat3 rotation(camera.worldFromCamera);
        EXPECT_NEAR(glm::determinant(rotation), 1.0f, 1e-5f);
        EXPECT_NEAR(glm::length(rotation[0]), 1.0f, 1e-5f);
        EXPECT_NEAR(glm::dot(rotation[0], rotation[2]), 0.0f, 1e-5f);
        EXPECT_NEAR(glm::dot(forwardOf(camera), glm::normalize(target - eye)), 1.0f, 1e-5f);
        EXPECT_GE(rotation[1].y, -1e-5f) << "upside down";
    }
}

TEST(CommandLineCamera, EyeAndTargetAreOfTheWorld)
{
    Scene scene = sceneWith(box(vec3(1), false, false));
    scene.originMeters = {5.0e5, 0.0, -5.0e6};
    CameraChoice choice;
    choice.eye = scene.originMeters + dvec3(4.125, 3.0, 5.0);
    choice.target = scene.originMeters + dvec3(0.125, 0.0, 0.0);
    const Result<Camera> camera = chooseCamera(scene, choice, 1.0f);
    ASSERT_TRUE(camera);
    EXPECT_LT(glm::distance(eyeOf(*camera), vec3(4.125f, 3.0f, 5.0f)), 1.0e-5f);
    EXPECT_LT(glm::distance(forwardOf(*camera), glm::normalize(vec3(-4, -3, -5))), 1.0e-5f);
}

TEST(CommandLineCamera, ChoiceOfCamera)
{
    Scene scene = sceneWith(box(vec3(1), false, false));
    scene.cameras.resize(2);
    scene.cameras[0].name = "first";
    scene.cameras[1].name = "second";
    CameraChoice choice;
    EXPECT_EQ(chooseCamera(scene, choice, 1.0f)->name, "first");
    choice.name = "second";
    EXPECT_EQ(chooseCamera(scene, choice, 1.0f)->name, "second");
    choice.name = "third";
    const Result<Camera> missing = chooseCamera(scene, choice, 1.0f);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("'first', 'second'"), std::string::npos) << missing.error().message;
    choice = {};
    choice.eye = dvec3(1, 2, 3);
    choice.verticalFovRadians = 0.5f;
    const Result<Camera> given = chooseCamera(scene, choice, 1.0f);
    ASSERT_TRUE(given);
    EXPECT_EQ(eyeOf(*given), vec3(1, 2, 3));
    EXPECT_EQ(given->verticalFovRadians, 0.5f);
}
