#pragma once
// The tile cache: estimates of tiles (runs of texels or probes) on disk. An interrupted bake continues, and a bake of a
// changed scene computes the tiles that the change affects.
//
// A tile's values are reused in two cases. The same bake (equal hash of all inputs) has written them. Or the last bake
// with the same layout and settings has, the tile's surface is the same, and its check samples agree: few paths per
// item, traced in both scenes with the same random numbers (correlated sampling). Paths that the change does not affect
// give equal values to the last bit, so that differences show the change without noise.
//
// A bake of some objects (openKeeping()) computes the items of those objects and takes all others from the last bake
// with the same layout, unchecked. Its tiles are in a folder of their own, with the check samples of their values. So
// the next whole bake finds the tiles that are out of date.
//
// Each bake has a folder of parts (PartFolder), so that several processes may fill one cache. A part holds a run of
// tiles whose numbers follow from the number of items alone.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"
#include "halflight/bake/part_folder.h"
#include "halflight/base/hash.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Items 0…count-1 in tiles of tileSize; the last tile can be smaller.
struct Tiling {
    std::size_t count = 0;
    std::size_t tileSize = 1;

    [[nodiscard]] std::size_t tileCount() const { return (count + tileSize - 1) / tileSize; }
    [[nodiscard]] std::size_t first(std::size_t tile) const { return tile * tileSize; }
    [[nodiscard]] std::size_t size(std::size_t tile) const { return std::min(tileSize, count - first(tile)); }
};

/// Parts of a stage with some number of tiles of 256 texels: about 64 of them, of 4 to 64 tiles. A part is what a
/// killed process loses; smaller ones would trace more texels beside their own, which sample plans read.
std::size_t texelTilesPerPart(std::size_t tiles);
constexpr std::size_t kTexelTile = 256; ///< texels; few, so that a local change is large in the sum of check samples
constexpr std::size_t kProbeTile = 8;   ///< probes
constexpr std::size_t kProbeTilesPerPart = 8;
/// Parts of a map's texels.
std::size_t texelParts(std::size_t texels);
/// Texels of each but the last.
std::size_t texelsOfPart(std::size_t texels);

/// The folder of an identity's results (IntegratorFactory::identity) in a cache directory. Bakes of other identities
/// neither read nor remove them.
std::filesystem::path folderOfIdentity(const std::filesystem::path& cache, const std::string& identity);
/// A sentence where a cache directory also holds results of other identities; empty otherwise.
std::string resultsOfOthers(const std::filesystem::path& cache, const std::string& identity);

/// A folder of parts in an identity's folder. Of those with the same suffix, all but the last few that have not been
/// used for an hour are removed.
PartFolder openBakeFolder(const std::filesystem::path& cache, const std::string& name, const std::string& suffix);

class BakeCache {
public:
    /// `bake` identifies all inputs of the bake, `layout` its texels and settings without the light. Without `compares`
    /// tiles of other bakes are not reused, and check samples are not computed.
    static Result<BakeCache> open(const std::filesystem::path& folder, Hash128 bake, Hash128 layout,
                                  bool compares = true);
    /// The tiles of the last finished bake with that layout. An error where none is left. Changes nothing.
    static Result<PartFolder> lastBake(const std::filesystem::path& folder, Hash128 layout);
    /// For a bake of some objects; `chosen` identifies them. An error where no last bake with that layout is left.
    static Result<BakeCache> openKeeping(const std::filesystem::path& folder, Hash128 bake, Hash128 layout,
                                         Hash128 chosen);

    /// One kind of work. `out` has the values of all items. Errors are those of the work's own functions, and write
    /// nothing.
    template<typename Value, typename Check> struct Work {
        std::string stage;             ///< names the parts
        const char* progressName = ""; ///< names the stage in progress
        std::size_t count = 0;
        std::size_t tileSize = 0;
        std::size_t tilesPerPart = 1;
        std::size_t perItem = 1; ///< values, and check samples, of an item; one after another in all lists
        /// Hash of the surface or the positions of a tile.
        std::function<Hash128(std::size_t firstItem, std::size_t itemCount)> surface;
        /// By item, in a bake of some objects: 1 = computed, 0 = kept, whatever its surface is now. Empty: tiles with
        /// an equal surface are kept.
        std::span<const uint8_t> chosen;
        /// False: a bake of some objects, too, compares all tiles with the last bake and computes those that differ.
        bool keeps = true;
        std::function<Status(std::span<const uint32_t> items, std::span<Value> out, const Progress&)> compute;
        /// Check samples: the same estimate with few paths.
        std::function<Status(std::span<const uint32_t> items, std::span<Check> out, const Progress&)> check;
        /// Whether the check samples of a tile differ between the old and the new scene.
        std::function<bool(std::span<const Check> before, std::span<const Check> now)> changed;
        /// If given, receives the values of tiles in place of a list.
        std::function<void(std::size_t firstItem, std::span<const Value> values)> take;
    };
    /// Has the values of all tiles, from the cache or computed, and keeps them. In a shared folder the work is shared
    /// with other processes, part by part. Finished parts stay in the cache after an error. That parts cannot be
    /// written is an error in a shared folder alone, and is kept in status().
    template<typename Value, typename Check>
    Status run(const Work<Value, Check>& work, std::span<Value> out, const Progress& progress);
    /// The same of some parts, in ascending order.
    template<typename Value, typename Check> Status run(const Work<Value, Check>& work,
                                                        std::span<const std::size_t> parts, std::span<Value> out,
                                                        const Progress& progress);
    /// Has some parts in the cache.
    template<typename Value, typename Check>
    Status fill(const Work<Value, Check>& work, std::span<const std::size_t> parts, const Progress& progress);

    [[nodiscard]] const TileCounts& counts() const { return counts_; }
    [[nodiscard]] Status status() const;
    /// The folder of all bakes with equal inputs, for results that are not tiles.
    [[nodiscard]] PartFolder& parts() { return parts_; }
    /// The folder of the tiles: the same, but in a bake of some objects.
    [[nodiscard]] PartFolder& tiles() { return mixed_ ? *mixed_ : parts_; }
    /// Tiles to keep that could not be read, and were computed.
    [[nodiscard]] std::size_t lostTiles() const { return lost_; }
    /// Marks the bake as complete: the next bake with this layout is compared with it.
    void finish();

private:
    template<typename Value, typename Check>
    Status runParts(const Work<Value, Check>& work, std::span<const std::size_t> parts, std::size_t partsAtOnce,
                    std::span<Value> out, const Progress& progress);
    BakeCache(const std::filesystem::path& folder, Hash128 bake, Hash128 layout, bool compares);

    PartFolder parts_;
    std::optional<PartFolder> mixed_; ///< of a bake of some objects
    PartFolder before_;               ///< of the previous bake with the same layout; its path may be empty
    std::filesystem::path lastFile_;  ///< names that bake
    Hash128 bake_;
    bool compares_;
    TileCounts counts_;
    std::size_t lost_ = 0;
    Status finished_;
};

} // namespace halflight
