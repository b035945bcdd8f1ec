#include "render/scene/frame_data.h"

#include "halflight/base/mathematics.h"
#include "halflight/shading/law.h"
#include "halflight/shading/light.h"

#include <algorithm>

namespace halflight {
namespace {

static_assert(int(RunMode::Realtime) == shading::kModeRealtime);
static_assert(int(RunMode::BakedIndirect) == shading::kModeBakedIndirect);
static_assert(int(RunMode::Shadowmask) == shading::kModeShadowmask);
static_assert(int(RunMode::DistanceShadowmask) == shading::kModeDistanceShadowmask);
static_assert(int(RunMode::Subtractive) == shading::kModeSubtractive);
static_assert(int(DebugView::Lit) == shading::kViewLit);
static_assert(int(DebugView::Shadowmask) == shading::kViewShadowmask);
static_assert(int(DebugView::Lightmap) == shading::kViewLightmap);
static_assert(int(DebugView::Probes) == shading::kViewProbes);
static_assert(int(DebugView::Cascades) == shading::kViewCascades);
static_assert(int(DebugView::Fade) == shading::kViewFade);
static_assert(int(DebugView::Overlap) == shading::kViewOverlap);
static_assert(int(DebugView::Texels) == shading::kViewTexels);
static_assert(int(CascadeBlend::Hard) == shading::kBlendHard);
static_assert(int(CascadeBlend::Dithered) == shading::kBlendDithered);
static_assert(int(CascadeBlend::Soft) == shading::kBlendSoft);
static_assert(int(LightType::Directional) == shading::kLightDirectional);
static_assert(int(LightType::Point) == shading::kLightPoint);
static_assert(int(LightType::Spot) == shading::kLightSpot);
static_assert(int(LightType::Rectangle) == shading::kLightRectangle);
static_assert(int(LightType::Disk) == shading::kLightDisk);
static_assert(shading::kFilterHalfWidthPcf <= filterReachTexels(ShadowFilter::Pcf));
static_assert(shading::kFilterHalfWidthSoft <= filterReachTexels(ShadowFilter::Soft));

int filterHalfWidth(ShadowFilter filter)
{
    switch (filter) {
    case ShadowFilter::Hard:
        return 0;
    case ShadowFilter::Soft:
        return shading::kFilterHalfWidthSoft;
    case ShadowFilter::Pcf:
        break;
    }
    return shading::kFilterHalfWidthPcf;
}

} // namespace

shading::GpuFrame gpuFrame(const GpuScene& scene, const FrameView& view, const RenderSettings& settings,
                           const FramePlan& plan)
{
    const Camera& camera = view.camera;
    const mat4& worldFromCamera = camera.worldFromCamera;
    const float halfHeight =
        camera.orthographic ? 0.5f * camera.orthographicHeightMeters : math::tan(0.5f * camera.verticalFovRadians);
    const float aspect = float(view.size.x) / float(view.size.y);
    const LightClusters& clusters = plan.clusters;
    const Sky& sky = scene.outline.scene.sky;

    shading::GpuFrame frame{};
    frame.cameraPosition = worldFromCamera[3];
    frame.cameraForward = vec4(-glm::normalize(vec3(worldFromCamera[2])), camera.orthographic ? 1.0f : 0.0f);
    frame.cameraRight = vec4(glm::normalize(vec3(worldFromCamera[0])) * (halfHeight * aspect), 0.0f);
    frame.cameraUp = vec4(glm::normalize(vec3(worldFromCamera[1])) * halfHeight, 0.0f);
    const mat4 clipFromView = view.clipFromView();
    frame.depthRange = vec4(clipFromView[2].z, clipFromView[2].w, clipFromView[3].z, clipFromView[3].w);
    frame.pictureSize = vec4(view.size, 0.0f, 0.0f);
    frame.fade = vec4(plan.fadeConstants, 0.0f, 0.0f);
    frame.cascadeFar = vec4(plan.cascadeFar[0], plan.cascadeFar[1], plan.cascadeFar[2], plan.cascadeFar[3]);
    frame.shadowBias = vec4(0.0f, 0.0f, settings.shadows.cascadeBlendFraction, 0.0f);
    frame.skyZenith = vec4(sky.zenith, 0.0f);
    frame.skyHorizon = vec4(sky.horizon, 0.0f);
    frame.skyGround = vec4(sky.ground, 0.0f);
    frame.skyPicture = skyPictureOfFrame(scene.sky, sky);
    frame.skyPictureNits = vec4(scene.sky.unitNits * scene.skyFactor, 0.0f);
    const vec3 ownShadowColor = subtractiveShadowColor(scene.outline, scene.groups.weights);
    frame.subtractiveShadowColor =
        vec4(settings.subtractiveShadowColor.value_or(ownShadowColor), scene.lightmapUnitLux);
    for (int c = 0; c < kMostMaskLayers * kLayerChannels; ++c) {
        const MaskChannel& channel = scene.outline.maskChannels[std::size_t(c)];
        frame.maskRange[c / kLayerChannels][c % kLayerChannels] = channel.rangeTexels;
        frame.maskPenumbra[c / kLayerChannels][c % kLayerChannels] = channel.penumbraTexels;
    }
    frame.clusterRange = vec4(clusters.nearMeters, clusters.farMeters,
                              float(clusters.size.z) / math::log2(clusters.farMeters / clusters.nearMeters), 0.0f);
    frame.clusterSize = ivec4(clusters.size, 0);
    frame.mode = ivec4(int(plan.mode), int(settings.view), plan.mainLight, int(plan.lights.size()));
    frame.shadow = ivec4(filterHalfWidth(settings.shadows.filter), settings.shadows.cascades,
                         int(settings.shadows.cascadeBlend), settings.proxyVolumes ? 1 : 0);
    const bool directional = settings.directionalLightmaps && !scene.outline.lightmapDirections.empty();
    frame.baked = ivec4(directional ? 1 : 0, scene.hasDynamicLightmaps ? 1 : 0, settings.specular ? 0 : 1,
                        scene.outline.maskLayers);
    frame.dynamicLightmap.x = scene.dynamicUnitLux;
    if (settings.reflectionProbes && plan.mode != RunMode::Realtime)
        frame.reflections = reflectionsOfFrame(scene.reflections);
    std::copy(std::begin(scene.skySh), std::end(scene.skySh), std::begin(frame.skySh));
    return frame;
}

namespace {

/// Where the light's channel holds for.
void setBakedReach(const Light& light, shading::GpuLight& out)
{
    constexpr float kNoCone = -2.0f;
    const BakingOutput& baking = light.baking;
    const float ofType = isAreaLight(light.type) ? 0.0f : kNoCone; // the front of an area light
    out.bakedReach = vec4(vec3(baking.worldFromLight[3]), baking.reachMeters);
    out.bakedCone = vec4(-glm::normalize(vec3(baking.worldFromLight[2])),
                         light.type == LightType::Spot ? math::cos(baking.outerConeRadians) : ofType);
}

} // namespace

std::vector<shading::GpuLight> gpuLights(const Scene& scene, const FramePlan& plan, const ShadowSettings& shadows)
{
    std::vector<shading::GpuLight> result;
    for (const FrameLight& frameLight : plan.lights) {
        const Light& light = scene.lights[std::size_t(frameLight.light)];
        shading::GpuLight out{};
        out.positionRange = vec4(light.position(), light.rangeMeters);
        out.colorIntensity = vec4(light.color * light.intensity, light.shadowStrength);
        out.axis = vec4(light.direction(), 0.0f);
        out.spot = vec4(shading::spotConstants(light.innerConeRadians, light.outerConeRadians),
                        float(frameLight.tileCount), 0.0f);
        const int flags = (frameLight.hasBaked ? shading::kLightHasBaked : 0) |
                          (frameLight.hasRealtimeShadow ? shading::kLightHasRealtime : 0) |
                          (frameLight.skipStatic ? shading::kLightSkipStatic : 0) |
                          (frameLight.skipDynamic ? shading::kLightSkipDynamic : 0) |
                          (frameLight.overflowed ? shading::kLightOverflowed : 0) |
                          (light.baking.coloredMask ? shading::kLightColoredMask : 0);
        out.info = ivec4(int(light.type), flags, std::max(frameLight.channel, 0), std::max(frameLight.firstTile, 0));
        const ShadowSettings biased = shadowSettingsOf(light, shadows);
        out.shadowBias = vec4(biased.depthBias, biased.normalBiasTexels,
                              biased.penumbrae ? halfSourceWidth(light) : 0.0f, biased.slopeBias);
        if (isAreaLight(light.type)) {
            out.halfX = vec4(light.halfWidth(), 0.0f);
            out.halfY = vec4(light.halfHeight(), 0.0f);
        }
        setBakedReach(light, out);
        result.push_back(out);
    }
    return result;
}

std::vector<shading::GpuTile> gpuTiles(const FramePlan& plan)
{
    std::vector<shading::GpuTile> result;
    for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
        const ShadowTile& tile = plan.tiles[i];
        shading::GpuTile out{};
        out.clipFromWorld = tile.clipFromWorld;
        out.planeFromWorld = mat4(glm::transpose(glm::inverse(glm::dmat4(tile.clipFromWorld))));
        out.rectangle = vec4(tile.atlasOffset, float(tile.size), float(tile.layer));
        out.parameters =
            vec4(tile.texelMeters, plan.castersOf(int(i)).empty() ? 0.0f : 1.0f, tile.nearMeters, tile.farMeters);
        result.push_back(out);
    }
    return result;
}

} // namespace halflight
