#include "scene/document/decode/decoded_buffer.h"

#include <algorithm>

namespace halflight {

Result<uint64_t> integerMember(const Json& object, const char* key, const std::string& path,
                               std::optional<uint64_t> fallback)
{
    const Json& value = member(object, key);
    if (value.is_null() && fallback) return *fallback;
    constexpr uint64_t kMost = 0xffffffff;
    if (!value.is_number_unsigned() || value.get<uint64_t>() > kMost)
        return invalid(path, std::string(key) + (value.is_null() ? " is missing" : " is not an unsigned integer"));
    return value.get<uint64_t>();
}

DecodedBuffer::DecodedBuffer(Json& json, std::vector<std::vector<std::byte>>& buffers)
    : json_(json), buffers_(buffers), index_(buffers.size())
{
    constexpr uint64_t kFree = uint64_t(1) << 28;
    constexpr uint64_t kMost = uint64_t(1) << 32; // a GLB can hold no more
    constexpr uint64_t kRatio = 256;              // the best that flat meshes reach is some 100:1
    uint64_t source = 0;
    for (const auto& buffer : buffers) source += buffer.size();
    left_ = std::min(kMost, kFree + kRatio * source);
}

Status DecodedBuffer::hasRoomFor(uint64_t bytes, const std::string& path) const
{
    if (bytes <= left_) return {};
    return invalid(path, "compressed data takes more memory than a file of this size may ask for");
}

Result<std::span<const std::byte>> DecodedBuffer::bytesOf(const Json& range, const std::string& path) const
{
    const auto buffer = integerMember(range, "buffer", path);
    if (!buffer) return buffer.error();
    const auto offset = integerMember(range, "byteOffset", path, 0);
    if (!offset) return offset.error();
    const auto length = integerMember(range, "byteLength", path);
    if (!length) return length.error();
    if (*buffer >= buffers_.size()) return invalid(path, "refers to a buffer that does not exist");
    const auto& data = buffers_[std::size_t(*buffer)];
    if (*length == 0 || *offset + *length > data.size())
        return invalid(path, "reaches past the end of buffer " + std::to_string(*buffer));
    return std::span(data).subspan(std::size_t(*offset), std::size_t(*length));
}

std::size_t DecodedBuffer::append(const std::vector<std::byte>& bytes)
{
    constexpr std::size_t kAlignment = 16;
    decoded_.resize((decoded_.size() + kAlignment - 1) / kAlignment * kAlignment);
    const std::size_t offset = decoded_.size();
    decoded_.insert(decoded_.end(), bytes.begin(), bytes.end());
    left_ -= std::min<uint64_t>(left_, bytes.size() + kAlignment);
    return offset;
}

std::size_t DecodedBuffer::place(std::size_t accessorIndex, Json accessor, const std::vector<std::byte>& bytes,
                                 int target, std::size_t byteStride)
{
    Json view = {{"buffer", index_}, {"byteOffset", append(bytes)}, {"byteLength", bytes.size()}, {"target", target}};
    if (byteStride != 0) view["byteStride"] = byteStride;
    Json& accessors = json_["accessors"];
    Json& views = json_["bufferViews"];
    const bool isFree = accessorIndex < accessors.size() && !accessors[accessorIndex].contains("bufferView") &&
                        !accessors[accessorIndex].contains("sparse");
    for (const char* key : {"byteOffset", "sparse"}) accessor.erase(key);
    accessor["bufferView"] = views.size();
    views.push_back(std::move(view));
    if (isFree) {
        accessors[accessorIndex] = std::move(accessor);
        return accessorIndex;
    }
    accessors.push_back(std::move(accessor));
    return accessors.size() - 1;
}

void DecodedBuffer::finish()
{
    if (decoded_.empty()) return;
    json_["buffers"].push_back({{"byteLength", decoded_.size()}});
    buffers_.push_back(std::move(decoded_));
}

} // namespace halflight
