#include "render/law_scene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

namespace halflight::test::law {

float realtimeOf(RunMode mode, int column)
{
    const bool dynamicOnly = mode == RunMode::Shadowmask || mode == RunMode::Subtractive;
    return inDynamicShadow(column) || (!dynamicOnly && inStaticShadow(column)) ? 0.0f : 1.0f;
}

vec3 lightmapOf(int column)
{
    return inStaticShadow(column) ? vec3(0.5f, 0.375f, 0.25f) : vec3(2.0f, 1.5f, 1.0f);
}

MixedLightingMode bakeModeFor(RunMode mode)
{
    if (mode == RunMode::Subtractive) return MixedLightingMode::Subtractive;
    if (mode == RunMode::BakedIndirect) return MixedLightingMode::BakedIndirect;
    return MixedLightingMode::Shadowmask;
}

Camera makeCamera()
{
    return lookAt(vec3(0, 4, 0), vec3(0, 2, -12), kPi / 3.0f);
}

LawScene makeScene(MixedLightingMode bakeMode)
{
    LawScene result;
    BakedScene& baked = result.baked;
    Scene& scene = baked.scene;
    baked.isBaked = true;
    baked.mode = bakeMode;
    const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
    result.floor =
        addObject(scene, makeRectangle(16.0f, 100.0f, material), glm::translate(mat4(1.0f), vec3(0, 0, -50)), true);
    scene.objects[0].lightmap = {0, vec2(0.5f), vec2(0.25f)};

    // Slabs along each column, off the camera's line to the floor.
    for (int column = 0; column < 4; ++column) {
        for (const bool isStatic : {true, false}) {
            if (!(isStatic ? inStaticShadow(column) : inDynamicShadow(column))) continue;
            const float height = isStatic ? 9.0f : 7.0f;
            const vec3 center = vec3(kColumns[std::size_t(column)], 0, -50) + kToSun * (height / kToSun.y);
            result.blockers.push_back(
                addObject(scene, makeRectangle(3.0f, 110.0f, material), glm::translate(mat4(1.0f), center), isStatic));
        }
    }
    Light sun = directionalLight(kToSun, kSunLux);
    bakeAsMixed(sun, bakeMode, bakeMode == MixedLightingMode::BakedIndirect ? -1 : 0);
    scene.lights.push_back(sun);

    constexpr int kPage = 128;
    Image<uint32_t> lightmap(kPage, kPage, glm::packF3x9_E1x5(vec3(64.0f)));
    ImageRgba8 mask(kPage, kPage, u8vec4(128));
    for (int y = kPage / 4 - 1; y <= kPage * 3 / 4; ++y) {
        for (int x = kPage / 4 - 1; x <= kPage * 3 / 4; ++x) {
            const int column = glm::clamp((x - kPage / 4) / (kPage / 8), 0, 3);
            lightmap(x, y) = glm::packF3x9_E1x5(lightmapOf(column));
            mask(x, y) = u8vec4(inStaticShadow(column) ? 51 : 255, 255, 255, 255);
        }
    }
    baked.lightmaps.push_back(lightmap);
    if (bakeMode == MixedLightingMode::Shadowmask) baked.shadowmasks.push_back(mask);
    result.mask = std::move(mask);
    return result;
}

void addMainLightMask(LawScene& law)
{
    law.baked.shadowmasks.push_back(law.mask);
}

RenderSettings settingsFor(RunMode mode, RenderPath path)
{
    RenderSettings settings;
    settings.mode = mode;
    settings.path = path;
    settings.size = kSize;
    settings.shadows.distanceMeters = kShadowDistance;
    settings.shadows.fadeRangeMeters = kFadeRange;
    settings.shadows.directionalMapSize = 1024;
    return settings;
}

std::vector<Site> sites()
{
    const Camera camera = makeCamera();
    std::vector<Site> result;
    int bands[3] = {0, 0, 0};
    for (int column = 0; column < 4; ++column) {
        for (const float depth : kDepths) {
            Site site{column, {}, {}, 0.0f};
            site.pixel = pixelOf(camera, kSize, vec3(kColumns[std::size_t(column)], 0, depth));
            const Ray ray = pixelRay(camera, kSize, site.pixel);
            site.point.position = onPlane(ray, 0.0f);
            site.point.view = -ray.direction;
            site.point.baseColor = kAlbedo;
            const float distance = glm::distance(ray.origin, site.point.position);
            site.fade = glm::clamp((distance - kShadowDistance) / kFadeRange + 1.0f, 0.0f, 1.0f);
            bands[site.fade == 0.0f ? 0 : site.fade == 1.0f ? 2 : 1]++;
            result.push_back(site);
        }
    }
    EXPECT_TRUE(bands[0] == 8 && bands[1] >= 32 && bands[2] >= 8)
        << bands[0] << ' ' << bands[1] << ' ' << bands[2] << ": near, within the fade, beyond";
    return result;
}

void expectSites(const RenderedFrame& frame, const std::function<vec3(const Site&)>& expected)
{
    for (const Site& site : sites())
        EXPECT_TRUE(near(vec3(frame.radiance(site.pixel.x, site.pixel.y)), expected(site), 1.0e-3f, kAbsolute))
            << kColumnNames[std::size_t(site.column)] << ", t = " << site.fade;
}

float attenuationByHand(RunMode mode, bool hasBaked, float baked, bool hasRealtime, float realtime, float fade,
                        float strength)
{
    const bool mixes = hasBaked && (mode == RunMode::Shadowmask || mode == RunMode::DistanceShadowmask ||
                                    mode == RunMode::Subtractive);
    const float faded = hasRealtime ? (1.0f - fade) * realtime + fade : 1.0f;
    float attenuation = faded;
    if (mixes && !hasRealtime) attenuation = baked;
    if (mixes && hasRealtime)
        attenuation = mode == RunMode::DistanceShadowmask ? (1.0f - fade) * realtime + fade * baked
                                                          : (faded < baked ? faded : baked);
    return 1.0f - strength + strength * attenuation;
}

vec3 subtractiveByHand(vec3 lightmap, vec3 mainIrradiance, float realtime, float fade, vec3 shadowColor, float strength,
                       float baked)
{
    const float faded = realtime + (1.0f - realtime) * fade;
    const float lost = faded < baked ? baked - faded : 0.0f; // B - min(B, F)
    vec3 result;
    for (int c = 0; c < 3; ++c) {
        const float guess = mainIrradiance[c] * lost;
        const float left = lightmap[c] - guess > shadowColor[c] ? lightmap[c] - guess : shadowColor[c];
        const float mixed = (1.0f - strength) * lightmap[c] + strength * left;
        result[c] = mixed < lightmap[c] ? mixed : lightmap[c];
    }
    return result;
}

} // namespace halflight::test::law
