// One light on one plane, three times: baked into the lightmap, realtime, path traced (spec S6–S8). What each has to
// be is known: a diffuse surface of albedo rho under irradiance E reflects rho E / pi; glTF's dielectric and metal by
// their BRDF, written out here a second time.

#include "pipeline/floor.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"
#include "halflight/shading/brdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace halflight::one_plane_test {
namespace {

constexpr ivec2 kSize(32, 32);
constexpr double kSunLux = 10.0;

/// What a plane is made of.
struct Surface {
    const char* name;
    float color;
    float metallic;
    float roughness;
    float specular;
};
constexpr Surface kDiffuse{"diffuse", 0.8f, 0.0f, 1.0f, 0.0f};
constexpr Surface kDullDielectric{"dull dielectric", 0.8f, 0.0f, 1.0f, 1.0f};
constexpr Surface kDarkDielectric{"dark dull dielectric", 0.2f, 0.0f, 1.0f, 1.0f};
constexpr Surface kSatinDielectric{"satin dielectric", 0.8f, 0.0f, 0.5f, 1.0f};
constexpr Surface kMetal{"metal", 0.9f, 1.0f, 0.6f, 1.0f};
constexpr Surface kDullMetal{"dull metal", 0.9f, 1.0f, 1.0f, 1.0f};

/// A floor of 8 m, seen from straight above.
Scene makePlane(const Surface& surface)
{
    Scene scene;
    Material material;
    material.baseColor = vec4(vec3(surface.color), 1.0f);
    material.metallic = surface.metallic;
    material.roughness = surface.roughness;
    material.specular = surface.specular;
    scene.materials.push_back(material);
    test::addFloor(scene, 4.0f);
    scene.sky = {vec3(0.0f), vec3(0.0f), vec3(0.0f)};
    Camera camera;
    camera.orthographic = true;
    camera.orthographicHeightMeters = 2.0f;
    camera.worldFromCamera = glm::inverse(glm::lookAt(vec3(0, 3, 0), vec3(0), vec3(0, 0, -1)));
    scene.cameras.push_back(camera);
    return scene;
}

Light makeSun(double cosine, LightMode mode)
{
    Light sun;
    sun.name = "sun";
    sun.type = LightType::Directional;
    const vec3 toSun(float(std::sqrt(1.0 - cosine * cosine)), float(cosine), 0.0f);
    sun.worldFromLight = glm::inverse(glm::lookAt(toSun, vec3(0), vec3(0, 0, 1)));
    sun.intensity = float(kSunLux);
    sun.mode = mode;
    return sun;
}

template<typename Picture> double meanOf(const Picture& picture)
{
    double sum = 0.0;
    for (const auto& texel : picture.texels()) sum += double(luminance(vec3(texel))) / double(picture.texelCount());
    return sum;
}

double realtimePicture(const Scene& scene, MixedLightingMode bakeMode, RunMode mode, bool specular = true,
                       RenderPath path = RenderPath::Forward)
{
    BakeSettings settings;
    settings.mode = bakeMode;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 64;
    settings.bounces = 0;
    auto baked = bake(scene, settings, embreeIntegrators());
    EXPECT_TRUE(baked) << baked.error().text();
    static auto renderer = Renderer::create({}); // one for all tests: to make it takes seconds
    EXPECT_TRUE(renderer) << renderer.error().text();
    EXPECT_TRUE((*renderer)->load(baked->baked));
    RenderSettings render;
    render.mode = mode;
    render.size = kSize;
    render.specular = specular;
    render.path = path;
    auto frame = (*renderer)->render(scene.cameras[0], render);
    EXPECT_TRUE(frame) << frame.error().text();
    return meanOf(frame->radiance);
}

double referencePicture(const Scene& scene, int samples)
{
    auto picture = renderReference(scene, scene.cameras[0], kSize, {samples, 0});
    EXPECT_TRUE(picture) << picture.error().text();
    return meanOf(*picture);
}

/// Radiance seen from straight above, of a sun whose direction has this cosine: glTF 2.0, appendix B.
double byHand(const Surface& s, double cosine)
{
    const double pi = 3.14159265358979;
    const double nh = std::sqrt(0.5 * (1.0 + cosine)); // of the half vector, with the normal and with the view alike
    const double grazing = std::pow(1.0 - nh, 5.0);
    const double f0 = s.metallic > 0.0f ? double(s.color) : 0.04 * double(s.specular);
    const double f90 = s.metallic > 0.0f ? 1.0 : double(s.specular);
    const double f = f0 + (f90 - f0) * grazing;
    const double a2 = std::pow(double(s.roughness), 4.0);
    const double d = a2 / (pi * std::pow(nh * nh * (a2 - 1.0) + 1.0, 2.0));
    const double v = 0.5 / (cosine + std::sqrt(cosine * cosine * (1.0 - a2) + a2));
    const double diffuse = (1.0 - f) * double(s.color) * (1.0 - double(s.metallic)) / pi;
    return (diffuse + f * d * v) * kSunLux * cosine;
}

constexpr double kCosines[] = {1.0, 0.5, 0.1};

TEST(OnePlaneS6S7, DiffuseIsAlbedoTimesIrradianceOverPiThreeTimes)
{
    for (const double cosine : kCosines) {
        Scene scene = makePlane(kDiffuse);
        const double expected = 0.8 * kSunLux * cosine / 3.14159265358979;
        scene.lights = {makeSun(cosine, LightMode::Baked)};
        // RGB9E5 has steps of 1/256 to 1/512.
        EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), expected,
                    0.003 * expected)
            << "baked, cosine " << cosine;
        EXPECT_NEAR(referencePicture(scene, 16), expected, 0.001 * expected) << "reference, cosine " << cosine;
        scene.lights = {makeSun(cosine, LightMode::Mixed)};
        EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Subtractive, RunMode::Subtractive), expected,
                    0.003 * expected)
            << "subtractive, cosine " << cosine;
        EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), expected,
                    0.002 * expected)
            << "shadowmask, cosine " << cosine;
        scene.lights = {makeSun(cosine, LightMode::Realtime)};
        EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), expected,
                    0.002 * expected)
            << "realtime, cosine " << cosine;
    }
}

/// Dull dielectrics, glTF's default but for the colour: where a lightmap has forgotten the direction, the three are
/// one.
TEST(OnePlaneS6S7, DullDielectricThreeTimes)
{
    for (const Surface& surface : {kDullDielectric, kDarkDielectric}) {
        for (const double cosine : kCosines) {
            Scene scene = makePlane(surface);
            const double expected = byHand(surface, cosine);
            // Of the direction the lobe knows: with the sun at the horizon 0.9 % of the light against 0.6 %, the mean.
            const double allowed = surface.color > 0.5f ? 0.01 : 0.03;
            scene.lights = {makeSun(cosine, LightMode::Baked)};
            EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), expected,
                        allowed * expected)
                << surface.name << " baked, cosine " << cosine;
            EXPECT_NEAR(referencePicture(scene, 16), expected, 0.001 * expected)
                << surface.name << " reference, cosine " << cosine;
            scene.lights = {makeSun(cosine, LightMode::Realtime)};
            EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), expected,
                        0.002 * expected)
                << surface.name << " realtime, cosine " << cosine;
        }
    }
}

/// Without specular every surface is as diffuse as in the bake: a dielectric of its colour, a metal of what its lobe
/// reflects to all sides.
TEST(OnePlaneS6S7, WithoutSpecularSurfacesAreAsInTheBake)
{
    for (const Surface& surface : {kDiffuse, kSatinDielectric, kMetal, kDullMetal}) {
        Scene scene = makePlane(surface);
        const float albedo = shading::transportAlbedo(vec3(surface.color), surface.metallic, surface.roughness).x;
        const double expected = double(albedo) * kSunLux * 0.5 / 3.14159265358979;
        for (const LightMode mode : {LightMode::Baked, LightMode::Realtime}) {
            for (const RenderPath path : {RenderPath::Forward, RenderPath::Deferred}) {
                scene.lights = {makeSun(0.5, mode)};
                EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask, false, path),
                            expected, 0.004 * expected)
                    << surface.name << (mode == LightMode::Baked ? ", baked" : ", realtime");
            }
        }
    }
}

/// Highlights depend on the light's direction: realtime picture and reference have the same ones.
TEST(OnePlaneS6S7, GlossAndMetalInRealtimePictureAndReference)
{
    for (const Surface& surface : {kSatinDielectric, kMetal, kDullMetal}) {
        for (const double cosine : kCosines) {
            Scene scene = makePlane(surface);
            const double expected = byHand(surface, cosine);
            scene.lights = {makeSun(cosine, LightMode::Realtime)};
            EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), expected,
                        0.002 * expected)
                << surface.name << " realtime, cosine " << cosine;
            EXPECT_NEAR(referencePicture(scene, 16), expected, 0.001 * expected)
                << surface.name << " reference, cosine " << cosine;
        }
    }
}

/// Under an even sky the lightmap has nothing to forget: its picture is that of the reference, metals included.
TEST(OnePlaneS6S7, EvenSkyOnEverySurface)
{
    for (const Surface& surface : {kDiffuse, kDullDielectric, kSatinDielectric, kMetal, kDullMetal}) {
        Scene scene = makePlane(surface);
        scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
        const double reference = referencePicture(scene, 256);
        if (surface.specular == 0.0f) EXPECT_NEAR(reference, 0.8, 0.002);
        // The specular lobe of a lightmap's light is a fit.
        EXPECT_NEAR(realtimePicture(scene, MixedLightingMode::Shadowmask, RunMode::Shadowmask), reference,
                    (surface.metallic > 0.0f ? 0.05 : 0.01) * reference)
            << surface.name;
    }
}

/// An emissive panel overhead, which the reference samples from both lobes: the mirror image of its radiance, and the
/// diffuse surface's rho E / pi.
TEST(OnePlaneS6S7, ReferenceMirrorsEmitters)
{
    for (const Surface& surface : {Surface{"mirror", 1.0f, 1.0f, 0.05f, 1.0f}, kDiffuse}) {
        Scene scene = makePlane(surface);
        Material panel;
        panel.baseColor = vec4(0.0f, 0.0f, 0.0f, 1.0f);
        panel.metallic = 0.0f;
        panel.specular = 0.0f;
        panel.emissiveNits = vec3(3.0f);
        scene.materials.push_back(panel);
        MeshPart part; // 2 m above, 40 m wide, facing down: radiance 3 from nearly all sides
        part.positions = {vec3(-20, 4, -20), vec3(20, 4, -20), vec3(20, 4, 20), vec3(-20, 4, 20)};
        part.normals.assign(4, vec3(0, -1, 0));
        part.indices = {0, 1, 2, 0, 2, 3};
        part.material = 1;
        Mesh mesh;
        mesh.parts.push_back(std::move(part));
        scene.meshes.push_back(std::move(mesh));
        Object object;
        object.name = "panel";
        object.mesh = 1;
        scene.objects.push_back(object);
        const double view = referencePicture(scene, 256);
        // Form factor of a square of half side a at height h above its centre: 4 / pi a' atan(a') with
        // a' = a / sqrt(a^2 + h^2), by adding four corner rectangles.
        const double a = 20.0 / std::sqrt(20.0 * 20.0 + 16.0);
        const double factor = 4.0 / 3.14159265358979 * a * std::atan(a);
        const double expected = surface.metallic > 0.0f ? 3.0 : 0.8 * 3.0 * factor;
        EXPECT_NEAR(view, expected, 0.015 * expected) << surface.name;
    }
}

} // namespace
} // namespace halflight::one_plane_test
