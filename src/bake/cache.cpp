#include "bake/cache.h"

#include "halflight/base/file.h"
#include "halflight/scene/baked_scene.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

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
    // Half a record at the end would hide what is appended behind it.
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

template<typename Value, typename Witness>
bool BakeCache::run(const Work<Value, Witness>& work, std::span<Value> out, const Progress& progress)
{
    const std::size_t tileCount = (work.count + work.tileSize - 1) / work.tileSize;
    const auto firstOf = [&](std::size_t tile) { return tile * work.tileSize; };
    const auto sizeOf = [&](std::size_t tile) { return std::min(work.tileSize, work.count - firstOf(tile)); };
    const auto bytesOf = [&](std::size_t tile) { return sizeOf(tile) * (sizeof(Value) + sizeof(Witness)); };
    std::vector<Hash128> surfaces(tileCount);
    for (std::size_t t = 0; t < tileCount; ++t) surfaces[t] = work.surface(firstOf(t), sizeOf(t));

    const auto take = [&](std::size_t tile, std::span<const std::byte> record) {
        std::memcpy(&out[firstOf(tile)], record.data(), sizeOf(tile) * sizeof(Value));
    };
    std::vector<std::size_t> open;       // to be computed
    std::vector<std::size_t> candidates; // to be asked for their witnesses
    counts_.tiles += tileCount;
    for (std::size_t t = 0; t < tileCount; ++t) {
        const auto own = own_.find(work.stage, uint32_t(t), surfaces[t]);
        if (own.size() == bytesOf(t)) {
            take(t, own);
            ++counts_.same;
            continue;
        }
        const bool known = before_.find(work.stage, uint32_t(t), surfaces[t]).size() == bytesOf(t);
        (known ? candidates : open).push_back(t);
    }

    const auto itemsOf = [&](std::span<const std::size_t> tiles) {
        std::vector<uint32_t> items;
        for (const std::size_t t : tiles)
            for (std::size_t i = 0; i < sizeOf(t); ++i) items.push_back(uint32_t(firstOf(t) + i));
        return items;
    };
    const auto store = [&](std::span<const std::size_t> tiles, std::span<const Witness> witnesses) {
        std::vector<TileFile::Record> records;
        std::size_t at = 0;
        for (const std::size_t t : tiles) {
            TileFile::Record record{work.stage, uint32_t(t), surfaces[t], std::vector<std::byte>(bytesOf(t))};
            std::memcpy(record.bytes.data(), &out[firstOf(t)], sizeOf(t) * sizeof(Value));
            std::memcpy(&record.bytes[sizeOf(t) * sizeof(Value)], &witnesses[at], sizeOf(t) * sizeof(Witness));
            at += sizeOf(t);
            records.push_back(std::move(record));
        }
        if (Status s = TileFile::append(file_, records); !s && status_) status_ = s;
    };

    std::map<std::size_t, std::vector<Witness>> witnessesOf; // of open tiles, where they were asked already
    const double witnessShare = candidates.empty() ? 0.0 : 0.1;
    if (!candidates.empty()) {
        const std::vector<uint32_t> items = itemsOf(candidates);
        std::vector<Witness> now(items.size());
        if (!work.witness(items, now, partOf(progress, 0.0, witnessShare))) return false;
        std::vector<std::size_t> kept;
        std::vector<Witness> keptWitnesses;
        std::size_t at = 0;
        for (const std::size_t t : candidates) {
            const auto record = before_.find(work.stage, uint32_t(t), surfaces[t]);
            std::vector<Witness> before(sizeOf(t));
            std::memcpy(before.data(), &record[sizeOf(t) * sizeof(Value)], sizeOf(t) * sizeof(Witness));
            const auto own = std::span<const Witness>(now).subspan(at, sizeOf(t));
            if (work.changed(before, own)) {
                open.push_back(t);
                witnessesOf.emplace(t, std::vector<Witness>(own.begin(), own.end()));
            } else {
                take(t, record);
                kept.push_back(t);
                // The old witnesses stay: small changes, one after another, must not creep in unseen.
                keptWitnesses.insert(keptWitnesses.end(), before.begin(), before.end());
                ++counts_.unchanged;
            }
            at += sizeOf(t);
        }
        std::sort(open.begin(), open.end());
        store(kept, keptWitnesses);
    }

    // In batches, so that an interruption loses little.
    constexpr std::size_t kBatchItems = 1 << 15;
    const std::size_t batchTiles = std::max<std::size_t>(1, kBatchItems / work.tileSize);
    for (std::size_t first = 0; first < open.size(); first += batchTiles) {
        const std::span<const std::size_t> tiles =
            std::span(open).subspan(first, std::min(batchTiles, open.size() - first));
        const auto fraction = [&](std::size_t done) {
            return witnessShare + (1.0 - witnessShare) * double(done) / double(open.size());
        };
        const Progress part = partOf(progress, fraction(first), fraction(first + tiles.size()));
        const std::vector<uint32_t> items = itemsOf(tiles);
        std::vector<Value> values(items.size());
        if (!work.compute(items, values, part)) return false;
        std::vector<std::size_t> unasked;
        std::copy_if(tiles.begin(), tiles.end(), std::back_inserter(unasked),
                     [&](std::size_t t) { return !witnessesOf.contains(t); });
        const std::vector<uint32_t> askedNow = itemsOf(unasked);
        std::vector<Witness> answers(askedNow.size());
        if (!askedNow.empty() && !work.witness(askedNow, answers, Progress{{}, progress.cancel})) return false;
        auto answer = answers.begin();
        for (const std::size_t t : unasked) {
            witnessesOf[t].assign(answer, answer + std::ptrdiff_t(sizeOf(t)));
            answer += std::ptrdiff_t(sizeOf(t));
        }
        std::vector<Witness> witnesses;
        for (const std::size_t t : tiles) {
            const std::vector<Witness> own = std::move(witnessesOf.extract(t).mapped());
            witnesses.insert(witnesses.end(), own.begin(), own.end());
        }
        for (std::size_t i = 0; i < items.size(); ++i) out[items[i]] = values[i];
        store(tiles, witnesses);
    }
    if (open.empty()) progress(work.name, 1.0);
    return true;
}

template bool BakeCache::run(const Work<IrradianceEstimate, float>&, std::span<IrradianceEstimate>, const Progress&);
template bool BakeCache::run(const Work<vec4, vec4>&, std::span<vec4>, const Progress&);
template bool BakeCache::run(const Work<ProbeEstimate, ProbeEstimate>&, std::span<ProbeEstimate>, const Progress&);

} // namespace halflight
