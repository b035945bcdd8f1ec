#pragma once
// Parts of `halflight bake`: its options, the check of its paths, what it prints.

#include "bake_device.h"
#include "console.h"

#include "halflight/bake/bake.h"
#include "halflight/base/files_in_use.h"
#include "halflight/scene/export.h"
#include "halflight/scene/gltf.h"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace halflight::cli {

inline constexpr double kLeastSeconds = 1.0; ///< of --time

struct BakeOptions {
    std::filesystem::path scene;
    std::filesystem::path output;
    std::filesystem::path settingsFile;
    std::filesystem::path reportFile;
    std::vector<std::pair<std::string, std::filesystem::path>> alsoRead; ///< what a farm's plan reads, by name
    BakeSettings bake;
    std::optional<ExportStyle> exportStyle; ///< writes core glTF instead of a baked file
    std::optional<float> exposureEv;        ///< of the export; empty = automatic
    bool exposureGiven = false;
    int exportScale = 0;                    ///< 0 = automatic
    std::filesystem::path sidecarDirectory; ///< empty = none
    WriteOptions write;
    vec3 skyNits{0.0f};
    bool skyGiven = false;
    std::optional<EmissionUnit> emissionUnit;
    DeviceChoice device;
    ProgressStyle progress = ProgressStyle::Auto;
    bool quiet = false;
    bool json = false;
};

/// Options of `halflight bake`: what light is computed, how it is stored, how a run works, and what it writes besides.
void addLightOptions(CLI::App& app, BakeOptions& options);
void addFormatOptions(CLI::App& app, BakeOptions& options);
void addRunOptions(CLI::App& app, BakeOptions& options);
void addReportOptions(CLI::App& app, BakeOptions& options);
/// The whole subcommand, without an action. `options` outlives it.
CLI::App& addBakeApp(CLI::App& parent, BakeOptions& options);
int runBake(const CLI::App& app, const BakeOptions& options);

/// What is wrong with the options together, as a sentence; empty when nothing is.
std::string contradiction(const CLI::App& app, const BakeOptions& options);
Result<Scene> readBakeScene(const BakeOptions& options);
/// What options change of the scene that was read, and of the settings.
void applyOptions(BakeOptions& options, Scene& scene);

/// All files of a bake. `scene`: names more that are read; may be null.
FilesInUse filesOfBake(const BakeOptions& options, const Scene* scene);
/// No file that the bake writes may replace one that it reads, or another that it writes; and its places can be written
/// to. `culprit`: the file of an error.
Status checkBakePaths(const BakeOptions& options, std::filesystem::path& culprit);
/// Folders that a command writes into, made and tried before it begins. Those that were new and hold nothing in the end
/// are removed again, so that a command that is refused or interrupted leaves none.
class OutputFolders {
public:
    OutputFolders() = default;
    OutputFolders(const OutputFolders&) = delete;
    OutputFolders& operator=(const OutputFolders&) = delete;
    ~OutputFolders();
    Status make(const std::filesystem::path& folder);

private:
    std::vector<std::filesystem::path> made_; ///< each after the one that it lies in
};

/// Lights that are not what their author asked for, where no other warning speaks of them yet.
std::vector<std::string> lightWarnings(const BakeReport& report);
void printBakeSummary(const BakeOptions& options, const BakeReport& report);

} // namespace halflight::cli
