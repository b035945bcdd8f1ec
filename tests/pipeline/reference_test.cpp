// From scene to picture, against the path-traced reference of the same camera: what is baked, what is realtime and how
// they mix adds up to the light there is (spec S6–S8, S10, S12, S13, S21).

#include "pipeline/pictures.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>

namespace halflight::reference_test {
namespace {

constexpr ivec2 kSize(160, 120);
constexpr int kBounces = 3;

int addMaterial(Scene& scene, vec3 color, vec3 emission = vec3(0.0f))
{
    Material material;
    material.baseColor = vec4(color, 1.0f);
    material.metallic = 0.0f;
    material.specular = 0.0f; // diffuse: what the reference traces
    material.emissiveNits = emission;
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

/// A closed box, faces outward; one mesh.
void addBox(Scene& scene, vec3 lower, vec3 upper, int material)
{
    MeshPart part;
    const vec3 s = upper - lower;
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            vec3 u(0.0f);
            vec3 v(0.0f);
            u[(axis + 1) % 3] = s[(axis + 1) % 3];
            v[(axis + 2) % 3] = s[(axis + 2) % 3];
            vec3 origin = lower;
            if (side == 1) origin[axis] = upper[axis];
            if (side == 0) std::swap(u, v);
            const auto base = uint32_t(part.positions.size());
            for (const vec3 p : {origin, origin + u, origin + u + v, origin + v}) {
                part.positions.push_back(p);
                part.normals.push_back(glm::normalize(glm::cross(u, v)));
            }
            for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(base + i);
        }
    }
    part.material = material;
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    Object object;
    object.name = "box " + std::to_string(scene.objects.size());
    object.mesh = int(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
}

mat4 lookAt(vec3 eye, vec3 target)
{
    return glm::inverse(glm::lookAt(eye, target, vec3(0, 1, 0)));
}

Light makeLight(const char* name, LightType type, vec3 position, vec3 target, float intensity, vec3 color)
{
    Light light;
    light.name = name;
    light.type = type;
    light.worldFromLight = lookAt(position, target + vec3(1e-3f, 0, 0));
    light.intensity = intensity;
    light.color = color;
    return light;
}

/// A room open to one side, with furniture, a lamp panel, sky and one light of each kind.
Scene makeRoom()
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.75f));
    const int red = addMaterial(scene, vec3(0.7f, 0.15f, 0.1f));
    const int blue = addMaterial(scene, vec3(0.15f, 0.25f, 0.7f));
    const int panel = addMaterial(scene, vec3(0.2f), vec3(6.0f));
    addBox(scene, vec3(-3, -0.2f, -3), vec3(3, 0, 3), white);
    addBox(scene, vec3(-3.2f, -0.2f, -3), vec3(-3, 3, 3), red);
    addBox(scene, vec3(-3.2f, -0.2f, -3.2f), vec3(3.2f, 3, -3), white);
    addBox(scene, vec3(3, -0.2f, -3), vec3(3.2f, 1.6f, 3), blue);
    addBox(scene, vec3(-3.2f, 3, -3.2f), vec3(1, 3.2f, 1), white);
    addBox(scene, vec3(-1.6f, 0, -1.8f), vec3(-0.4f, 1.6f, -0.9f), white);
    addBox(scene, vec3(0.6f, 0, -0.4f), vec3(1.5f, 0.8f, 0.5f), red);
    addBox(scene, vec3(-2.4f, 2.4f, -2.9f), vec3(-0.6f, 2.7f, -2.85f), panel);
    scene.sky = {vec3(0.3f, 0.5f, 0.9f), vec3(0.7f, 0.75f, 0.8f), vec3(0.2f)};
    scene.lights = {
        makeLight("sun", LightType::Directional, vec3(4, 6, 3), vec3(0), 5.0f, vec3(1, 0.95f, 0.85f)),
        makeLight("lamp", LightType::Point, vec3(0.4f, 2.2f, -1.9f), vec3(0), 6.0f, vec3(1, 0.8f, 0.6f)),
        makeLight("spot", LightType::Spot, vec3(-2.2f, 2.6f, 1.5f), vec3(0.5f, 0, 0.5f), 20.0f, vec3(0.7f, 0.9f, 1))};
    scene.lights[2].innerConeRadians = 0.4f;
    scene.lights[2].outerConeRadians = 0.6f;
    Camera camera;
    camera.worldFromCamera = lookAt(vec3(1.8f, 2.0f, 4.6f), vec3(-0.4f, 0.9f, -1.0f));
    camera.verticalFovRadians = 0.9f;
    scene.cameras.push_back(camera);
    return scene;
}

BakedScene bakeRoom(const Scene& scene, MixedLightingMode mode, int mostMaskLayers = kMostMaskLayers)
{
    BakeSettings settings;
    settings.mode = mode;
    settings.mostMaskLayers = mostMaskLayers;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 512;
    settings.samples = 128;
    settings.bounces = kBounces;
    auto result = bake(scene, settings, embreeIntegrators());
    EXPECT_TRUE(result) << result.error().text();
    return std::move(result->baked);
}

class ReferencePicture : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        scene_ = new Scene(makeRoom());
        auto picture = renderReference(*scene_, scene_->cameras[0], kSize, {512, kBounces});
        ASSERT_TRUE(picture) << picture.error().text();
        reference_ = new ImageRgb32f(std::move(*picture));
    }
    static void TearDownTestSuite()
    {
        delete scene_;
        delete reference_;
    }

    static double error(const BakedScene& baked, RunMode mode)
    {
        return meanRelativeError(drawPicture(baked, scene_->cameras[0], mode, kSize), *reference_);
    }

    static Scene* scene_;
    static ImageRgb32f* reference_;
};
Scene* ReferencePicture::scene_ = nullptr;
ImageRgb32f* ReferencePicture::reference_ = nullptr;

TEST_F(ReferencePicture, ShadowmaskBakeS7S12S13)
{
    const BakedScene baked = bakeRoom(*scene_, MixedLightingMode::Shadowmask);
    for (const RunMode mode : {RunMode::BakedIndirect, RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        const double e = error(baked, mode);
        std::printf("mode %d: mean relative luminance error %.4f\n", int(mode), e);
        EXPECT_LT(e, 0.05) << "mode " << int(mode);
    }
}

TEST_F(ReferencePicture, SubtractiveBakeS21)
{
    const double e = error(bakeRoom(*scene_, MixedLightingMode::Subtractive), RunMode::Subtractive);
    std::printf("subtractive: mean relative luminance error %.4f\n", e);
    EXPECT_LT(e, 0.05);
}

/// Written to a file and read back, the picture is the same: nothing the renderer needs is lost on the way.
TEST_F(ReferencePicture, ThroughTheFileS5)
{
    const auto path =
        std::filesystem::temp_directory_path() / ("halflight_reference_" + std::to_string(::getpid()) + ".glb");
    ASSERT_TRUE(writeBakedScene(path, bakeRoom(*scene_, MixedLightingMode::Shadowmask)));
    auto read = readBakedScene(path);
    std::filesystem::remove(path);
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_LT(error(*read, RunMode::Shadowmask), 0.05);
}

/// Seven mixed lights that all overlap: those without a channel are baked, and the picture is still right (spec S10).
TEST_F(ReferencePicture, OverflowStaysRightS10)
{
    Scene scene = *scene_;
    for (int i = 0; i < 4; ++i) {
        scene.lights.push_back(makeLight(("extra " + std::to_string(i)).c_str(), LightType::Point,
                                         vec3(-2.0f + float(i), 1.2f + 0.3f * float(i), 1.0f), vec3(0), 1.5f, vec3(1)));
    }
    auto reference = renderReference(scene, scene.cameras[0], kSize, {512, kBounces});
    ASSERT_TRUE(reference);
    std::swap(*reference_, *reference);
    const BakedScene baked = bakeRoom(scene, MixedLightingMode::Shadowmask, 1);
    int fullyBaked = 0;
    for (const Light& light : baked.scene.lights) fullyBaked += light.baking.bakeType == LightMode::Baked ? 1 : 0;
    EXPECT_EQ(fullyBaked, 3);
    const double e = error(baked, RunMode::Shadowmask);
    std::swap(*reference_, *reference);
    std::printf("overflow: mean relative luminance error %.4f\n", e);
    EXPECT_LT(e, 0.05);
}

} // namespace
} // namespace halflight::reference_test
