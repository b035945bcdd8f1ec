#include "bake/cache.h"

#include "halflight/base/bytes.h"
#include "halflight/base/file.h"
#include "halflight/scene/baked_scene.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace halflight {
namespace {

constexpr std::size_t kKeptBakes = 8;
constexpr std::chrono::hours kInUse{1}; ///< a folder used within it may belong to a bake that runs
constexpr const char* kSuffix = ".tiles";

/// The folders of a kind, the most recently used first.
std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>>
foldersIn(const std::filesystem::path& folder, const std::string& suffix)
{
    std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> found;
    std::error_code ec;
    for (std::filesystem::directory_iterator entry(folder, ec), end; !ec && entry != end; entry.increment(ec)) {
        if (entry->path().extension() == suffix) found.emplace_back(entry->last_write_time(ec), entry->path());
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a > b; });
    return found;
}

std::filesystem::path lastBake(const std::filesystem::path& folder, const std::filesystem::path& lastFile)
{
    const Result<std::vector<std::byte>> bytes = readFile(lastFile);
    if (!bytes || bytes->size() != 32) return {};
    std::string name(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    if (name.find_first_not_of("0123456789abcdef") != std::string::npos) return {};
    return folder / (name + kSuffix);
}

} // namespace

std::size_t texelTilesPerPart(std::size_t tiles)
{
    constexpr std::size_t kParts = 64;
    return std::clamp<std::size_t>((tiles + kParts - 1) / kParts, 4, 64);
}

std::size_t texelParts(std::size_t texels)
{
    const std::size_t tiles = Tiling{texels, kTexelTile}.tileCount();
    const std::size_t perPart = texelTilesPerPart(tiles);
    return (tiles + perPart - 1) / perPart;
}

std::size_t texelsOfPart(std::size_t texels)
{
    return texelTilesPerPart(Tiling{texels, kTexelTile}.tileCount()) * kTexelTile;
}

PartFolder openBakeFolder(const std::filesystem::path& cache, const std::string& name, const std::string& suffix)
{
    PartFolder parts(cache / (name + suffix));
    std::error_code ec;
    std::filesystem::create_directories(parts.path(), ec);
    const auto now = std::filesystem::file_time_type::clock::now();
    std::filesystem::last_write_time(parts.path(), now, ec);
    parts.removeAbandoned(kInUse);
    const auto folders = foldersIn(cache, suffix);
    for (std::size_t i = kKeptBakes; i < folders.size(); ++i) {
        if (now - folders[i].first > kInUse) std::filesystem::remove_all(folders[i].second, ec);
    }
    return parts;
}

BakeCache::BakeCache(const std::filesystem::path& folder, Hash128 bake, Hash128 layout, bool compares)
    : parts_(openBakeFolder(folder, bake.hex(), kSuffix)), before_({}), lastFile_(folder / (layout.hex() + ".last")),
      bake_(bake), compares_(compares)
{
    if (compares_) before_ = PartFolder(lastBake(folder, lastFile_));
}

Result<BakeCache> BakeCache::open(const std::filesystem::path& folder, Hash128 bake, Hash128 layout, bool compares)
{
    BakeCache cache(folder, bake, layout, compares);
    std::error_code ec;
    if (!std::filesystem::is_directory(cache.parts_.path(), ec))
        return Error{ErrorCode::WriteFailed, cache.parts_.path().string() + " cannot be made into a folder"};
    return cache;
}

void BakeCache::finish()
{
    finished_ = writeFileAtomically(lastFile_, bake_.hex());
}

Status BakeCache::status() const
{
    return parts_.status() ? finished_ : parts_.status();
}

namespace {

/// Share of a stage's progress that the comparison of check samples takes.
constexpr double kComparisonShare = 0.1;
/// Items that a bake by itself computes between two writes: what an interruption can lose.
constexpr std::size_t kBatchItems = 1 << 15;

std::vector<uint32_t> itemsOf(const Tiling& tiling, std::span<const std::size_t> tiles)
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

enum class TileState : uint8_t { Missing, Own, Compare, Unchanged, Changed };

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

    /// Takes tiles with an equal surface from a folder.
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
                const bool whole = record.header.surface == tiles_[i].header.surface &&
                                   record.values.size() == tiling_.size(tiles_[i].header.tile) &&
                                   (!needsChecks || record.checks.size() == record.values.size());
                if (!whole) continue;
                tiles_[i] = std::move(record);
                states_[i] = state;
            }
        }
    }

    /// Compares check samples with those of the last bake. False when cancelled.
    bool compare(const Progress& progress)
    {
        const std::vector<std::size_t> places = placesOf(TileState::Compare);
        if (places.empty()) return true;
        std::vector<Check> now(itemCount(places));
        if (!work_.check(items(places), now, progress)) return false;
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
        return true;
    }

    /// Computes the values of missing and changed tiles, and check samples of missing ones. False when cancelled.
    bool compute(bool withChecks, const Progress& progress)
    {
        std::vector<std::size_t> places = placesOf(TileState::Missing);
        if (withChecks && !places.empty()) {
            std::vector<Check> checks(itemCount(places));
            if (!work_.check(items(places), checks, Progress{{}, progress.cancel})) return false;
            distribute(places, std::span<const Check>(checks), &Record<Value, Check>::checks);
        }
        const std::vector<std::size_t> changed = placesOf(TileState::Changed);
        places.insert(places.end(), changed.begin(), changed.end());
        std::sort(places.begin(), places.end());
        if (places.empty()) return true;
        std::vector<Value> values(itemCount(places));
        if (!work_.compute(items(places), values, progress)) return false;
        distribute(places, std::span<const Value>(values), &Record<Value, Check>::values);
        return true;
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

    void merge(std::span<Value> out) const
    {
        for (const Record<Value, Check>& tile : tiles_)
            std::copy(tile.values.begin(), tile.values.end(),
                      out.begin() + std::ptrdiff_t(tiling_.first(tile.header.tile)));
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
    [[nodiscard]] std::size_t itemCount(std::span<const std::size_t> places) const
    {
        return std::accumulate(places.begin(), places.end(), std::size_t(0), [&](std::size_t sum, std::size_t i) {
            return sum + tiling_.size(tiles_[i].header.tile);
        });
    }
    template<typename T> void distribute(std::span<const std::size_t> places, std::span<const T> all,
                                         std::vector<T> Record<Value, Check>::*member)
    {
        for (const std::size_t i : places) {
            const auto own = all.first(tiling_.size(tiles_[i].header.tile));
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

} // namespace

template<typename Value, typename Check>
bool BakeCache::runParts(const Work<Value, Check>& work, std::span<const std::size_t> parts, std::size_t partsAtOnce,
                         std::span<Value> out, const Progress& progress)
{
    const Tiling tiling{work.count, work.tileSize};
    for (std::size_t first = 0; first < parts.size(); first += partsAtOnce) {
        const auto some = parts.subspan(first, std::min(partsAtOnce, parts.size() - first));
        const double begin = double(first) / double(parts.size());
        const double end = double(first + some.size()) / double(parts.size());
        TileGroup<Value, Check> group(work, tiling, some);
        group.take(parts_, TileState::Own, false);
        if (compares_) group.take(before_, TileState::Compare, true);
        const double compared = begin + (group.count(TileState::Compare) > 0 ? kComparisonShare : 0.0) * (end - begin);
        if (!group.compare(partOf(progress, begin, compared))) return false;
        if (!group.compute(compares_, partOf(progress, compared, end))) return false;
        if (!group.write(parts_) && parts_.isShared()) return false;
        if (!out.empty()) group.merge(out);
        counts_.tiles += group.size();
        counts_.same += group.count(TileState::Own);
        counts_.unchanged += group.count(TileState::Unchanged);
    }
    progress(work.progressName, 1.0);
    return true;
}

template<typename Value, typename Check>
bool BakeCache::run(const Work<Value, Check>& work, std::span<Value> out, const Progress& progress)
{
    const std::size_t tiles = Tiling{work.count, work.tileSize}.tileCount();
    return run(work, workOrder((tiles + work.tilesPerPart - 1) / work.tilesPerPart, parts_.share()), out, progress);
}

template<typename Value, typename Check> bool BakeCache::run(const Work<Value, Check>& work,
                                                             std::span<const std::size_t> parts, std::span<Value> out,
                                                             const Progress& progress)
{
    const std::size_t atOnce = std::max<std::size_t>(1, kBatchItems / (work.tilesPerPart * work.tileSize));
    return runParts(work, parts, parts_.isShared() ? 1 : atOnce, out, progress);
}

template<typename Value, typename Check>
bool BakeCache::fill(const Work<Value, Check>& work, std::span<const std::size_t> parts, const Progress& progress)
{
    return runParts(work, parts, 1, std::span<Value>(), progress);
}

template bool BakeCache::run(const Work<IrradianceEstimate, float>&, std::span<IrradianceEstimate>, const Progress&);
template bool BakeCache::run(const Work<vec4, vec4>&, std::span<vec4>, const Progress&);
template bool BakeCache::run(const Work<IrradianceEstimate, float>&, std::span<const std::size_t>,
                             std::span<IrradianceEstimate>, const Progress&);
template bool BakeCache::run(const Work<ProbeEstimate, ProbeEstimate>&, std::span<ProbeEstimate>, const Progress&);
template bool BakeCache::fill(const Work<IrradianceEstimate, float>&, std::span<const std::size_t>, const Progress&);
template bool BakeCache::fill(const Work<vec4, vec4>&, std::span<const std::size_t>, const Progress&);

} // namespace halflight
