// Mixed shadows in whole pictures, against the path-traced reference of the same scene: what subtraction takes away,
// what surfaces without shadows receive, and blended casters on both sides of the shadow distance.
#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

namespace halflight::mixed_picture_test {
namespace {

constexpr ivec2 kSize(160, 120);
constexpr int kBounces = 2;

int addMaterial(Scene& scene, vec4 color)
{
    Material material;
    material.baseColor = color;
    material.metallic = 0.0f;
    material.specular = 0.0f; // diffuse: what the reference traces
    material.doubleSided = true;
    if (color.w < 1.0f) material.alphaMode = Material::AlphaMode::Blend;
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

/// A rectangle that faces up.
Object& addSlab(Scene& scene, vec3 center, vec2 size, int material, bool isStatic)
{
    MeshPart part;
    for (const vec2 corner : {vec2(-1, 1), vec2(1, 1), vec2(1, -1), vec2(-1, -1)}) {
        part.positions.push_back(center + 0.5f * vec3(corner.x * size.x, 0, corner.y * size.y));
        part.normals.emplace_back(0, 1, 0);
    }
    part.indices = {0, 1, 2, 0, 2, 3};
    part.material = material;
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    Object object;
    object.name = "slab " + std::to_string(scene.objects.size());
    object.mesh = int(scene.meshes.size());
    object.isStatic = isStatic;
    scene.meshes.push_back(std::move(mesh));
    scene.objects.push_back(object);
    return scene.objects.back();
}

Light sunAlong(vec3 direction, float lux)
{
    Light light;
    light.name = "sun";
    light.type = LightType::Directional;
    light.worldFromLight = glm::inverse(glm::lookAt(vec3(0), direction, vec3(0, 0, 1)));
    light.intensity = lux;
    return light;
}

/// A floor under a sky and the sun from above. A high static slab throws a shadow on x < 0; a dynamic one on z > 0,
/// small and high enough that the sky does not miss it.
Scene makeCrossing()
{
    Scene scene;
    const int white = addMaterial(scene, vec4(0.6f, 0.5f, 0.4f, 1.0f));
    addSlab(scene, vec3(0), vec2(16, 16), white, true).name = "floor";
    addSlab(scene, vec3(-4, 9, 0), vec2(8, 16), white, true);
    addSlab(scene, vec3(0, 20, 1), vec2(5, 2), white, false);
    scene.lights = {sunAlong(vec3(1e-3f, -1, 0), 6.0f)};
    scene.sky = {vec3(0.15f, 0.2f, 0.3f), vec3(0.15f, 0.2f, 0.3f), vec3(0.1f)};
    Camera camera;
    camera.worldFromCamera = glm::inverse(glm::lookAt(vec3(0, 3, 7), vec3(0, 0, 0.5f), vec3(0, 1, 0)));
    camera.verticalFovRadians = 0.8f;
    scene.cameras.push_back(camera);
    return scene;
}

/// Mean radiance around the pixel that shows a point.
template<typename Picture> vec3 at(const Picture& picture, const Camera& camera, vec3 point)
{
    const mat4 viewFromWorld = glm::inverse(camera.worldFromCamera);
    const vec3 v(viewFromWorld * vec4(point, 1.0f));
    const float scale = 0.5f * float(kSize.y) / std::tan(0.5f * camera.verticalFovRadians);
    const ivec2 pixel(int(0.5f * float(kSize.x) - scale * v.x / v.z), int(0.5f * float(kSize.y) + scale * v.y / v.z));
    vec3 sum(0.0f);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) sum += vec3(picture(pixel.x + x, pixel.y + y)) / 9.0f;
    return sum;
}

class MixedPicture : public testing::Test {
protected:
    static BakeResult bakeScene(const Scene& scene, MixedLightingMode mode,
                                const std::function<void(BakeSettings&)>& change = {})
    {
        BakeSettings settings;
        settings.mode = mode;
        settings.quality = Quality::Preview;
        settings.lightmapSize = 256;
        settings.samples = 128;
        settings.bounces = kBounces;
        if (change) change(settings);
        auto result = bake(scene, settings, embreeIntegrators());
        EXPECT_TRUE(result) << result.error().text();
        return std::move(*result);
    }
    static RenderedFrame draw(const BakedScene& baked, RenderSettings settings)
    {
        auto renderer = Renderer::create({.validation = true});
        EXPECT_TRUE(renderer) << renderer.error().text();
        EXPECT_TRUE((*renderer)->load(baked));
        settings.size = kSize;
        settings.shadows.directionalMapSize = 1024;
        auto frame = (*renderer)->render(baked.scene.cameras[0], settings);
        EXPECT_TRUE(frame) << frame.error().text();
        for (const std::string& message : (*renderer)->validationMessages()) ADD_FAILURE() << message;
        return std::move(*frame);
    }
    static ImageRgb32f reference(const Scene& scene)
    {
        auto picture = renderReference(scene, scene.cameras[0], kSize, {256, kBounces});
        EXPECT_TRUE(picture) << picture.error().text();
        return std::move(*picture);
    }
};

const vec3 kLit(2, 0, -1);
const vec3 kInStatic(-2, 0, -1);
const vec3 kInDynamic(2, 0, 1);
const vec3 kInBoth(-2, 0, 1);

// S22. With the main light's mask the picture is the truth also where a dynamic shadow lies within a baked one.
TEST_F(MixedPicture, SubtractiveWithMaskIsExactS22)
{
    const Scene scene = makeCrossing();
    const BakeResult result = bakeScene(scene, MixedLightingMode::Subtractive);
    ASSERT_EQ(result.baked.shadowmasks.size(), result.baked.lightmaps.size());
    ASSERT_TRUE(result.report.mainLight);
    EXPECT_TRUE(result.report.mainLight->mask);
    EXPECT_TRUE(result.report.mainLight->colorByBake);
    const ImageRgb32f truth = reference(scene);
    const Camera& camera = scene.cameras[0];
    for (const RenderPath path : {RenderPath::Forward, RenderPath::Deferred}) {
        RenderSettings settings;
        settings.mode = RunMode::Subtractive;
        settings.path = path;
        const RenderedFrame frame = draw(result.baked, settings);
        for (const vec3 place : {kLit, kInStatic, kInDynamic, kInBoth}) {
            const vec3 expected = at(truth, camera, place);
            const vec3 found = at(frame.radiance, camera, place);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], expected[c], 0.04f * expected[c]) << place.x << ' ' << place.z << ' ' << c;
        }
    }
}

// S23. Without it the guess takes too much there; the colour that the bake chose is about the light there is.
TEST_F(MixedPicture, SubtractiveDefaultColorIsTheLightOfTheShadeS23)
{
    const Scene scene = makeCrossing();
    const auto withoutMask = [](BakeSettings& settings) { settings.subtractiveMask = false; };
    const BakeResult result = bakeScene(scene, MixedLightingMode::Subtractive, withoutMask);
    EXPECT_TRUE(result.baked.shadowmasks.empty());
    const ImageRgb32f truth = reference(scene);
    const Camera& camera = scene.cameras[0];
    RenderSettings settings;
    settings.mode = RunMode::Subtractive;
    const RenderedFrame frame = draw(result.baked, settings);
    for (const vec3 place : {kLit, kInStatic, kInDynamic, kInBoth}) {
        const vec3 expected = at(truth, camera, place);
        const vec3 found = at(frame.radiance, camera, place);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], expected[c], 0.25f * expected[c]) << place.x << ' ' << place.z << ' ' << c;
    }
    // Black is for those who ask for it, in the file or at run time.
    settings.subtractiveShadowColor = vec3(0.0f);
    EXPECT_EQ(at(draw(result.baked, settings).radiance, camera, kInBoth), vec3(0.0f));
    Scene black = scene;
    black.subtractiveShadowColor = vec3(0.0f);
    const BakeResult asked = bakeScene(black, MixedLightingMode::Subtractive, withoutMask);
    EXPECT_FALSE(asked.report.mainLight->colorByBake);
    EXPECT_EQ(subtractiveShadowColor(asked.baked), vec3(0.0f));
}

// S30. An object that receives no shadows has none: in a subtractive or baked lightmap, in the mask, at run time and in
// the reference.
TEST_F(MixedPicture, ObjectsWithoutShadowsS30)
{
    for (const bool byMaterial : {false, true}) {
        Scene scene = makeCrossing();
        if (byMaterial) {
            scene.materials.push_back(scene.materials[0]);
            scene.materials.back().receiveShadows = false;
            scene.meshes[0].parts[0].material = int(scene.materials.size()) - 1;
        } else {
            scene.objects[0].receiveShadows = false;
        }
        const ImageRgb32f truth = reference(scene);
        const Camera& camera = scene.cameras[0];
        const auto expectTruth = [&](const BakedScene& baked, RunMode mode, const char* what) {
            RenderSettings settings;
            settings.mode = mode;
            const RenderedFrame frame = draw(baked, settings);
            for (const vec3 place : {kLit, kInStatic, kInDynamic, kInBoth}) {
                const float expected = luminance(at(truth, camera, place));
                EXPECT_GT(expected, 0.8f) << "the sun's light is there";
                EXPECT_NEAR(luminance(at(frame.radiance, camera, place)), expected, 0.04f * expected)
                    << what << ' ' << place.x << ' ' << place.z;
            }
        };
        expectTruth(bakeScene(scene, MixedLightingMode::Subtractive).baked, RunMode::Subtractive, "subtractive");
        const BakedScene masked = bakeScene(scene, MixedLightingMode::Shadowmask).baked;
        expectTruth(masked, RunMode::Shadowmask, "shadowmask");
        expectTruth(masked, RunMode::DistanceShadowmask, "distance shadowmask");
        Scene fully = scene;
        fully.lights[0].mode = LightMode::Baked;
        expectTruth(bakeScene(fully, MixedLightingMode::Shadowmask).baked, RunMode::Shadowmask, "baked light");
    }
}

// S13. The shadow of a blended static surface is the same from the map and from the mask.
TEST_F(MixedPicture, BlendedShadowsDoNotPopS13)
{
    for (const float alpha : {0.25f, 0.5f, 0.75f}) {
        Scene scene = makeCrossing();
        scene.objects.resize(2);
        scene.meshes[1].parts[0].material = addMaterial(scene, vec4(0.5f, 0.5f, 0.5f, alpha));
        scene.sky = {};
        const BakedScene baked =
            bakeScene(scene, MixedLightingMode::Shadowmask, [](BakeSettings& s) { s.bounces = 0; }).baked;
        // Of many pixels in the shade, the mean.
        const auto shade = [&](float distance) {
            RenderSettings settings;
            settings.mode = RunMode::DistanceShadowmask;
            settings.shadows.distanceMeters = distance;
            const RenderedFrame frame = draw(baked, settings);
            float sum = 0.0f;
            int count = 0;
            for (float x = -2.2f; x < -0.6f; x += 0.2f)
                for (float z = -1.0f; z < 2.0f; z += 0.2f, ++count)
                    sum += luminance(at(frame.radiance, scene.cameras[0], vec3(x, 0, z)));
            return sum / float(count);
        };
        const float unshadowed = 6.0f * luminance(vec3(0.6f, 0.5f, 0.4f)) / kPi;
        EXPECT_NEAR(shade(40.0f) / unshadowed, 1.0f - alpha, 0.02f) << "realtime";
        EXPECT_NEAR(shade(2.0f) / unshadowed, 1.0f - alpha, 0.02f) << "baked";
    }
}

} // namespace
} // namespace halflight::mixed_picture_test
