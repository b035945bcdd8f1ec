// S33. A mixed lamp in a light group, baked red: white, red and off, against the path-traced reference of the changed
// lamp.
#include "bake/test_scene.h"
#include "pipeline/pictures.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace halflight::test::lamp_states_test {
namespace {

constexpr ivec2 kSize(128, 96);
constexpr float kCandela = 20.0f;
const vec3 kRed(0.9f, 0.2f, 0.1f);

/// A closed room with two coloured walls, a box that throws a shadow, and the lamp alone.
Scene room(vec3 color)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.7f));
    addBox(scene, vec3(-2, 0, -2), vec3(2, 2.5f, 2), white, true);
    const int yellow = addMaterial(scene, vec3(0.7f, 0.6f, 0.2f));
    const int blue = addMaterial(scene, vec3(0.2f, 0.3f, 0.7f));
    for (Material& material : scene.materials) material.specular = 0.0f;
    scene.meshes[2].parts[0].material = yellow;
    scene.meshes[3].parts[0].material = blue;
    addBox(scene, vec3(-1.1f, 0, -1.2f), vec3(-0.2f, 1.1f, -0.4f), white, false);
    Light lamp = makeLight(LightType::Point, vec3(0.5f, 1.9f, 0.2f), vec3(0, -1, 0), kCandela, LightMode::Mixed);
    lamp.name = lamp.group = "lamp";
    lamp.color = color;
    scene.lights.push_back(lamp);
    Camera camera;
    camera.worldFromCamera = glm::inverse(glm::lookAt(vec3(1.6f, 1.6f, 1.8f), vec3(-0.5f, 0.7f, -0.6f), vec3(0, 1, 0)));
    camera.verticalFovRadians = 1.1f;
    scene.cameras.push_back(camera);
    return scene;
}

ImageRgb32f truthOf(vec3 color)
{
    const Scene scene = room(color);
    auto picture = renderReference(scene, scene.cameras[0], kSize, {128});
    EXPECT_TRUE(picture) << picture.error().text();
    return std::move(*picture);
}

double meanOf(const ImageRgb32f& picture)
{
    double sum = 0.0;
    for (const vec3 radiance : picture.texels()) sum += double(luminance(radiance));
    return sum / double(picture.texelCount());
}

/// Mean difference of luminance over boxes of 4 x 4 pixels, in which most of the reference's noise is gone.
double difference(const ImageRgba32f& picture, const ImageRgb32f& truth)
{
    double sum = 0.0;
    for (int y = 0; y < kSize.y; y += 4)
        for (int x = 0; x < kSize.x; x += 4) {
            double off = 0.0;
            for (int i = 0; i < 16; ++i) {
                const ivec2 p(x + i % 4, y + i / 4);
                off += double(luminance(vec3(picture(p.x, p.y))) - luminance(truth(p.x, p.y)));
            }
            sum += std::abs(off);
        }
    return sum / double(truth.texelCount());
}

TEST(LampStatesS33, WhiteRedAndOffAreTheReferences)
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = 128;
    settings.lightmapSize = 256;
    settings.reflectionProbes = false;
    auto baked = bake(room(kRed), settings, embreeIntegrators());
    ASSERT_TRUE(baked) << baked.error().text();
    ASSERT_EQ(baked->baked.groups.size(), 1u);
    RendererOptions options;
    options.validation = true;
    auto renderer = Renderer::create(options);
    ASSERT_TRUE(renderer) << renderer.error().text();
    ASSERT_TRUE((*renderer)->load(baked->baked));
    double on = 0.0; // mean of the white lamp's picture, the first
    for (const vec3 weight : {vec3(1.0f), kRed, vec3(0.0f)}) {
        ASSERT_TRUE((*renderer)->setLightGroup("lamp", weight));
        const ImageRgb32f truth = truthOf(weight);
        if (on == 0.0) on = meanOf(truth);
        for (const RenderPath path : {RenderPath::Forward, RenderPath::Deferred}) {
            RenderSettings drawn;
            drawn.mode = RunMode::Shadowmask;
            drawn.path = path;
            drawn.size = kSize;
            drawn.supersampling = 2;
            const auto frame = (*renderer)->render(room(weight).cameras[0], drawn);
            ASSERT_TRUE(frame) << frame.error().text();
            const double share = difference(frame->radiance, truth) / on;
            std::printf("weight %.1f %.1f %.1f: off by %.4f of the lamp's mean\n", double(weight.x), double(weight.y),
                        double(weight.z), share);
            EXPECT_LT(share, weight == vec3(0.0f) ? 0.005 : 0.06);
        }
    }
    for (const std::string& message : (*renderer)->validationMessages()) ADD_FAILURE() << message;
}

} // namespace
} // namespace halflight::test::lamp_states_test
