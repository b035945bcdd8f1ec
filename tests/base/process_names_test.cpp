// Temporary names of processes that have the same number on the same host, as in containers.

#include "halflight/base/file.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>
#include <string>

namespace halflight {
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

TEST(TemporaryNames, DISABLED_Print)
{
    std::cout << "name " << temporaryOf("file").string() << "\n";
}

TEST(TemporaryNames, DifferWhereNumbersOfProcessesRepeat)
{
    const std::string self = std::filesystem::canonical("/proc/self/exe").string();
    const std::string command = "unshare --pid --fork '" + self +
                                "' --gtest_filter=TemporaryNames.DISABLED_Print --gtest_also_run_disabled_tests 2>&1 | "
                                "grep '^name file'";
    const std::string first = outputOf(command);
    if (first.empty()) GTEST_SKIP() << "this system lets nobody make a namespace of processes";
    EXPECT_NE(first, outputOf(command));
    EXPECT_EQ(temporaryOf("file"), temporaryOf("file")) << "what a signal handler removes is what was written";
}

} // namespace
} // namespace halflight
