#include "halflight/bake/part_folder.h"

#include "halflight/base/file.h"
#include "halflight/base/hash.h"
#include "halflight/base/system.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <numeric>
#include <random>

namespace halflight {
namespace {

constexpr char kMagic[8] = {'H', 'L', 'P', 'A', 'R', 'T', 'S', '1'};
constexpr const char* kPartSuffix = ".part";
constexpr const char* kTemporary = ".tmp-";

struct Header {
    char magic[8];
    Hash128 checksum; ///< of the name and the bytes that follow
};
static_assert(std::has_unique_object_representations_v<Header>);

Hash128 checksumOf(std::string_view name, std::span<const std::byte> bytes)
{
    return Hasher().add(name).bytes(bytes.data(), bytes.size()).hash();
}

/// Names of processes on all hosts differ.
std::string randomName()
{
    std::random_device device;
    return Hasher().add(device()).add(device()).add(device()).add(device()).hash().hex();
}

} // namespace

std::string partName(std::string_view stage, std::size_t part)
{
    constexpr std::size_t kDigits = 5;
    const std::string number = std::to_string(part);
    return std::string(stage) + '-' + std::string(kDigits - std::min(kDigits, number.size()), '0') + number;
}

std::vector<std::size_t> workOrder(std::size_t count, WorkShare share)
{
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    const auto others = std::stable_partition(order.begin(), order.end(),
                                              [&](std::size_t i) { return i % share.count == share.index; });
    const auto rank = [&](std::size_t i) { return hashCombine(share.index, uint32_t(i)); };
    std::stable_sort(others, order.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    return order;
}

std::filesystem::path PartFolder::fileOf(std::string_view name) const
{
    return folder_ / (std::string(name) + kPartSuffix);
}

bool PartFolder::contains(std::string_view name) const
{
    std::error_code ec;
    return std::filesystem::is_regular_file(fileOf(name), ec);
}

std::optional<std::vector<std::byte>> PartFolder::read(std::string_view name) const
{
    Result<std::vector<std::byte>> file = readFile(fileOf(name));
    if (!file || file->size() < sizeof(Header)) return std::nullopt;
    Header header{};
    std::memcpy(&header, file->data(), sizeof(header));
    if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) return std::nullopt;
    file->erase(file->begin(), file->begin() + sizeof(Header));
    if (checksumOf(name, *file) != header.checksum) return std::nullopt;
    return std::move(*file);
}

bool PartFolder::write(std::string_view name, std::span<const std::byte> bytes)
{
    Header header{};
    std::memcpy(header.magic, kMagic, sizeof(kMagic));
    header.checksum = checksumOf(name, bytes);
    std::vector<std::byte> file(sizeof(Header) + bytes.size());
    std::memcpy(file.data(), &header, sizeof(header));
    if (!bytes.empty()) std::memcpy(&file[sizeof(Header)], bytes.data(), bytes.size());
    const std::filesystem::path path = fileOf(name);
    const std::filesystem::path temporary = path.string() + std::string(kTemporary) + randomName();
    std::error_code ec;
    std::filesystem::create_directories(folder_, ec);
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(file.data()), std::streamsize(file.size()));
    stream.close();
    const Status renamed =
        stream ? renameOver(temporary, path) : Error{ErrorCode::WriteFailed, "cannot be written (is the disk full?)"};
    if (renamed) return true;
    if (status_) status_ = Error{ErrorCode::WriteFailed, path.string() + " " + renamed.error().message};
    std::filesystem::remove(temporary, ec);
    return false;
}

void PartFolder::removeAbandoned(std::chrono::hours age) const
{
    std::error_code ec;
    const auto now = std::filesystem::file_time_type::clock::now();
    for (std::filesystem::directory_iterator entry(folder_, ec), end; !ec && entry != end; entry.increment(ec)) {
        const bool isTemporary = entry->path().filename().string().find(kTemporary) != std::string::npos;
        std::error_code gone;
        if (isTemporary && now - entry->last_write_time(gone) > age) std::filesystem::remove(entry->path(), gone);
    }
}

Result<std::vector<std::vector<std::byte>>> PartFolder::complete(std::string_view stage, std::size_t count,
                                                                 const Compute& compute)
{
    std::vector<std::vector<std::byte>> parts(count);
    std::vector<uint8_t> computed(count);
    const auto make = [&](std::size_t part) -> Status {
        Result<std::vector<std::byte>> bytes = compute(part);
        if (!bytes) return bytes.error();
        parts[part] = std::move(*bytes);
        computed[part] = 1;
        return !isShared() || write(partName(stage, part), parts[part]) ? Status() : status_;
    };
    for (const std::size_t part : workOrder(count, share())) {
        if (isShared() && contains(partName(stage, part))) continue;
        if (Status s = make(part); !s) return s.error();
    }
    for (std::size_t part = 0; part < count; ++part) {
        if (computed[part] != 0) continue;
        std::optional<std::vector<std::byte>> bytes = read(partName(stage, part));
        if (bytes) {
            parts[part] = std::move(*bytes);
        } else if (Status s = make(part); !s) {
            return s.error();
        }
    }
    return parts;
}

} // namespace halflight
