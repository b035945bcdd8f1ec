#include "bake/group_stages.h"

#include "bake/denoise/denoise.h"
#include "bake/geometry/indices.h"
#include "bake/live/live_light.h"
#include "bake/pages/dilate.h"
#include "bake/pages/encode.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/render/compose.h"
#include "halflight/scene/probe_cells.h"
#include "halflight/scene/turning_lights.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace halflight {
namespace {

/// Texels darker than this share of the 99th percentile are black, so that they take no bytes.
constexpr float kDimShare = 1.0f / 4096.0f;
/// Bits of groups' mantissas in RGB9E5, of nine: half a step is 0.8 % of a texel's brightest channel at most. Bits that
/// hold noise take bytes, and do not compress.
constexpr uint32_t kMantissaBits = 7;
/// Bits of groups' mean directions, of eight: half a step is 1.6 % of a unit vector.
constexpr uint32_t kDirectionBits = 6;

/// Light of one component by texel, lux, and its pages.
struct LightValues {
    std::vector<vec3> irradiance;
    std::vector<vec3> direct;  ///< empty without direct light of fully baked lights
    std::vector<vec3> moments; ///< empty without directions
};
struct LightPages {
    std::vector<ImageRgb32f> irradiance;
    std::vector<ImageRgb32f> moments; ///< empty without directions
};

/// Releases the signals.
LightValues valuesOf(Signals& signals)
{
    const std::size_t count = signals.gathered.size();
    LightValues values;
    values.irradiance = largeVector<vec3>(count);
    forEachIndex(count, [&](std::size_t i) { values.irradiance[i] = signals.irradiance(i); });
    release(signals.gathered);
    values.direct = largeVector<vec3>(signals.direct.size());
    forEachIndex(values.direct.size(), [&](std::size_t i) { values.direct[i] = signals.direct[i].irradiance; });
    release(signals.direct);
    values.moments = std::move(signals.moments);
    return values;
}

void addMainLight(const MainLight& main, LightValues& values)
{
    if (values.direct.empty()) values.direct = largeVector<vec3>(values.irradiance.size());
    main.addTo(values.irradiance);
    main.addTo(values.direct);
    if (!values.moments.empty()) main.addMomentTo(values.moments);
}

/// Of all components at one time, because they take the same texels' means.
void fillAll(const CachedIntegrator& cached, const std::vector<uint8_t>& valid, std::vector<LightValues>& components)
{
    std::vector<std::vector<vec3>*> quantities;
    for (LightValues& values : components)
        for (std::vector<vec3>* quantity : {&values.irradiance, &values.direct, &values.moments})
            if (!quantity->empty()) quantities.push_back(quantity);
    fillInvalid<vec3>(cached.geometry, cached.map, valid, quantities);
}

/// Releases the values.
LightPages pagesOf(const TexelMap& map, LightValues& values, const std::vector<SeamSample>& seams)
{
    LightPages pages;
    pages.irradiance = dilate(map, values.irradiance, kDilationRings);
    release(values.irradiance);
    std::vector<ImageRgb32f> direct;
    if (!values.direct.empty()) direct = dilate(map, values.direct, kDilationRings);
    release(values.direct);
    const std::vector<float> weights = lightSeamWeights(seams, pages.irradiance, direct);
    release(direct);
    stitchSeams(map, seams, weights, pages.irradiance);
    if (values.moments.empty()) return pages;
    pages.moments = dilate(map, values.moments, kDilationRings);
    release(values.moments);
    stitchSeams(map, seams, weights, pages.moments);
    return pages;
}

void blackenDark(std::vector<ImageRgb32f>& pages)
{
    std::vector<float> lights;
    for (const ImageRgb32f& page : pages)
        for (const vec3 texel : page.texels())
            if (const float light = luminance(texel); light > 0.0f) lights.push_back(light);
    if (lights.empty()) return;
    const auto high = lights.begin() + std::ptrdiff_t(lights.size() - 1 - lights.size() / 100);
    std::nth_element(lights.begin(), high, lights.end());
    const float least = kDimShare * *high;
    for (ImageRgb32f& page : pages)
        for (vec3& texel : page.texels())
            if (luminance(texel) < least) texel = vec3(0.0f);
}

/// To kMantissaBits. Mantissas that would need another exponent stay below it.
void roundMantissas(std::vector<Image<uint32_t>>& pages)
{
    constexpr uint32_t kAll = 9;
    constexpr uint32_t kStep = 1u << (kAll - kMantissaBits);
    constexpr uint32_t kMost = (1u << kAll) - kStep;
    for (Image<uint32_t>& page : pages) {
        for (uint32_t& texel : page.texels()) {
            for (uint32_t shift = 0; shift < 3 * kAll; shift += kAll) {
                const uint32_t mantissa = (texel >> shift) & ((1u << kAll) - 1);
                const uint32_t rounded = std::min((mantissa + kStep / 2) & ~(kStep - 1), kMost);
                texel = (texel & ~(((1u << kAll) - 1) << shift)) | (rounded << shift);
            }
        }
    }
}

/// To kDirectionBits.
void roundDirections(std::vector<ImageRgba8>& pages)
{
    constexpr int kStep = 1 << (8 - int(kDirectionBits));
    for (ImageRgba8& page : pages)
        for (u8vec4& texel : page.texels())
            for (int c = 0; c < 3; ++c) {
                // In steps from the middle, which is no direction.
                const int steps = int(std::lround(float(int(texel[c]) - 128) / float(kStep)));
                texel[c] = u8vec4::value_type(std::clamp(128 + steps * kStep, 0, 255));
            }
}

/// Whether punctual lights of a component are fully baked.
bool hasBakedLights(const LightComponents& components, const BakedScene& baked, int component)
{
    for (std::size_t i = 0; i < components.ofLight.size(); ++i) {
        const bool baking =
            baked.mode == MixedLightingMode::Subtractive || baked.scene.lights[i].baking.bakeType == LightMode::Baked;
        if (components.ofLight[i] == component && baking) return true;
    }
    return false;
}

/// Whether some of a component's light in the lightmap has not been reflected.
bool hasDirectLight(const LightComponents& components, const BakedScene& baked, int component)
{
    if (std::ranges::count(components.ofSky, component) > 0) return true;
    if (std::ranges::count(components.ofMaterial, component) > 0) return true;
    return hasBakedLights(components, baked, component);
}

/// Pages without light have no texels.
void encodeGroup(const LightPages& pages, BakedGroup& group)
{
    group.unitLux = lightmapUnitFor(pages.irradiance);
    group.lightmaps = encodeLightmap(pages.irradiance, group.unitLux);
    if (group.direct) {
        roundMantissas(group.lightmaps);
        if (!pages.moments.empty()) group.directions = encodeDirections(pages.irradiance, pages.moments);
        roundDirections(group.directions);
    }
    group.peakLux = 0.0f;
    for (std::size_t p = 0; p < pages.irradiance.size(); ++p) {
        float peak = 0.0f;
        for (const vec3 texel : pages.irradiance[p].texels()) peak = std::max({peak, texel.x, texel.y, texel.z});
        group.peakLux = std::max(group.peakLux, peak);
        if (peak > 0.0f) continue;
        group.lightmaps[p] = {};
        if (!group.directions.empty()) group.directions[p] = {};
    }
}

} // namespace

LightComponents componentsOf(const LightGrouping& grouping)
{
    LightComponents components;
    if (grouping.groups.empty()) return components;
    components.count = int(grouping.groups.size()) + 1;
    for (const int group : grouping.ofLight) components.ofLight.push_back(group + 1);
    for (const int group : grouping.ofMaterial) components.ofMaterial.push_back(group + 1);
    for (std::size_t part = 0; part < grouping.ofSky.size(); ++part) components.ofSky[part] = grouping.ofSky[part] + 1;
    return components;
}

Status traceComponents(const BakeRun& run, const CachedIntegrator& cached, PreparedLightmap& lightmap,
                       std::span<IrradianceEstimate> estimates, ComponentSignals& components)
{
    std::vector<ComponentSignals::Content> contents;
    for (int c = 0; c < run.components.count; ++c) {
        const bool reflected = c > 0 && !hasDirectLight(run.components, run.baked(), c); // and nothing else
        contents.push_back(
            {hasBakedLights(run.components, run.baked(), c), run.report().quality.directional && !reflected});
    }
    components = ComponentSignals(estimates.size(), contents);
    if (run.live != nullptr) return run.live->irradiance(cached, lightmap, estimates, components, run.progress);
    return cached.irradianceByComponent(lightmap, estimates, components, run.progress);
}

Status componentPagesStage(const BakeRun& run, const CachedIntegrator& cached, ComponentSignals& components,
                           const std::vector<uint8_t>& valid, const MainLight* main,
                           const std::vector<SeamSample>& seams, BakeReport& report)
{
    BakedScene& baked = run.baked();
    StageTimer timer(report, "group pages");
    std::vector<LightValues> values;
    for (Signals& signals : components.components()) {
        const std::size_t c = values.size();
        LightValues& own = values.emplace_back(valuesOf(signals));
        if (main == nullptr) continue;
        vec3& color = c > 0 ? baked.groups[c - 1].shadowColor : baked.defaultShadowColor;
        color = chooseShadowColor(*main, own.irradiance, valid, run.settings.subtractiveMask);
        if (std::size_t(run.components.ofLight[main->light]) == c) addMainLight(*main, own);
    }
    components = {}; // its lists are released
    fillAll(cached, valid, values);
    run.result.groupIrradiance.resize(baked.groups.size());
    for (std::size_t c = 0; c < values.size(); ++c) {
        if (run.progress.cancelled()) return cancelledError();
        LightPages pages = pagesOf(cached.map, values[c], seams);
        if (c > 0) {
            blackenDark(pages.irradiance);
            baked.groups[c - 1].direct = hasDirectLight(run.components, baked, int(c));
            encodeGroup(pages, baked.groups[c - 1]);
            run.result.groupIrradiance[c - 1] = std::move(pages.irradiance);
            continue;
        }
        baked.lightmapUnitLux = lightmapUnitFor(pages.irradiance);
        baked.lightmaps = encodeLightmap(pages.irradiance, baked.lightmapUnitLux);
        if (!pages.moments.empty()) baked.lightmapDirections = encodeDirections(pages.irradiance, pages.moments);
        run.result.irradiance = std::move(pages.irradiance);
    }
    if (run.live != nullptr && main == nullptr) run.live->finish(run.result.irradiance, run.result.groupIrradiance);
    timer.finish();
    return {};
}

void addLayersOfComponents(BakedProbes& probes)
{
    for (std::vector<SphericalHarmonicsL2>& light : probes.components) {
        ProbeSet own = probes.set;
        for (std::size_t i = 0; i < light.size(); ++i) own.probes[i].radiance = light[i];
        if (!addProbeLayers(own)) return;
        light.clear();
        for (const Probe& probe : own.probes) light.push_back(probe.radiance);
    }
}

void keepComponentsOfProbes(const BakedProbes& probes, BakedScene& baked)
{
    for (std::size_t c = 0; c < probes.components.size(); ++c) {
        if (c > 0) {
            baked.groups[c - 1].radiance = probes.components[c];
            continue;
        }
        for (std::size_t i = 0; i < baked.probes.probes.size(); ++i)
            baked.probes.probes[i].radiance = probes.components[0][i];
    }
}

WhitePages whitePages(const BakeResult& result)
{
    WhitePages pages;
    pages.irradiance = result.irradiance;
    pages.components.lightmaps.emplace_back(result.irradiance);
    for (const std::vector<ImageRgb32f>& group : result.groupIrradiance) {
        pages.components.lightmaps.emplace_back(group);
        for (std::size_t p = 0; p < pages.irradiance.size(); ++p)
            for (std::size_t i = 0; i < pages.irradiance[p].texelCount(); ++i)
                pages.irradiance[p].data()[i] += group[p].data()[i];
    }
    if (result.baked.lightmapDirections.empty()) return pages;
    BakedScene all;
    all.lightmaps = result.baked.lightmaps;
    all.lightmapUnitLux = result.baked.lightmapUnitLux;
    all.lightmapDirections = result.baked.lightmapDirections;
    for (const BakedGroup& group : result.baked.groups) {
        BakedGroup& copy = all.groups.emplace_back();
        copy.unitLux = group.unitLux;
        copy.lightmaps = group.lightmaps;
        copy.directions = group.directions;
    }
    composeGroups(all, std::vector<vec3>(all.groups.size(), vec3(1.0f)));
    pages.directions = std::move(all.lightmapDirections);
    return pages;
}

namespace {

/// Light of a bake with brighter white, as LightGroup::finished has it.
void scaleWhite(float factor, BakedGroup& group, std::vector<ImageRgb32f>& irradiance)
{
    if (factor == 1.0f) return;
    group.weight /= factor;
    group.unitLux *= factor;
    group.peakLux *= factor;
    group.shadowColor *= factor;
    group.reflections.unitNits *= factor;
    for (SphericalHarmonicsL2& probe : group.radiance)
        for (vec3& coefficient : probe) coefficient *= factor;
    for (ImageRgb32f& page : irradiance)
        for (vec3& texel : page.texels()) texel *= factor;
}

} // namespace

Result<LightGrouping> beginGroups(GroupChoice choice, MixedLightingMode mode, Scene& scene, BakedScene& baked)
{
    for (Material& material : scene.materials) material.bakedGroup = -1; // of an earlier bake
    for (Light& light : scene.lights) light.baking.turning = {};
    Result<LightGrouping> grouping = groupLights(scene, choice, mode);
    if (!grouping) return grouping;
    grouping->exchange(scene);
    grouping->spread(scene);
    for (std::size_t g = 0; g < grouping->groups.size(); ++g) {
        BakedGroup& group = baked.groups.emplace_back();
        group.name = grouping->groups[g].name;
        group.weight = grouping->groups[g].weight;
        group.sky = std::ranges::count(grouping->ofSky, int(g)) > 0;
    }
    return grouping;
}

void finishGroups(LightGrouping& grouping, BakeResult& result)
{
    if (grouping.groups.empty()) return;
    BakedScene& baked = result.baked;
    Scene& scene = baked.scene;
    grouping.gather(scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        Light& light = scene.lights[i];
        light.baking.group = grouping.ofLight[i];
        light.baking.white = light.color * light.intensity;
    }
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        scene.materials[i].bakedGroup = grouping.ofMaterial[i];
        scene.materials[i].whiteNits = scene.materials[i].emissiveNits;
    }
    grouping.exchange(scene);
    for (Light& light : scene.lights)
        if (light.baking.group >= 0 || turns(light)) light.baking.atBake.colorIntensity = light.color * light.intensity;
    for (std::size_t g = 0; g < baked.groups.size(); ++g)
        scaleWhite(grouping.groups[g].finished, baked.groups[g], result.groupIrradiance[g]);
}

} // namespace halflight
