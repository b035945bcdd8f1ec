#pragma once
// Tiles of the tile cache while a bake finds, compares, computes and writes them.

#include "bake/cache/cache.h"

#include "halflight/base/bytes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace halflight {

inline std::vector<uint32_t> itemsOf(const Tiling& tiling, std::span<const std::size_t> tiles)
{
    std::vector<uint32_t> items;
    for (const std::size_t t : tiles)
        for (std::size_t i = 0; i < tiling.size(t); ++i) items.push_back(uint32_t(tiling.first(t) + i));
    return items;
}

/// One tile in a part, followed by its values and check samples.
struct RecordHeader {
    uint32_t tile = 0;
    uint32_t values = 0;
    uint32_t checks = 0; ///< as many as values, or none
    uint32_t reserved = 0;
    Hash128 surface;
};

template<typename Value, typename Check> struct Record {
    RecordHeader header;
    std::vector<Value> values;
    std::vector<Check> checks;
};

template<typename Value, typename Check>
std::map<std::size_t, Record<Value, Check>> readRecords(const PartFolder& folder, const std::string& name)
{
    std::map<std::size_t, Record<Value, Check>> records;
    const std::optional<std::vector<std::byte>> bytes = folder.read(name);
    if (!bytes) return records;
    ByteReader reader(*bytes);
    while (!reader.atEnd()) {
        Record<Value, Check> record;
        reader.read(record.header);
        reader.read(record.values).read(record.checks);
        if (!reader.ok() || record.values.size() != record.header.values) return {};
        records.emplace(record.header.tile, std::move(record));
    }
    return records;
}

enum class TileState : uint8_t { Missing, Own, Compare, Unchanged, Changed, Kept };

/// One or more parts of a stage while their tiles are found, compared and computed.
template<typename Value, typename Check> class TileGroup {
public:
    using Work = BakeCache::Work<Value, Check>;

    TileGroup(const Work& work, Tiling tiling, std::span<const std::size_t> parts)
        : work_(work), tiling_(tiling), parts_(parts)
    {
        for (const std::size_t part : parts) {
            const std::size_t first = part * work.tilesPerPart;
            const std::size_t end = std::min(first + work.tilesPerPart, tiling.tileCount());
            for (std::size_t t = first; t < end; ++t)
                tiles_.push_back({{uint32_t(t), 0, 0, 0, work.surface(tiling.first(t), tiling.size(t))}, {}, {}});
        }
        states_.assign(tiles_.size(), TileState::Missing);
    }

    /// Takes tiles from a folder; those with an equal surface unless items are chosen.
    void take(const PartFolder& folder, TileState state, bool needsChecks)
    {
        if (folder.path().empty()) return;
        std::size_t i = 0;
        for (const std::size_t part : parts_) {
            const std::size_t end = std::min(i + work_.tilesPerPart, tiles_.size());
            auto records = missing(i, end) ? readRecords<Value, Check>(folder, partName(work_.stage, part))
                                           : std::map<std::size_t, Record<Value, Check>>();
            for (; i < end; ++i) {
                const auto found = records.find(tiles_[i].header.tile);
                if (states_[i] != TileState::Missing || found == records.end()) continue;
                Record<Value, Check>& record = found->second;
                const bool fits = !work_.chosen.empty() || record.header.surface == tiles_[i].header.surface;
                const bool whole = fits && record.values.size() == valuesOf(tiles_[i].header.tile) &&
                                   (!needsChecks || record.checks.size() == record.values.size());
                if (!whole) continue;
                tiles_[i] = std::move(record);
                states_[i] = state;
            }
        }
    }

    /// Compares check samples with those of the last bake.
    Status compare(const Progress& progress)
    {
        const std::vector<std::size_t> places = placesOf(TileState::Compare);
        if (places.empty()) return {};
        std::vector<Check> now(valueCount(places));
        if (Status s = work_.check(items(places), now, progress); !s) return s;
        std::span<const Check> rest(now);
        for (const std::size_t i : places) {
            const auto own = rest.first(tiles_[i].values.size());
            rest = rest.subspan(own.size());
            // An unchanged tile keeps the old check samples, so that a series of small changes adds up until it is
            // detected.
            if (!work_.changed(tiles_[i].checks, own)) {
                states_[i] = TileState::Unchanged;
                continue;
            }
            states_[i] = TileState::Changed;
            tiles_[i].checks.assign(own.begin(), own.end());
        }
        return {};
    }

    /// Computes the chosen items of kept tiles, values and check samples.
    Status computeChosen(const Progress& progress)
    {
        if (work_.chosen.empty()) return {};
        std::vector<uint32_t> chosen;
        for (const std::size_t i : placesOf(TileState::Kept)) {
            const std::size_t first = tiling_.first(tiles_[i].header.tile);
            for (std::size_t k = 0; k < tiling_.size(tiles_[i].header.tile); ++k)
                if (work_.chosen[first + k] != 0) chosen.push_back(uint32_t(first + k));
        }
        if (chosen.empty()) return {};
        const std::size_t n = work_.perItem;
        std::vector<Check> checks(chosen.size() * n);
        std::vector<Value> values(chosen.size() * n);
        if (Status s = work_.check(chosen, checks, Progress{{}, progress.cancel}); !s) return s;
        if (Status s = work_.compute(chosen, values, progress); !s) return s;
        std::size_t next = 0;
        for (const std::size_t i : placesOf(TileState::Kept)) {
            Record<Value, Check>& tile = tiles_[i];
            const std::size_t first = tiling_.first(tile.header.tile);
            const std::size_t before = next;
            const std::size_t size = tiling_.size(tile.header.tile);
            for (; next < chosen.size() && chosen[next] < first + size; ++next) {
                const std::size_t to = (chosen[next] - first) * n;
                std::copy_n(values.begin() + std::ptrdiff_t(next * n), n, tile.values.begin() + std::ptrdiff_t(to));
                if (tile.checks.size() != tile.values.size()) continue;
                std::copy_n(checks.begin() + std::ptrdiff_t(next * n), n, tile.checks.begin() + std::ptrdiff_t(to));
            }
            states_[i] = next > before ? TileState::Changed : TileState::Kept;
            if (next == before + size) tile.header.surface = work_.surface(first, size);
        }
        return {};
    }

    /// Number of missing tiles with items that are to be kept.
    [[nodiscard]] std::size_t lost() const
    {
        if (work_.chosen.empty()) return 0;
        const std::vector<std::size_t> places = placesOf(TileState::Missing);
        return std::size_t(std::count_if(places.begin(), places.end(), [&](std::size_t i) {
            const std::size_t tile = tiles_[i].header.tile;
            const auto chosen = work_.chosen.subspan(tiling_.first(tile), tiling_.size(tile));
            return std::find(chosen.begin(), chosen.end(), uint8_t(0)) != chosen.end();
        }));
    }

    /// Computes the values of missing and changed tiles, and check samples of missing ones.
    Status compute(bool withChecks, const Progress& progress)
    {
        std::vector<std::size_t> places = placesOf(TileState::Missing);
        if (withChecks && !places.empty()) {
            std::vector<Check> checks(valueCount(places));
            if (Status s = work_.check(items(places), checks, Progress{{}, progress.cancel}); !s) return s;
            distribute(places, std::span<const Check>(checks), &Record<Value, Check>::checks);
        }
        const std::vector<std::size_t> changed = placesOf(TileState::Changed);
        places.insert(places.end(), changed.begin(), changed.end());
        std::sort(places.begin(), places.end());
        if (places.empty()) return {};
        std::vector<Value> values(valueCount(places));
        if (Status s = work_.compute(items(places), values, progress); !s) return s;
        distribute(places, std::span<const Value>(values), &Record<Value, Check>::values);
        return {};
    }

    /// Writes the parts that have tiles from elsewhere than the folder. False when one cannot be written.
    bool write(PartFolder& folder)
    {
        bool written = true;
        std::size_t i = 0;
        for (const std::size_t part : parts_) {
            const std::size_t end = std::min(i + work_.tilesPerPart, tiles_.size());
            const bool isOwn = std::all_of(states_.begin() + std::ptrdiff_t(i), states_.begin() + std::ptrdiff_t(end),
                                           [](TileState s) { return s == TileState::Own; });
            ByteWriter writer;
            for (; i < end; ++i) {
                RecordHeader& header = tiles_[i].header;
                header.values = uint32_t(tiles_[i].values.size());
                header.checks = uint32_t(tiles_[i].checks.size());
                if (!isOwn) writer.add(header).add(tiles_[i].values).add(tiles_[i].checks);
            }
            if (!isOwn) written = folder.write(partName(work_.stage, part), writer.take()) && written;
        }
        return written;
    }

    /// Gives the values to Work::take, else to `out` unless it is empty.
    void merge(std::span<Value> out) const
    {
        for (const Record<Value, Check>& tile : tiles_) {
            const std::size_t first = tiling_.first(tile.header.tile);
            if (work_.take) {
                work_.take(first, tile.values);
            } else if (!out.empty()) {
                std::ranges::copy(tile.values, out.begin() + std::ptrdiff_t(first * work_.perItem));
            }
        }
    }
    [[nodiscard]] std::size_t count(TileState state) const { return placesOf(state).size(); }
    [[nodiscard]] std::size_t size() const { return tiles_.size(); }

private:
    [[nodiscard]] bool missing(std::size_t begin, std::size_t end) const
    {
        return std::any_of(states_.begin() + std::ptrdiff_t(begin), states_.begin() + std::ptrdiff_t(end),
                           [](TileState s) { return s == TileState::Missing; });
    }
    [[nodiscard]] std::vector<std::size_t> placesOf(TileState state) const
    {
        std::vector<std::size_t> places;
        for (std::size_t i = 0; i < states_.size(); ++i)
            if (states_[i] == state) places.push_back(i);
        return places;
    }
    [[nodiscard]] std::vector<uint32_t> items(std::span<const std::size_t> places) const
    {
        std::vector<std::size_t> tiles;
        for (const std::size_t i : places) tiles.push_back(tiles_[i].header.tile);
        return itemsOf(tiling_, tiles);
    }
    [[nodiscard]] std::size_t valuesOf(std::size_t tile) const { return tiling_.size(tile) * work_.perItem; }
    [[nodiscard]] std::size_t valueCount(std::span<const std::size_t> places) const
    {
        return std::accumulate(places.begin(), places.end(), std::size_t(0),
                               [&](std::size_t sum, std::size_t i) { return sum + valuesOf(tiles_[i].header.tile); });
    }
    template<typename T> void distribute(std::span<const std::size_t> places, std::span<const T> all,
                                         std::vector<T> Record<Value, Check>::*member)
    {
        for (const std::size_t i : places) {
            const auto own = all.first(valuesOf(tiles_[i].header.tile));
            (tiles_[i].*member).assign(own.begin(), own.end());
            all = all.subspan(own.size());
        }
    }

    const Work& work_;
    Tiling tiling_;
    std::span<const std::size_t> parts_;
    std::vector<Record<Value, Check>> tiles_;
    std::vector<TileState> states_;
};

} // namespace halflight
