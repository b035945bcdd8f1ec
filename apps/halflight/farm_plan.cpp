#include "farm_plan.h"

#include "farm_line.h"
#include "terminal.h"

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
constexpr int kVersion = 3;

/// The last step of a path, without control characters, which no message shows as they are.
std::string fileNameOf(std::string name)
{
    name = fs::path(name).filename().string();
    return printable(name) == name ? name : std::string();
}

nlohmann::json jsonOf(const PlannedScene& scene)
{
    return {{"name", scene.name},
            {"scene", scene.scene.generic_string()},
            {"settings", scene.settings.generic_string()},
            {"options", scene.options},
            {"cache", scene.cache.generic_string()},
            {"inputs", scene.bake.inputs},
            {"parts", scene.bake.folder},
            {"tiles", scene.bake.tiles},
            {"texels", scene.bake.texels},
            {"maskLayers", scene.bake.maskLayers},
            {"identity", scene.bake.identity}};
}

/// A plan's numbers and words, as any other input's. The first thing wrong is the error, with its place.
class PlanReader {
public:
    Status read(const nlohmann::json& json, FarmPlan& plan)
    {
        check(json, "", {"format", "version", "compares", "scenes"});
        plan.compares = flag(json, "", "compares");
        const nlohmann::json& scenes = json.is_object() && json.contains("scenes") ? json["scenes"] : json;
        if (!scenes.is_array() || scenes.empty()) refuse("/scenes", "is not a list of scenes");
        for (std::size_t i = 0; wrong_ && i < scenes.size(); ++i) {
            const std::string path = "/scenes/" + std::to_string(i);
            plan.scenes.push_back(scene(scenes[i], path, plan.compares));
            if (!names_.insert(plan.scenes.back().name).second) refuse(path + "/name", "is another scene's too");
        }
        return wrong_;
    }

private:
    void refuse(const std::string& path, const std::string& why)
    {
        if (wrong_) wrong_ = Error{ErrorCode::FileInvalid, "plan.json: " + path + " " + why};
    }

    /// An object with these members and no others.
    void check(const nlohmann::json& json, const std::string& path, const std::set<std::string>& names)
    {
        if (!json.is_object()) return refuse(path.empty() ? "it" : path, "is not an object");
        for (const std::string& name : names) {
            if (!json.contains(name)) refuse(path + "/" + name, "is missing");
        }
        for (const auto& [name, value] : json.items()) {
            if (!names.contains(name)) refuse(path + "/" + name, "is no part of a plan");
        }
    }

    bool flag(const nlohmann::json& json, const std::string& path, const char* key)
    {
        if (json.is_object() && json.contains(key) && json[key].is_boolean()) return json[key].get<bool>();
        refuse(path + "/" + key, "is not true or false");
        return false;
    }

    uint64_t number(const nlohmann::json& json, const std::string& path, const char* key, uint64_t most)
    {
        const bool isWhole = json.is_object() && json.contains(key) && json[key].is_number_unsigned();
        if (isWhole && json[key].get<uint64_t>() <= most) return json[key].get<uint64_t>();
        refuse(path + "/" + key, "is not a whole number from 0 to " + std::to_string(most));
        return 0;
    }

    std::string text(const nlohmann::json& json, const std::string& path, const char* key)
    {
        if (json.is_object() && json.contains(key) && json[key].is_string()) return json[key].get<std::string>();
        refuse(path + "/" + key, "is not a text");
        return {};
    }

    /// A file or folder in the plan's folder. `mayBeElsewhere`: or an absolute path.
    fs::path place(const nlohmann::json& json, const std::string& path, const char* key, bool mayBeElsewhere)
    {
        const std::string name = text(json, path, key);
        const fs::path file = name;
        const bool leaves = std::any_of(file.begin(), file.end(), [](const fs::path& step) { return step == ".."; });
        if (name.find('\0') != std::string::npos || leaves || (file.has_root_path() && !mayBeElsewhere))
            refuse(path + "/" + key, "is not in the plan's folder");
        return file;
    }

    /// A name that is one step of a path, so that no file of this name is elsewhere.
    std::string stepName(const nlohmann::json& json, const std::string& path, const char* key)
    {
        std::string name = text(json, path, key);
        if (name.empty() || name == "." || name == ".." || name != fileNameOf(name))
            refuse(path + "/" + key, "is not a file's name");
        return name;
    }

    PlannedScene scene(const nlohmann::json& json, const std::string& path, bool compares)
    {
        constexpr uint64_t kMostTexels = uint64_t(1) << 34; // 256 pages of 8192 x 8192
        check(json, path,
              {"name", "scene", "settings", "options", "cache", "inputs", "parts", "tiles", "texels", "maskLayers",
               "identity"});
        PlannedScene scene;
        scene.name = stepName(json, path, "name");
        scene.scene = place(json, path, "scene", false);
        if (scene.scene.empty()) refuse(path + "/scene", "names no file");
        scene.settings = place(json, path, "settings", false);
        scene.cache = place(json, path, "cache", compares);
        if (scene.cache.empty()) refuse(path + "/cache", "names no folder");
        scene.bake.inputs = text(json, path, "inputs");
        scene.bake.folder = stepName(json, path, "parts");
        scene.bake.identity = stepName(json, path, "identity");
        scene.bake.texels = number(json, path, "texels", kMostTexels);
        scene.bake.tiles = std::size_t(number(json, path, "tiles", farmTiles(kMostTexels)));
        if (scene.bake.tiles != farmTiles(scene.bake.texels))
            refuse(path + "/tiles", "is not the number of tiles of so many texels");
        scene.bake.maskLayers = int(number(json, path, "maskLayers", kMostMaskLayers));
        scene.options = options(json, path);
        return scene;
    }

    /// Only such as `farm plan` itself takes: none that names a file or prints help.
    std::vector<std::string> options(const nlohmann::json& json, const std::string& path)
    {
        std::vector<std::string> words;
        const nlohmann::json& list = json.is_object() && json.contains("options") ? json["options"] : json;
        if (!list.is_array()) refuse(path + "/options", "is not a list of texts");
        for (const nlohmann::json& word : list) {
            if (!word.is_string()) {
                refuse(path + "/options", "is not a list of texts");
                return {};
            }
            words.push_back(word.get<std::string>());
        }
        if (const std::string sentence = wrongPlanOptions(words); !sentence.empty())
            refuse(path + "/options", "are not options of a bake: " + sentence);
        return words;
    }

    Status wrong_;
    std::set<std::string> names_;
};

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
    const auto has = [&](const char* key, const nlohmann::json& value) {
        return json.is_object() && json.contains(key) && json[key] == value;
    };
    if (!has("format", kFormat))
        return Error{ErrorCode::FileInvalid, "its plan.json is not a plan that `halflight farm plan` wrote"};
    if (!has("version", kVersion))
        return Error{ErrorCode::Unsupported, "its plan.json is of another version of the program: plan anew"};
    FarmPlan plan;
    plan.folder = folder;
    if (Status status = PlanReader().read(json, plan); !status) return status.error();
    return plan;
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
        if (file.root_name() != common.root_name()) // of Windows
            return Error{ErrorCode::Unsupported, file.string() + " is on another drive than the scene"};
        const fs::path copy = plan.folder / inPlan / file.lexically_relative(common);
        fs::create_directories(copy.parent_path(), ec);
        if (!ec) fs::copy_file(file, copy, fs::copy_options::overwrite_existing, ec);
        if (ec) return Error{ErrorCode::WriteFailed, copy.string() + " cannot be written (" + ec.message() + ")"};
    }
    planned.scene = inPlan / whole(sceneFile).lexically_relative(common);
    if (!settingsFile.empty()) planned.settings = inPlan / whole(settingsFile).lexically_relative(common);
    return {};
}

std::vector<std::pair<std::string, fs::path>> filesOfPlan(const FarmPlan& plan)
{
    std::vector<std::pair<std::string, fs::path>> files = {{"the plan", plan.folder / "plan.json"},
                                                           {"the plan's number of workers", plan.folder / "workers"}};
    for (const PlannedScene& scene : plan.scenes) {
        files.emplace_back("the plan's scene " + scene.name, plan.pathOf(scene.scene));
        if (!scene.settings.empty())
            files.emplace_back("the settings of the plan's scene " + scene.name, plan.pathOf(scene.settings));
    }
    return files;
}

Result<uint32_t> lastWorkerCount(const FarmPlan& plan)
{
    const auto bytes = readFile(plan.folder / "workers");
    if (!bytes && bytes.error().code == ErrorCode::FileNotFound) return 0u;
    if (!bytes) return Error{bytes.error().code, "workers: " + bytes.error().message};
    std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    if (text.ends_with('\n')) text.pop_back();
    constexpr std::size_t kDigits = 9;
    const bool isWhole = !text.empty() && text.size() <= kDigits && text.find_first_not_of("0123456789") == text.npos;
    const uint32_t count = isWhole ? uint32_t(std::stoul(text)) : 0;
    if (count >= 1 && count <= kMostFarmProcesses) return count;
    return Error{ErrorCode::FileInvalid, "its file workers holds no number of workers from 1 to " +
                                             std::to_string(kMostFarmProcesses) + ": give it as --of"};
}

void noteWorkerCount(const FarmPlan& plan, uint32_t count)
{
    const Result<uint32_t> last = lastWorkerCount(plan);
    if (last && *last == count) return;
    // Only what `join` and `status` say depends on it.
    [[maybe_unused]] const Status status = writeFileAtomically(plan.folder / "workers", std::to_string(count) + "\n");
}

std::vector<uint32_t> workersToRepeat(const FarmPlan& plan, uint32_t workers, bool verify)
{
    const std::vector<std::vector<uint32_t>> workerOf = farmProcesses(plan.bakes(), workers);
    std::set<uint32_t> indices;
    for (std::size_t s = 0; s < plan.scenes.size(); ++s) {
        const PlannedScene& scene = plan.scenes[s];
        for (const std::size_t tile : missingFarmTiles(plan.pathOf(scene.cache), scene.bake, verify))
            indices.insert(workerOf[s][tile]);
    }
    return {indices.begin(), indices.end()};
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
