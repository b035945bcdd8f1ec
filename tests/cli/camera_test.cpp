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

Scene doubleSided(Scene scene)
{
    scene.materials.resize(1);
    scene.materials[0].doubleSided = true;
    for (Mesh& mesh : scene.meshes) {
        for (MeshPart& part : mesh.parts) part.material = 0;
    }
    return scene;
}

void add(Scene& scene, Mesh mesh, vec3 position)
{
    Object object;
    object.mesh = int(scene.meshes.size());
    object.worldFromObject[3] = vec4(position, 1.0f);
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
}

bool eyeInside(const Scene& scene, float aspect = 1.5f)
{
    const Bounds bounds = scene.bounds();
    const vec3 eye = eyeOf(automaticCamera(scene, aspect));
    return glm::all(glm::greaterThan(eye, bounds.min)) && glm::all(glm::lessThan(eye, bounds.max));
}

void expectWholeFromOutside(const Scene& scene, const char* what)
{
    const Bounds bounds = scene.bounds();
    const Camera camera = automaticCamera(scene, 1.5f);
    float reach = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const vec3 corner(i & 1 ? bounds.max.x : bounds.min.x, i & 2 ? bounds.max.y : bounds.min.y,
                          i & 4 ? bounds.max.z : bounds.min.z);
        const float depth = glm::dot(corner - eyeOf(camera), forwardOf(camera));
        EXPECT_GT(depth, camera.nearMeters) << what;
        EXPECT_LT(depth, camera.farMeters) << what;
        const vec2 p = project(camera, corner, 1.5f);
        reach = std::max({reach, std::abs(p.x), std::abs(p.y)});
    }
    EXPECT_LE(reach, 1.0f) << what;
    EXPECT_GT(reach, 0.8f) << what;
}

// Case default-view: a closed double-sided box is an object, whatever its size and place.
TEST(CommandLineCamera, ClosedObjectsOfAllSizesAreSeenFromOutside)
{
    for (const float size : {1.0e-6f, 2.0e-4f, 0.05f, 1.0f, 3.0e3f, 4.0e6f}) {
        for (const bool inward : {false, true}) {
            Scene scene = doubleSided(sceneWith(box(size * vec3(1, 0.7f, 1.2f), inward, false)));
            scene.objects[0].worldFromObject[3] = vec4(size * vec3(3, -5, 2), 1.0f);
            expectWholeFromOutside(scene, ("double-sided, " + std::to_string(size)).c_str());
        }
        expectWholeFromOutside(sceneWith(box(size * vec3(1, 0.7f, 1.2f), false, false)), "one-sided");
    }
}

TEST(CommandLineCamera, ThickDoubleSidedShellIsSeenFromOutside)
{
    Scene shell = sceneWith(box(vec3(1), false, false));
    add(shell, box(vec3(0.9f), true, false), vec3(0));
    expectWholeFromOutside(doubleSided(shell), "a shell with two walls");
}

// Blender writes most rooms with double-sided walls: what stands in them, or a lamp, tells them from boxes.
TEST(CommandLineCamera, DoubleSidedRoomsWithThingsInThemAreSeenFromInside)
{
    const vec3 half(4, 1.5f, 3);
    const Scene empty = doubleSided(sceneWith(box(half, false, false)));
    EXPECT_FALSE(eyeInside(empty));
    Scene furnished = empty;
    add(furnished, box(vec3(1.2f, 0.5f, 0.8f), false, false), vec3(0.8f, -1.0f, 0.0f));
    add(furnished, box(vec3(0.4f, 1.4f, 1.5f), false, false), vec3(-3.5f, 0.0f, 0.0f));
    EXPECT_TRUE(eyeInside(doubleSided(furnished)));
    Scene lamp = empty;
    lamp.lights.resize(1);
    lamp.lights[0].type = LightType::Point;
    lamp.lights[0].worldFromLight[3] = vec4(0, 1.4f, 0, 1);
    EXPECT_TRUE(eyeInside(lamp));
    lamp.lights[0].worldFromLight[3] = vec4(0, 2.4f, 0, 1); // above the box
    EXPECT_FALSE(eyeInside(lamp));
}

TEST(CommandLineCamera, OneSidedRoomWithThingsInItIsSeenFromInside)
{
    Scene room = sceneWith(box(vec3(4, 1.5f, 3), true, false));
    add(room, box(vec3(0.5f), false, false), vec3(1.0f, -1.0f, 0.5f));
    EXPECT_TRUE(eyeInside(room));
    // The same from walls without a back, of another size.
    for (Object& object : room.objects) object.worldFromObject = glm::mat4(mat3(1.0e-3f)) * object.worldFromObject;
    EXPECT_TRUE(eyeInside(room));
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
