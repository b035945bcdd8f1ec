#pragma once

#include "halflight/base/result.h"

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

namespace halflight {

Result<std::vector<std::byte>> readFile(const std::filesystem::path& path);

/// Writes to a temporary name beside `path` and renames it, so that `path` is either the old file or the whole new one.
Status writeFileAtomically(const std::filesystem::path& path, const void* bytes, std::size_t byteCount);
Status writeFileAtomically(const std::filesystem::path& path, std::string_view text);

} // namespace halflight
