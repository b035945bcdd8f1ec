// S35. Masks with a colour: the law is one for each colour channel, on static and on dynamic receivers, in both paths.
#include "render/scene/probe_field.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

namespace halflight::test::colored_masks_test {
namespace {

constexpr ivec2 kSize{160, 90};
const vec3 kAlbedo(0.6f, 0.5f, 0.4f);
const vec3 kLightmap(4.0f, 3.0f, 2.0f); // lux
const u8vec4 kMasks[2] = {{204, 102, 51, 153}, {51, 153, 255, 0}};
constexpr float kReach = 6.0f;

/// linearField() with another order of channels in the second layer.
ProbeSample layeredField(vec3 p)
{
    ProbeSample sample = linearField(p);
    const vec4 first = sample.occlusion.layers[0];
    sample.occlusion.layers[1] = 0.9f * vec4(first.w, first.x, first.y, first.z);
    return sample;
}

/// A static floor at x > 0 with a mask, and a dynamic one at x < 0 with one sample of the probes.
BakedScene twoFloors(int layers)
{
    BakedScene baked;
    addProbes(baked, layeredField);
    baked.maskLayers = layers;
    const int material = addMaterial(baked.scene, vec4(kAlbedo, 1.0f));
    for (const bool isStatic : {true, false}) {
        const mat4 place = glm::translate(mat4(1.0f), vec3(isStatic ? 3 : -3, 0, 0));
        const int floor = addObject(baked.scene, makeRectangle(5, 8, material), place, isStatic);
        Object& object = baked.scene.objects[std::size_t(floor)];
        object.castShadows = false;
        object.probeLighting = ProbeLighting::Single;
        if (isStatic) object.lightmap = {0, vec2(1.0f), vec2(0.0f)};
    }
    baked.lightmaps.emplace_back(8, 8, glm::packF3x9_E1x5(kLightmap));
    for (int layer = 0; layer < layers; ++layer) baked.shadowmasks.emplace_back(8, 8, kMasks[layer]);
    return baked;
}

void addLight(BakedScene& baked, Light light, int channel, bool colored)
{
    bakeAsMixed(light, baked.mode, channel);
    light.baking.coloredMask = colored;
    baked.scene.lights.push_back(light);
}

/// B by hand.
vec3 bakedOf(const Light& light, bool onStatic)
{
    const int channel = light.baking.occlusionMaskChannel;
    vec4 layer = vec4(kMasks[channel / 4]) / 255.0f;
    if (!onStatic) layer = layeredField(vec3(-3, 0, 0)).occlusion.layers[std::size_t(channel / 4)];
    return light.baking.coloredMask ? vec3(layer) : vec3(layer[channel % 4]);
}

class ColoredMasksS35 : public BothPaths {
protected:
    const Camera camera = lookAt(vec3(0.5f, 9.0f, 6.0f), vec3(0));

    RenderedFrame draw(const BakedScene& baked, RunMode mode, float shadowDistance = 50.0f)
    {
        RenderSettings settings;
        settings.path = GetParam();
        settings.mode = mode;
        settings.size = kSize;
        settings.shadows.distanceMeters = shadowDistance;
        return render(baked, camera, settings);
    }
    /// Compares every third pixel with `radianceAt(point, whether it is static)`.
    template<typename RadianceAt> void expectFloors(const RenderedFrame& frame, const RadianceAt& radianceAt) const
    {
        int compared = 0;
        for (int y = 1; y < kSize.y; y += 3)
            for (int x = 1; x < kSize.x; x += 3) {
                const Ray ray = pixelRay(camera, kSize, {x, y});
                const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
                const vec3 p = point.position;
                if (std::abs(std::abs(p.x) - 3.0f) > 2.4f || std::abs(p.z) > 3.8f) continue;
                vec3 expected;
                if (!radianceAt(point, p.x > 0.0f, expected)) continue;
                ++compared;
                ASSERT_TRUE(near(vec3(frame.radiance(x, y)), expected, 4.0e-3f, 1.0e-3f)) << "at " << p.x << ' ' << p.z;
            }
        EXPECT_GT(compared, 200);
    }
};

INSTANTIATE_TEST_SUITE_P(, ColoredMasksS35, kBothPaths, pathNameOf);

/// What is not direct light.
vec3 indirectOf(const ShadedPoint& point, bool onStatic)
{
    return indirectRadiance(point, onStatic ? kLightmap : irradianceOf(layeredField(vec3(-3, 0, 0)), vec3(0, 1, 0)));
}

TEST_P(ColoredMasksS35, EachColorHasItsOwnAttenuation)
{
    BakedScene baked = twoFloors(2);
    Light first = directionalLight(vec3(0.1f, 1, 0), 3.0f);
    first.shadowStrength = 0.8f;
    addLight(baked, first, 0, true);
    addLight(baked, directionalLight(vec3(-0.2f, 1, 0.1f), 2.0f), 3, false);
    addLight(baked, directionalLight(vec3(0.1f, 1, 0.3f), 1.5f), 4, true);
    for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
        const RenderedFrame frame = draw(baked, mode, 0.1f); // all is beyond the shadow distance
        EXPECT_TRUE(frame.plan.coloredMasks);
        expectFloors(frame, [&](const ShadedPoint& point, bool onStatic, vec3& radiance) {
            radiance = indirectOf(point, onStatic);
            for (const Light& light : baked.scene.lights) {
                const vec3 attenuation = glm::mix(vec3(1.0f), bakedOf(light, onStatic), light.shadowStrength);
                radiance += directRadiance(point, light, 1.0f) * attenuation;
            }
            return true;
        });
    }
}

/// Beyond its reach B is 1 in all colours; a frame without such a light has other shaders, and the same grey light.
TEST_P(ColoredMasksS35, EndsAtItsReach)
{
    BakedScene baked = twoFloors(1);
    Light lamp;
    lamp.type = LightType::Point;
    lamp.worldFromLight = lightPose(vec3(3, 5, 0), vec3(0, -1, 0));
    lamp.intensity = 100.0f;
    addLight(baked, lamp, 0, true);
    baked.scene.lights[0].baking.reachMeters = kReach;
    const RenderedFrame frame = draw(baked, RunMode::Shadowmask);
    int beyond = 0;
    expectFloors(frame, [&](const ShadedPoint& point, bool onStatic, vec3& radiance) {
        const float distance = glm::distance(point.position, vec3(3, 5, 0));
        if (std::abs(distance - kReach) < 0.05f) return false;
        beyond += distance > kReach ? 1 : 0;
        const vec3 attenuation = distance > kReach ? vec3(1.0f) : bakedOf(baked.scene.lights[0], onStatic);
        radiance = indirectOf(point, onStatic) + directRadiance(point, baked.scene.lights[0], 1.0f) * attenuation;
        return true;
    });
    EXPECT_GT(beyond, 50);
}

/// A dynamic board over both floors: on the static one the light of the main light is taken away colour by colour; on
/// the dynamic one min(F, B).
TEST_P(ColoredMasksS35, SubtractsWhatArrives)
{
    for (const bool withMask : {true, false}) {
        BakedScene baked = twoFloors(1);
        if (!withMask) baked.shadowmasks.clear();
        baked.mode = MixedLightingMode::Subtractive;
        const mat4 place = glm::translate(mat4(1.0f), vec3(0, 20, 2));
        addObject(baked.scene, makeRectangle(20, 4, 0), place, false); // its shadow is on z > 0
        Light sun = directionalLight(vec3(0, 1, 0), 2.0f);
        sun.castShadows = true;
        addLight(baked, sun, 0, true);
        const RenderedFrame frame = draw(baked, RunMode::Subtractive);
        expectFloors(frame, [&](const ShadedPoint& point, bool onStatic, vec3& radiance) {
            if (std::abs(point.position.z) < 0.3f) return false;
            const bool shadowed = point.position.z > 0.0f;
            if (!onStatic) {
                const vec3 attenuation = shadowed ? vec3(0.0f) : bakedOf(baked.scene.lights[0], false);
                radiance = indirectOf(point, false) + directRadiance(point, baked.scene.lights[0], 1.0f) * attenuation;
                return true;
            }
            const vec3 arrives = withMask ? bakedOf(baked.scene.lights[0], true) : vec3(1.0f);
            radiance = indirectRadiance(point, kLightmap - (shadowed ? 2.0f * arrives : vec3(0.0f)));
            return true;
        });
    }
}

} // namespace
} // namespace halflight::test::colored_masks_test
