// Temporary names of processes that have the same number on the same host, as in containers.

#include "halflight/base/file.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>
#include <string>

namespace halflight::process_names_test {
namespace {

std::string outputOf(const std::string& command)
{
    std::string output;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return output;
    std::array<char, 4096> bytes{};
    while (const std::size_t count = std::fread(bytes.data(), 1, bytes.size(), pipe))
        output.append(bytes.data(), count);
    return ::pclose(pipe) == 0 ? output : std::string();
}

constexpr const char* kPrints = "HALFLIGHT_TEST_PRINTS"; ///< of the processes that the test starts

TEST(TemporaryNames, DifferWhereNumbersOfProcessesRepeat)
{
    if (std::getenv(kPrints) != nullptr) {
        std::cout << "name " << temporaryOf("file").string() << "\n";
        return;
    }
    const std::string self = std::filesystem::canonical("/proc/self/exe").string();
    const std::string command = std::string(kPrints) + "=1 unshare --pid --fork '" + self +
                                "' --gtest_filter=TemporaryNames.* 2>&1 | grep '^name file'";
    const std::string first = outputOf(command);
    if (first.empty()) GTEST_SKIP() << "this system lets nobody make a namespace of processes";
    EXPECT_NE(first, outputOf(command));
    EXPECT_EQ(temporaryOf("file"), temporaryOf("file")) << "what a signal handler removes is what was written";
}

} // namespace
} // namespace halflight::process_names_test
