#include "halflight/bake/bake.h"

#include "bake/cache/cached_integrator.h"
#include "bake/denoise_stages.h"
#include "bake/first_stages.h"
#include "bake/group_stages.h"
#include "bake/lights/main_light.h"
#include "bake/live/live_light.h"
#include "bake/mask_stages.h"
#include "bake/pages/dilate.h"
#include "bake/pages/encode.h"
#include "bake/pages/stage_images.h"
#include "bake/probes/probes.h"
#include "bake/reflections/reflections.h"
#include "bake/reflections/specular_points.h"
#include "bake/report/bake_report.h"
#include "bake/seams/seams.h"
#include "bake/sides/hidden_sides.h"
#include "bake/time_limit.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/system.h"
#include "halflight/scene/probe_cells.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace halflight {
namespace {

/// Estimates of all texels; in subtractive bakes also the main light's mask and direct light.
Status lightmapStage(const BakeRun& run, const CachedIntegrator& cached, std::unique_ptr<PreparedLightmap> lightmap,
                     std::vector<IrradianceEstimate>& estimates, ComponentSignals& components,
                     std::optional<MainLight>& main)
{
    BakeReport& report = run.report();
    Integrator& integrator = cached.integrator;
    StageTimer timer(report, "lightmap");
    const uint64_t earlier = integrator.raysTraced();
    // What texels have in common takes the most memory, and is there before lists by texel. A cache may have it all.
    if (cached.cache == nullptr)
        if (Status s = lightmap->prepareAll(run.progress); !s) return s;
    estimates = largeVector<IrradianceEstimate>(cached.map.texels.size());
    const Status status = run.components.count > 0 ? traceComponents(run, cached, *lightmap, estimates, components)
                          : run.live != nullptr
                              ? run.live->irradiance(cached, *lightmap, estimates, components, run.progress)
                              : cached.irradiance(*lightmap, estimates, run.progress);
    if (!status) return status;
    lightmap.reset(); // what the texels have in common
    timer.finish(integrator.raysTraced() - earlier);
    main = findMainLight(run.baked().scene);
    if (main) {
        StageTimer mainTimer(report, "main light");
        const uint64_t before = integrator.raysTraced();
        if (Status s = bakeMainLight(cached, *main, run.progress); !s) return s;
        mainTimer.finish(integrator.raysTraced() - before);
    }
    reportNoise(estimates, main, report);
    if (run.images != nullptr && !run.settings.imagesDirectory.empty()) {
        std::vector<vec3> raw = splitEstimates(estimates).irradiance;
        if (main) main->addTo(raw);
        run.noteImages(dumpPages(run.settings, "lightmap_raw", dilate(cached.map, raw, 0), *run.images));
    }
    return {};
}

/// From estimates to encoded pages. Arrays are released as soon as they are no longer needed, `estimates` too.
Status lightmapPagesStage(const BakeRun& run, const CachedIntegrator& cached,
                          std::vector<IrradianceEstimate>& estimates, const std::vector<uint8_t>& valid,
                          const std::optional<MainLight>& main, const std::vector<SeamSample>& seams,
                          BakeReport& report)
{
    BakedScene& baked = run.baked();
    TexelValues values = splitEstimates(estimates);
    const bool directional = run.report().quality.directional;
    std::vector<vec3> moments(directional ? estimates.size() : 0);
    forEachIndex(moments.size(), [&](std::size_t i) { moments[i] = estimates[i].moment; });
    release(estimates);
    if (main) {
        baked.defaultShadowColor = chooseShadowColor(*main, values.irradiance, valid, run.settings.subtractiveMask);
        main->addTo(values.irradiance);
        main->addTo(values.direct);
    }
    StageTimer fillTimer(report, "fill");
    if (main && directional) main->addMomentTo(moments);
    std::vector<std::vector<vec3>*> quantities{&values.irradiance, &values.direct};
    if (directional) quantities.push_back(&moments);
    fillInvalid<vec3>(cached.geometry, cached.map, valid, quantities);
    fillTimer.finish();
    StageTimer timer(report, "seams");
    std::vector<ImageRgb32f>& pages = run.result.irradiance;
    pages = dilate(cached.map, values.irradiance, kDilationRings);
    release(values.irradiance);
    const std::vector<float> weights =
        lightSeamWeights(seams, pages, dilate(cached.map, values.direct, kDilationRings));
    release(values.direct);
    stitchSeams(cached.map, seams, weights, pages);
    timer.finish();
    if (run.progress.cancelled()) return cancelledError();
    // Until the bake ends, a main light is drawn in realtime, and must not come twice.
    if (run.live != nullptr && !main) run.live->finish(pages, {});
    StageTimer encodeTimer(report, "encode");
    baked.lightmapUnitLux = lightmapUnitFor(pages);
    baked.lightmaps = encodeLightmap(pages, baked.lightmapUnitLux);
    encodeTimer.finish();
    if (!directional) return {};
    std::vector<ImageRgb32f> momentPages = dilate(cached.map, moments, kDilationRings);
    stitchSeams(cached.map, seams, weights, momentPages);
    baked.lightmapDirections = encodeDirections(pages, momentPages);
    return {};
}

Status probeStage(const BakeRun& run, const CachedIntegrator& cached)
{
    BakeReport& report = run.report();
    BakedScene& baked = run.baked();
    StageTimer timer(report, "probes");
    const uint64_t before = cached.integrator.raysTraced();
    Result<BakedProbes> probes = bakeProbes(baked.scene, run.settings.probeSpacingMeters, run.settings.probeLayout,
                                            cached.settings.cache.denoised, cached, report.warnings, run.progress);
    if (!probes) return probes.error();
    addLayersOfComponents(*probes);
    baked.probes = std::move(probes->set);
    if (addProbeLayers(baked.probes) && run.settings.probeLayout == ProbeLayout::Grid)
        report.warnings.push_back(
            "probes: those outside geometry lie in one plane, so the file holds a list of them and "
            "their copies above, and no grid; a smaller --probe-spacing gives more layers");
    Result<ProbeSight> sight = findProbeSight(baked.probes, cached.integrator, run.progress);
    if (!sight) return sight.error();
    baked.probes.sight = std::move(*sight);
    report.probeCheck = checkProbes(baked, *probes, report.warnings);
    keepComponentsOfProbes(*probes, baked);
    report.probeCount = int(baked.probes.probes.size());
    report.validProbeCount = int(
        std::count_if(baked.probes.probes.begin(), baked.probes.probes.end(), [](const Probe& p) { return p.valid; }));
    timer.finish(cached.integrator.raysTraced() - before);
    return {};
}

Status reflectionStage(const BakeRun& run, const CachedIntegrator& cached)
{
    if (!run.settings.reflectionProbes) return {};
    BakeReport& report = run.report();
    StageTimer timer(report, "reflection probes");
    const uint64_t before = cached.integrator.raysTraced();
    const bool grouped = run.components.count > 0;
    const WhitePages white = grouped ? whitePages(run.result) : WhitePages();
    const LightmapPages pages = grouped ? LightmapPages{white.irradiance, white.directions}
                                        : LightmapPages{run.result.irradiance, run.baked().lightmapDirections};
    if (Status s = bakeReflections(run.baked(), cached, pages, white.components, report.quality.reflectionSize,
                                   report.warnings, run.progress);
        !s)
        return s;
    report.reflectionProbeCount = int(run.baked().reflections.probes.size());
    timer.finish(cached.integrator.raysTraced() - before);
    return {};
}

/// Which sample points are valid, and the seams: one thread finds these for much of the time, beside rays.
Status validityAndSeams(const BakeRun& run, FirstStages& firstStages, std::vector<SeamSample>& seams)
{
    BakeReport seamsReport; // of the background, which must not write to the bake's own
    seamsReport.began = run.report().began;
    Background background;
    background.run([&] {
        StageTimer timer(seamsReport, "find seams");
        seams = findSeams(firstStages.geometry, firstStages.map.pageSize);
        timer.finish();
    });
    Status tested;
    inIsolation([&] { tested = validityStage(run, firstStages); });
    background.wait();
    if (!tested) return tested;
    run.report().stages.push_back(seamsReport.stages.front());
    return dropHiddenSeams(*firstStages.integrator, seams);
}

/// All stages that trace rays or work on their results.
class TraceStages {
public:
    /// `began`: when the bake did, by secondsNow().
    TraceStages(const BakeRun& run, const CachedIntegrator& cached, const DeviceDenoiser& denoiser, double began,
                std::vector<SeamSample> seams)
        : run_(run), cached_(cached), denoiser_(denoiser), began_(began), lightmap_(cached.prepare()),
          valid_(validTexels(cached.map)), seams_(std::move(seams))
    {
        pagesReport_.began = masksReport_.began = run.report().began;
    }

    Status trace()
    {
        const bool timed = run_.settings.seconds > 0.0;
        if (timed) {
            // What is left for the lightmap is known once the others are done.
            if (Status s = masksAndProbes(); !s) return s;
            masks_.wait();
            if (Status s = chooseSamples(run_, began_, cached_, *lightmap_); !s) return s;
        }
        if (Status s = lightmapStage(run_, cached_, std::move(lightmap_), estimates_, components_, main_); !s) return s;
        if (Status s = denoise(); !s) return s;
        // Pages are made in the background while others trace: to make seams equal takes one thread a while.
        Status made;
        Status traced;
        pages_.run([&] {
            made = isGrouped() ? componentPages()
                               : lightmapPagesStage(run_, cached_, estimates_, valid_, main_, seams_, pagesReport_);
        });
        if (!timed) inIsolation([&] { traced = masksAndProbes(); });
        pages_.wait();
        if (!traced) return traced;
        if (!made) return made;
        Status reflected;
        inIsolation([&] { reflected = reflectionStage(run_, cached_); }); // beside the last of the masks' pages
        if (!reflected) return reflected;
        masks_.wait();
        return finish();
    }

private:
    [[nodiscard]] bool isGrouped() const { return run_.components.count > 0; }

    /// Components have the light where there are some: estimates are released.
    Status denoise()
    {
        if (!isGrouped()) return denoiseStage(run_, cached_, seams_, denoiser_, estimates_);
        samples_ = largeVector<uint8_t>(estimates_.size());
        forEachIndex(samples_.size(), [&](std::size_t i) { samples_[i] = DenoiserTexels::samplesOf(estimates_[i]); });
        release(estimates_);
        return denoiser_ ? denoiseComponentsNow(run_.report()) : Status();
    }
    Status denoiseComponentsNow(BakeReport& report)
    {
        return denoiseStage(run_, cached_, seams_, denoiser_, valid_, samples_, components_, report);
    }
    /// A device has denoised before others trace there. The processor does it while they trace.
    Status componentPages()
    {
        if (!denoiser_)
            if (Status s = denoiseComponentsNow(pagesReport_); !s) return s;
        return componentPagesStage(run_, cached_, components_, valid_, main_ ? &*main_ : nullptr, seams_, pagesReport_);
    }

    Status masksAndProbes()
    {
        if (Status s = shadowmaskStage(run_, cached_, valid_, seams_, masksReport_, masks_); !s) return s;
        return probeStage(run_, cached_);
    }

    Status finish()
    {
        BakeReport& report = run_.report();
        for (const BakeReport* pages : {&pagesReport_, &masksReport_})
            report.stages.insert(report.stages.end(), pages->stages.begin(), pages->stages.end());
        std::ranges::stable_sort(report.stages, {}, &StageReport::start);
        if (run_.images != nullptr)
            run_.noteImages(dumpPages(run_.settings, "lightmap", run_.result.irradiance, *run_.images));
        BakedScene& baked = run_.baked();
        for (LightReport& light : report.lights)
            light.distanceMask =
                light.channel >= 0 && baked.maskChannels[std::size_t(light.channel)].rangeTexels > 0.0f;
        if (main_) {
            if (run_.settings.subtractiveMask)
                baked.shadowmasks = maskPages(cached_, valid_, seams_, main_->mask(), kLayerChannels,
                                              std::span(baked.maskChannels).first<kLayerChannels>());
            reportMainLight(baked, *main_, run_.settings, report);
        }
        return {};
    }

    const BakeRun& run_;
    const CachedIntegrator& cached_;
    const DeviceDenoiser& denoiser_;
    double began_;
    std::unique_ptr<PreparedLightmap> lightmap_; ///< of the time before the lightmap
    ComponentSignals components_;                ///< of bakes with light groups
    std::vector<IrradianceEstimate> estimates_;
    std::vector<uint8_t> samples_; ///< of components: DenoiserTexels::samples
    std::vector<uint8_t> valid_;
    std::vector<SeamSample> seams_;
    std::optional<MainLight> main_;
    BakeReport pagesReport_; ///< of the background, which must not write to the bake's own
    BakeReport masksReport_;
    Background pages_; ///< of the lightmap; ends before what it works on
    Background masks_; ///< pages of mask layers
};

} // namespace

std::string cacheWarning(const std::filesystem::path& folder, const Error& error)
{
    return "the cache " + folder.string() + " is not complete, so the next bake computes more: " + error.message;
}

namespace {

/// bake() with one kind of integrators.
Result<BakeResult> bakeWith(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                            const Progress& progress, LiveLight* live)
{
    const auto start = StageTimer::Clock::now();
    const double began = secondsNow(settings);
    if (settings.seconds > 0.0 &&
        (settings.samples > 0 || settings.noiseTarget > 0.0f || !settings.cacheDirectory.empty()))
        return Error{ErrorCode::InvalidArgument, "a bake that ends at a time chooses its samples, and uses no cache"};
    const ThreadLimit threads(settings.threads);
    BakeResult result;
    BakeReport& report = result.report;
    FileGroup images;
    Result<LightGrouping> grouping = beginGroups(settings.groups, settings.mode, scene, result.baked);
    if (!grouping) return grouping.error();
    if (live != nullptr && !grouping->groups.empty()) live->setGroups(*grouping, integratorFactory);
    const BakeRun run{settings, progress, result, live, &images, componentsOf(*grouping)};
    FirstStages firstStages;
    if (Status status = prepareTexels(run, std::move(scene), integratorFactory, CacheUse{}, firstStages); !status)
        return status.error();
    if (live != nullptr)
        if (Status s = live->begin(result.baked, firstStages.cached(), progress); !s) return s.error();
    std::vector<SeamSample> seams;
    if (Status status = validityAndSeams(run, firstStages, seams); !status) return status.error();
    std::optional<BakeCache>& cache = firstStages.cache;
    const CachedIntegrator cached = firstStages.cached();
    if (Status status = TraceStages(run, cached, integratorFactory.denoise, began, std::move(seams)).trace(); !status)
        return status.error();
    finishGroups(*grouping, result);

    if (cache) {
        cache->finish();
        if (!cache->status()) report.warnings.push_back(cacheWarning(settings.cacheDirectory, cache->status().error()));
        report.cache = cache->counts();
        report.warnings.insert(report.warnings.end(), firstStages.notes.begin(), firstStages.notes.end());
        if (cache->lostTiles() > 0) {
            report.warnings.push_back(std::to_string(cache->lostTiles()) +
                                      " tiles of the last bake cannot be read; their texels were baked anew");
        }
    }
    run.noteImages(dumpResult(settings, result.baked, images));
    run.noteImages(images.commit());
    report.peakMemoryBytes = halflight::peakMemoryBytes();
    if (integratorFactory.peakDeviceBytes) report.peakDeviceBytes = integratorFactory.peakDeviceBytes();
    report.seconds = std::chrono::duration<double>(StageTimer::Clock::now() - start).count();
    return result;
}

} // namespace

Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress)
{
    return bake(std::move(scene), settings, integratorFactory, progress, nullptr);
}

Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress, LiveLight* live)
{
    if (integratorFactory.instead == nullptr)
        return bakeWith(std::move(scene), settings, integratorFactory, progress, live);
    Result<BakeResult> result = bakeWith(scene, settings, integratorFactory, progress, live);
    if (result || result.error().code != ErrorCode::DeviceFailed) return result;
    // Nothing of the device is kept: the bytes are those of a bake without it.
    const std::string lost = "the GPU failed, and the processor baked instead: " + result.error().message;
    result = bakeWith(std::move(scene), settings, *integratorFactory.instead, progress, live);
    if (result) result->report.warnings.push_back(lost);
    return result;
}

} // namespace halflight
