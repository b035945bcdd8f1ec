#pragma once
// Scenes whose picture is known, and what is known about them.

#include "halflight/render/renderer.h"
#include "light_pose.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace halflight::test {

/// A renderer with the validation layer on, which the tests of a suite share, as the CPU driver takes seconds to
/// prepare its shaders; every test ends with the layer having said nothing.
class RenderTest : public testing::Test {
protected:
    static void SetUpTestSuite();
    static void TearDownTestSuite() { renderer.reset(); }
    void SetUp() override;
    void TearDown() override;
    /// For tests of a renderer that has loaded nothing.
    void startAnew();
    /// Loads and renders; fails the test with the error.
    RenderedFrame render(const BakedScene& baked, const Camera& camera, const RenderSettings& settings);
    /// The same of what is loaded.
    RenderedFrame render(const Camera& camera, const RenderSettings& settings);

    inline static std::unique_ptr<Renderer> renderer;

private:
    std::size_t earlierMessages_ = 0; ///< of other tests
};

/// Tests whose answer is the same forward and deferred.
class BothPaths : public RenderTest, public testing::WithParamInterface<RenderPath> {};
inline const auto kBothPaths = testing::Values(RenderPath::Forward, RenderPath::Deferred);
inline const char* pathName(RenderPath path)
{
    return path == RenderPath::Forward ? "Forward" : "Deferred";
}
inline std::string pathNameOf(const testing::TestParamInfo<RenderPath>& info)
{
    return pathName(info.param);
}

/// Camera at `eye` that looks at `target`.
Camera lookAt(vec3 eye, vec3 target, float verticalFovRadians = kPi / 3.0f);
/// Pixel that shows a point of the world, and the ray through that pixel's centre.
ivec2 pixelOf(const Camera& camera, ivec2 size, vec3 point);
struct Ray {
    vec3 origin;
    vec3 direction;
};
Ray pixelRay(const Camera& camera, ivec2 size, ivec2 pixel);
/// Where that ray meets the plane y = height.
vec3 onPlane(const Ray& ray, float height);

/// Rectangle in the plane y = 0 of its own space, facing up; uv 0 and lightmap (0,0) at (-x, -z), (1,1) at (+x, +z).
Mesh makeRectangle(float width, float depth, int material = -1);
/// Adds a mesh as an object.
int addObject(Scene& scene, Mesh mesh, const mat4& worldFromObject, bool isStatic);
/// Dull material: albedo, not metallic, roughness 1.
int addMaterial(Scene& scene, vec4 baseColor);

Light directionalLight(vec3 toLight, float lux);
/// Marks a light as mixed by a bake, with this channel.
void bakeAsMixed(Light& light, MixedLightingMode mode, int channel);

/// A surface point as the renderer shades it, without textures.
struct ShadedPoint {
    vec3 position{0.0f};
    vec3 normal{0.0f, 1.0f, 0.0f};
    vec3 view{0.0f};
    vec3 baseColor{1.0f};
    float metallic = 0.0f;
    float roughness = 1.0f;
};
/// Radiance by direct light of one light, times the shadow attenuation.
vec3 directRadiance(const ShadedPoint& point, const Light& light, float attenuation);
/// Radiance by indirect irradiance on a lightmapped surface.
vec3 indirectRadiance(const ShadedPoint& point, vec3 irradiance);

/// Pixels of two pictures that differ in a channel by more than half a percent of the brighter one and 1/2000 of the
/// first picture's mean.
struct PictureDifference {
    int differing = 0;
    int lit = 0; ///< pixels that are not black
    ivec2 worst{0};
    float worstRelative = 0.0f; ///< difference there, relative to what was allowed times half a percent
};
PictureDifference compare(const ImageRgba32f& a, const ImageRgba32f& b);

/// Componentwise |actual - expected| <= relative * expected + absolute.
testing::AssertionResult near(vec3 actual, vec3 expected, float relative = 1.0e-3f, float absolute = 1.0e-5f);

} // namespace halflight::test
