#include "camera.h"
#include "scene_caster.h"
#include "view_scenes.h"

#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

using namespace halflight;
using namespace halflight::cli;

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

namespace {

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

} // namespace

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

namespace {

// What a view shows of a scene, by brute force over rays and vertices.
struct Shown {
    float fronts = 0.0f; // share of the pixels with something that show fronts
    float near = 0.0f;   // share of pixels with something within a twentieth of the diagonal
    float reach = 0.0f;  // of vertices, from the picture's middle; 1 = its edge
    bool isInside = false;
};

Shown shownBy(const Scene& scene, const Camera& camera, float aspect)
{
    constexpr ivec2 kGrid(32, 18);
    const Bounds box = scene.bounds();
    const SceneCaster caster(scene);
    const float tangent = std::tan(0.5f * camera.verticalFovRadians);
    float met = 0.0f;
    Shown shown;
    for (int i = 0; i < kGrid.x * kGrid.y; ++i) {
        const vec2 p = 2.0f * (vec2(i % kGrid.x, i / kGrid.x) + 0.5f) / vec2(kGrid) - 1.0f;
        const vec3 d = glm::normalize(vec3(p.x * tangent * aspect, p.y * tangent, -1.0f));
        const SceneHit hit = caster.cast(eyeOf(camera), mat3(camera.worldFromCamera) * d);
        if (!hit) continue;
        met += 1.0f;
        shown.fronts += hit.front ? 1.0f : 0.0f;
        shown.near += hit.distance < 0.05f * glm::length(box.size()) ? 1.0f / float(kGrid.x * kGrid.y) : 0.0f;
    }
    shown.fronts /= std::max(met, 1.0f);
    for (const Object& object : scene.objects) {
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            for (const uint32_t v : part.indices) {
                const vec2 p = project(camera, vec3(object.worldFromObject * vec4(part.positions[v], 1.0f)), aspect);
                shown.reach = std::max({shown.reach, std::abs(p.x), std::abs(p.y)});
            }
        }
    }
    const vec3 eye = eyeOf(camera);
    shown.isInside = glm::all(glm::greaterThan(eye, box.min)) && glm::all(glm::lessThan(eye, box.max));
    return shown;
}

struct Default {
    const char* file;
    bool inside;
};

class DefaultView : public testing::TestWithParam<Default> {};
INSTANTIATE_TEST_SUITE_P(
    , DefaultView,
    testing::Values(Default{"cases/view-inside/table.glb", false}, Default{"cases/default-view/cube.gltf", false},
                    Default{"scenes/cornell_box_emissive.glb", false},
                    Default{"scenes/dream_apartment_no_uv.glb", false},
                    Default{"scenes/japanese_bridge_garden.glb", false},
                    Default{"scenes/mixed_lighting_chair.glb", false}, Default{"scenes/negative_scale_zoo.glb", false},
                    Default{"scenes/no_indices_building.glb", false}, Default{"scenes/primitive_zoo.glb", false},
                    Default{"scenes/alpha_blend_mode_test.glb", false},
                    Default{"scenes/many_cubes_shared_mesh.glb", false}, Default{"scenes/grey_white_room.glb", true}),
    [](const auto& info) { return std::filesystem::path(info.param.file).stem().string(); });

// Case view-inside, and scenes without a camera: fronts, no wall at arm's length, the picture filled.
TEST_P(DefaultView, ShowsTheWholeFromOutside)
{
    const std::filesystem::path path = std::filesystem::path(HALFLIGHT_SHARED_DIR) / GetParam().file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared files beside this checkout";
    ReadOptions options;
    options.decodeTextures = false;
    const Result<Scene> scene = readScene(path, options);
    ASSERT_TRUE(scene) << scene.error().text();
    for (const float aspect : {16.0f / 9.0f, 0.7f}) {
        const Shown shown = shownBy(*scene, automaticCamera(*scene, aspect), aspect);
        EXPECT_EQ(shown.isInside, GetParam().inside);
        EXPECT_GT(shown.fronts, 0.8f);
        EXPECT_LT(shown.near, 0.1f);
        if (GetParam().inside) continue;
        EXPECT_LE(shown.reach, 1.0f);
        EXPECT_GE(shown.reach, 0.9f);
    }
}

} // namespace

// Things around the middle are no walls: barrels on a table, seen from outside whatever their faces.
TEST(CommandLineCamera, ThingsAroundTheMiddleAreSeenFromOutside)
{
    Scene table = sceneWith(box(vec3(1.0f, 0.03f, 0.7f), false, false));
    for (int i = 0; i < 10; ++i) {
        const float angle = 0.2f * float(i) * kPi;
        add(table, box(vec3(0.14f, 0.4f, 0.14f), false, false),
            vec3(0.7f * std::cos(angle), 0.45f, 0.5f * std::sin(angle)));
    }
    EXPECT_FALSE(eyeInside(table));
    EXPECT_FALSE(eyeInside(doubleSided(table)));
    const Shown shown = shownBy(table, automaticCamera(table, 1.5f), 1.5f);
    EXPECT_EQ(shown.fronts, 1.0f);
    EXPECT_GE(shown.reach, 0.9f);
}

// A box with thick walls and nothing in it is a thing; a room with outer walls too, and furniture, is a room.
TEST(CommandLineCamera, ClosedShellsWithNothingInThemAreSeenFromOutside)
{
    Scene shell = sceneWith(box(vec3(2, 1.5f, 2), false, false));
    add(shell, box(vec3(1.9f, 1.4f, 1.9f), true, false), vec3(0));
    EXPECT_FALSE(eyeInside(shell));
    add(shell, box(vec3(0.5f, 0.7f, 0.5f), false, false), vec3(0.9f, -0.7f, 0.8f));
    add(shell, box(vec3(0.3f, 1.2f, 0.8f), false, false), vec3(-1.5f, -0.2f, 0.2f));
    EXPECT_TRUE(eyeInside(shell));
}

// Long diagonals reach to the edges as boxes do: it is the vertices that count, not their bounds.
TEST(CommandLineCamera, OutlinesFillThePicture)
{
    Scene rod = sceneWith(box(vec3(5, 0.05f, 0.05f), false, false),
                          glm::mat4(mat3(vec3(0.6f, 0.6f, 0.53f), vec3(-0.7f, 0.7f, 0), vec3(-0.37f, -0.37f, 0.85f))));
    Mesh ball;
    MeshPart& part = ball.parts.emplace_back();
    for (int i = 0; i < 3 * 2000; ++i) { // loose triangles on a sphere
        const float z = 1.0f - 2.0f * (float(i / 3) + 0.5f) / 2000.0f;
        const float phi = 2.39996323f * float(i / 3) + 0.02f * float(i % 3);
        const float r = std::sqrt(1.0f - z * z);
        part.positions.emplace_back(r * std::cos(phi), z + 0.002f * float(i % 2), r * std::sin(phi));
        part.indices.push_back(uint32_t(i));
    }
    Scene balls = doubleSided(sceneWith(ball));
    for (int i = 1; i < 300; ++i) { // so many that only their outlines are looked at
        balls.objects.push_back(balls.objects[0]);
        balls.objects.back().worldFromObject[3] = vec4(float(i % 20), 0.3f * float(i % 7), float(i / 20), 1.0f);
    }
    for (const Scene& scene : {rod, balls}) {
        for (const float aspect : {1.8f, 0.6f}) {
            const Camera camera = automaticCamera(scene, aspect);
            vec2 low(kInfinity);
            vec2 high(-kInfinity);
            for (const Object& object : scene.objects) {
                for (const vec3& v : scene.meshes[0].parts[0].positions) {
                    const vec2 p = project(camera, vec3(object.worldFromObject * vec4(v, 1.0f)), aspect);
                    low = glm::min(low, p);
                    high = glm::max(high, p);
                }
            }
            // Both edges of one axis, at 0.95 but for the outline's 1 %.
            const vec2 size = high - low;
            const int axis = size.x > size.y ? 0 : 1;
            EXPECT_NEAR(low[axis], -0.95f, 0.02f);
            EXPECT_NEAR(high[axis], 0.95f, 0.02f);
            EXPECT_LE(size[1 - axis], 1.94f);
        }
    }
}
