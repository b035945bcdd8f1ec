#include "bake/first_stages.h"

#include "bake/geometry/facet_orientation.h"
#include "bake/geometry/flatten.h"
#include "bake/lights/channels.h"
#include "bake/lights/colored_masks.h"
#include "bake/texels/rasterize.h"

#include "bake/first_stages_parts.h"
#include "bake/live/live_light.h"
#include "bake/settings/memory_limit.h"
#include "bake/settings/quality.h"
#include "bake/sides/hidden_sides.h"
#include "bake/sides/sheet_sides.h"
#include "bake/some_objects.h"

#include "halflight/unwrap/unwrap.h"

#include <algorithm>
#include <string>
#include <utility>

namespace halflight {
namespace {

constexpr int kFewestSamples = 16; ///< per texel, of the cache integrator: one block

struct PageLayout {
    int size = 0; ///< texels along a side
    int count = 0;
};

/// Lightmap coordinates; the scene moves into the result.
Result<UnwrappedScene> unwrapOrTake(const BakeRun& run, Scene scene, SourceTree& tree, const SheetTest& sheetTest,
                                    std::optional<PartFolder>& kept)
{
    UnwrappedScene taken;
    if (kept && takeUnwrapped(*kept, scene, taken)) return taken;
    const UnwrapSettings settings = unwrapSettings(scene, run.settings);
    Result<UnwrappedScene> unwrapped =
        unwrap(std::move(scene), settings, run.progress, hiddenSidesTest(tree), sheetTest);
    if (!tree.status()) return tree.status().error();
    if (unwrapped && kept) keepUnwrapped(*kept, *unwrapped);
    return unwrapped;
}

Result<PageLayout> unwrapStage(const BakeRun& run, Scene scene, SourceTree& tree, const SheetTest& sheetTest,
                               std::optional<PartFolder>& kept)
{
    BakeReport& report = run.report();
    StageTimer timer(report, "unwrap");
    Result<UnwrappedScene> unwrapped = unwrapOrTake(run, std::move(scene), tree, sheetTest, kept);
    if (!unwrapped) return unwrapped.error();
    BakedScene& baked = run.baked();
    baked.scene = std::move(unwrapped->scene);
    baked.mode = run.settings.mode;
    baked.isBaked = true;
    report.meshes = unwrapped->meshes;
    report.pageCount = unwrapped->pageCount;
    report.pageSize = unwrapped->pageSize;
    report.chartCount = unwrapped->chartCount;
    report.cuts = unwrapped->cuts;
    report.texelsPerMeter = unwrapped->texelsPerMeter;
    report.densityFrom = unwrapped->densityFrom;
    report.atlasCoverage = unwrapped->coverage;
    report.warnings.insert(report.warnings.end(), unwrapped->warnings.begin(), unwrapped->warnings.end());
    timer.finish();
    return PageLayout{unwrapped->pageSize, unwrapped->pageCount};
}

IntegrationSettings integrationSettings(const BakeSettings& settings, const BakeQuality& quality)
{
    IntegrationSettings integration;
    integration.integrator = settings.integrator;
    integration.isa = settings.isa;
    integration.cache.noiseTarget = settings.noiseTarget;
    integration.cache.denoised = settings.denoiser != Denoiser::Off;
    integration.samples = quality.samples;
    integration.shadowSamples = quality.shadowSamples;
    integration.bounces = quality.bounces;
    integration.glossyBounces = settings.glossyBounces;
    integration.probeSamples = quality.probeSamples;
    integration.seed = settings.seed;
    return integration;
}

/// Geometry and the integrator; `geometry` outlives the integrator.
Result<std::unique_ptr<Integrator>> buildStage(const BakeRun& run, const IntegratorFactory& factory,
                                               const PageLayout& pages, const IntegrationSettings& integration,
                                               std::optional<PartFolder>& kept, const SourceTree& tree,
                                               BakeGeometry& geometry)
{
    BakeReport& report = run.report();
    Scene& scene = run.baked().scene;
    StageTimer timer(report, "build");
    const bool taken = kept && takeGeometry(*kept, geometry);
    if (!taken) geometry = flattenGeometry(scene, pages.size, GeometryFilter::Static);
    report.triangleCount = geometry.triangleCount();
    limitBounces(scene, integration);
    const int samples = run.settings.samples;
    if (integration.integrator == IntegratorKind::Cache && samples > 0 && samples < kFewestSamples) {
        report.warnings.push_back(std::to_string(samples) + " samples per texel are asked for: the cache " +
                                  "integrator takes " + std::to_string(kFewestSamples) + " at least (one block)");
    }
    Result<std::unique_ptr<Integrator>> integrator =
        taken ? factory.make(scene, geometry, integration)
              : repairOrientation(factory, scene, geometry, integration, tree.integrator());
    if (!integrator) return integrator.error();
    if (kept && !taken) keepGeometry(*kept, geometry);
    if (run.progress.cancelled()) return cancelledError();
    report.integrator = (*integrator)->description();
    reportFlipped(scene, geometry, report);
    timer.finish();
    return integrator;
}

/// S35. Coloured masks. Where there are some, the integrator is made anew, which reads the lights' channels.
Status colorStage(const BakeRun& run, const IntegratorFactory& factory, FirstStages& firstStages)
{
    Scene& scene = run.baked().scene;
    if (!hasMask(scene, run.settings.mode) || coloringGlassOf(scene).empty()) return {};
    StageTimer timer(run.report(), "coloured shadows");
    const uint64_t before = firstStages.integrator->raysTraced();
    std::vector<float> shares(scene.lights.size());
    if (Status s = firstStages.integrator->coloredShadows(firstStages.map, shares, run.progress); !s) return s;
    const bool shadowmask = run.settings.mode == MixedLightingMode::Shadowmask;
    const ColoredMasks masks = colorMasks(scene, shares, shadowmask ? run.settings.mostMaskLayers : 1);
    timer.finish(firstStages.integrator->raysTraced() - before);
    reportColoredMasks(scene, masks.leftGray, run.settings.mostMaskLayers, run.report());
    if (!masks.any) return {};
    auto integrator = factory.make(scene, firstStages.geometry, firstStages.integration);
    if (!integrator) return integrator.error();
    firstStages.integrator = std::move(*integrator);
    return {};
}

TexelMap rasterizeStage(const BakeRun& run, const BakeGeometry& geometry, const PageLayout& pages,
                        std::optional<PartFolder>& kept, bool keep)
{
    StageTimer timer(run.report(), "rasterize");
    TexelMap map;
    if (!kept || !takeTexels(*kept, map)) {
        map = rasterizeTexels(geometry, pages.size, pages.count);
        if (kept && keep) keepTexels(*kept, map);
    }
    run.report().coveredTexels = map.texels.size();
    reportTwoSided(run.baked().scene, geometry, map, run.report());
    timer.finish();
    return map;
}

/// What a bake of some objects keeps of the last bake. An error, with nothing written, where the last bake does not
/// have it.
Status chooseKept(const BakeRun& run, const std::vector<uint8_t>& objects, Hash128 layout, const TexelOwners& owners,
                  FirstStages& firstStages)
{
    Result<std::vector<uint8_t>> chosen = chosenTexels(firstStages.geometry, firstStages.map, objects);
    if (!chosen) return chosen.error();
    const Result<PartFolder> last = BakeCache::lastBake(firstStages.cacheFolder, layout);
    if (!last) return last.error();
    if (Status status = owners.compareObjects(*last, objects); !status) return status;
    firstStages.chosen = std::move(*chosen);
    const std::string light = owners.lightWithoutMask(*last);
    firstStages.keepsMasks = light.empty();
    if (light.empty()) return {};
    run.report().warnings.push_back("the last bake in the cache has no mask of the light '" + light +
                                    "': the masks of all objects and all light probes are baked where they have " +
                                    "changed; the other objects' lightmaps are still those of the last bake");
    return {};
}

/// A bake of all objects goes on with a warning where the cache cannot be opened.
Status openCache(const BakeRun& run, const std::vector<uint8_t>& objects, const CacheUse& use, FirstStages& firstStages)
{
    const std::filesystem::path& folder = firstStages.cacheFolder;
    if (folder.empty()) return {};
    const Scene& scene = run.baked().scene;
    const Hash128 layout = layoutHash(firstStages.map, firstStages.integration, run.settings.mode, scene);
    const Hash128 light = lightHash(layout, scene, firstStages.geometry);
    const TexelOwners owners(scene, firstStages.geometry, firstStages.map);
    if (!objects.empty())
        if (Status status = chooseKept(run, objects, layout, owners, firstStages); !status) return status;
    Result<BakeCache> cache =
        firstStages.chosen.empty()
            ? BakeCache::open(folder, light, layout, use.compares)
            : BakeCache::openKeeping(folder, light, layout, Hasher().add(firstStages.chosen).hash());
    if (!cache && !firstStages.chosen.empty()) return cache.error();
    if (!cache) {
        run.report().warnings.push_back(cacheWarning(run.settings.cacheDirectory, cache.error()));
        return {};
    }
    firstStages.cache = std::move(*cache);
    for (std::string& note : moveFoldersAway(firstStages.cache->tiles())) firstStages.notes.push_back(std::move(note));
    if (!firstStages.chosen.empty())
        for (std::string& note : moveFoldersAway(firstStages.cache->parts()))
            firstStages.notes.push_back(std::move(note));
    owners.keepIn(firstStages.cache->tiles());
    return {};
}

/// Whose results these are, and where the cache has them.
Status identify(const BakeRun& run, const IntegratorFactory& factory, FirstStages& firstStages)
{
    Result<std::string> identity = factory.identity(run.settings.isa);
    if (!identity) return identity.error();
    run.report().identity = std::move(*identity);
    const std::filesystem::path& cache = run.settings.cacheDirectory;
    const bool mixed = run.settings.mixedIdentities;
    firstStages.cacheFolder = folderOfIdentity(cache, mixed ? kMixedIdentities : run.report().identity);
    if (cache.empty() || mixed) return {};
    std::string others = resultsOfOthers(cache, run.report().identity);
    if (!others.empty()) firstStages.notes.push_back(std::move(others));
    return {};
}

} // namespace

bool hasMask(const Scene& scene, MixedLightingMode mode)
{
    if (mode == MixedLightingMode::Subtractive) return findMainLight(scene).has_value();
    return mode == MixedLightingMode::Shadowmask &&
           std::any_of(scene.lights.begin(), scene.lights.end(),
                       [](const Light& light) { return light.baking.occlusionMaskChannel >= 0; });
}

Status prepareTexels(const BakeRun& run, Scene scene, const IntegratorFactory& factory, const CacheUse& use,
                     FirstStages& firstStages)
{
    BakeReport& report = run.report();
    report.quality = qualityOf(run.settings, scene);
    report.warnings = scene.warnings;
    const uint64_t triangles = trianglesOf(scene);
    if (Status status = checkMemory({0, triangles, 0.0}); !status) return status;
    if (farFromOrigin(scene)) {
        report.warnings.emplace_back(
            "the scene lies far from its origin for its size, where positions are coarse: call "
            "recenter() before baking");
    }
    std::vector<uint8_t> objects;
    if (!run.settings.only.empty()) {
        if (run.settings.cacheDirectory.empty())
            return Error{ErrorCode::InvalidArgument, "a bake of some objects needs a cache, with the last bake"};
        Result<std::vector<uint8_t>> chosen = chosenObjects(scene, run.settings.only);
        if (!chosen) return chosen.error();
        objects = std::move(*chosen);
    }
    if (Status status = identify(run, factory, firstStages); !status) return status;
    std::optional<PartFolder> kept = frontFolder(scene, run.settings, firstStages.cacheFolder);
    if (kept)
        for (std::string& note : moveFoldersAway(*kept)) firstStages.notes.push_back(std::move(note));
    firstStages.integration = integrationSettings(run.settings, report.quality);
    firstStages.integration.components = run.components;
    if (run.live != nullptr) {
        Status shown = run.live->beginWithProbes(scene, run.settings, factory, firstStages.integration, run.progress);
        if (!shown) return shown;
    }
    assignShadowmaskChannels(scene, run.settings.mode, run.settings.mostMaskLayers);
    SourceTree tree(factory, firstStages.integration);
    const SheetTest sheets =
        keptSheetTest(scene, run.settings, firstStages.cacheFolder,
                      sheetSidesTest(tree, run.settings.twoSided, run.progress), tree, run.progress);
    const Result<PageLayout> pages = unwrapStage(run, std::move(scene), tree, sheets, kept);
    if (!pages) return pages.error();
    const double texels =
        double(report.atlasCoverage) * double(pages->count) * double(pages->size) * double(pages->size);
    if (Status status = checkMemory({uint64_t(texels), triangles, report.texelsPerMeter}); !status) return status;
    reportLights(run.baked().scene, report);

    auto integrator = buildStage(run, factory, *pages, firstStages.integration, kept, tree, firstStages.geometry);
    if (!integrator) return integrator.error();
    firstStages.integrator = std::move(*integrator);
    firstStages.map = rasterizeStage(run, firstStages.geometry, *pages, kept, use.share.has_value());
    if (Status status = colorStage(run, factory, firstStages); !status) return status;
    if (Status status = openCache(run, objects, use, firstStages); !status) return status;
    if (firstStages.cache && use.share) firstStages.cache->parts().shareWith(*use.share);
    return kept && use.share ? kept->status() : Status();
}

Status validityStage(const BakeRun& run, FirstStages& firstStages)
{
    StageTimer timer(run.report(), "validity");
    PartFolder* const parts = firstStages.cache ? &firstStages.cache->parts() : nullptr;
    if (Status s = firstStages.integrator->findValidPoints(firstStages.map, parts, run.progress); !s) return s;
    if (run.progress.cancelled()) return cancelledError();
    timer.finish(firstStages.integrator->raysTraced());
    return {};
}

} // namespace halflight
