#include "farm_plan.h"

#include "halflight/base/file.h"
#include "halflight/scene/gltf.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <string_view>

namespace halflight::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "halflight farm plan";
constexpr int kVersion = 1;

nlohmann::json jsonOf(const PlannedScene& scene)
{
    return {{"name", scene.name},         {"scene", scene.scene.string()}, {"settings", scene.settings.string()},
            {"options", scene.options},   {"cache", scene.cache.string()}, {"inputs", scene.bake.inputs},
            {"parts", scene.bake.folder}, {"tiles", scene.bake.tiles},     {"texels", scene.bake.texels},
            {"mask", scene.bake.mask}};
}

PlannedScene sceneOf(const nlohmann::json& json)
{
    PlannedScene scene;
    scene.name = json.at("name").get<std::string>();
    scene.scene = json.at("scene").get<std::string>();
    scene.settings = json.at("settings").get<std::string>();
    scene.options = json.at("options").get<std::vector<std::string>>();
    scene.cache = json.at("cache").get<std::string>();
    scene.bake.inputs = json.at("inputs").get<std::string>();
    scene.bake.folder = json.at("parts").get<std::string>();
    scene.bake.tiles = json.at("tiles").get<std::size_t>();
    scene.bake.texels = json.at("texels").get<uint64_t>();
    scene.bake.mask = json.at("mask").get<bool>();
    return scene;
}

/// The deepest folder that holds all files.
fs::path commonFolder(const std::vector<fs::path>& files)
{
    fs::path common = files.front().parent_path();
    const auto holds = [](const fs::path& folder, const fs::path& file) {
        return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
    };
    for (const fs::path& file : files) {
        while (!holds(common, file) && common.has_relative_path()) common = common.parent_path();
    }
    return common;
}

} // namespace

std::vector<FarmBake> FarmPlan::bakes() const
{
    std::vector<FarmBake> bakes;
    for (const PlannedScene& scene : scenes) bakes.push_back(scene.bake);
    return bakes;
}

std::vector<std::string> FarmPlan::bakeArguments(const PlannedScene& scene, const std::string& output) const
{
    std::vector<std::string> arguments = {"bake", pathOf(scene.scene).string(), "-o", output};
    if (!scene.settings.empty()) arguments.insert(arguments.end(), {"--settings", pathOf(scene.settings).string()});
    arguments.insert(arguments.end(), scene.options.begin(), scene.options.end());
    arguments.insert(arguments.end(), {"--cache", pathOf(scene.cache).string()});
    return arguments;
}

Result<FarmPlan> readPlan(const fs::path& folder)
{
    const auto bytes = readFile(folder / "plan.json");
    if (!bytes) return Error{bytes.error().code, "holds no plan (plan.json: " + bytes.error().message + ")"};
    const auto* text = reinterpret_cast<const char*>(bytes->data());
    const nlohmann::json json = nlohmann::json::parse(text, text + bytes->size(), nullptr, false);
    try {
        if (json.at("format").get<std::string>() != kFormat || json.at("version").get<int>() != kVersion)
            return Error{ErrorCode::Unsupported, "its plan.json is of another version of the program: plan anew"};
        FarmPlan plan;
        plan.folder = folder;
        plan.compares = json.at("compares").get<bool>();
        for (const nlohmann::json& scene : json.at("scenes")) plan.scenes.push_back(sceneOf(scene));
        return plan;
    } catch (const nlohmann::json::exception&) {
        return Error{ErrorCode::FileInvalid, "its plan.json is not a plan that `halflight farm plan` wrote"};
    }
}

Status writePlan(const FarmPlan& plan)
{
    nlohmann::json scenes = nlohmann::json::array();
    for (const PlannedScene& scene : plan.scenes) scenes.push_back(jsonOf(scene));
    const nlohmann::json json = {
        {"format", kFormat}, {"version", kVersion}, {"compares", plan.compares}, {"scenes", scenes}};
    return writeFileAtomically(plan.folder / "plan.json", json.dump(2) + "\n");
}

Status copyScene(const Scene& scene, const fs::path& sceneFile, const fs::path& settingsFile, const FarmPlan& plan,
                 PlannedScene& planned)
{
    std::error_code ec;
    const auto whole = [&](const fs::path& path) { return fs::absolute(path, ec).lexically_normal(); };
    std::set<fs::path> files = {whole(sceneFile)};
    for (const fs::path& file : externalFiles(scene))
        if (fs::exists(file, ec)) files.insert(whole(file));
    if (!settingsFile.empty()) {
        files.insert(whole(settingsFile));
        const Result<std::vector<fs::path>> named = filesOfSettings(settingsFile);
        if (!named) return named.error();
        for (const fs::path& file : *named) files.insert(whole(file));
    }
    const fs::path common = commonFolder({files.begin(), files.end()});
    const fs::path inPlan = fs::path("scenes") / std::to_string(plan.scenes.size());
    for (const fs::path& file : files) {
        const fs::path copy = plan.folder / inPlan / file.lexically_relative(common);
        fs::create_directories(copy.parent_path(), ec);
        if (!ec) fs::copy_file(file, copy, fs::copy_options::overwrite_existing, ec);
        if (ec) return Error{ErrorCode::WriteFailed, copy.string() + " cannot be written (" + ec.message() + ")"};
    }
    planned.scene = inPlan / whole(sceneFile).lexically_relative(common);
    if (!settingsFile.empty()) planned.settings = inPlan / whole(settingsFile).lexically_relative(common);
    return {};
}

uint32_t lastWorkerCount(const FarmPlan& plan)
{
    const auto bytes = readFile(plan.folder / "workers");
    if (!bytes) return 0;
    const std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    return uint32_t(std::strtoul(text.c_str(), nullptr, 10));
}

void noteWorkerCount(const FarmPlan& plan, uint32_t count)
{
    if (lastWorkerCount(plan) == count) return;
    // Only what `join` and `status` say depends on it.
    [[maybe_unused]] const Status status = writeFileAtomically(plan.folder / "workers", std::to_string(count) + "\n");
}

std::vector<uint32_t> workersToRepeat(const FarmPlan& plan, uint32_t workers, bool verify)
{
    std::vector<std::set<std::size_t>> missing;
    for (const PlannedScene& scene : plan.scenes) {
        const auto tiles = missingFarmTiles(plan.pathOf(scene.cache), scene.bake, verify);
        missing.emplace_back(tiles.begin(), tiles.end());
    }
    std::vector<uint32_t> indices;
    for (uint32_t index = 0; index < workers; ++index) {
        const std::vector<FarmWork> works = farmWork(plan.bakes(), {index, workers});
        bool any = false;
        for (std::size_t s = 0; s < works.size(); ++s) {
            any = any || std::any_of(works[s].tiles.begin(), works[s].tiles.end(),
                                     [&](std::size_t tile) { return missing[s].contains(tile); });
        }
        if (any) indices.push_back(index);
    }
    return indices;
}

std::string arrayList(const std::vector<uint32_t>& indices)
{
    std::string list;
    for (std::size_t i = 0; i < indices.size();) {
        std::size_t end = i + 1;
        while (end < indices.size() && indices[end] == indices[end - 1] + 1) ++end;
        if (!list.empty()) list += ',';
        list += std::to_string(indices[i]);
        if (end - i == 2) list += ',' + std::to_string(indices[i + 1]);
        if (end - i > 2) list += '-' + std::to_string(indices[end - 1]);
        i = end;
    }
    return list;
}

} // namespace halflight::cli
