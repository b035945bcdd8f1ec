#pragma once
// What a command reads and what it will write: no output may replace an input.

#include "halflight/base/result.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

/// Names of files that are known only in part before a command ends.
struct FileNames {
    std::string prefix;
    bool isNumbered = false;           ///< digits follow the prefix
    std::optional<std::string> suffix; ///< what ends the name; empty optional: any extension
};

/// Files of one command. They are compared by identity (device and number of the file), so that links, hard links,
/// "./a/../b" and names in another case are seen through; files that are yet to be made are compared by their place.
class FilesInUse {
public:
    /// `name`: what messages call the file ("the scene"). An empty path is none.
    void reads(std::string name, std::filesystem::path file);
    /// `option`: what messages call it ("--report"). An empty path is none.
    void writes(std::string option, std::filesystem::path file);
    /// Files of these names in a folder, of which the command writes some.
    void writesIn(std::string option, std::filesystem::path folder, std::vector<FileNames> names);

    /// InvalidArgument where a file that is written would replace one that is read, or another that is written.
    /// `culprit`: the file that would be replaced, by the name under which it would be written.
    [[nodiscard]] Status check(std::filesystem::path& culprit) const;

private:
    struct Named {
        std::string name;
        std::filesystem::path file;
    };
    struct Names {
        std::string option;
        std::filesystem::path folder;
        std::vector<FileNames> names;
    };
    using Owners = std::map<std::string, std::string>; // name by identity

    Status checkFolder(const Names& written, const Owners& read, Owners& owners, std::filesystem::path& culprit) const;

    std::vector<Named> reads_;
    std::vector<Named> writes_;
    std::vector<Names> folders_;
};

} // namespace halflight
