#include "bake/live/live_light.h"

#include "bake/geometry/flatten.h"
#include "bake/geometry/indices.h"
#include "bake/lights/channels.h"
#include "bake/probes/probes.h"

#include "halflight/base/rgb9e5.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>

namespace halflight {
namespace {

/// Texels along a side of the squares that first light has a sample in; more where that makes more than kMostSquares.
constexpr int kSquareSide = 2;
constexpr std::size_t kMostSquares = 8192;
/// Paths of a sample: with its neighbours' about 64, whose noise does not hide the light.
constexpr int kPathsOfSample = 16;
/// How much brighter than first light the lightmap may get before it is clamped.
constexpr float kHeadroom = 8.0f;
/// Texels until the first look at the view; then so many as take about a second, since each request computes some
/// texels beside its own, and threads wait for its end.
constexpr std::size_t kFirstTexels = 16'384;
constexpr double kSecondsAtOnce = 1.0;

/// A grid of light probes, roughly.
Result<ProbeSet> roughProbes(const Scene& scene, float spacingMeters, Integrator& integrator, const Progress& progress)
{
    std::vector<std::string> unread; // the bake says it
    ProbeSet set = probeGrid(scene, spacingMeters, unread);
    std::vector<vec3> positions;
    for (const Probe& probe : set.probes) positions.push_back(probe.position);
    std::vector<ProbeEstimate> estimates(positions.size());
    const std::vector<uint32_t> all = allIndices(positions.size());
    if (Status s = integrator.probes(positions, all, kPathsOfSample, estimates, progress); !s) return s.error();
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        set.probes[i].radiance = estimates[i].radiance;
        set.probes[i].valid = estimates[i].valid;
    }
    fillInvalidProbes(set);
    return set;
}

/// No mask is there yet: lights with a channel are realtime lights of baked indirect.
void withoutMask(BakedScene& light)
{
    light.mode = MixedLightingMode::BakedIndirect;
    for (Light& each : light.scene.lights) {
        BakingOutput& baking = each.baking;
        baking.group = -1; // of an earlier bake
        baking.turning = {};
        if (!baking.isBaked || baking.bakeType != LightMode::Mixed) continue;
        // Subtractive bakes have the direct light of all but the main light in the lightmap.
        if (baking.mixedMode == MixedLightingMode::Subtractive && baking.occlusionMaskChannel < 0)
            baking.bakeType = LightMode::Baked;
        baking.mixedMode = MixedLightingMode::BakedIndirect;
        baking.occlusionMaskChannel = -1;
        baking.coloredMask = false;
    }
}

} // namespace

void LiveLight::setGroups(const LightGrouping& grouping, const IntegratorFactory& factory)
{
    grouping_ = grouping;
    factors_.clear();
    for (const LightGroup& group : grouping.groups) factors_.push_back(group.weight * group.finished);
    factory_ = &factory;
}

void LiveLight::takeOwnLight(Scene& scene) const
{
    if (!grouping_) return;
    LightGrouping own = *grouping_;
    own.gather(scene);
    own.exchange(scene);
}

Status LiveLight::roughIrradiance(const Scene& own, const CachedIntegrator& cached, std::span<const uint32_t> texels,
                                  std::vector<vec3>& light, const Progress& progress) const
{
    std::unique_ptr<Integrator> integrator;
    if (grouping_) { // that of the bake has white light
        IntegrationSettings few = cached.settings;
        few.components = {};
        few.fewRays = true;
        Result<std::unique_ptr<Integrator>> made = factory_->make(own, cached.geometry, few);
        if (!made) return made.error();
        integrator = std::move(*made);
    }
    TexelRequest request{texels, kPathsOfSample};
    request.rough = true;
    std::vector<IrradianceEstimate> estimates(texels.size());
    const std::unique_ptr<PreparedLightmap> lightmap =
        integrator != nullptr ? integrator->prepare(cached.map, nullptr) : cached.prepare();
    if (Status s = lightmap->irradiance(request, estimates, progress); !s) return s;
    for (const IrradianceEstimate& estimate : estimates) light.push_back(estimate.irradiance);
    return {};
}

Status LiveLight::beginWithProbes(Scene scene, const BakeSettings& settings, const IntegratorFactory& factory,
                                  const IntegrationSettings& integration, const Progress& progress)
{
    progress("first light", 0.0);
    BakedScene light;
    light.isBaked = true;
    light.scene = std::move(scene);
    takeOwnLight(light.scene);
    for (Object& object : light.scene.objects) object.lightmap = {};
    assignShadowmaskChannels(light.scene, settings.mode, settings.mostMaskLayers);
    limitBounces(light.scene, integration);
    const BakeGeometry geometry = flattenGeometry(light.scene, 1, GeometryFilter::Static);
    IntegrationSettings few = integration;
    few.fewRays = true;
    few.components = {};
    Result<std::unique_ptr<Integrator>> integrator = factory.make(light.scene, geometry, few);
    if (!integrator) return {}; // the bake finds the same, and says it
    const Progress quiet{{}, progress.cancel};
    Result<ProbeSet> probes = roughProbes(light.scene, settings.probeSpacingMeters, **integrator, quiet);
    if (!probes) return probes.error();
    integrator->reset();
    probes_ = std::move(*probes);
    light.probes = probes_;
    withoutMask(light);

    {
        const std::lock_guard lock(mutex_);
        probeLight_ = std::move(light);
    }
    constexpr std::chrono::milliseconds kLook(5);
    while (waits_ && !progress.cancelled()) std::this_thread::sleep_for(kLook);
    return progress.cancelled() ? Status(cancelledError()) : Status();
}

Status LiveLight::begin(const BakedScene& scene, const CachedIntegrator& cached, const Progress& progress)
{
    progress("first light", 0.0);
    const TexelMap& map = cached.map;
    const Progress quiet{{}, progress.cancel};
    int side = kSquareSide;
    while (map.texels.size() / std::size_t(side * side) > kMostSquares) side *= 2;
    const std::vector<uint32_t> texels = sampleTexels(map, side);
    BakedScene light = scene;
    light.groups.clear();
    takeOwnLight(light.scene);
    std::vector<vec3> values;
    if (Status s = roughIrradiance(light.scene, cached, texels, values, quiet); !s) return s;
    progress("first light", 0.5);
    LivePages pages(map);
    pages.spread(texels, values, side);
    light.probes = std::move(probes_);
    withoutMask(light);
    while (kHeadroom * pages.brightest() > kMaxRgb9e5 * light.lightmapUnitLux) light.lightmapUnitLux *= 2.0f;
    light.lightmaps = pages.takeAll(light.lightmapUnitLux);
    progress("first light", 1.0);

    const std::lock_guard lock(mutex_);
    map_ = &map;
    pages_.emplace(std::move(pages));
    unitLux_ = light.lightmapUnitLux;
    light_ = std::move(light);
    return {};
}

Status LiveLight::irradiance(const CachedIntegrator& cached, PreparedLightmap& lightmap,
                             std::span<IrradianceEstimate> out, ComponentSignals& components, const Progress& progress)
{
    const TexelMap& map = cached.map;
    const std::size_t count = components.count();
    TexelOrder order = cached.cache != nullptr
                           ? TexelOrder::ofRuns(cached.geometry, map, texelsOfPart(map.texels.size()))
                           : TexelOrder::ofCharts(cached.geometry, map);
    std::vector<uint32_t> texels;
    std::vector<IrradianceEstimate> estimates;
    std::vector<IrradianceEstimate> parts;
    std::size_t atOnce = kFirstTexels;
    std::size_t done = 0;
    while (done < map.texels.size()) {
        const auto start = std::chrono::steady_clock::now();
        std::vector<std::size_t> pieces = order.next(view(), atOnce);
        std::sort(pieces.begin(), pieces.end()); // requests are ascending
        texels.clear();
        for (const std::size_t piece : pieces)
            texels.insert(texels.end(), order.texelsOf(piece).begin(), order.texelsOf(piece).end());
        std::sort(texels.begin(), texels.end());
        const double share = 1.0 / double(map.texels.size());
        const Progress part = partOf(progress, double(done) * share, double(done + texels.size()) * share);
        if (cached.cache != nullptr) {
            if (Status s = cached.irradianceOfParts(lightmap, pieces, out, components, part); !s) return s;
        } else {
            estimates.assign(texels.size(), {});
            parts.assign(texels.size() * count, {});
            const Status traced = count > 0 ? lightmap.irradianceByComponent({texels}, estimates, parts, part)
                                            : lightmap.irradiance({texels}, estimates, part);
            if (!traced) return traced;
            for (std::size_t i = 0; i < texels.size(); ++i) {
                out[texels[i]] = estimates[i];
                components.set(texels[i], std::span(parts).subspan(i * count, count));
            }
        }
        done += texels.size();
        show(map, texels, out, components);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        const double fitting = double(texels.size()) * kSecondsAtOnce / std::max(taken.count(), 1.0e-3);
        atOnce = std::clamp(std::size_t(fitting), kFirstTexels / 4, 2 * atOnce);
    }
    return {};
}

void LiveLight::show(const TexelMap& map, std::span<const uint32_t> texels, std::span<const IrradianceEstimate> all,
                     const ComponentSignals& components)
{
    const std::lock_guard lock(mutex_);
    if (!pages_ || map_ != &map) return;
    for (const uint32_t texel : texels) {
        if (!all[texel].valid) continue;
        vec3 light = all[texel].irradiance;
        if (components.count() > 0) {
            light = components.irradiance(texel, 0); // the rest
            for (std::size_t g = 0; g < factors_.size(); ++g)
                light += factors_[g] * components.irradiance(texel, g + 1);
        }
        pages_->set(texel, light);
    }
}

void LiveLight::finish(const std::vector<ImageRgb32f>& pages, const std::vector<std::vector<ImageRgb32f>>& groups)
{
    const std::lock_guard lock(mutex_);
    if (!pages_) return;
    for (std::size_t i = 0; i < map_->texels.size(); ++i) {
        const Texel& texel = map_->texels[i];
        vec3 light = pages[texel.page](texel.x, texel.y);
        for (std::size_t g = 0; g < groups.size(); ++g) light += factors_[g] * groups[g][texel.page](texel.x, texel.y);
        pages_->set(uint32_t(i), light);
    }
}

void LiveLight::setWaits(bool waits)
{
    waits_ = waits;
}

void LiveLight::setView(const BakeView& view)
{
    const std::lock_guard lock(mutex_);
    view_ = view;
}

std::optional<BakeView> LiveLight::view() const
{
    const std::lock_guard lock(mutex_);
    return view_;
}

std::optional<BakedScene> LiveLight::takeProbeLight()
{
    const std::lock_guard lock(mutex_);
    return std::exchange(probeLight_, std::nullopt);
}

std::optional<BakedScene> LiveLight::takeLight()
{
    const std::lock_guard lock(mutex_);
    if (light_) {
        taken_ = true;
        probeLight_.reset();
    }
    return std::exchange(light_, std::nullopt);
}

std::vector<LightTile> LiveLight::takeTiles()
{
    const std::lock_guard lock(mutex_);
    return taken_ && pages_ ? pages_->takeChanged(unitLux_) : std::vector<LightTile>();
}

} // namespace halflight
