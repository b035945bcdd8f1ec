#pragma once
// A bake by many processes: each computes parts of it as pure functions of scene and settings into a common cache
// directory (PartFolder). The bake itself (bake() with that directory) then finds all of them. There is no leader and
// no lock, and nothing is sent.

#include "halflight/bake/bake.h"
#include "halflight/bake/part_folder.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace halflight {

/// What has to be computed of one bake. Tile i is the i-th part of the lightmap and of the mask.
struct FarmBake {
    std::string inputs;   ///< bakeHash() of scene and settings
    std::string identity; ///< of the machines that may compute it (IntegratorFactory::identity), or kMixedIdentities
    std::string folder;   ///< of its parts, in the identity's folder of the cache: a hash of all that light depends on
    std::size_t tiles = 0;
    uint64_t texels = 0;
    int maskLayers = 0; ///< that tiles have beside their light
};

/// Stages of the work. Cache: validity, the radiance cache and the probes. Workers share it part by part, and one that
/// finds parts of others missing computes them. Tiles: lightmap and mask, which need the first stage.
enum class FarmStage { All, Cache, Tiles };

/// Tiles of so many texels.
std::size_t farmTiles(uint64_t texels);
/// Processes that may share a bake, at most.
inline constexpr uint32_t kMostFarmProcesses = 1u << 24;

/// The work of one process on one bake.
struct FarmWork {
    FarmStage stage = FarmStage::All;
    WorkShare share;                ///< of the cache stage; count 0: none
    std::vector<std::size_t> tiles; ///< of the tile stage
};

/// Unwraps and rasterizes, and keeps the results in BakeSettings::cacheDirectory. Errors: those of bake(), and
/// WriteFailed.
Result<FarmBake> planFarm(Scene scene, const BakeSettings& settings, const IntegratorFactory& factory,
                          const Progress& progress = {});

/// FileInvalid if scene and settings are not those of a plan.
Status checkFarmInputs(const Scene& scene, const BakeSettings& settings, const FarmBake& planned);

/// Unsupported, in words that name both, where this machine's identity is not the plan's.
Status checkFarmIdentity(const BakeSettings& settings, const FarmBake& planned, const IntegratorFactory& factory);

/// Does a process's work. `compares`: tiles of the last bake with this layout are reused where the scene's change does
/// not show (bake() with a cache directory does so). Returns the bake's report so far, with warnings of this process
/// alone: the bake says the others. Errors: those of bake(), checkFarmInputs() and checkFarmIdentity(); WriteFailed;
/// Unsupported if the tiles' first stage is not complete.
Result<BakeReport> workOnFarm(Scene scene, const BakeSettings& settings, const FarmBake& planned, const FarmWork& work,
                              bool compares, const IntegratorFactory& factory, const Progress& progress = {});

/// Whether the cache stage is complete.
bool isFarmCacheComplete(const std::filesystem::path& cacheDirectory, const FarmBake& bake);
/// Tiles that are missing. `verify`: also those whose checksum is wrong.
std::vector<std::size_t> missingFarmTiles(const std::filesystem::path& cacheDirectory, const FarmBake& bake,
                                          bool verify);

/// The work of process `index` of `count` on several bakes, by bake. The bakes' texels are laid side by side, and each
/// process has a stretch of equal length: small bakes go to one process, large ones are split. Tiles of a split bake
/// are spread, because neighbours on a page take similar times.
std::vector<FarmWork> farmWork(const std::vector<FarmBake>& bakes, WorkShare process);
/// Which of `count` processes has each tile, by bake and tile.
std::vector<std::vector<uint32_t>> farmProcesses(const std::vector<FarmBake>& bakes, uint32_t count);

} // namespace halflight
