#pragma once

#include "halflight/base/function_ref.h"
#include "halflight/base/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string_view>
#include <vector>

namespace halflight {

/// A regular file's bytes, at most the first `firstBytes` of them. Folders, pipes and devices are errors; none is
/// opened.
Result<std::vector<std::byte>> readFile(const std::filesystem::path& path,
                                        uint64_t firstBytes = std::numeric_limits<uint64_t>::max());

/// The file that writing to `path` replaces, there or not yet: `path` itself or, when that is a symbolic link, what it
/// leads to. Error when a folder or something else that is not a regular file (a pipe, a device) is there.
Result<std::filesystem::path> replacedFile(const std::filesystem::path& path);

/// Writes a small file into a folder and removes it again: WriteFailed, with the reason, where that does not work (no
/// such folder, no right to write, a full or read-only disk). For places that a long run writes at its end.
Status tryWriting(const std::filesystem::path& folder);

/// The temporary name under which replaceAtomically() writes: beside the file, with random digits that
/// this process keeps.
std::filesystem::path temporaryOf(const std::filesystem::path& file);

/// Calls `write` with a temporary name beside replacedFile(path) and renames what it wrote, so that `path` is either
/// the old file or the whole new one. A symbolic link stays one. On an error nothing is left under the temporary name.
Status replaceAtomically(const std::filesystem::path& path,
                         FunctionRef<Status(const std::filesystem::path& temporary)> write);

/// The same for bytes that are there already. `mayReplace` is asked when they are written; false ends with
/// ErrorCode::Cancelled and leaves nothing.
Status writeFileAtomically(const std::filesystem::path& path, const void* bytes, std::size_t byteCount,
                           const std::function<bool()>& mayReplace = {});
Status writeFileAtomically(const std::filesystem::path& path, std::string_view text);

} // namespace halflight
