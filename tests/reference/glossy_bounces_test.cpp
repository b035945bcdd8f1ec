// Light that specular lobes carry from surface to surface (spec S6).

#include "bake/both_integrators.h"
#include "reference/traced.h"

#include "halflight/shading/brdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace halflight::test::glossy_bounces_test {
namespace {

constexpr int kPage = 64;

class GlossyBouncesS6 : public BothIntegrators {};
INSTANTIATE_TEST_SUITE_P(Transport, GlossyBouncesS6, kBoth, integratorName);

/// Walls of a closed room that emit 2 nits and reflect rho, both parts of the BRDF together: irradiance is
/// 2 pi / (1 - rho).
TEST_P(GlossyBouncesS6, ClosedRoomReflectsBothParts)
{
    for (const Finish& f : {Finish{vec3(0.5f), 0.0f, 0.4f}, Finish{vec3(0.5f), 0.0f, 1.0f},
                            Finish{vec3(0.7f), 1.0f, 0.5f}, Finish{vec3(0.6f), 0.5f, 0.6f, 0.5f}}) {
        Scene scene;
        const int walls = addFinish(scene, f);
        scene.materials.back().emissiveNits = vec3(2.0f);
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), walls, true, kPage);
        IntegrationSettings settings = transport();
        settings.samples = 256;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
        const SurfaceReflectance surface{f.color, f.metallic, f.roughness, f.specular};
        const double albedo =
            double((surface.diffuseAlbedo() + shading::averageSpecular(surface.f0(), surface.f90(), f.roughness)).x);
        const double expected = kPi * 2.0 / (1.0 - albedo);
        // The fit of averageSpecular() is off by 0.006 for metals.
        const double tolerance = 0.01 + 0.006 * double(f.metallic) / (1.0 - albedo);
        EXPECT_NEAR(compare(bench.irradiance(), expected).mean / expected, 1.0, tolerance)
            << "metallic " << f.metallic << ", roughness " << f.roughness;
    }
}

/// A sunlit floor between two walls, which the sun does not reach: it comes over the wall at -2 and goes down between.
Scene makeSunlitFloor(const Finish& finish)
{
    Scene scene;
    const int floor = addFinish(scene, finish);
    const int black = addMaterial(scene, vec3(0.0f));
    addRectangle(scene, {vec3(-1, 0, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, floor, kPage, {vec2(1), vec2(15)});
    addRectangle(scene, {vec3(-2, 0, 2), vec3(0, 0, -4), vec3(0, 2, 0)}, black, kPage, {vec2(17, 1), vec2(33, 9)});
    addRectangle(scene, {vec3(2, 0, -2), vec3(0, 0, 4), vec3(0, 2, 0)}, black, kPage, {vec2(17, 17), vec2(33, 25)});
    for (std::size_t wall = 1; wall <= 2; ++wall) scene.objects[wall].castShadows = false;
    scene.lights.push_back(
        makeLight(LightType::Directional, vec3(0), glm::normalize(vec3(2, -1, 0)), 100.0f, LightMode::Mixed));
    return scene;
}

struct Walls {
    double behind = 0.0; ///< mean irradiance of the wall that the sun comes from
    double ahead = 0.0;
};

Walls irradianceOfWalls(const Scene& scene, const IntegrationSettings& settings)
{
    Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    Walls walls;
    int count = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const float x = bench.positionOf(bench.map.texels[i]).x;
        if (std::abs(x) < 1.5f) continue;
        (x < 0.0f ? walls.behind : walls.ahead) += double(estimates[i].irradiance.y);
        ++count;
    }
    walls.behind /= 0.5 * count;
    walls.ahead /= 0.5 * count;
    return walls;
}

/// The same by the path tracer of pictures, along cosine-distributed rays from points of the wall at `x`.
double tracedIrradiance(const Traced& truth, float x)
{
    constexpr uint32_t kRays = 1 << 16;
    const vec3 normal(x < 0.0f ? 1.0f : -1.0f, 0, 0);
    double sum = 0.0;
    uint64_t rays = 0;
    for (uint32_t i = 0; i < kRays; ++i) {
        Sampler sampler(3, 5, i);
        const vec2 at = sampler.next2();
        const SurfacePoint point{vec3(x, 2.0f * at.x, 4.0f * at.y - 2.0f), normal, normal};
        const vec3 direction = gatherDirection(point, sampler.next2());
        sum += double(
            truth.tracer->radiance(point.position + 1.0e-4f * normal, direction, RayUse::Light, 0, sampler, rays).y);
    }
    return kPi * sum / kRays;
}

TEST_P(GlossyBouncesS6, LobesThrowLightForward)
{
    for (const Finish& f :
         {Finish{vec3(0.2f), 0.0f, 0.4f}, Finish{vec3(0.2f), 0.0f, 0.8f}, Finish{vec3(0.5f), 1.0f, 0.6f}}) {
        const Scene scene = makeSunlitFloor(f);
        IntegrationSettings settings = transport();
        settings.samples = 1024;
        const Walls walls = irradianceOfWalls(scene, settings);
        settings.glossyBounces = false;
        const Walls diffuse = irradianceOfWalls(scene, settings);
        const Traced truth(scene, {ReferenceSurfaces::Full});
        const Walls expected{tracedIrradiance(truth, -2.0f), tracedIrradiance(truth, 2.0f)};
        ASSERT_GT(expected.ahead, 1.3 * expected.behind);
        // The path tracer's diffuse part is the mean over directions, which matters for a sun as low as this.
        if (GetParam() == IntegratorKind::Path) {
            EXPECT_NEAR(walls.behind, expected.behind, 0.04 * expected.behind);
            EXPECT_NEAR(walls.ahead, expected.ahead, 0.04 * expected.ahead);
            continue;
        }
        // The cache has the first moment of a patch's light alone. This sun, 27 degrees above a dark floor, is a hard
        // case for it.
        EXPECT_NEAR(walls.ahead, expected.ahead, 0.7 * std::abs(diffuse.ahead - expected.ahead));
        EXPECT_GT(walls.ahead, 1.3 * walls.behind);
    }
}

} // namespace
} // namespace halflight::test::glossy_bounces_test
