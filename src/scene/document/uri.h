#pragma once
// What a URI of a glTF document stands for: bytes in the URI itself (data:), or a file beside the document.

#include "halflight/base/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace halflight {

/// "%20" and the like resolved to bytes; a '%' without two hexadecimal digits stays, and '+' is a plus (RFC 3986).
std::string percentDecoded(std::string_view text);
/// A file's name as a relative URI (RFC 3986): unreserved characters as they are, all other bytes as %XX.
std::string percentEncoded(std::string_view name);

/// Whether the URI's scheme is data: (schemes are case-insensitive, RFC 3986 section 3.1).
bool isDataUri(std::string_view uri);

/// The bytes of a data: URI (RFC 2397): base64 or percent-encoded; media type and parameters may be missing.
Result<std::vector<std::byte>> decodeDataUri(std::string_view uri);

/// At most the first `firstBytes` bytes of what `uri` stands for. Files are looked for with percent-decoding first,
/// then under the name as it stands. Errors are sentences that name the file, without a glTF path.
Result<std::vector<std::byte>> readUri(std::string_view uri, const std::filesystem::path& directory,
                                       uint64_t firstBytes = std::numeric_limits<uint64_t>::max());

} // namespace halflight
