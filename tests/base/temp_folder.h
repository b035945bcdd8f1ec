#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

namespace halflight::test {

/// A folder of this test's own, removed at its end; or of a name's, for what tests share.
class TempFolder {
public:
    TempFolder() : TempFolder(::testing::UnitTest::GetInstance()->current_test_info()->name()) {}
    explicit TempFolder(const std::string& name)
        : path_(std::filesystem::temp_directory_path() / ("halflight_" + std::to_string(::getpid()) + "_" + name))
    {
        std::filesystem::create_directories(path_);
    }
    ~TempFolder()
    {
        std::error_code ec;
        std::filesystem::permissions(path_, std::filesystem::perms::owner_all, ec);
        std::filesystem::remove_all(path_, ec);
    }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    [[nodiscard]] std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
    [[nodiscard]] std::size_t fileCount() const
    {
        return std::size_t(
            std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
    }

private:
    std::filesystem::path path_;
};

} // namespace halflight::test
