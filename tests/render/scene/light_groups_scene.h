#pragma once
// A baked scene with light groups, made by hand: a lightmapped floor, a lamp that shines on it, an emissive plate, a
// mixed sun, dynamic objects under probes, and a sky.

#include "render/render_test.h"

#include "halflight/base/rgb9e5.h"
#include "halflight/render/compose.h"

#include <glm/gtc/matrix_transform.hpp>

#include <string>
#include <vector>

namespace halflight::test {

enum GroupOfScene { kLamp = 0, kSun = 1, kDay = 2, kLampWithPlate = 3 };

/// Pages and probes. Page 0 is nobody's; groups have no light there. Values differ by texel.
inline void addGroupLight(BakedScene& baked, bool directional)
{
    const auto page = [](vec3 light, int salt) {
        Image<uint32_t> texels(16, 16);
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x)
                texels(x, y) = packRgb9e5(light * (0.5f + float((5 * x + 3 * y + salt) % 16) / 16.0f));
        return texels;
    };
    baked.lightmaps = {Image<uint32_t>(16, 16), page(vec3(0.3f, 0.2f, 0.25f), 0)};
    const vec3 lights[] = {vec3(2.0f, 3.0f, 4.0f), vec3(0.2f, 0.15f, 0.1f), vec3(0.5f, 0.8f, 1.0f), vec3(1.0f)};
    for (std::size_t g = 0; g < 4; ++g)
        baked.groups[g].lightmaps = {Image<uint32_t>(), page(lights[g], 3 * int(g) + 1)};
    baked.shadowmasks.assign(2, ImageRgba8(16, 16, u8vec4(128, 255, 255, 255)));
    if (directional) {
        const auto mean = [](vec3 direction) { return ImageRgba8(16, 16, u8vec4(direction * 127.5f + 128.0f, 200)); };
        baked.lightmapDirections = {mean(vec3(0)), mean(vec3(0, 0.7f, 0))};
        baked.groups[kLamp].directions = {ImageRgba8(), mean(vec3(0.5f, 0.6f, 0.2f))};
        baked.groups[kLampWithPlate].directions = {ImageRgba8(), mean(vec3(-0.7f, 0.4f, 0))};
    }
    for (int i = 0; i < 8; ++i) {
        Probe probe;
        probe.position = vec3(i & 1 ? 4 : -4, i & 2 ? 4 : 0, i & 4 ? 4 : -4);
        probe.radiance[0] = vec3(i & 1 ? 0.4f : 0.1f);
        probe.occlusion.layers[0] = vec4(i & 4 ? 0.9f : 0.3f, 1, 1, 1);
        baked.probes.probes.push_back(probe);
        for (std::size_t g = 0; g < 4; ++g) {
            SphericalHarmonicsL2& own = baked.groups[g].radiance.emplace_back();
            own[0] = lights[g] * (i & 2 ? 1.0f : 0.5f);
            own[1] = own[0] * (g == kLamp ? 2.0f : 0.3f); // the lamp's rings: alone, irradiance from below would be < 0
        }
    }
}

/// Groups: "lamp" (a mixed point light), "sun" (mixed, directional, with a mask), "day" (the sky), "neon" (a baked lamp
/// and an emissive plate). All but "day" are saved at a weight that is not 1.
inline BakedScene groupedScene(bool directional = false)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = MixedLightingMode::Shadowmask;
    Scene& scene = baked.scene;
    const int floor = addMaterial(scene, vec4(0.6f, 0.5f, 0.4f, 1.0f));
    addObject(scene, makeRectangle(8, 8, floor), mat4(1.0f), true);
    scene.objects[0].lightmap = {1, vec2(1.0f), vec2(0.0f)};
    const int neon = addMaterial(scene, vec4(0.2f, 0.2f, 0.2f, 1.0f));
    addObject(scene, makeRectangle(1, 1, neon), glm::translate(mat4(1.0f), vec3(-2.5f, 0.3f, 0)), true);
    addObject(scene, makeRectangle(1.5f, 1.5f, floor), glm::translate(mat4(1.0f), vec3(1.5f, 0.5f, 1)), false);
    addObject(scene, makeRectangle(2, 1, floor), glm::translate(mat4(1.0f), vec3(1.0f, 0.4f, -2)), false);
    scene.objects[3].probeLighting = ProbeLighting::Volume;
    scene.objects[3].probeResolution = {5, 2, 3};
    for (std::size_t i = 1; i < 4; ++i) scene.objects[i].castShadows = false;

    const vec3 weights[] = {vec3(1.0f, 0.5f, 0.25f), vec3(0.5f), vec3(1.0f), vec3(0.0f, 0.8f, 0.4f)};
    const char* names[] = {"lamp", "sun", "day", "neon"};
    for (int g = 0; g < 4; ++g) {
        BakedGroup& group = baked.groups.emplace_back();
        group.name = names[g];
        group.weight = weights[g];
        group.sky = g == kDay;
        group.unitLux = g == kSun ? 8.0f : 1.0f;
    }
    const auto addLight = [&](Light light, const char* name, int group, vec3 white) {
        light.name = name;
        light.baking.group = group;
        light.baking.white = white;
        light.color = weights[group];
        light.intensity = white.x;
        light.castShadows = group == kSun;
        light.baking.atBake = lightAtBake(light);
        scene.lights.push_back(light);
    };
    Light lamp;
    lamp.type = LightType::Point;
    lamp.worldFromLight = lightPose(vec3(0, 2, 0), vec3(0, -1, 0));
    bakeAsMixed(lamp, baked.mode, -1);
    addLight(lamp, "ceiling lamp", kLamp, vec3(20.0f));
    Light sun = directionalLight(vec3(0.3f, 1, 0.2f), 1.0f);
    bakeAsMixed(sun, baked.mode, 0);
    addLight(sun, "the sun", kSun, vec3(6.0f));
    Light tube = lamp;
    tube.baking.bakeType = LightMode::Baked;
    addLight(tube, "tube", kLampWithPlate, vec3(5.0f));
    Material& plate = scene.materials[std::size_t(neon)];
    plate.bakedGroup = kLampWithPlate;
    plate.whiteNits = vec3(3.0f, 2.0f, 1.0f);
    plate.emissiveNits = plate.whiteNits * weights[kLampWithPlate];
    scene.sky.zenith = vec3(0.2f, 0.3f, 0.5f);
    scene.sky.horizon = vec3(0.4f, 0.4f, 0.4f);
    scene.sky.ground = vec3(0.1f, 0.05f, 0.0f);

    addGroupLight(baked, directional);
    return baked;
}

/// The bake as composeGroups() makes it of these weights.
inline BakedScene stateOf(BakedScene baked, const std::vector<GroupWeight>& changes)
{
    const Result<std::vector<vec3>> weights = groupWeights(baked, changes);
    EXPECT_TRUE(weights);
    composeGroups(baked, *weights);
    return baked;
}

inline const std::vector<GroupWeight> kAllGroupsOff = {
    {"lamp", vec3(0)}, {"sun", vec3(0)}, {"day", vec3(0)}, {"neon", vec3(0)}};

/// How often a frame composed the lightmap.
inline int composePassesOf(const RenderedFrame& frame)
{
    int count = 0;
    for (const PassReport& pass : frame.passes) count += pass.name == "compose" ? 1 : 0;
    return count;
}

} // namespace halflight::test
