#pragma once
// Where decoded data goes, and where encoded data comes from.

#include "scene/document/document.h"

#include <optional>

namespace halflight {

/// A non-negative integer member; `fallback` where it is absent.
Result<uint64_t> integerMember(const Json& object, const char* key, const std::string& path,
                               std::optional<uint64_t> fallback = {});

/// A new buffer behind the document's. It may take 256 MiB and 256 times the buffers' size, and 4 GiB at most.
class DecodedBuffer {
public:
    DecodedBuffer(Json& json, std::vector<std::vector<std::byte>>& buffers);

    [[nodiscard]] Json& json() const { return json_; }
    /// Its number among the document's.
    [[nodiscard]] std::size_t index() const { return index_; }
    /// Whether so many bytes more may be decoded; the error has this path.
    [[nodiscard]] Status hasRoomFor(uint64_t bytes, const std::string& path) const;
    [[nodiscard]] uint64_t left() const { return left_; }
    /// The bytes that an extension's buffer, byteOffset and byteLength name.
    [[nodiscard]] Result<std::span<const std::byte>> bytesOf(const Json& range, const std::string& path) const;

    /// Adds decoded bytes and returns their place here.
    std::size_t append(const std::vector<std::byte>& bytes);
    /// Gives `accessor` the decoded bytes, and returns its number. It replaces accessor `accessorIndex` if that exists
    /// and has no data.
    std::size_t place(std::size_t accessorIndex, Json accessor, const std::vector<std::byte>& bytes, int target,
                      std::size_t byteStride);
    /// Puts it into the document, unless nothing was decoded.
    void finish();

private:
    Json& json_;
    std::vector<std::vector<std::byte>>& buffers_;
    const std::size_t index_;
    std::vector<std::byte> decoded_;
    uint64_t left_ = 0;
};

} // namespace halflight
