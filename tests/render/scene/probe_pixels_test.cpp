// S14. Dynamic objects in the picture: each takes light and occlusion of the probes around its middle, interpolated.
#include "halflight/shading/sh.h"
#include "render/law_scene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <cmath>

namespace halflight::test::probe_pixels_test {
namespace {

constexpr ivec2 kSize{320, 120};

/// A value that is linear in space, so that every correct interpolation gives it exactly: probes on a grid, one of them
/// inside geometry and full of nonsense.
float linearField(vec3 p, vec3 slope, float offset)
{
    return glm::dot(p, slope) + offset;
}
vec3 coefficient(int i, vec3 p)
{
    if (i == 0)
        return {linearField(p, vec3(0.05f, 0.1f, 0.02f), 3.0f), linearField(p, vec3(-0.04f, 0.0f, 0.03f), 2.5f),
                linearField(p, vec3(0.0f, 0.1f, 0.05f), 2.0f)};
    return vec3(linearField(p, vec3(0.004f, 0.002f, -0.003f) * float(i), 0.03f * float(i) - 0.1f));
}
vec4 occlusionAt(vec3 p)
{
    return {linearField(p, vec3(0.05f, 0, 0), 0.5f), linearField(p, vec3(-0.05f, 0, 0), 0.45f),
            linearField(p, vec3(0, 0.1f, 0.02f), 0.2f), linearField(p, vec3(0.02f, 0.05f, 0), 0.6f)};
}

/// A row of dynamic plates over a dark floor far below, with four lights of a channel each.
struct ProbeScene {
    BakedScene baked;
    Camera camera = lookAt(vec3(0, 5, 9), vec3(0, 1, 0), 0.7f);
    std::vector<vec3> centers;

    ProbeScene()
    {
        baked.isBaked = true;
        Scene& scene = baked.scene;
        const int material = addMaterial(scene, vec4(0.7f, 0.6f, 0.5f, 1.0f));
        addObject(scene, makeRectangle(1, 1, material), glm::translate(mat4(1.0f), vec3(0, -50, 0)), true);
        scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
        baked.lightmaps.emplace_back(4, 4, uint32_t(0));
        baked.shadowmasks.emplace_back(4, 4, u8vec4(255));
        for (int i = 0; i < 5; ++i) {
            centers.push_back({-6.0f + 3.0f * float(i), 0.3f + 0.4f * float(i), 0.5f * float(i % 2)});
            addObject(scene, makeRectangle(1, 1, material), glm::translate(mat4(1.0f), centers.back()), false);
        }
        for (int x = -2; x <= 2; ++x)
            for (int y = 0; y < 3; ++y)
                for (int z = -1; z <= 1; ++z) {
                    Probe probe;
                    probe.position = vec3(4 * x, 2 * y - 1, 3 * z);
                    for (int i = 0; i < 9; ++i) probe.radiance[std::size_t(i)] = coefficient(i, probe.position);
                    probe.occlusion.layers[0] = occlusionAt(probe.position);
                    if (x == 0 && y == 1 && z == 0) {
                        probe.valid = false;
                        probe.radiance.fill(vec3(99.0f));
                        probe.occlusion.layers[0] = vec4(0.0f);
                    }
                    baked.probes.probes.push_back(probe);
                }
        const LightType types[] = {LightType::Directional, LightType::Point, LightType::Spot, LightType::Directional};
        const vec3 positions[] = {vec3(0), vec3(-3, 4, 2), vec3(2, 5, 1), vec3(0)};
        const vec3 directions[] = {vec3(0.3f, -1, 0.2f), vec3(0, -1, 0), vec3(-0.2f, -1, 0), vec3(-0.4f, -1, -0.1f)};
        for (int i = 0; i < 4; ++i) {
            Light light;
            light.type = types[i];
            light.worldFromLight = lightPose(positions[i], directions[i]);
            light.intensity = types[i] == LightType::Directional ? 1.0f + float(i) : 20.0f;
            light.innerConeRadians = 0.9f;
            light.outerConeRadians = 1.2f;
            bakeAsMixed(light, MixedLightingMode::Shadowmask, 3 - i);
            scene.lights.push_back(light);
        }
    }
};

using ModePath = std::tuple<RunMode, RenderPath>;
class ProbePixelsS14 : public RenderTest, public testing::WithParamInterface<ModePath> {};
INSTANTIATE_TEST_SUITE_P(, ProbePixelsS14,
                         testing::Combine(testing::Values(RunMode::BakedIndirect, RunMode::Shadowmask,
                                                          RunMode::DistanceShadowmask),
                                          kBothPaths));

// Near, within the fade, and beyond the shadow distance. All plates cast; none stands in another's light.
TEST_P(ProbePixelsS14, LightAndFourOcclusionsInterpolated)
{
    const auto [mode, path] = GetParam();
    for (const float distance : {60.0f, 12.0f, 5.0f}) {
        const ProbeScene scene;
        RenderSettings settings;
        settings.mode = mode;
        settings.path = path;
        settings.size = kSize;
        settings.shadows.distanceMeters = distance;
        settings.shadows.fadeRangeMeters = 4.0f;
        const RenderedFrame frame = render(scene.baked, scene.camera, settings);
        for (const vec3 center : scene.centers) {
            const ivec2 pixel = pixelOf(scene.camera, kSize, center);
            const Ray ray = pixelRay(scene.camera, kSize, pixel);
            const ShadedPoint point{onPlane(ray, center.y), vec3(0, 1, 0), -ray.direction, vec3(0.7f, 0.6f, 0.5f)};
            const float fade =
                glm::clamp((glm::distance(ray.origin, point.position) - distance) / 4.0f + 1.0f, 0.0f, 1.0f);
            vec3 irradiance(0.0f);
            for (int i = 0; i < 9; ++i)
                irradiance += coefficient(i, center) * shading::shIrradianceWeight(i, vec3(0, 1, 0));
            vec3 expected(0.0f);
            for (std::size_t i = 0; i < 4; ++i) {
                const Light& light = scene.baked.scene.lights[i];
                const FrameLight* planned = nullptr;
                for (const FrameLight& candidate : frame.plan.lights)
                    if (candidate.light == int(i)) planned = &candidate;
                ASSERT_TRUE(planned);
                if (distance == 60.0f) EXPECT_TRUE(planned->hasRealtimeShadow) << "the plates themselves";
                const float baked = occlusionAt(center)[light.baking.occlusionMaskChannel];
                expected += directRadiance(point, light,
                                           law::attenuationByHand(mode, mode != RunMode::BakedIndirect, baked,
                                                                  planned->hasRealtimeShadow, 1.0f, fade, 1.0f));
            }
            // Roughness 1: the specular lobe sees what the normal sees.
            expected += indirectRadiance(point, irradiance);
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 2.0e-3f))
                << "x " << center.x << " t " << fade;
        }
    }
}

} // namespace
} // namespace halflight::test::probe_pixels_test
