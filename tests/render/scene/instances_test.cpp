// S15. As many instances as one draw of the seeds has, each with its own interpolated probe light and occlusion.
#include "render/scene/probe_field.h"

#include <glm/gtc/matrix_transform.hpp>

namespace halflight::test::instances_test {
namespace {

constexpr int kColumns = 33;
constexpr int kRows = 31;
constexpr int kPixels = 8; // per instance
constexpr float kPitch = 0.25f;

/// No two neighbouring probes alike, all of them linear in no direction.
ProbeSample wildField(vec3 p)
{
    ProbeSample sample;
    const auto hash = [&](float a, float b, float c) { return 0.5f + 0.5f * std::sin(a * p.x + b * p.y + c * p.z); };
    sample.radiance[0] = {1.0f + hash(3, 5, 7), 1.0f + hash(2, 9, 4), 1.0f + hash(8, 1, 6)};
    sample.radiance[1] = sample.radiance[0] * (0.3f * hash(5, 4, 3));
    sample.occlusion.layers[0] = {hash(7, 2, 9), hash(1, 8, 5), hash(6, 6, 1), hash(4, 3, 8)};
    return sample;
}

class InstancesS15 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(Paths, InstancesS15, kBothPaths, pathNameOf);

TEST_P(InstancesS15, OneDrawOf1023EachWithItsOwnProbes)
{
    BakedScene baked;
    addProbes(baked, wildField);
    const vec3 albedo(0.5f, 0.6f, 0.7f);
    const int material = addMaterial(baked.scene, vec4(albedo, 1.0f));
    addObject(baked.scene, makeRectangle(0.8f * kPitch, 0.8f * kPitch, material), mat4(1.0f), false);
    const Object first = baked.scene.objects[0];
    baked.scene.objects.clear();
    std::vector<vec3> positions;
    for (int i = 0; i < kColumns * kRows; ++i) {
        Object object = first;
        object.castShadows = false; // baked shadows only
        const vec2 place = (vec2(i % kColumns, i / kColumns) - 0.5f * vec2(kColumns - 1, kRows - 1)) * kPitch;
        positions.emplace_back(place.x, 0.013f * float(i % 101), place.y);
        object.worldFromObject = glm::translate(mat4(1.0f), positions.back());
        baked.scene.objects.push_back(object);
    }
    ASSERT_EQ(positions.size(), 1023u);
    for (int channel = 0; channel < 4; ++channel) {
        Light sun = directionalLight(vec3(0.5f * float(channel % 2) - 0.2f, 1, 0.3f * float(channel / 2)), 1.0f);
        sun.color = vec3(channel == 0 || channel == 3, channel == 1 || channel == 3, channel == 2);
        bakeAsMixed(sun, MixedLightingMode::Shadowmask, channel);
        baked.scene.lights.push_back(sun);
    }

    Camera camera = lookAt(vec3(0, 10, 0), vec3(0));
    camera.orthographic = true;
    camera.orthographicHeightMeters = kRows * kPitch;
    RenderSettings settings;
    settings.path = GetParam();
    settings.mode = RunMode::Shadowmask;
    settings.size = {kColumns * kPixels, kRows * kPixels};
    const RenderedFrame frame = render(baked, camera, settings);

    const std::vector<ProbeSample> samples = sampleProbes(ProbeInterpolator(baked), positions);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        ShadedPoint point;
        point.view = vec3(0, 1, 0);
        point.baseColor = albedo;
        vec3 expected = indirectRadiance(point, irradianceOf(samples[i], point.normal));
        for (const Light& light : baked.scene.lights)
            expected += directRadiance(point, light, samples[i].occlusion[light.baking.occlusionMaskChannel]);
        const ivec2 pixel(int(i) % kColumns * kPixels + kPixels / 2, int(i) / kColumns * kPixels + kPixels / 2);
        ASSERT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 5.0e-3f)) << "instance " << i;
    }
    for (const PassReport& pass : frame.passes) {
        const bool drawsMeshes = pass.name == "depth" || pass.name == "forward" || pass.name == "g-buffer";
        if (!drawsMeshes || (pass.name == "forward" && GetParam() == RenderPath::Deferred)) continue;
        EXPECT_EQ(pass.draws, 1) << pass.name;
        EXPECT_EQ(pass.instances, 1023) << pass.name;
    }
}

} // namespace
} // namespace halflight::test::instances_test
