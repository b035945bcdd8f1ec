// One mesh with a valid TEXCOORD_1 on nodes that need layouts of different density: some keep it, some are unwrapped.

#include "pipeline/pictures.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/scene/gltf.h"

#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>

namespace halflight::kept_layouts_test {
namespace {

constexpr ivec2 kSize(160, 120);
constexpr int kBounces = 3;

/// Adds a square that faces `normal`, with TEXCOORD_1 in a rectangle of the uv square.
void addSquare(MeshPart& part, vec3 center, vec3 u, vec3 v, vec2 uvFrom, vec2 uvTo)
{
    const auto first = uint32_t(part.positions.size());
    for (const vec2 at : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
        part.positions.push_back(center + at.x * u + at.y * v);
        part.normals.push_back(glm::normalize(glm::cross(u, v)));
        part.uv[1].push_back(glm::mix(uvFrom, uvTo, 0.5f * at + 0.5f));
    }
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + i);
}

void addObject(Scene& scene, int mesh, const mat4& worldFromObject)
{
    Object object;
    object.name = "object " + std::to_string(scene.objects.size());
    object.mesh = mesh;
    object.worldFromObject = worldFromObject;
    scene.objects.push_back(object);
}

/// A floor without TEXCOORD_1 and boxes that share a mesh with one.
Scene floorAndBoxes(float halfWidth)
{
    Scene scene;
    for (const vec3 color : {vec3(0.8f), vec3(0.9f, 0.7f, 0.5f)}) {
        Material material;
        material.baseColor = vec4(color, 1.0f);
        material.metallic = 0.0f;
        scene.materials.push_back(material);
    }
    MeshPart floor;
    addSquare(floor, vec3(0), vec3(0, 0, halfWidth), vec3(halfWidth, 0, 0), vec2(0), vec2(1));
    floor.uv[1].clear();
    floor.material = 0;
    MeshPart box;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-0.5f, 0.5f}) {
            vec3 n(0), u(0), v(0);
            n[axis] = side;
            u[(axis + 1) % 3] = 0.5f;
            v[(axis + 2) % 3] = side;
            const vec2 cell(float(axis) / 3.0f, side < 0.0f ? 0.0f : 0.5f);
            addSquare(box, n, u, v, cell + vec2(0.02f), cell + vec2(1.0f / 3.0f, 0.5f) - vec2(0.02f));
        }
    }
    box.material = 1;
    for (MeshPart* part : {&floor, &box}) {
        part->sourcePrimitive = 0;
        scene.meshes.push_back({"", {*part}, int(scene.meshes.size())});
    }
    addObject(scene, 0, mat4(1.0f));
    Light sun;
    sun.name = "sun";
    sun.type = LightType::Directional;
    sun.intensity = 3.0f;
    sun.worldFromLight = glm::inverse(glm::lookAt(vec3(3, 5, 2), vec3(0), vec3(0, 1, 0)));
    scene.lights.push_back(sun);
    scene.sky = {vec3(0.3f, 0.4f, 0.5f), vec3(0.4f), vec3(0.2f)};
    Camera camera;
    camera.worldFromCamera =
        glm::inverse(glm::lookAt(vec3(0, 1.2f, 1.6f) * halfWidth, vec3(0, 0.3f, 0), vec3(0, 1, 0)));
    camera.verticalFovRadians = 0.9f;
    scene.cameras.push_back(camera);
    return scene;
}

Scene boxesOfSeveralScales()
{
    Scene scene = floorAndBoxes(4.0f);
    const vec3 scales[] = {vec3(1), vec3(-1, 1, 1), vec3(1, 2, -1), vec3(0.5f)};
    for (int i = 0; i < 4; ++i) {
        const vec3 at(-3.0f + 2.0f * float(i), 0.5f * scales[i].y, 0.0f);
        addObject(scene, 1, glm::scale(glm::translate(mat4(1.0f), at), scales[i]));
    }
    return scene;
}

Scene boxesOfSeveralLightmapScales()
{
    Scene scene = floorAndBoxes(5.0f);
    const float scales[] = {1.0f, 0.3f, 0.1f};
    for (int i = 0; i < 3; ++i) {
        addObject(scene, 1, glm::translate(mat4(1.0f), vec3(-3.0f + 3.0f * float(i), 0.5f, 0.0f)));
        scene.objects.back().lightmapScale = scales[i];
    }
    return scene;
}

/// The picture is the reference's, and as near to it as without any kept layout.
void expectRightPicture(Scene scene)
{
    for (Material& material : scene.materials) material.specular = 0.0f; // diffuse: what the reference traces
    const Camera camera = scene.cameras.at(0);
    auto reference = renderReference(scene, camera, kSize, {96, kBounces});
    ASSERT_TRUE(reference) << reference.error().text();
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 512;
    settings.samples = 32;
    settings.bounces = kBounces;
    double errors[2];
    for (const UvMode mode : {UvMode::Auto, UvMode::Unwrap}) {
        settings.uvMode = mode;
        const auto result = bake(scene, settings, embreeIntegrators());
        ASSERT_TRUE(result) << result.error().text();
        int kept = 0;
        for (const MeshUnwrapReport& mesh : result->report.meshes) kept += mesh.kept;
        EXPECT_EQ(kept > 0, mode == UvMode::Auto);
        EXPECT_LT(kept, int(result->report.meshes.size()) - 1); // the floor has none, and one box more loses its own
        errors[int(mode == UvMode::Unwrap)] =
            meanRelativeError(drawPicture(result->baked, camera, RunMode::Shadowmask, kSize), *reference);
    }
    std::printf("mean relative luminance error: %.4f kept where possible, %.4f unwrapped\n", errors[0], errors[1]);
    EXPECT_LT(errors[0], 0.04);
    EXPECT_LT(errors[0], errors[1] + 0.01);
}

TEST(KeptAndNewLayoutsOfOneMesh, GiveTheReferencesPictureAtSeveralScales)
{
    expectRightPicture(boxesOfSeveralScales());
}

TEST(KeptAndNewLayoutsOfOneMesh, GiveTheReferencesPictureAtSeveralLightmapScales)
{
    expectRightPicture(boxesOfSeveralLightmapScales());
}

class SharedKeptLayouts : public testing::TestWithParam<const char*> {};

TEST_P(SharedKeptLayouts, GiveTheReferencesPicture)
{
    const auto path = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "cases/kept-uv1-shared-mesh" / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared cases beside this checkout";
    Result<Scene> scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    expectRightPicture(std::move(*scene));
}

INSTANTIATE_TEST_SUITE_P(Cases, SharedKeptLayouts, testing::Values("sharedkept.glb", "keptextras.glb"),
                         [](const auto& info) { return std::string(info.index == 0 ? "scales" : "lightmap_scales"); });

} // namespace
} // namespace halflight::kept_layouts_test
