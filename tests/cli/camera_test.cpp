#include "camera.h"

#include <gtest/gtest.h>

using namespace halflight;
using namespace halflight::cli;

namespace {

// A box from -half to half; `inward` turns its faces to the inside, `open` leaves the +Z face out.
Mesh box(vec3 half, bool inward, bool open)
{
    MeshPart part;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            if (open && axis == 2 && side > 0.0f) continue;
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            const auto first = uint32_t(part.positions.size());
            for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
                vec3 p;
                p[axis] = side * half[axis];
                p[u] = corner.x * half[u];
                p[v] = corner.y * half[v];
                part.positions.push_back(p);
            }
            const bool flip = (side < 0.0f) != inward;
            const uvec3 order = flip ? uvec3(2, 1, 0) : uvec3(0, 1, 2);
            const uvec3 rest = flip ? uvec3(3, 2, 0) : uvec3(0, 2, 3);
            for (int i = 0; i < 3; ++i) part.indices.push_back(first + order[i]);
            for (int i = 0; i < 3; ++i) part.indices.push_back(first + rest[i]);
        }
    }
    Mesh mesh;
    mesh.parts = {part};
    return mesh;
}

Scene sceneWith(Mesh mesh, const mat4& worldFromObject = mat4(1.0f))
{
    Scene scene;
    scene.meshes.push_back(std::move(mesh));
    Object object;
    object.mesh = 0;
    object.worldFromObject = worldFromObject;
    scene.objects.push_back(object);
    return scene;
}

vec3 eyeOf(const Camera& camera)
{
    return vec3(camera.worldFromCamera[3]);
}
vec3 forwardOf(const Camera& camera)
{
    return -vec3(camera.worldFromCamera[2]);
}

// Picture coordinates in [-1, 1] when the point is in view.
vec2 project(const Camera& camera, vec3 point, float aspect)
{
    const vec3 p = vec3(glm::inverse(camera.worldFromCamera) * vec4(point, 1.0f));
    const float tangent = std::tan(0.5f * camera.verticalFovRadians);
    return vec2(p.x / (tangent * aspect), p.y / tangent) / -p.z;
}

} // namespace

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

TEST(CommandLineCamera, ModelSeenFromOutsideFillsThePictureWithoutLeavingIt)
{
    for (const vec3 half : {vec3(1, 1, 1), vec3(40, 2, 10), vec3(0.01f, 3, 0.01f)}) {
        const float aspect = 16.0f / 9.0f;
        const Camera camera = automaticCamera(sceneWith(box(half, false, false)), aspect);
        float reach = 0.0f;
        for (int i = 0; i < 8; ++i) {
            const vec3 corner = half * vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
            const vec2 p = project(camera, corner, aspect);
            reach = std::max({reach, std::abs(p.x), std::abs(p.y)});
        }
        EXPECT_LE(reach, 1.0f);
        EXPECT_GT(reach, 0.8f);
        EXPECT_GT(camera.farMeters, glm::distance(eyeOf(camera), vec3(0)) + glm::length(half));
    }
}

TEST(CommandLineCamera, RoomIsSeenFromInside)
{
    const vec3 half(4, 1.5f, 3);
    const Camera camera = automaticCamera(sceneWith(box(half, true, false)), 1.5f);
    EXPECT_TRUE(glm::all(glm::lessThan(glm::abs(eyeOf(camera)), half)));
    EXPECT_GT(glm::dot(forwardOf(camera), glm::normalize(-eyeOf(camera))), 0.8f);
}

// The same room with its object mirrored: glTF keeps the front a front.
TEST(CommandLineCamera, MirroredRoomIsSeenFromInside)
{
    const vec3 half(4, 1.5f, 3);
    mat4 mirror(1.0f);
    mirror[0][0] = -1.0f;
    const Camera camera = automaticCamera(sceneWith(box(half, true, false), mirror), 1.5f);
    EXPECT_TRUE(glm::all(glm::lessThan(glm::abs(eyeOf(camera)), half)));
}

TEST(CommandLineCamera, EmptyAndFlatScenesGiveFiniteCameras)
{
    Scene flat = sceneWith(box(vec3(2, 0, 2), false, false));
    for (const Scene& scene : {Scene(), flat}) {
        const Camera camera = automaticCamera(scene, 1.0f);
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) EXPECT_TRUE(std::isfinite(camera.worldFromCamera[i][j]));
        }
    }
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
