#pragma once
// The plan of `halflight farm`: a folder that holds all that workers read and write.
//
//   DIR/plan.json       scenes, options, tiles; written last
//   DIR/scenes/N/       a copy of each scene with its files
//   DIR/cache/          parts, unless --cache names another folder; several scenes have a folder each in it
//   DIR/workers         of how many workers the last one was one

#include "halflight/bake/farm.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace halflight::cli {

struct PlannedScene {
    std::string name;                 ///< of its output, unique in the plan
    std::filesystem::path scene;      ///< in the plan's folder
    std::filesystem::path settings;   ///< in the plan's folder; empty = none
    std::vector<std::string> options; ///< of `halflight bake`
    std::filesystem::path cache;      ///< as FarmPlan::cache, of this scene
    FarmBake bake;
};

struct FarmPlan {
    std::filesystem::path folder;
    bool compares = false; ///< --cache was given: tiles of the last bake are reused
    std::vector<PlannedScene> scenes;

    [[nodiscard]] std::filesystem::path pathOf(const std::filesystem::path& inPlan) const
    {
        return inPlan.empty() ? inPlan : folder / inPlan; // an absolute path stays
    }
    [[nodiscard]] std::vector<FarmBake> bakes() const;
    /// The command line of the bake of a scene with the plan's cache.
    [[nodiscard]] std::vector<std::string> bakeArguments(const PlannedScene& scene, const std::string& output) const;
};

Result<FarmPlan> readPlan(const std::filesystem::path& folder);
Status writePlan(const FarmPlan& plan);

/// Copies a scene with the files that it and its settings name, in their places relative to one another.
Status copyScene(const Scene& scene, const std::filesystem::path& sceneFile, const std::filesystem::path& settingsFile,
                 const FarmPlan& plan, PlannedScene& planned);

/// Its files that `join` reads, with names for messages; not those that scenes name.
std::vector<std::pair<std::string, std::filesystem::path>> filesOfPlan(const FarmPlan& plan);

/// Workers so far: the number that the last one was given, or 0. Error where the file that says so holds none.
Result<uint32_t> lastWorkerCount(const FarmPlan& plan);
void noteWorkerCount(const FarmPlan& plan, uint32_t count);

/// Indices of workers that have tiles missing, of `workers`. `verify` reads the tiles.
std::vector<uint32_t> workersToRepeat(const FarmPlan& plan, uint32_t workers, bool verify);
/// "3,17-19,42", as job arrays take it.
std::string arrayList(const std::vector<uint32_t>& indices);

} // namespace halflight::cli
