#pragma once
// What bakes leave behind for later ones: estimates of tiles (runs of texels or probes), so that an interrupted bake
// goes on where it stopped and a changed scene is baked anew only where the change shows.
//
// A tile is taken over from the same bake (same content in, same bytes out), or from the last bake with the same layout
// and settings when its own surface is the same and its witnesses agree: a few of its paths, traced in the new scene
// with the random numbers they had in the old one. Whatever did not change along them gives the same values to the last
// bit, so what differs is what the change does to the tile, without noise.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"
#include "halflight/base/hash.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <vector>

namespace halflight {

/// Probes come in several batches: batch n is Probes + n.
enum class CachedStage : uint32_t { Lightmap, Shadowmask, Probes };

/// Tiles of one bake in one file: records that are appended as tiles are done, each with a checksum, so that whatever a
/// crash cut short is left out when the file is read again.
class TileFile {
public:
    /// Reads what is there; nothing when there is no such file or it is not one of ours.
    explicit TileFile(const std::filesystem::path& path);

    /// The record's bytes, or none. `surface` is what the tile lies on, and has to be the same.
    [[nodiscard]] std::span<const std::byte> find(CachedStage stage, uint32_t tile, Hash128 surface) const;
    /// Of the whole records: what follows them was cut short.
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

class BakeCache {
public:
    /// `bake` identifies all that goes into the bake, `layout` its texels and settings but not the light. Keeps the
    /// last few bakes of the folder, which is made when it is not there.
    static Result<BakeCache> open(const std::filesystem::path& folder, Hash128 bake, Hash128 layout);

    /// One kind of work on items 0…count-1, in tiles of tileSize.
    template<typename Value, typename Witness> struct Work {
        CachedStage stage{};
        const char* name = ""; ///< for progress
        std::size_t count = 0;
        std::size_t tileSize = 0;
        /// What the tile lies on.
        std::function<Hash128(std::size_t firstItem, std::size_t itemCount)> surface;
        std::function<bool(std::span<const uint32_t> items, std::span<Value> out, const Progress&)> compute;
        std::function<bool(std::span<const uint32_t> items, std::span<Witness> out, const Progress&)> witness;
        /// Whether a tile's witnesses of the old scene and of the new one tell different stories.
        std::function<bool(std::span<const Witness> before, std::span<const Witness> now)> changed;
    };
    /// False when cancelled; what was finished until then stays in the cache. Errors of writing are kept in status().
    template<typename Value, typename Witness>
    bool run(const Work<Value, Witness>& work, std::span<Value> out, const Progress& progress);

    [[nodiscard]] const TileCounts& counts() const { return counts_; }
    [[nodiscard]] const Status& status() const { return status_; }
    /// The bake is whole: the next one with this layout is compared with it.
    void finish();

private:
    BakeCache(std::filesystem::path folder, Hash128 bake, Hash128 layout);

    std::filesystem::path file_;     ///< tiles of this bake
    std::filesystem::path lastFile_; ///< names the bake before with the same layout
    Hash128 bake_;
    TileFile own_;
    TileFile before_;
    TileCounts counts_;
    Status status_;
};

} // namespace halflight
