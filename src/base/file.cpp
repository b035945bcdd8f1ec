#include "halflight/base/file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <unistd.h>

namespace halflight {

Result<std::vector<std::byte>> readFile(const std::filesystem::path& path)
{
    std::error_code ec;
    if (std::filesystem::is_directory(path, ec)) return Error{ErrorCode::FileNotFound, "is a folder, not a file"};
    std::ifstream stream(path, std::ios::binary | std::ios::ate);
    if (!stream) {
        return Error{ErrorCode::FileNotFound,
                     errno == ENOENT ? "no such file" : std::string("cannot be opened (") + std::strerror(errno) + ")"};
    }
    const std::streamoff size = stream.tellg();
    std::vector<std::byte> bytes(size > 0 ? std::size_t(size) : 0);
    stream.seekg(0);
    if (!bytes.empty() && !stream.read(reinterpret_cast<char*>(bytes.data()), size)) {
        return Error{ErrorCode::FileInvalid, "could not be read to its end"};
    }
    return bytes;
}

Status writeFileAtomically(const std::filesystem::path& path, const void* bytes, std::size_t byteCount)
{
    std::filesystem::path temporary = path;
    temporary += ".tmp" + std::to_string(::getpid());
    std::error_code ec;
    {
        std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
        if (!stream) {
            return Error{ErrorCode::WriteFailed, std::string("cannot be written (") + std::strerror(errno) + ")"};
        }
        stream.write(static_cast<const char*>(bytes), std::streamsize(byteCount));
        stream.close();
        if (!stream) {
            std::filesystem::remove(temporary, ec);
            return Error{ErrorCode::WriteFailed, "could not be written to its end (disk full?)"};
        }
    }
    std::filesystem::rename(temporary, path, ec);
    if (ec) {
        const std::string reason = ec.message();
        std::filesystem::remove(temporary, ec);
        return Error{ErrorCode::WriteFailed, "cannot be replaced (" + reason + ")"};
    }
    return {};
}

Status writeFileAtomically(const std::filesystem::path& path, std::string_view text)
{
    return writeFileAtomically(path, text.data(), text.size());
}

} // namespace halflight
