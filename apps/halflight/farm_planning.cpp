// halflight farm plan: a folder with all that workers need.

#include "bake_device.h"
#include "bake_options.h"
#include "console.h"
#include "farm_line.h"
#include "farm_plan.h"
#include "terminal.h"

#include "halflight/bake/farm.h"
#include "halflight/base/file.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>

namespace halflight::cli {

namespace {

namespace fs = std::filesystem;

struct PlanOptions {
    std::vector<fs::path> scenes;
    fs::path list;
    fs::path folder;
    bool quiet = false;
    BakeOptions bake; ///< only for parsing; the plan keeps the words
};

/// The bake's options as they were given, without those that name files.
std::vector<std::string> givenOptions(const CLI::App& app)
{
    const std::set<std::string> left = {"--output", "--list",     "--settings", "--cache", "--threads",
                                        "--quiet",  "--progress", "--mixed",    "--help"};
    std::vector<std::string> words;
    for (const CLI::Option* option : app.get_options()) {
        if (option->count() == 0 || option->get_lnames().empty()) continue;
        const std::string name = "--" + option->get_lnames().front();
        if (left.contains(name)) continue;
        words.push_back(name);
        if (option->get_expected_min() > 0) words.push_back(CLI::detail::join(option->results(), ","));
    }
    return words;
}

Result<std::vector<fs::path>> scenesOf(const PlanOptions& options)
{
    std::vector<fs::path> scenes = options.scenes;
    if (options.list.empty()) return scenes;
    const auto bytes = readFile(options.list);
    if (!bytes) return bytes.error();
    std::string text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    std::replace(text.begin(), text.end(), '\r', '\n');
    for (const std::string& line : CLI::detail::split(text, '\n')) {
        const std::string name = CLI::detail::trim_copy(line);
        if (!name.empty() && name[0] != '#') scenes.push_back(options.list.parent_path() / name);
    }
    if (scenes.empty()) return Error{ErrorCode::InvalidArgument, "names no scene"};
    return scenes;
}

/// The folder is new or empty, so that a plan never mixes with another.
Status makePlanFolder(const fs::path& folder, OutputFolders& folders)
{
    if (Status status = folders.make(folder); !status) return status;
    std::error_code ec;
    if (!fs::is_empty(folder, ec)) {
        return Error{ErrorCode::InvalidArgument,
                     "is not empty; a plan takes a folder of its own, so name another or remove it"};
    }
    return {};
}

/// Empties the folder, which only this plan wrote into, so that the next try finds it as this one did.
void removePlan(const fs::path& folder)
{
    std::error_code ec;
    for (fs::directory_iterator entry(folder, ec), end; !ec && entry != end; entry.increment(ec)) {
        std::error_code gone;
        fs::remove_all(entry->path(), gone);
    }
}

std::string uniqueName(const FarmPlan& plan, const std::string& stem)
{
    const auto taken = [&](const std::string& name) {
        return std::any_of(plan.scenes.begin(), plan.scenes.end(), [&](const auto& s) { return s.name == name; });
    };
    std::string plain = stem;
    for (char& c : plain) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '_';
    }
    if (printable(plain) != plain || plain == "." || plain == "..") plain = "scene";
    std::string name = plain;
    for (int i = 2; taken(name); ++i) name = fmt::format("{}-{}", plain, i);
    return name;
}

/// What is wrong with a line of a farm, as a sentence; empty when nothing is.
std::string contradictionOf(const BakeLine& line)
{
    if (line.options.bake.seconds > 0.0)
        return "--time measures the machine that bakes, and a farm has several: --samples N says how many samples";
    return contradiction(*line.app, line.options);
}

/// Adds a scene to the plan. `culprit`: the file of an error.
Status planScene(const PlanOptions& options, const fs::path& file, const std::vector<std::string>& words, bool several,
                 const Progress& progress, FarmPlan& plan, fs::path& culprit)
{
    PlannedScene planned;
    planned.name = uniqueName(plan, file.stem().string());
    planned.options = words;
    planned.cache = "cache";
    std::error_code ec;
    if (plan.compares) planned.cache = fs::absolute(options.bake.bake.cacheDirectory, ec);
    if (several) planned.cache /= planned.name; // a cache keeps the last few bakes, so each scene has its own
    culprit = file;
    ReadOptions read;
    read.settingsFile = options.bake.settingsFile;
    read.emissionUnit = options.bake.emissionUnit;
    {
        Result<Scene> scene = readScene(file, read);
        if (!scene) return scene.error();
        if (Status status = copyScene(*scene, file, options.bake.settingsFile, plan, planned); !status) return status;
    }
    // What workers will read is what is planned.
    BakeLine line(plan.bakeArguments(planned, "plan.glb"));
    line.options.bake.threads = options.bake.bake.threads;
    line.options.bake.mixedIdentities = options.bake.bake.mixedIdentities;
    Result<Scene> scene = sceneOf(line);
    if (!scene) return scene.error();
    const Result<IntegratorFactory> integrators = integratorsOn(line.options.device, *scene, line.options.bake);
    if (!integrators) return integrators.error();
    Result<FarmBake> bake = planFarm(std::move(*scene), line.options.bake, *integrators, progress);
    if (!bake) return bake.error();
    planned.bake = *bake;
    plan.scenes.push_back(std::move(planned));
    return {};
}

int runPlan(const CLI::App& app, const PlanOptions& options)
{
    const Result<std::vector<fs::path>> scenes = scenesOf(options);
    if (!scenes) return fail(options.list, scenes.error());
    if (scenes->empty()) return wrongUsage("farm plan", "name a scene, or a list of scenes with --list");
    const std::vector<std::string> words = givenOptions(app);
    FarmPlan plan;
    plan.folder = options.folder;
    plan.compares = !options.bake.bake.cacheDirectory.empty();
    {
        PlannedScene any;
        any.options = words;
        BakeLine line(plan.bakeArguments(any, "plan.glb"));
        if (const std::string sentence = contradictionOf(line); !sentence.empty())
            return wrongUsage("farm plan", sentence);
    }
    OutputFolders folders;
    if (Status status = makePlanFolder(options.folder, folders); !status) return fail(options.folder, status.error());
    std::optional<ProgressDisplay> display(std::in_place, options.quiet ? ProgressStyle::Quiet : options.bake.progress);
    const Progress progress = display->progress();
    for (const fs::path& scene : *scenes) {
        fs::path culprit;
        if (Status s = planScene(options, scene, words, scenes->size() > 1, progress, plan, culprit); !s) {
            display.reset();
            removePlan(options.folder);
            return fail(culprit, s.error());
        }
    }
    const Status written = writePlan(plan);
    display.reset();
    if (!written) {
        removePlan(options.folder);
        return fail(options.folder / "plan.json", written.error());
    }
    if (options.quiet) return kOk;
    for (const PlannedScene& scene : plan.scenes) {
        print("{}: {} texels in {} tiles{}\n", scene.name, grouped(scene.bake.texels), scene.bake.tiles,
              scene.bake.maskLayers > 0 ? ", with masks" : "");
    }
    return kOk;
}

} // namespace

std::string wrongPlanOptions(const std::vector<std::string>& words)
{
    CLI::App app;
    app.allow_windows_style_options(false);
    app.set_help_flag(); // --help is none
    BakeOptions options;
    addLightOptions(app, options);
    addFormatOptions(app, options);
    app.remove_option(app.get_option("--settings"));
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
        if (std::string sentence = emptyValue(app); !sentence.empty()) return sentence;
        std::vector<std::string> arguments = {"bake", "scene.glb", "-o", "plan.glb"};
        arguments.insert(arguments.end(), words.begin(), words.end());
        const BakeLine line(arguments);
        return contradictionOf(line);
    } catch (const CLI::ParseError& error) {
        return error.what();
    }
}

Command addFarmPlan(CLI::App& parent)
{
    auto options = std::make_shared<PlanOptions>();
    CLI::App& app = *parent.add_subcommand("plan", "Write a folder with all that workers need");
    app.add_option("SCENE", options->scenes, "the scenes, .glb or .gltf")->type_name(" ");
    app.add_option("-o,--output", options->folder, "the plan's folder: new or empty, seen by all workers")
        ->required()
        ->type_name("DIR");
    app.add_option("--list", options->list, "a text file with one scene a line, relative to it")->type_name("FILE");
    app.add_option("--cache", options->bake.bake.cacheDirectory,
                   "take tiles of earlier bakes from this folder, and keep these there; seen by all workers. Several "
                   "scenes have a folder each in it")
        ->type_name("DIR");
    app.add_flag(
        "--mixed", options->bake.bake.mixedIdentities,
        "machines of all kinds may work on the plan: charts are the plan's, and the light of each tile has the "
        "bytes of the machine that computed it. Without it, workers must give the plan's bytes");
    addInt(app, "--threads", options->bake.bake.threads, 0, 4096, "of the plan itself; 0 = all cores (default 0)");
    addProgress(app, options->bake.progress);
    addLightOptions(app, options->bake);
    addFormatOptions(app, options->bake);
    app.option_defaults()->group("Output");
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight farm plan scene.glb -o plan --quality high");
    return {&app, [options, &app] { return runPlan(app, *options); }};
}

} // namespace halflight::cli
