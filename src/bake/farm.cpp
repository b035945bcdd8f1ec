#include "halflight/bake/farm.h"

#include "bake/probes/probes.h"

#include "bake/first_stages.h"
#include "bake/first_stages_parts.h"
#include "bake/group_stages.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace halflight {
namespace {

constexpr const char* kPrepared = "prepared"; ///< an empty part: the cache stage is complete

PartFolder partsOf(const std::filesystem::path& cacheDirectory, const FarmBake& bake)
{
    return PartFolder(folderOfIdentity(cacheDirectory, bake.identity) / bake.folder);
}

/// Tiles of a bake in the order in which they are laid out for the processes: spread over the pages.
std::vector<std::size_t> spreadTiles(std::size_t count)
{
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    const auto rank = [](std::size_t tile) { return hashPcg(uint32_t(tile)); };
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    return order;
}

/// The texels of all bakes side by side, of which each process has a stretch of equal length.
class TexelLine {
public:
    TexelLine(const std::vector<FarmBake>& bakes, uint32_t processes) : processes_(processes)
    {
        for (const FarmBake& bake : bakes) all_ += length(bake);
    }
    static uint64_t length(const FarmBake& bake) { return std::max<uint64_t>(bake.texels, 1); }
    /// Of the i-th tile that is laid out, within its bake.
    static uint64_t middleOf(const FarmBake& bake, std::size_t i)
    {
        return length(bake) * (2 * i + 1) / (2 * bake.tiles);
    }
    [[nodiscard]] uint32_t processAt(uint64_t place) const
    {
        return uint32_t(std::min<uint64_t>(uint64_t(double(place) / double(all_) * processes_), processes_ - 1));
    }

private:
    uint64_t all_ = 0;
    uint32_t processes_;
};

/// The first process solves the radiosity system. The others do probes and masks meanwhile, and then find the solution,
/// or solve it themselves.
Status prepareStage(const BakeRun& run, FirstStages& firstStages, PreparedLightmap& lightmap, const FarmBake& planned,
                    const FarmWork& work)
{
    PartFolder& parts = firstStages.cache->parts();
    if (parts.contains(kPrepared)) return {};
    const bool first = parts.share().index == 0;
    if (Status s = first ? lightmap.prepareAll(run.progress) : lightmap.prepareParts(run.progress); !s) return s;
    const BakeSettings& settings = run.settings;
    std::vector<std::string> warnings; // the bake's own run of this stage says them
    const auto probes =
        bakeProbes(run.baked().scene, settings.probeSpacingMeters, settings.probeLayout,
                   firstStages.integration.cache.denoised, firstStages.cached(), warnings, run.progress);
    if (!probes) return probes.error();
    if (!first) {
        const int layers = work.stage == FarmStage::All ? planned.maskLayers : 0;
        if (Status s = firstStages.cached().fillShadowmasks(layers, work.tiles, run.progress); !s) return s;
        if (Status s = lightmap.prepareAll(run.progress); !s) return s;
    }
    if (parts.status()) parts.write(kPrepared, {});
    return parts.status();
}

Status tileStage(const BakeRun& run, FirstStages& firstStages, PreparedLightmap& lightmap, const FarmBake& planned,
                 const FarmWork& work)
{
    if (!firstStages.cache->parts().contains(kPrepared))
        return Error{ErrorCode::Unsupported, "the cache stage is not complete, which the tiles need"};
    const CachedIntegrator cached = firstStages.cached();
    if (Status s = cached.fillIrradiance(lightmap, work.tiles, run.progress); !s) return s;
    if (Status s = cached.fillShadowmasks(planned.maskLayers, work.tiles, run.progress); !s) return s;
    return firstStages.cache->status();
}

} // namespace

Result<FarmBake> planFarm(Scene scene, const BakeSettings& settings, const IntegratorFactory& factory,
                          const Progress& progress)
{
    const ThreadLimit threads(settings.threads);
    BakeResult result;
    FirstStages firstStages;
    FarmBake bake;
    bake.inputs = bakeHash(scene, settings).hex();
    const Result<LightGrouping> grouping = beginGroups(settings.groups, settings.mode, scene, result.baked);
    if (!grouping) return grouping.error();
    const BakeRun run{settings, progress, result, nullptr, nullptr, componentsOf(*grouping)};
    const CacheUse use{false, WorkShare{}};
    if (Status status = prepareTexels(run, std::move(scene), factory, use, firstStages); !status) return status.error();
    if (!firstStages.cache) return Error{ErrorCode::WriteFailed, result.report.warnings.back()};
    bake.identity = settings.mixedIdentities ? kMixedIdentities : result.report.identity;
    bake.folder = firstStages.cache->parts().path().filename().string();
    bake.texels = firstStages.map.texels.size();
    bake.tiles = texelParts(firstStages.map.texels.size());
    if (hasMask(result.baked.scene, settings.mode)) bake.maskLayers = maskLayersOf(result.baked.scene);
    return bake;
}

Status checkFarmInputs(const Scene& scene, const BakeSettings& settings, const FarmBake& planned)
{
    if (bakeHash(scene, settings).hex() == planned.inputs) return {};
    return Error{ErrorCode::FileInvalid,
                 "is not the scene that was planned, or this is another version of the program: plan anew"};
}

Status checkFarmIdentity(const BakeSettings& settings, const FarmBake& planned, const IntegratorFactory& factory)
{
    if (planned.identity == kMixedIdentities) return {};
    const Result<std::string> identity = factory.identity(settings.isa);
    if (!identity) return identity.error();
    if (*identity == planned.identity) return {};
    return Error{ErrorCode::Unsupported,
                 "was planned for " + planned.identity + ", and this program on this processor is " + *identity +
                     ", whose light has other bytes: plan with --isa sse2, which suits processors of one maker, or " +
                     "with --mixed, which suits all, and work with the same version of the program"};
}

Result<BakeReport> workOnFarm(Scene scene, const BakeSettings& settings, const FarmBake& planned, const FarmWork& work,
                              bool compares, const IntegratorFactory& factory, const Progress& progress)
{
    const ThreadLimit threads(settings.threads);
    BakeResult result;
    if (Status status = checkFarmInputs(scene, settings, planned); !status) return status.error();
    if (Status status = checkFarmIdentity(settings, planned, factory); !status) return status.error();
    const Result<LightGrouping> grouping = beginGroups(settings.groups, settings.mode, scene, result.baked);
    if (!grouping) return grouping.error();
    const BakeRun run{settings, progress, result, nullptr, nullptr, componentsOf(*grouping)};
    FirstStages firstStages;
    const CacheUse use{compares, work.share};
    if (Status status = prepareTexels(run, std::move(scene), factory, use, firstStages); !status) return status.error();
    if (!firstStages.cache) return Error{ErrorCode::WriteFailed, result.report.warnings.back()};
    if (firstStages.map.texels.size() != planned.texels || farmTiles(planned.texels) != planned.tiles ||
        firstStages.cache->parts().path().filename() != planned.folder)
        return Error{ErrorCode::FileInvalid, "has other texels than the plan says: plan anew"};
    if (Status status = validityStage(run, firstStages); !status) return status.error();
    const std::unique_ptr<PreparedLightmap> lightmap = firstStages.cached().prepare();
    if (work.stage != FarmStage::Tiles) {
        if (Status status = prepareStage(run, firstStages, *lightmap, planned, work); !status) return status.error();
    }
    if (work.stage != FarmStage::Cache && !work.tiles.empty()) {
        if (Status status = tileStage(run, firstStages, *lightmap, planned, work); !status) return status.error();
    }
    result.report.cache = firstStages.cache->counts();
    result.report.warnings = std::move(firstStages.notes);
    return std::move(result.report);
}

bool isFarmCacheComplete(const std::filesystem::path& cacheDirectory, const FarmBake& bake)
{
    return partsOf(cacheDirectory, bake).contains(kPrepared);
}

std::vector<std::size_t> missingFarmTiles(const std::filesystem::path& cacheDirectory, const FarmBake& bake,
                                          bool verify)
{
    const PartFolder parts = partsOf(cacheDirectory, bake);
    const auto has = [&](const std::string& name) {
        return verify ? parts.read(name).has_value() : parts.contains(name);
    };
    std::vector<uint8_t> isMissing(bake.tiles);
    parallelFor(bake.tiles, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tile = begin; tile < end; ++tile) {
            bool missing = !has(partName("lightmap", tile));
            for (int layer = 0; layer < bake.maskLayers && !missing; ++layer)
                missing = !has(partName(maskStage(layer), tile));
            isMissing[tile] = missing;
        }
    });
    std::vector<std::size_t> missing;
    for (std::size_t tile = 0; tile < bake.tiles; ++tile)
        if (isMissing[tile] != 0) missing.push_back(tile);
    return missing;
}

std::size_t farmTiles(uint64_t texels)
{
    return texelParts(std::size_t(texels));
}

std::vector<std::vector<uint32_t>> farmProcesses(const std::vector<FarmBake>& bakes, uint32_t count)
{
    const TexelLine line(bakes, count);
    std::vector<std::vector<uint32_t>> processes;
    uint64_t first = 0;
    for (const FarmBake& bake : bakes) {
        std::vector<uint32_t>& ofTile = processes.emplace_back(bake.tiles);
        const std::vector<std::size_t> tiles = spreadTiles(bake.tiles);
        for (std::size_t i = 0; i < tiles.size(); ++i)
            ofTile[tiles[i]] = line.processAt(first + line.middleOf(bake, i));
        first += TexelLine::length(bake);
    }
    return processes;
}

std::vector<FarmWork> farmWork(const std::vector<FarmBake>& bakes, WorkShare process)
{
    const TexelLine line(bakes, process.count);
    std::vector<FarmWork> works(bakes.size());
    uint64_t first = 0;
    for (std::size_t b = 0; b < bakes.size(); ++b) {
        const uint64_t texels = TexelLine::length(bakes[b]);
        const std::vector<std::size_t> tiles = spreadTiles(bakes[b].tiles);
        const uint32_t firstProcess = line.processAt(first);
        const uint32_t lastProcess = line.processAt(first + texels - 1);
        works[b].share.count = lastProcess - firstProcess + 1;
        works[b].share.index = std::clamp(process.index, firstProcess, lastProcess) - firstProcess;
        for (std::size_t i = 0; i < tiles.size(); ++i) {
            if (line.processAt(first + line.middleOf(bakes[b], i)) == process.index) works[b].tiles.push_back(tiles[i]);
        }
        if (process.index < firstProcess || process.index > lastProcess) works[b].share.count = 0;
        first += texels;
    }
    return works;
}

} // namespace halflight
