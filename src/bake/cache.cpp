#include "bake/cache.h"

#include "halflight/base/file.h"
#include "halflight/scene/baked_scene.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

namespace halflight {
namespace {

constexpr char kMagic[8] = {'H', 'L', 'T', 'I', 'L', 'E', 'S', '1'};
constexpr std::size_t kKeptBakes = 8;
constexpr const char* kSuffix = ".tiles";

struct RecordHeader {
    uint32_t stage;
    uint32_t tile;
    Hash128 surface;
    uint64_t byteCount;
    Hash128 checksum; ///< of the bytes that follow
};
static_assert(std::has_unique_object_representations_v<RecordHeader>);

Hash128 checksumOf(std::span<const std::byte> bytes)
{
    return Hasher().bytes(bytes.data(), bytes.size()).hash();
}

/// The folder's tile files, the most recently used first.
std::vector<std::filesystem::path> tileFiles(const std::filesystem::path& folder)
{
    std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> found;
    std::error_code ec;
    for (std::filesystem::directory_iterator entry(folder, ec), end; !ec && entry != end; entry.increment(ec)) {
        if (entry->path().extension() == kSuffix) found.emplace_back(entry->last_write_time(ec), entry->path());
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a > b; });
    std::vector<std::filesystem::path> files;
    for (auto& [time, path] : found) files.push_back(std::move(path));
    return files;
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

TileFile::TileFile(const std::filesystem::path& path)
{
    Result<std::vector<std::byte>> bytes = readFile(path);
    if (!bytes || bytes->size() < sizeof(kMagic) || std::memcmp(bytes->data(), kMagic, sizeof(kMagic)) != 0) return;
    bytes_ = std::move(*bytes);
    std::size_t at = sizeof(kMagic);
    byteCount_ = at;
    while (bytes_.size() - at >= sizeof(RecordHeader)) {
        RecordHeader header{};
        std::memcpy(&header, &bytes_[at], sizeof(header));
        at += sizeof(header);
        if (header.byteCount > bytes_.size() - at) break;
        const std::span<const std::byte> record(&bytes_[at], std::size_t(header.byteCount));
        if (checksumOf(record) != header.checksum) break;
        records_[{header.stage, header.tile}] = {at, record.size(), header.surface};
        at += record.size();
        byteCount_ = at;
    }
}

std::span<const std::byte> TileFile::find(CachedStage stage, uint32_t tile, Hash128 surface) const
{
    const auto it = records_.find({uint32_t(stage), tile});
    if (it == records_.end() || it->second.surface != surface) return {};
    return {bytes_.data() + it->second.begin, it->second.size};
}

Status TileFile::append(const std::filesystem::path& path, std::span<const Record> records)
{
    std::vector<std::byte> bytes;
    const auto add = [&](const void* data, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(data);
        bytes.insert(bytes.end(), first, first + size);
    };
    std::error_code ec;
    if (!std::filesystem::exists(path, ec)) add(kMagic, sizeof(kMagic));
    for (const Record& record : records) {
        const RecordHeader header{uint32_t(record.stage), record.tile, record.surface, record.bytes.size(),
                                  checksumOf(record.bytes)};
        add(&header, sizeof(header));
        add(record.bytes.data(), record.bytes.size());
    }
    std::ofstream stream(path, std::ios::binary | std::ios::app);
    stream.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    stream.flush();
    if (!stream) return Error{ErrorCode::WriteFailed, path.string() + " cannot be written (is the disk full?)"};
    return {};
}

BakeCache::BakeCache(std::filesystem::path folder, Hash128 bake, Hash128 layout)
    : file_(folder / (bake.hex() + kSuffix)), lastFile_(folder / (layout.hex() + ".last")), bake_(bake), own_(file_),
      before_(lastBake(folder, lastFile_))
{}

Result<BakeCache> BakeCache::open(const std::filesystem::path& folder, Hash128 bake, Hash128 layout)
{
    std::error_code ec;
    std::filesystem::create_directories(folder, ec);
    if (ec) {
        return Error{ErrorCode::WriteFailed, folder.string() + " cannot be made into a folder (" + ec.message() + ")"};
    }
    BakeCache cache(folder, bake, layout);
    // Records behind an incomplete one could not be found.
    if (cache.own_.byteCount() == 0) {
        std::filesystem::remove(cache.file_, ec);
    } else {
        std::filesystem::resize_file(cache.file_, cache.own_.byteCount(), ec);
        std::filesystem::last_write_time(cache.file_, std::filesystem::file_time_type::clock::now(), ec);
    }
    std::vector<std::filesystem::path> files = tileFiles(folder);
    for (std::size_t i = kKeptBakes; i < files.size(); ++i) std::filesystem::remove(files[i], ec);
    return cache;
}

void BakeCache::finish()
{
    if (Status s = writeFileAtomically(lastFile_, bake_.hex()); !s && status_) status_ = s;
}

namespace {

/// Share of a stage's progress that the comparison of check samples takes.
constexpr double kComparisonShare = 0.1;
/// Items that are computed between two writes: what an interruption can lose.
constexpr std::size_t kBatchItems = 1 << 15;

/// Check samples by tile, of tiles that were compared and have changed.
template<typename Check> using ChecksOfTiles = std::map<std::size_t, std::vector<Check>>;

std::vector<uint32_t> itemsOf(const Tiling& tiling, std::span<const std::size_t> tiles)
{
    std::vector<uint32_t> items;
    for (const std::size_t t : tiles)
        for (std::size_t i = 0; i < tiling.size(t); ++i) items.push_back(uint32_t(tiling.first(t) + i));
    return items;
}

/// A record holds a tile's values, then its check samples.
template<typename Value, typename Check> std::size_t recordBytes(const Tiling& tiling, std::size_t tile)
{
    return tiling.size(tile) * (sizeof(Value) + sizeof(Check));
}
template<typename Value>
void mergeRecord(const Tiling& tiling, std::size_t tile, std::span<const std::byte> record, std::span<Value> out)
{
    std::memcpy(&out[tiling.first(tile)], record.data(), tiling.size(tile) * sizeof(Value));
}
template<typename Value, typename Check>
std::vector<Check> checksIn(const Tiling& tiling, std::size_t tile, std::span<const std::byte> record)
{
    std::vector<Check> checks(tiling.size(tile));
    std::memcpy(checks.data(), &record[tiling.size(tile) * sizeof(Value)], tiling.size(tile) * sizeof(Check));
    return checks;
}

/// Records of tiles whose values are in `out`; `checks` holds the check samples of all of them in order.
template<typename Value, typename Check>
std::vector<TileFile::Record> recordsOf(CachedStage stage, const TilePlan& plan, std::span<const std::size_t> tiles,
                                        std::span<const Value> out, std::span<const Check> checks)
{
    const Tiling& tiling = plan.tiling;
    std::vector<TileFile::Record> records;
    for (const std::size_t t : tiles) {
        const std::size_t size = tiling.size(t);
        TileFile::Record record{stage, uint32_t(t), plan.surfaces[t],
                                std::vector<std::byte>(recordBytes<Value, Check>(tiling, t))};
        std::memcpy(record.bytes.data(), &out[tiling.first(t)], size * sizeof(Value));
        std::memcpy(&record.bytes[size * sizeof(Value)], checks.data(), size * sizeof(Check));
        checks = checks.subspan(size);
        records.push_back(std::move(record));
    }
    return records;
}

/// Check samples of the given tiles, in order: those of `known` (which lose them), the others computed now. Nothing
/// when cancelled.
template<typename Value, typename Check>
std::optional<std::vector<Check>> checksOf(const BakeCache::Work<Value, Check>& work, const Tiling& tiling,
                                           std::span<const std::size_t> tiles, ChecksOfTiles<Check>& known,
                                           const Progress& progress)
{
    std::vector<std::size_t> unknown;
    std::copy_if(tiles.begin(), tiles.end(), std::back_inserter(unknown),
                 [&](std::size_t t) { return !known.contains(t); });
    const std::vector<uint32_t> items = itemsOf(tiling, unknown);
    std::vector<Check> computed(items.size());
    if (!items.empty() && !work.check(items, computed, Progress{{}, progress.cancel})) return std::nullopt;
    auto next = computed.begin();
    std::vector<Check> checks;
    for (const std::size_t t : tiles) {
        if (auto found = known.extract(t)) {
            checks.insert(checks.end(), found.mapped().begin(), found.mapped().end());
        } else {
            const auto end = next + std::ptrdiff_t(tiling.size(t));
            checks.insert(checks.end(), next, end);
            next = end;
        }
    }
    return checks;
}

} // namespace

template<typename Value, typename Check> TilePlan BakeCache::plan(const Work<Value, Check>& work) const
{
    TilePlan plan;
    plan.tiling = {work.count, work.tileSize};
    for (std::size_t t = 0; t < plan.tiling.tileCount(); ++t) {
        plan.surfaces.push_back(work.surface(plan.tiling.first(t), plan.tiling.size(t)));
        const std::size_t bytes = recordBytes<Value, Check>(plan.tiling, t);
        const auto holds = [&](const TileFile& file) {
            return file.find(work.stage, uint32_t(t), plan.surfaces[t]).size() == bytes;
        };
        (holds(own_) ? plan.reuse : holds(before_) ? plan.compare : plan.compute).push_back(t);
    }
    return plan;
}

void BakeCache::append(std::span<const TileFile::Record> records)
{
    if (Status s = TileFile::append(file_, records); !s && status_) status_ = s;
}

template<typename Value, typename Check>
bool BakeCache::compare(const Work<Value, Check>& work, TilePlan& plan, std::span<Value> out,
                        std::map<std::size_t, std::vector<Check>>& changedChecks, const Progress& progress)
{
    const std::vector<uint32_t> items = itemsOf(plan.tiling, plan.compare);
    std::vector<Check> now(items.size());
    if (!work.check(items, now, progress)) return false;
    std::vector<std::size_t> unchanged;
    std::vector<Check> unchangedChecks;
    std::span<const Check> rest(now);
    for (const std::size_t t : plan.compare) {
        const auto record = before_.find(work.stage, uint32_t(t), plan.surfaces[t]);
        const std::vector<Check> before = checksIn<Value, Check>(plan.tiling, t, record);
        const auto own = rest.first(plan.tiling.size(t));
        rest = rest.subspan(own.size());
        if (work.changed(before, own)) {
            plan.compute.push_back(t);
            changedChecks.emplace(t, std::vector<Check>(own.begin(), own.end()));
            continue;
        }
        mergeRecord(plan.tiling, t, record, out);
        unchanged.push_back(t);
        // The record keeps the old check samples, so that a series of small changes adds up until it is detected.
        unchangedChecks.insert(unchangedChecks.end(), before.begin(), before.end());
    }
    counts_.unchanged += unchanged.size();
    std::sort(plan.compute.begin(), plan.compute.end());
    append(recordsOf<Value, Check>(work.stage, plan, unchanged, out, unchangedChecks));
    return true;
}

template<typename Value, typename Check>
bool BakeCache::compute(const Work<Value, Check>& work, const TilePlan& plan, std::span<Value> out,
                        std::map<std::size_t, std::vector<Check>>& changedChecks, const Progress& progress)
{
    const std::span<const std::size_t> all(plan.compute);
    const std::size_t batchTiles = std::max<std::size_t>(1, kBatchItems / work.tileSize);
    for (std::size_t first = 0; first < all.size(); first += batchTiles) {
        const auto tiles = all.subspan(first, std::min(batchTiles, all.size() - first));
        const Progress part =
            partOf(progress, double(first) / double(all.size()), double(first + tiles.size()) / double(all.size()));
        const std::vector<uint32_t> items = itemsOf(plan.tiling, tiles);
        std::vector<Value> values(items.size());
        if (!work.compute(items, values, part)) return false;
        const auto checks = checksOf<Value, Check>(work, plan.tiling, tiles, changedChecks, progress);
        if (!checks) return false;
        for (std::size_t i = 0; i < items.size(); ++i) out[items[i]] = values[i];
        append(recordsOf<Value, Check>(work.stage, plan, tiles, out, *checks));
    }
    return true;
}

template<typename Value, typename Check>
bool BakeCache::run(const Work<Value, Check>& work, std::span<Value> out, const Progress& progress)
{
    TilePlan plan = this->plan(work);
    counts_.tiles += plan.tiling.tileCount();
    counts_.same += plan.reuse.size();
    for (const std::size_t t : plan.reuse)
        mergeRecord(plan.tiling, t, own_.find(work.stage, uint32_t(t), plan.surfaces[t]), out);
    ChecksOfTiles<Check> changedChecks;
    const double compared = plan.compare.empty() ? 0.0 : kComparisonShare;
    if (!plan.compare.empty() && !compare(work, plan, out, changedChecks, partOf(progress, 0.0, compared)))
        return false;
    if (!compute(work, plan, out, changedChecks, partOf(progress, compared, 1.0))) return false;
    if (plan.compute.empty()) progress(work.name, 1.0);
    return true;
}

template bool BakeCache::run(const Work<IrradianceEstimate, float>&, std::span<IrradianceEstimate>, const Progress&);
template bool BakeCache::run(const Work<vec4, vec4>&, std::span<vec4>, const Progress&);
template bool BakeCache::run(const Work<ProbeEstimate, ProbeEstimate>&, std::span<ProbeEstimate>, const Progress&);

} // namespace halflight
