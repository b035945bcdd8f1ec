#pragma once
// The tile cache: estimates of tiles (runs of texels or probes) on disk. An interrupted bake continues, and a bake of a
// changed scene computes the tiles that the change affects.
//
// A tile's values are reused in two cases. The same bake (equal hash of all inputs) has written them. Or the last bake
// with the same layout and settings has, the tile's surface is the same, and its check samples agree: few paths per
// item, traced in both scenes with the same random numbers (correlated sampling). Paths that the change does not affect
// give equal values to the last bit, so that differences show the change without noise.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"
#include "halflight/base/hash.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <vector>

namespace halflight {

/// Probes come in several batches: batch n is Probes + n.
enum class CachedStage : uint32_t { Lightmap, Shadowmask, Probes };

/// Tiles of one bake in one file. Records are appended as tiles are done, each with a checksum: reading stops at the
/// first incomplete one.
class TileFile {
public:
    /// Reads the file. Empty if it does not exist or is of another format.
    explicit TileFile(const std::filesystem::path& path);

    /// The record's bytes; empty if there is none, or if it lies on another surface.
    [[nodiscard]] std::span<const std::byte> find(CachedStage stage, uint32_t tile, Hash128 surface) const;
    /// Size of the file up to the last complete record.
    [[nodiscard]] std::size_t byteCount() const { return byteCount_; }

    struct Record {
        CachedStage stage;
        uint32_t tile;
        Hash128 surface;
        std::vector<std::byte> bytes;
    };
    static Status append(const std::filesystem::path& path, std::span<const Record> records);

private:
    struct Place {
        std::size_t begin;
        std::size_t size;
        Hash128 surface;
    };
    std::vector<std::byte> bytes_;
    std::size_t byteCount_ = 0;
    std::map<std::pair<uint32_t, uint32_t>, Place> records_;
};

/// Items 0…count-1 in tiles of tileSize; the last tile can be smaller.
struct Tiling {
    std::size_t count = 0;
    std::size_t tileSize = 1;

    [[nodiscard]] std::size_t tileCount() const { return (count + tileSize - 1) / tileSize; }
    [[nodiscard]] std::size_t first(std::size_t tile) const { return tile * tileSize; }
    [[nodiscard]] std::size_t size(std::size_t tile) const { return std::min(tileSize, count - first(tile)); }
};

/// What is done with each tile; the lists are ascending and disjoint.
struct TilePlan {
    Tiling tiling;
    std::vector<Hash128> surfaces;    ///< by tile
    std::vector<std::size_t> reuse;   ///< written by the same bake
    std::vector<std::size_t> compare; ///< written by the last bake: reused if the check samples agree
    std::vector<std::size_t> compute; ///< the others
};

class BakeCache {
public:
    /// `bake` identifies all inputs of the bake, `layout` its texels and settings without the light. Creates the
    /// folder, and keeps the last few bakes in it.
    static Result<BakeCache> open(const std::filesystem::path& folder, Hash128 bake, Hash128 layout);

    /// One kind of work. Functions that return bool return false when cancelled; `out` has one entry per item.
    template<typename Value, typename Check> struct Work {
        CachedStage stage{};
        const char* name = ""; ///< for progress
        std::size_t count = 0;
        std::size_t tileSize = 0;
        /// Hash of the surface or the positions of a tile.
        std::function<Hash128(std::size_t firstItem, std::size_t itemCount)> surface;
        std::function<bool(std::span<const uint32_t> items, std::span<Value> out, const Progress&)> compute;
        /// Check samples: the same estimate with few paths.
        std::function<bool(std::span<const uint32_t> items, std::span<Check> out, const Progress&)> check;
        /// Whether the check samples of a tile differ between the old and the new scene.
        std::function<bool(std::span<const Check> before, std::span<const Check> now)> changed;
    };
    /// Plans, computes and merges the tiles. False when cancelled; finished batches stay in the cache. Write errors are
    /// kept in status().
    template<typename Value, typename Check>
    bool run(const Work<Value, Check>& work, std::span<Value> out, const Progress& progress);

    [[nodiscard]] const TileCounts& counts() const { return counts_; }
    [[nodiscard]] const Status& status() const { return status_; }
    /// Marks the bake as complete: the next bake with this layout is compared with it.
    void finish();

private:
    BakeCache(std::filesystem::path folder, Hash128 bake, Hash128 layout);

    template<typename Value, typename Check> [[nodiscard]] TilePlan plan(const Work<Value, Check>& work) const;
    /// Merges plan.compare's unchanged tiles into `out` and moves the others to plan.compute, with their new check
    /// samples in `changedChecks` (by tile).
    template<typename Value, typename Check>
    bool compare(const Work<Value, Check>& work, TilePlan& plan, std::span<Value> out,
                 std::map<std::size_t, std::vector<Check>>& changedChecks, const Progress& progress);
    /// Computes plan.compute in batches and merges them. Takes check samples from `changedChecks` where it has them.
    template<typename Value, typename Check>
    bool compute(const Work<Value, Check>& work, const TilePlan& plan, std::span<Value> out,
                 std::map<std::size_t, std::vector<Check>>& changedChecks, const Progress& progress);
    void append(std::span<const TileFile::Record> records);

    std::filesystem::path file_;     ///< tiles of this bake
    std::filesystem::path lastFile_; ///< names the previous bake with the same layout
    Hash128 bake_;
    TileFile own_;
    TileFile before_;
    TileCounts counts_;
    Status status_;
};

} // namespace halflight
