// What one sees through coloured glass.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

namespace halflight::test::glass_pixels_test {
namespace {

constexpr ivec2 kSize{96, 54};

class GlassPixels : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, GlassPixels, kBothPaths, pathNameOf);

/// A white wall in the plane z = 0 under a sun, and a pane half a metre before it.
struct Pane {
    BakedScene baked;
    Light sun = directionalLight(vec3(0, 0.2f, 1), 2.0f);
    int material = 0;

    explicit Pane(vec4 color)
    {
        Scene& scene = baked.scene;
        const mat4 upright = glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0));
        addObject(scene, makeRectangle(4, 4, addMaterial(scene, vec4(1.0f))), upright, true);
        material = addMaterial(scene, color);
        addObject(scene, makeRectangle(3, 3, material), glm::translate(mat4(1.0f), vec3(0, 0, 0.5f)) * upright, false);
        scene.objects.back().castShadows = false; // what is seen through it, not what it keeps back
        scene.lights.push_back(sun);
    }
    Material& pane() { return baked.scene.materials[std::size_t(material)]; }

    /// The wall through the pane, and over it the light of what the pane stops.
    [[nodiscard]] vec3 expected(const Camera& camera) const
    {
        const Material& pane = baked.scene.materials[std::size_t(material)];
        const Ray ray = pixelRay(camera, kSize, kSize / 2);
        ShadedPoint point{ray.origin - ray.direction * (ray.origin.z / ray.direction.z), vec3(0, 0, 1), -ray.direction,
                          vec3(1.0f)};
        const vec3 behind = directRadiance(point, sun, 1.0f);
        point.baseColor = vec3(pane.baseColor);
        return behind * pane.passed(pane.baseColor, 0.0f, 1.0f, vec3(1.0f)) +
               directRadiance(point, sun, 1.0f) * pane.coverage(pane.baseColor.w, 0.0f, 1.0f);
    }
};

TEST_P(GlassPixels, TransmissionAndTintColorWhatIsBehindS35)
{
    const Camera camera = lookAt(vec3(0.3f, 0.2f, 3.0f), vec3(0.3f, 0.2f, 0));
    RenderSettings settings;
    settings.path = GetParam();
    settings.size = kSize;
    settings.shadows.directionalMapSize = 1024;
    const auto seen = [&](const Pane& pane) {
        return vec3(render(pane.baked, camera, settings).radiance(kSize.x / 2, kSize.y / 2));
    };
    Pane glass(vec4(0.9f, 0.25f, 0.1f, 1.0f));
    glass.pane().transmission = 0.7f;
    EXPECT_TRUE(near(seen(glass), glass.expected(camera)));
    Pane tinted(vec4(0.1f, 0.4f, 0.9f, 0.4f));
    tinted.pane().alphaMode = Material::AlphaMode::Blend;
    tinted.pane().tinted = true;
    EXPECT_TRUE(near(seen(tinted), tinted.expected(camera)));
}

} // namespace
} // namespace halflight::test::glass_pixels_test
