#include "bake/group_stages.h"

#include "bake/denoise/denoise.h"
#include "bake/geometry/indices.h"
#include "bake/pages/dilate.h"
#include "bake/pages/encode.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/scene/probe_cells.h"

#include <algorithm>

namespace halflight {
namespace {

/// Texels darker than this share of the 99th percentile are black, so that they take no bytes.
constexpr float kDarkShare = 1.0f / 4096.0f;

/// Pages of one component, lux.
struct LightPages {
    std::vector<ImageRgb32f> irradiance;
    std::vector<ImageRgb32f> moments; ///< empty without directions
};

/// `main`: subtractive's main light where it belongs to the component, else null.
LightPages pagesOf(const CachedIntegrator& cached, const std::vector<IrradianceEstimate>& estimates,
                   const MainLight* main, const std::vector<uint8_t>& valid, const std::vector<SeamSample>& seams,
                   bool directional)
{
    LightPages pages;
    TexelValues values = splitEstimates(estimates);
    if (main != nullptr) {
        main->addTo(values.irradiance);
        main->addTo(values.direct);
    }
    fillInvalid(cached.geometry, cached.map, valid, values.irradiance);
    fillInvalid(cached.geometry, cached.map, valid, values.direct);
    pages.irradiance = dilate(cached.map, values.irradiance, kDilationRings);
    const std::vector<float> weights =
        lightSeamWeights(seams, pages.irradiance, dilate(cached.map, values.direct, kDilationRings));
    stitchSeams(cached.map, seams, weights, pages.irradiance);
    if (!directional) return pages;
    std::vector<vec3>& moments = values.irradiance;
    forEachIndex(moments.size(), [&](std::size_t i) { moments[i] = estimates[i].moment; });
    if (main != nullptr) main->addMomentTo(moments);
    fillInvalid(cached.geometry, cached.map, valid, moments);
    pages.moments = dilate(cached.map, moments, kDilationRings);
    stitchSeams(cached.map, seams, weights, pages.moments);
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
    const float least = kDarkShare * *high;
    for (ImageRgb32f& page : pages)
        for (vec3& texel : page.texels())
            if (luminance(texel) < least) texel = vec3(0.0f);
}

/// Pages without light have no texels.
void encodeGroup(const LightPages& pages, BakedGroup& group)
{
    group.unitLux = lightmapUnitFor(pages.irradiance);
    group.lightmaps = encodeLightmap(pages.irradiance, group.unitLux);
    if (!pages.moments.empty()) group.directions = encodeDirections(pages.irradiance, pages.moments);
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
    components.ofSky = grouping.ofSky + 1;
    return components;
}

Status traceComponents(const CachedIntegrator& cached, PreparedLightmap& lightmap,
                       std::span<IrradianceEstimate> estimates, std::vector<IrradianceEstimate>& components,
                       const Progress& progress)
{
    components = largeVector<IrradianceEstimate>(estimates.size() * std::size_t(cached.settings.components.count));
    return cached.irradianceByComponent(lightmap, estimates, components, progress);
}

Status componentPagesStage(const BakeRun& run, const CachedIntegrator& cached,
                           std::vector<IrradianceEstimate>& components, const std::vector<uint8_t>& valid,
                           const MainLight* main, const std::vector<SeamSample>& seams, BakeReport& report)
{
    BakedScene& baked = run.baked();
    const bool directional = run.report().quality.directional;
    const std::size_t count = baked.groups.size() + 1;
    StageTimer timer(report, "group pages");
    std::vector<IrradianceEstimate> own = largeVector<IrradianceEstimate>(cached.map.texels.size());
    run.result.groupIrradiance.resize(baked.groups.size());
    for (std::size_t c = 0; c < count; ++c) {
        forEachIndex(own.size(), [&](std::size_t i) { own[i] = components[i * count + c]; });
        const bool lit = std::ranges::any_of(own, [](const auto& e) { return e.irradiance != vec3(0.0f); });
        if (lit && run.settings.denoiser != Denoiser::Off)
            denoise(cached.geometry, cached.map, seams, own, directional);
        if (run.progress.cancelled()) return cancelledError();
        if (main != nullptr) {
            vec3& color = c > 0 ? baked.groups[c - 1].shadowColor : baked.defaultShadowColor;
            color = chooseShadowColor(*main, splitEstimates(own).irradiance, valid, run.settings.subtractiveMask);
        }
        const bool holdsMain = main != nullptr && std::size_t(run.components.ofLight[main->light]) == c;
        LightPages pages = pagesOf(cached, own, holdsMain ? main : nullptr, valid, seams, directional);
        if (c > 0) {
            blackenDark(pages.irradiance);
            encodeGroup(pages, baked.groups[c - 1]);
            run.result.groupIrradiance[c - 1] = std::move(pages.irradiance);
            continue;
        }
        baked.lightmapUnitLux = lightmapUnitFor(pages.irradiance);
        baked.lightmaps = encodeLightmap(pages.irradiance, baked.lightmapUnitLux);
        if (directional) baked.lightmapDirections = encodeDirections(pages.irradiance, pages.moments);
        run.result.irradiance = std::move(pages.irradiance);
    }
    release(components);
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

std::vector<ImageRgb32f> composedPages(const BakeResult& result)
{
    std::vector<ImageRgb32f> pages = result.irradiance;
    for (std::size_t g = 0; g < result.groupIrradiance.size(); ++g) {
        const vec3 weight = result.baked.groups[g].weight;
        for (std::size_t p = 0; p < pages.size(); ++p)
            for (std::size_t i = 0; i < pages[p].texelCount(); ++i)
                pages[p].data()[i] += weight * result.groupIrradiance[g][p].data()[i];
    }
    return pages;
}

namespace {

/// Gives the scene its own light back, and what the bake had of it.
void finishGroups(LightGrouping& grouping, BakedScene& baked)
{
    Scene& scene = baked.scene;
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
        if (light.baking.group >= 0) light.baking.atBake.colorIntensity = light.color * light.intensity;
}

} // namespace

Result<LightGrouping> beginGroups(GroupChoice choice, Scene& scene, BakedScene& baked)
{
    for (Material& material : scene.materials) material.bakedGroup = -1; // of an earlier bake
    Result<LightGrouping> grouping = groupLights(scene, choice);
    if (!grouping) return grouping;
    grouping->exchange(scene);
    for (std::size_t g = 0; g < grouping->groups.size(); ++g)
        baked.groups.push_back({grouping->groups[g].name, grouping->groups[g].weight, grouping->ofSky == int(g)});
    return grouping;
}

Status withOwnLight(const BakeRun& run, LightGrouping& grouping, const IntegratorFactory& factory, FirstStages& stages)
{
    if (grouping.groups.empty()) return {};
    finishGroups(grouping, run.baked());
    if (!run.settings.reflectionProbes) return {};
    stages.integration.components = {};
    auto integrator = factory.make(run.baked().scene, stages.geometry, stages.integration);
    if (!integrator) return integrator.error();
    stages.integrator = std::move(*integrator);
    return {};
}

} // namespace halflight
