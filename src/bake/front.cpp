#include "bake/front.h"

#include "bake/front_parts.h"
#include "bake/hidden_sides.h"
#include "bake/live_light.h"
#include "bake/quality.h"
#include "bake/sheet_sides.h"
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
Result<UnwrappedScene> unwrapOrTake(const Stages& stages, Scene scene, const CrossingTest& crossingTest,
                                    const SheetTest& sheetTest, std::optional<PartFolder>& kept)
{
    UnwrappedScene taken;
    if (kept && takeUnwrapped(*kept, scene, taken)) return taken;
    UnwrapSettings settings;
    settings.uvMode = stages.settings.uvMode;
    settings.texelsPerMeter = stages.settings.texelsPerMeter;
    settings.pageSize = stages.report().quality.lightmapSize;
    settings.paddingTexels = stages.settings.paddingTexels;
    settings.cutPage = stages.settings.lightmapSize == 0;
    if (stages.settings.lightmapSize == 0 && stages.settings.texelsPerMeter == 0.0f)
        settings.mostTexelsPerMeter = sceneDensity(scene, settings.pageSize);
    Result<UnwrappedScene> unwrapped = unwrap(std::move(scene), settings, stages.progress, crossingTest, sheetTest);
    if (unwrapped && kept) keepUnwrapped(*kept, *unwrapped);
    return unwrapped;
}

Result<PageLayout> unwrapStage(const Stages& stages, Scene scene, const CrossingTest& crossingTest,
                               const SheetTest& sheetTest, std::optional<PartFolder>& kept)
{
    BakeReport& report = stages.report();
    StageTimer timer(report, "unwrap");
    Result<UnwrappedScene> unwrapped = unwrapOrTake(stages, std::move(scene), crossingTest, sheetTest, kept);
    if (!unwrapped) return unwrapped.error();
    BakedScene& baked = stages.baked();
    baked.scene = std::move(unwrapped->scene);
    baked.mode = stages.settings.mode;
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
    integration.cache.noiseTarget = settings.noiseTarget;
    integration.cache.texelStep = settings.texelStep;
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
Result<std::unique_ptr<Integrator>> buildStage(const Stages& stages, const IntegratorFactory& factory,
                                               const PageLayout& pages, const IntegrationSettings& integration,
                                               std::optional<PartFolder>& kept, const SourceTree& tree,
                                               BakeGeometry& geometry)
{
    BakeReport& report = stages.report();
    Scene& scene = stages.baked().scene;
    StageTimer timer(report, "build");
    const bool taken = kept && takeGeometry(*kept, geometry);
    if (!taken) geometry = flattenGeometry(scene, pages.size, GeometryFilter::Static);
    report.triangleCount = geometry.triangleCount();
    limitBounces(scene, integration);
    const int samples = stages.settings.samples;
    if (integration.integrator == IntegratorKind::Cache && samples > 0 && samples < kFewestSamples) {
        report.warnings.push_back(std::to_string(samples) + " samples per texel are asked for: the cache " +
                                  "integrator takes " + std::to_string(kFewestSamples) + " at least (one block)");
    }
    Result<std::unique_ptr<Integrator>> integrator =
        taken ? factory(scene, geometry, integration)
              : repairOrientation(factory, scene, geometry, integration, tree.integrator());
    if (!integrator) return integrator.error();
    if (kept && !taken) keepGeometry(*kept, geometry);
    if (stages.progress.cancelled()) return cancelledError();
    report.integrator = (*integrator)->description();
    reportFlipped(scene, geometry, report);
    timer.finish();
    return integrator;
}

TexelMap rasterizeStage(const Stages& stages, const BakeGeometry& geometry, const PageLayout& pages,
                        std::optional<PartFolder>& kept, bool keep)
{
    StageTimer timer(stages.report(), "rasterize");
    TexelMap map;
    if (!kept || !takeTexels(*kept, map)) {
        map = rasterizeTexels(geometry, pages.size, pages.count);
        if (kept && keep) keepTexels(*kept, map);
    }
    stages.report().coveredTexels = map.texels.size();
    reportTwoSided(stages.baked().scene, geometry, map, stages.report());
    timer.finish();
    return map;
}

/// What a bake of some objects keeps of the last bake. An error, with nothing written, where the last bake does not
/// have it.
Status chooseKept(const Stages& stages, const std::vector<uint8_t>& objects, Hash128 layout, const TexelOwners& owners,
                  Front& front)
{
    Result<std::vector<uint8_t>> chosen = chosenTexels(front.geometry, front.map, objects);
    if (!chosen) return chosen.error();
    const Result<PartFolder> last = BakeCache::lastBake(stages.settings.cacheDirectory, layout);
    if (!last) return last.error();
    if (Status status = owners.compareObjects(*last, objects); !status) return status;
    front.chosen = std::move(*chosen);
    const std::string light = owners.lightWithoutMask(*last);
    front.keepsMasks = light.empty();
    if (light.empty()) return {};
    stages.report().warnings.push_back("the last bake in the cache has no mask of the light '" + light +
                                       "': the masks of all objects and all light probes are baked where they have " +
                                       "changed; the other objects' lightmaps are still those of the last bake");
    return {};
}

/// A bake of all objects goes on with a warning where the cache cannot be opened.
Status openCache(const Stages& stages, const std::vector<uint8_t>& objects, const CacheUse& use, Front& front)
{
    const std::filesystem::path& folder = stages.settings.cacheDirectory;
    if (folder.empty()) return {};
    const Scene& scene = stages.baked().scene;
    const Hash128 layout = layoutHash(front.map, front.integration, stages.settings.mode);
    const Hash128 light = lightHash(layout, scene, front.geometry);
    const TexelOwners owners(scene, front.geometry, front.map);
    if (!objects.empty())
        if (Status status = chooseKept(stages, objects, layout, owners, front); !status) return status;
    Result<BakeCache> cache = front.chosen.empty()
                                  ? BakeCache::open(folder, light, layout, use.compares)
                                  : BakeCache::openKeeping(folder, light, layout, Hasher().add(front.chosen).hash());
    if (!cache && !front.chosen.empty()) return cache.error();
    if (!cache) {
        stages.report().warnings.push_back(cacheWarning(folder, cache.error()));
        return {};
    }
    front.cache = std::move(*cache);
    for (std::string& note : moveFoldersAway(front.cache->tiles())) front.notes.push_back(std::move(note));
    if (!front.chosen.empty())
        for (std::string& note : moveFoldersAway(front.cache->parts())) front.notes.push_back(std::move(note));
    owners.keepIn(front.cache->tiles());
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

Status prepareTexels(const Stages& stages, Scene scene, const IntegratorFactory& factory, const CacheUse& use,
                     Front& front)
{
    BakeReport& report = stages.report();
    report.quality = qualityOf(stages.settings, scene);
    report.warnings = scene.warnings;
    if (farFromOrigin(scene)) {
        report.warnings.emplace_back(
            "the scene lies far from its origin for its size, where positions are coarse: call "
            "recenter() before baking");
    }
    std::vector<uint8_t> objects;
    if (!stages.settings.only.empty()) {
        if (stages.settings.cacheDirectory.empty())
            return Error{ErrorCode::InvalidArgument, "a bake of some objects needs a cache, with the last bake"};
        Result<std::vector<uint8_t>> chosen = chosenObjects(scene, stages.settings.only);
        if (!chosen) return chosen.error();
        objects = std::move(*chosen);
    }
    std::optional<PartFolder> kept = frontFolder(scene, stages.settings);
    if (kept) front.notes = moveFoldersAway(*kept);
    front.integration = integrationSettings(stages.settings, report.quality);
    if (stages.live != nullptr &&
        !stages.live->beginWithProbes(scene, stages.settings, factory, front.integration, stages.progress))
        return cancelledError();
    assignShadowmaskChannels(scene, stages.settings.mode);
    SourceTree tree(factory, front.integration);
    SheetTest sheets = keptSheetTest(scene, stages.settings,
                                     sheetSidesTest(tree, stages.settings.twoSided, stages.progress), stages.progress);
    const Result<PageLayout> pages =
        unwrapStage(stages, std::move(scene), hiddenSidesTest(tree), std::move(sheets), kept);
    if (!pages) return pages.error();
    reportLights(stages.baked().scene, report);

    auto integrator = buildStage(stages, factory, *pages, front.integration, kept, tree, front.geometry);
    if (!integrator) return integrator.error();
    front.integrator = std::move(*integrator);
    front.map = rasterizeStage(stages, front.geometry, *pages, kept, use.share.has_value());
    if (Status status = openCache(stages, objects, use, front); !status) return status;
    if (front.cache) {
        if (use.share) front.cache->parts().shareWith(*use.share);
        front.integrator->keepIn(&front.cache->parts());
    }
    return kept && use.share ? kept->status() : Status();
}

Status validityStage(const Stages& stages, Front& front)
{
    StageTimer timer(stages.report(), "validity");
    const bool found = front.integrator->findValidPoints(front.map, stages.progress);
    if (stages.progress.cancelled()) return cancelledError();
    if (!found) return front.cache && !front.cache->status() ? front.cache->status() : cancelledError();
    timer.finish(front.integrator->raysTraced());
    return {};
}

} // namespace halflight
