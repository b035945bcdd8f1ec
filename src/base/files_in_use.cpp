#include "halflight/base/files_in_use.h"

#include "halflight/base/file.h"
#include "halflight/base/system.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

namespace halflight {

namespace {

namespace fs = std::filesystem;

/// Equal for two names of one file.
std::string identityOf(const fs::path& file)
{
    if (const std::string identity = fileIdentity(file); !identity.empty()) return identity;
    const Result<fs::path> replaced = replacedFile(file);
    const fs::path& target = replaced ? *replaced : file;
    std::error_code ec;
    const fs::path place = fs::weakly_canonical(fs::absolute(target, ec), ec);
    return (ec ? target : place).string();
}

std::string lower(std::string text)
{
    for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// The name that a command would write where `name` is there already, in any case.
std::optional<std::string> writtenName(const FileNames& names, const std::string& name)
{
    const std::string low = lower(name);
    if (!low.starts_with(lower(names.prefix))) return std::nullopt;
    const std::size_t digits = names.isNumbered ? low.find_first_not_of("0123456789", names.prefix.size()) : 0;
    const std::size_t end = names.isNumbered ? std::min(digits, low.size()) : names.prefix.size();
    if (names.isNumbered && end == names.prefix.size()) return std::nullopt;
    const std::string rest = low.substr(end);
    const bool fits = names.suffix ? rest == lower(*names.suffix)
                                   : rest.starts_with('.') && rest.find_first_of(".", 1) == std::string::npos;
    if (!fits) return std::nullopt;
    return names.prefix + low.substr(names.prefix.size(), end - names.prefix.size()) + names.suffix.value_or(rest);
}

Error replaces(const std::string& option, const std::string& name)
{
    return Error{ErrorCode::InvalidArgument, option + " would replace " + name};
}

} // namespace

void FilesInUse::reads(std::string name, fs::path file)
{
    if (!file.empty()) reads_.push_back({std::move(name), std::move(file)});
}

void FilesInUse::writes(std::string option, fs::path file)
{
    if (!file.empty()) writes_.push_back({std::move(option), std::move(file)});
}

void FilesInUse::writesIn(std::string option, fs::path folder, std::vector<FileNames> names)
{
    folders_.push_back({std::move(option), std::move(folder), std::move(names)});
}

Status FilesInUse::check(fs::path& culprit) const
{
    Owners read;
    for (const Named& file : reads_) read.try_emplace(identityOf(file.file), file.name);
    Owners written;
    for (const Named& file : writes_) {
        culprit = file.file;
        const std::string identity = identityOf(file.file);
        if (const auto owner = read.find(identity); owner != read.end()) return replaces(file.name, owner->second);
        const auto [other, isNew] = written.try_emplace(identity, file.name);
        if (!isNew) return replaces(file.name, other->second);
    }
    for (const Names& folder : folders_) {
        if (Status status = checkFolder(folder, read, written, culprit); !status) return status;
    }
    culprit.clear();
    return {};
}

// Numbers of pictures are known at the end only, so all of these names count: those that are in the folder, whatever
// they lead to, and other outputs that are yet to be made there.
Status FilesInUse::checkFolder(const Names& written, const Owners& read, Owners& owners, fs::path& culprit) const
{
    std::set<std::string> names; // a folder has no order of its own
    const auto add = [&](const fs::path& file) {
        for (const FileNames& pattern : written.names) {
            if (const auto name = writtenName(pattern, file.filename().string())) names.insert(*name);
        }
    };
    const fs::path folder = written.folder.empty() ? fs::path(".") : written.folder;
    std::error_code ec;
    for (fs::directory_iterator entry(folder, ec), end; !ec && entry != end; entry.increment(ec)) add(entry->path());
    for (const Named& file : writes_) {
        add(file.file);
        if (const Result<fs::path> target = replacedFile(file.file)) add(*target);
    }
    for (const std::string& name : names) {
        culprit = written.folder / name;
        const std::string identity = identityOf(culprit);
        if (const auto owner = read.find(identity); owner != read.end()) return replaces(written.option, owner->second);
        const auto other = owners.try_emplace(identity, written.option).first;
        if (other->second != written.option) return replaces(written.option, other->second);
    }
    return {};
}

} // namespace halflight
