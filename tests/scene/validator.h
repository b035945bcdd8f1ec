#pragma once
// The Khronos glTF validator, for tests.

#include <array>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <sys/wait.h>
#include <vector>

namespace halflight::test {

inline int run(const std::string& command, std::string& output)
{
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return -1;
    std::array<char, 4096> buffer;
    while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) output.append(buffer.data(), n);
    const int status = ::pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Runs the validator and checks that no file has an error, and that all warnings are of the kinds docs/format.md lists.
// Returns why there was no validator to run, or nothing.
inline std::string validateIfPossible(const std::vector<std::filesystem::path>& files)
{
    std::string output;
    if (run("node --version 2>/dev/null", output) != 0) return "node is not installed";
    std::string command = std::string("node '") + HALFLIGHT_SOURCE_DIR + "/tests/scene/validate_gltf.js'";
    for (const auto& file : files) command += " '" + file.string() + "'";
    output.clear();
    const int exitCode = run(command + " 2>&1", output);
    if (exitCode == 3) return output;
    EXPECT_TRUE(exitCode == 0 || exitCode == 1) << output;
    if (testing::Test::HasFailure()) return {};
    const nlohmann::json report = nlohmann::json::parse(output);
    EXPECT_EQ(report.size(), files.size());
    for (const auto& [name, result] : report.items()) {
        EXPECT_EQ(result["numErrors"], 0) << name << "\n" << result["errors"].dump(1).substr(0, 3000);
        for (const auto& [code, count] : result["warnings"].items()) {
            const bool known = code == "UNSUPPORTED_EXTENSION" || code == "VALUE_NOT_IN_LIST" ||
                               code == "IMAGE_UNRECOGNIZED_FORMAT" || code == "MESH_PRIMITIVE_GENERATED_TANGENT_SPACE";
            EXPECT_TRUE(known) << name << ": " << code << " x " << count;
        }
    }
    testing::Test::RecordProperty("report", output);
    return {};
}

// The same for a test that has nothing else to do: skips it where there is no validator.
inline void validate(const std::vector<std::filesystem::path>& files)
{
    if (const std::string why = validateIfPossible(files); !why.empty()) GTEST_SKIP() << why;
}

} // namespace halflight::test
