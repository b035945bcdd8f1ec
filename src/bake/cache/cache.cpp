#include "bake/cache/cache.h"

#include "bake/cache/tile_group.h"

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

std::filesystem::path lastFolder(const std::filesystem::path& folder, const std::filesystem::path& lastFile)
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

std::filesystem::path folderOfIdentity(const std::filesystem::path& cache, const std::string& identity)
{
    return cache.empty() ? cache : cache / identity;
}

std::string resultsOfOthers(const std::filesystem::path& cache, const std::string& identity)
{
    std::vector<std::string> others;
    std::error_code ec;
    for (std::filesystem::directory_iterator entry(cache, ec), end; !ec && entry != end; entry.increment(ec)) {
        const std::string name = entry->path().filename().string();
        if (name.starts_with("cpu-") && name != identity && entry->is_directory(ec)) others.push_back(name);
    }
    if (others.empty()) return {};
    std::sort(others.begin(), others.end());
    std::string names;
    for (const std::string& name : others) names += (names.empty() ? "" : ", ") + name;
    return "the cache " + cache.string() + " also holds results of other programs or processors (" + names +
           "): they " + "stay there, and are not used here, where it is " + identity;
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
    if (compares_) before_ = PartFolder(lastFolder(folder, lastFile_));
}

Result<BakeCache> BakeCache::open(const std::filesystem::path& folder, Hash128 bake, Hash128 layout, bool compares)
{
    BakeCache cache(folder, bake, layout, compares);
    std::error_code ec;
    if (!std::filesystem::is_directory(cache.parts_.path(), ec))
        return Error{ErrorCode::WriteFailed, cache.parts_.path().string() + " cannot be made into a folder"};
    return cache;
}

Result<PartFolder> BakeCache::lastBake(const std::filesystem::path& folder, Hash128 layout)
{
    const std::filesystem::path last = lastFolder(folder, folder / (layout.hex() + ".last"));
    std::error_code ec;
    if (!last.empty() && std::filesystem::is_directory(last, ec)) return PartFolder(last);
    return Error{ErrorCode::Unsupported,
                 "the cache " + folder.string() + " holds no finished bake with this layout and these settings, " +
                     "whose light the other objects could keep: bake the whole scene once with this cache"};
}

Result<BakeCache> BakeCache::openKeeping(const std::filesystem::path& folder, Hash128 bake, Hash128 layout,
                                         Hash128 chosen)
{
    const Result<PartFolder> found = lastBake(folder, layout);
    if (!found) return found.error();
    const std::filesystem::path last = found->path();
    openBakeFolder(folder, last.stem().string(), kSuffix); // so that it counts as used
    Result<BakeCache> cache = open(folder, bake, layout);
    if (!cache) return cache;
    cache->bake_ = Hasher().add(bake).add(std::string_view(last.stem().string())).add(chosen).hash();
    cache->mixed_ = openBakeFolder(folder, cache->bake_.hex(), kSuffix);
    return cache;
}

void BakeCache::finish()
{
    finished_ = writeFileAtomically(lastFile_, bake_.hex());
}

Status BakeCache::status() const
{
    if (!parts_.status()) return parts_.status();
    return mixed_ && !mixed_->status() ? mixed_->status() : finished_;
}

namespace {

/// Share of a stage's progress that the comparison of check samples takes.
constexpr double kComparisonShare = 0.1;
/// Items that a bake by itself computes between two writes: what an interruption can lose.
constexpr std::size_t kBatchItems = 1 << 15;

} // namespace

template<typename Value, typename Check>
Status BakeCache::runParts(const Work<Value, Check>& work, std::span<const std::size_t> parts, std::size_t partsAtOnce,
                           std::span<Value> out, const Progress& progress)
{
    const Tiling tiling{work.count, work.tileSize};
    for (std::size_t first = 0; first < parts.size(); first += partsAtOnce) {
        const auto some = parts.subspan(first, std::min(partsAtOnce, parts.size() - first));
        const double begin = double(first) / double(parts.size());
        const double end = double(first + some.size()) / double(parts.size());
        TileGroup<Value, Check> group(work, tiling, some);
        group.take(tiles(), TileState::Own, false);
        if (mixed_ && work.keeps) {
            group.take(before_, TileState::Kept, false);
        } else if (compares_) {
            group.take(before_, TileState::Compare, true);
        }
        lost_ += group.lost();
        const double compared = begin + (group.count(TileState::Compare) > 0 ? kComparisonShare : 0.0) * (end - begin);
        if (Status s = group.compare(partOf(progress, begin, compared)); !s) return s;
        if (Status s = group.compute(compares_, partOf(progress, compared, end)); !s) return s;
        if (Status s = group.computeChosen(partOf(progress, compared, end)); !s) return s;
        if (!group.write(tiles()) && parts_.isShared()) return tiles().status();
        group.merge(out);
        counts_.tiles += group.size();
        counts_.same += group.count(TileState::Own);
        counts_.unchanged += group.count(TileState::Unchanged);
        counts_.kept += group.count(TileState::Kept);
    }
    progress(work.progressName, 1.0);
    return {};
}

template<typename Value, typename Check>
Status BakeCache::run(const Work<Value, Check>& work, std::span<Value> out, const Progress& progress)
{
    const std::size_t tiles = Tiling{work.count, work.tileSize}.tileCount();
    return run(work, workOrder((tiles + work.tilesPerPart - 1) / work.tilesPerPart, parts_.share()), out, progress);
}

template<typename Value, typename Check> Status BakeCache::run(const Work<Value, Check>& work,
                                                               std::span<const std::size_t> parts, std::span<Value> out,
                                                               const Progress& progress)
{
    const std::size_t atOnce = std::max<std::size_t>(1, kBatchItems / (work.tilesPerPart * work.tileSize));
    return runParts(work, parts, parts_.isShared() ? 1 : atOnce, out, progress);
}

template<typename Value, typename Check>
Status BakeCache::fill(const Work<Value, Check>& work, std::span<const std::size_t> parts, const Progress& progress)
{
    return runParts(work, parts, 1, std::span<Value>(), progress);
}

template Status BakeCache::run(const Work<IrradianceEstimate, float>&, std::span<IrradianceEstimate>, const Progress&);
template Status BakeCache::run(const Work<vec4, vec4>&, std::span<vec4>, const Progress&);
template Status BakeCache::run(const Work<IrradianceEstimate, float>&, std::span<const std::size_t>,
                               std::span<IrradianceEstimate>, const Progress&);
template Status BakeCache::run(const Work<ProbeEstimate, ProbeEstimate>&, std::span<ProbeEstimate>, const Progress&);
template Status BakeCache::fill(const Work<IrradianceEstimate, float>&, std::span<const std::size_t>, const Progress&);
template Status BakeCache::fill(const Work<vec4, vec4>&, std::span<const std::size_t>, const Progress&);

} // namespace halflight
