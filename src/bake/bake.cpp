#include "halflight/bake/bake.h"

#include "bake/bake_report.h"
#include "bake/denoise.h"
#include "bake/dilate.h"
#include "bake/encode.h"
#include "bake/front.h"
#include "bake/gather.h"
#include "bake/hidden_sides.h"
#include "bake/live_light.h"
#include "bake/main_light.h"
#include "bake/mask_field.h"
#include "bake/probes.h"
#include "bake/reflections.h"
#include "bake/seams.h"
#include "bake/stage_images.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/system.h"
#include "halflight/scene/probe_cells.h"

#include <algorithm>
#include <array>
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
Status lightmapStage(const Stages& stages, const Gather& gather, std::vector<IrradianceEstimate>& estimates,
                     std::optional<MainLight>& main)
{
    BakeReport& report = stages.report();
    Integrator& integrator = gather.integrator;
    StageTimer timer(report, "lightmap");
    const uint64_t earlier = integrator.raysTraced();
    const bool done = stages.live != nullptr ? stages.live->irradiance(gather, estimates, stages.progress)
                                             : gather.irradiance(estimates, stages.progress);
    if (!done) return cancelledError();
    integrator.releaseIrradiance();
    timer.finish(integrator.raysTraced() - earlier);
    main = findMainLight(stages.baked().scene);
    if (main) {
        StageTimer mainTimer(report, "main light");
        const uint64_t before = integrator.raysTraced();
        if (!bakeMainLight(gather, *main, stages.progress)) return cancelledError();
        mainTimer.finish(integrator.raysTraced() - before);
    }
    reportNoise(estimates, main, report);
    if (stages.images != nullptr && !stages.settings.imagesDirectory.empty()) {
        std::vector<vec3> raw = splitEstimates(estimates).irradiance;
        if (main) main->addTo(raw);
        stages.noteImages(dumpPages(stages.settings, "lightmap_raw", dilate(gather.map, raw, 0), *stages.images));
    }
    return {};
}

Status denoiseStage(const Stages& stages, const Gather& gather, std::span<const SeamSample> seams,
                    std::vector<IrradianceEstimate>& estimates)
{
    if (stages.settings.denoiser == Denoiser::Off) return {};
    const bool openImage = stages.settings.denoiser == Denoiser::OpenImage;
    StageTimer timer(stages.report(), "denoise");
    stages.progress("denoise", 0.0);
    std::vector<vec3> gathered; // before the built-in denoiser
    if (openImage) {
        gathered.reserve(estimates.size());
        for (const IrradianceEstimate& e : estimates) gathered.push_back(e.irradiance - e.direct);
    }
    denoise(gather.geometry, gather.map, seams, estimates, stages.report().quality.directional);
    if (openImage) {
        if (Status status = imageDenoise(gather.map, gathered, estimates, stages.progress); !status)
            return status.error();
    }
    timer.finish();
    if (stages.progress.cancelled()) return cancelledError();
    return {};
}

/// From estimates to encoded pages. `valid` serves the shadowmask too. Large arrays are released as soon as
/// they are no longer needed.
Status lightmapPagesStage(const Stages& stages, const Gather& gather, const std::vector<IrradianceEstimate>& estimates,
                          const std::optional<MainLight>& main, const std::vector<SeamSample>& seams,
                          std::vector<uint8_t>& valid)
{
    const BakeSettings& settings = stages.settings;
    BakedScene& baked = stages.baked();
    TexelValues values = splitEstimates(estimates);
    if (main) {
        baked.defaultShadowColor = chooseShadowColor(*main, values.irradiance, values.valid, settings.subtractiveMask);
        main->addTo(values.irradiance);
        main->addTo(values.direct);
    }
    valid = std::move(values.valid);
    StageTimer fillTimer(stages.report(), "fill");
    fillInvalid(gather.geometry, gather.map, valid, values.irradiance);
    fillInvalid(gather.geometry, gather.map, valid, values.direct);
    fillTimer.finish();
    StageTimer timer(stages.report(), "seams");
    std::vector<ImageRgb32f>& pages = stages.result.irradiance;
    pages = dilate(gather.map, values.irradiance, kDilationRings);
    release(values.irradiance);
    const std::vector<float> weights =
        lightSeamWeights(seams, pages, dilate(gather.map, values.direct, kDilationRings));
    release(values.direct);
    stitchSeams(gather.map, seams, weights, pages);
    timer.finish();
    if (stages.progress.cancelled()) return cancelledError();
    if (stages.images != nullptr) stages.noteImages(dumpPages(settings, "lightmap", pages, *stages.images));
    // Until the bake ends, a main light is drawn in realtime, and must not come twice.
    if (stages.live != nullptr && !main) stages.live->finish(pages);
    StageTimer encodeTimer(stages.report(), "encode");
    baked.lightmapUnitLux = lightmapUnitFor(pages);
    baked.lightmaps = encodeLightmap(pages, baked.lightmapUnitLux);
    encodeTimer.finish();
    if (!stages.report().quality.directional) return {};
    std::vector<vec3> moments;
    moments.reserve(estimates.size());
    for (const IrradianceEstimate& e : estimates) moments.push_back(e.moment);
    if (main) main->addMomentTo(moments);
    fillInvalid(gather.geometry, gather.map, valid, moments);
    std::vector<ImageRgb32f> momentPages = dilate(gather.map, moments, kDilationRings);
    stitchSeams(gather.map, seams, weights, momentPages);
    baked.lightmapDirections = encodeDirections(pages, momentPages);
    return {};
}

/// A mask's pages: filled inside geometry, dilated, stitched, encoded.
std::vector<ImageRgba8> maskPages(const Gather& gather, const std::vector<uint8_t>& valid,
                                  const std::vector<SeamSample>& seams, std::vector<vec4> mask, bool distances,
                                  std::array<MaskChannel, 4>& channels)
{
    fillInvalid(gather.geometry, gather.map, valid, mask);
    if (distances) channels = maskToDistances(gather.map, mask);
    std::vector<ImageRgba32f> pages = dilate(gather.map, mask, kDilationRings, distances);
    stitchSeams(gather.map, seams, maskSeamWeights(seams, pages), pages, !distances);
    return encodeShadowmask(pages);
}

Status shadowmaskStage(const Stages& stages, const Gather& gather, const std::vector<uint8_t>& valid,
                       const std::vector<SeamSample>& seams)
{
    BakedScene& baked = stages.baked();
    if (stages.settings.mode != MixedLightingMode::Shadowmask || !hasMask(baked.scene, stages.settings.mode)) return {};
    StageTimer timer(stages.report(), "shadowmask");
    const uint64_t before = gather.integrator.raysTraced();
    std::vector<vec4> mask = largeVector<vec4>(gather.map.texels.size());
    if (!gather.shadowmask(mask, stages.progress)) return cancelledError();
    baked.shadowmasks = maskPages(gather, valid, seams, std::move(mask),
                                  stages.settings.maskEncoding == MaskEncoding::Distance, baked.maskChannels);
    for (LightReport& light : stages.report().lights) {
        light.distanceMask = light.channel >= 0 && baked.maskChannels[std::size_t(light.channel)].rangeTexels > 0.0f;
    }
    timer.finish(gather.integrator.raysTraced() - before);
    if (stages.progress.cancelled()) return cancelledError();
    return {};
}

Status probeStage(const Stages& stages, const Gather& gather)
{
    BakeReport& report = stages.report();
    BakedScene& baked = stages.baked();
    StageTimer timer(report, "probes");
    const uint64_t before = gather.integrator.raysTraced();
    std::optional<BakedProbes> probes =
        bakeProbes(baked.scene, stages.settings.probeSpacingMeters, stages.settings.probeLayout,
                   gather.settings.cache.denoised, gather, report.warnings, stages.progress);
    if (!probes) return cancelledError();
    baked.probes = std::move(probes->set);
    if (addProbeLayers(baked.probes) && stages.settings.probeLayout == ProbeLayout::Grid)
        report.warnings.push_back(
            "probes: those outside geometry lie in one plane, so the file holds a list of them and "
            "their copies above, and no grid; a smaller --probe-spacing gives more layers");
    std::optional<ProbeSight> sight = findProbeSight(baked.probes, gather.integrator, stages.progress);
    if (!sight) return cancelledError();
    baked.probes.sight = std::move(*sight);
    report.probeCheck = checkProbes(baked, *probes, report.warnings);
    report.probeCount = int(baked.probes.probes.size());
    report.validProbeCount = int(
        std::count_if(baked.probes.probes.begin(), baked.probes.probes.end(), [](const Probe& p) { return p.valid; }));
    timer.finish(gather.integrator.raysTraced() - before);
    return {};
}

Status reflectionStage(const Stages& stages, const Gather& gather)
{
    if (!stages.settings.reflectionProbes) return {};
    BakeReport& report = stages.report();
    StageTimer timer(report, "reflection probes");
    const uint64_t before = gather.integrator.raysTraced();
    if (!bakeReflections(stages.baked(), gather, stages.result.irradiance, report.quality.reflectionSize,
                         report.warnings, stages.progress))
        return cancelledError();
    report.reflectionProbeCount = int(stages.baked().reflections.probes.size());
    timer.finish(gather.integrator.raysTraced() - before);
    return {};
}

/// All stages that trace rays or work on their results.
Status traceStages(const Stages& stages, const Gather& gather)
{
    std::vector<IrradianceEstimate> estimates = largeVector<IrradianceEstimate>(gather.map.texels.size());
    std::optional<MainLight> main;
    if (Status s = lightmapStage(stages, gather, estimates, main); !s) return s;
    StageTimer timer(stages.report(), "find seams");
    std::vector<SeamSample> seams = findSeams(gather.geometry, gather.map.pageSize);
    dropHiddenSeams(gather.integrator, seams);
    timer.finish();
    if (Status s = denoiseStage(stages, gather, seams, estimates); !s) return s;
    std::vector<uint8_t> valid;
    if (Status s = lightmapPagesStage(stages, gather, estimates, main, seams, valid); !s) return s;
    release(estimates);
    if (Status s = shadowmaskStage(stages, gather, valid, seams); !s) return s;
    if (main) {
        BakedScene& baked = stages.baked();
        if (stages.settings.subtractiveMask)
            baked.shadowmasks = maskPages(gather, valid, seams, main->mask(), false, baked.maskChannels);
        reportMainLight(baked, *main, stages.settings, stages.report());
    }
    if (Status s = probeStage(stages, gather); !s) return s;
    return reflectionStage(stages, gather);
}

} // namespace

std::string cacheWarning(const std::filesystem::path& folder, const Error& error)
{
    return "the cache " + folder.string() + " is not complete, so the next bake computes more: " + error.message;
}

Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress)
{
    return bake(std::move(scene), settings, integratorFactory, progress, nullptr);
}

Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress, LiveLight* live)
{
    const auto start = StageTimer::Clock::now();
    const ThreadLimit threads(settings.threads);
    BakeResult result;
    BakeReport& report = result.report;
    FileGroup images;
    const Stages stages{settings, progress, result, live, &images};
    Front front;
    if (Status status = prepareTexels(stages, std::move(scene), integratorFactory, CacheUse{}, front); !status)
        return status.error();
    if (live != nullptr && !live->begin(result.baked, front.gather(), progress)) return cancelledError();
    if (Status status = validityStage(stages, front); !status) return status.error();
    std::optional<BakeCache>& cache = front.cache;
    const Gather gather = front.gather();
    if (Status status = traceStages(stages, gather); !status) return status.error();

    if (cache) {
        cache->finish();
        if (!cache->status()) report.warnings.push_back(cacheWarning(settings.cacheDirectory, cache->status().error()));
        report.cache = cache->counts();
        report.warnings.insert(report.warnings.end(), front.notes.begin(), front.notes.end());
        if (cache->lostTiles() > 0) {
            report.warnings.push_back(std::to_string(cache->lostTiles()) +
                                      " tiles of the last bake cannot be read; their texels were baked anew");
        }
    }
    stages.noteImages(dumpResult(settings, result.baked, images));
    stages.noteImages(images.commit());
    report.peakMemoryBytes = halflight::peakMemoryBytes();
    report.seconds = std::chrono::duration<double>(StageTimer::Clock::now() - start).count();
    return result;
}

} // namespace halflight
