#pragma once

#include "halflight/base/function_ref.h"
#include "halflight/base/result.h"

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

namespace halflight {

/// Files that belong together: all of them are whole in the end, or none is new. Each is written under a temporary name
/// beside its own; commit() gives all their names. What was not committed is removed.
class FileGroup {
public:
    FileGroup() = default;
    FileGroup(const FileGroup&) = delete;
    FileGroup& operator=(const FileGroup&) = delete;
    ~FileGroup();

    /// Calls `write` with the temporary name. Errors name the file, and no later call of this group does anything.
    Status add(const std::filesystem::path& file, FunctionRef<Status(const std::filesystem::path& temporary)> write);
    Status add(const std::filesystem::path& file, const void* bytes, std::size_t byteCount);
    Status add(const std::filesystem::path& file, std::string_view text);

    /// In the order of the calls. The error of an add(), or the first file that cannot be replaced; then those before
    /// it are removed.
    Status commit();

private:
    Status failed(const std::filesystem::path& file, const Error& error);

    std::vector<std::pair<std::filesystem::path, std::filesystem::path>> files_; ///< temporary name, name
    Status status_;
};

} // namespace halflight
