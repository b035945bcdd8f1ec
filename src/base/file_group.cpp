#include "halflight/base/file_group.h"

#include "halflight/base/file.h"
#include "halflight/base/system.h"

namespace halflight {

FileGroup::~FileGroup()
{
    std::error_code ec;
    for (const auto& [temporary, file] : files_) std::filesystem::remove(temporary, ec);
}

Status FileGroup::add(const std::filesystem::path& file,
                      FunctionRef<Status(const std::filesystem::path& temporary)> write)
{
    if (!status_) return status_;
    const Result<std::filesystem::path> replaced = replacedFile(file);
    if (!replaced) return failed(file, replaced.error());
    files_.emplace_back(temporaryOf(*replaced), *replaced);
    const Status written = write(files_.back().first);
    return written ? Status() : failed(file, written.error());
}

Status FileGroup::add(const std::filesystem::path& file, const void* bytes, std::size_t byteCount)
{
    return add(
        file, [&](const std::filesystem::path& temporary) { return writeFileAtomically(temporary, bytes, byteCount); });
}

Status FileGroup::add(const std::filesystem::path& file, std::string_view text)
{
    return add(file, text.data(), text.size());
}

Status FileGroup::commit()
{
    if (!status_) return status_;
    for (std::size_t i = 0; i < files_.size(); ++i) {
        const Status renamed = renameOver(files_[i].first, files_[i].second);
        if (renamed) continue;
        std::error_code ec;
        for (std::size_t k = 0; k < i; ++k) std::filesystem::remove(files_[k].second, ec);
        return failed(files_[i].second, renamed.error());
    }
    files_.clear();
    return {};
}

Status FileGroup::failed(const std::filesystem::path& file, const Error& error)
{
    status_ = Error{error.code, file.string() + " " + error.message, error.object};
    return status_;
}

} // namespace halflight
