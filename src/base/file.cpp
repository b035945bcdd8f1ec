#include "halflight/base/file.h"

#include "halflight/base/system.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>
#include <string>

namespace halflight {

namespace {

/// 64 random bits that this process keeps. Numbers of processes and names of hosts repeat in containers and
/// WebAssembly.
const std::string& processToken()
{
    static const std::string token = [] {
        std::random_device random;
        std::string digits(16, '0');
        for (char& digit : digits) digit = "0123456789abcdef"[random() % 16];
        return digits;
    }();
    return token;
}

} // namespace

Result<std::vector<std::byte>> readFile(const std::filesystem::path& path, uint64_t firstBytes)
{
    std::error_code ec;
    const std::filesystem::file_status status = std::filesystem::status(path, ec);
    if (std::filesystem::is_directory(status)) return Error{ErrorCode::FileNotFound, "is a folder, not a file"};
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
        return Error{ErrorCode::FileNotFound, "is a device, a pipe or a socket, not a regular file"};
    }
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    if (!stream) {
        return Error{ErrorCode::FileNotFound,
                     errno == ENOENT ? "no such file" : std::string("cannot be opened (") + std::strerror(errno) + ")"};
    }
    const std::streamoff size = stream.tellg();
    std::vector<std::byte> bytes(size > 0 ? std::size_t(std::min(uint64_t(size), firstBytes)) : 0);
    stream.seekg(0);
    if (!bytes.empty() && !stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()))) {
        return Error{ErrorCode::FileInvalid, "could not be read to its end"};
    }
    return bytes;
}

Result<std::filesystem::path> replacedFile(const std::filesystem::path& path)
{
    namespace fs = std::filesystem;
    std::error_code ec;
    const fs::file_status status = fs::status(path, ec);
    if (fs::is_directory(status)) return Error{ErrorCode::WriteFailed, "is a folder, not a file"};
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        return Error{ErrorCode::WriteFailed, "is a device, a pipe or a socket, and only regular files are replaced"};
    }
    // By hand: canonical() fails where the link's target is yet to be made.
    fs::path file = path;
    constexpr int kMaxLinks = 40; // Linux's own limit
    for (int links = 0; fs::is_symlink(fs::symlink_status(file, ec)); ++links) {
        const fs::path target = fs::read_symlink(file, ec);
        if (ec || links == kMaxLinks) {
            return Error{ErrorCode::WriteFailed, "is a symbolic link that cannot be followed"};
        }
        file = file.parent_path() / target; // an absolute target replaces the whole
    }
    return file;
}

Status tryWriting(const std::filesystem::path& folder)
{
    const std::filesystem::path where = folder.empty() ? std::filesystem::path(".") : folder;
    std::error_code ec;
    // Windows' C library does not know "D:", the folder in which that drive is.
    const bool isDrive = where.has_root_name() && !where.has_root_directory();
    const std::filesystem::path whole = isDrive ? std::filesystem::absolute(where, ec) : where;
    if (!std::filesystem::is_directory(whole, ec)) {
        return Error{ErrorCode::WriteFailed, "the folder " + where.string() + " does not exist"};
    }
    const std::filesystem::path trial = whole / (".halflight-trial" + processToken());
    errno = 0;
    std::ofstream stream(trial, std::ios::binary | std::ios::trunc);
    const std::string block(4096, '\0'); // one block of usual file systems: an empty file fits a full disk
    stream.write(block.data(), std::streamsize(block.size()));
    stream.close();
    const bool written = bool(stream);
    const std::string reason = std::strerror(errno != 0 ? errno : EIO);
    std::filesystem::remove(trial, ec);
    if (written) return {};
    return Error{ErrorCode::WriteFailed, "the folder " + where.string() + " cannot be written to (" + reason + ")"};
}

std::filesystem::path temporaryOf(const std::filesystem::path& file)
{
    std::filesystem::path temporary = file;
    temporary += ".tmp" + processToken();
    return temporary;
}

Status replaceAtomically(const std::filesystem::path& path,
                         FunctionRef<Status(const std::filesystem::path& temporary)> write)
{
    const Result<std::filesystem::path> file = replacedFile(path);
    if (!file) return file.error();
    const std::filesystem::path temporary = temporaryOf(*file);
    std::error_code ec;
    if (Status status = write(temporary); !status) {
        std::filesystem::remove(temporary, ec);
        return status;
    }
    const Status renamed = renameOver(temporary, *file);
    if (!renamed) std::filesystem::remove(temporary, ec);
    return renamed;
}

Status writeFileAtomically(const std::filesystem::path& path, const void* bytes, std::size_t byteCount,
                           const std::function<bool()>& mayReplace)
{
    return replaceAtomically(path, [&](const std::filesystem::path& temporary) -> Status {
        std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
        if (!stream) {
            return Error{ErrorCode::WriteFailed, std::string("cannot be written (") + std::strerror(errno) + ")"};
        }
        stream.write(static_cast<const char*>(bytes), std::streamsize(byteCount));
        stream.close();
        if (!stream) return Error{ErrorCode::WriteFailed, "could not be written to its end (disk full?)"};
        if (mayReplace && !mayReplace()) return cancelledError();
        return {};
    });
}

Status writeFileAtomically(const std::filesystem::path& path, std::string_view text)
{
    return writeFileAtomically(path, text.data(), text.size());
}

} // namespace halflight
