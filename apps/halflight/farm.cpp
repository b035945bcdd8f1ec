// halflight farm: one bake, or many, by any number of processes on any number of machines.

#include "bake_device.h"
#include "bake_options.h"
#include "console.h"
#include "farm_line.h"
#include "farm_plan.h"
#include "interrupt.h"
#include "terminal.h"

#include "halflight/bake/farm.h"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace halflight::cli {

namespace {

namespace fs = std::filesystem;

// --- work

struct WorkOptions {
    fs::path folder;
    int index = 0;
    int of = 1;
    FarmStage stage = FarmStage::All;
    int threads = 0;
    ProgressStyle progress = ProgressStyle::Auto;
    bool quiet = false;
};

/// What a scene of the plan still has to have done by this worker.
Result<BakeReport> workOnScene(const WorkOptions& options, const FarmPlan& plan, const PlannedScene& planned,
                               FarmWork work, const Progress& progress)
{
    work.stage = options.stage;
    BakeLine line(plan.bakeArguments(planned, "plan.glb"));
    line.options.bake.threads = options.threads;
    line.options.bake.mixedIdentities = planned.bake.identity == kMixedIdentities;
    Result<Scene> scene = sceneOf(line);
    if (!scene) return scene.error();
    const Result<IntegratorFactory> integrators = integratorsOn(line.options.device, *scene, line.options.bake);
    if (!integrators) return integrators.error();
    return workOnFarm(std::move(*scene), line.options.bake, planned.bake, work, plan.compares, *integrators, progress);
}

int runWork(const WorkOptions& options)
{
    if (options.index >= options.of)
        return wrongUsage("farm work", fmt::format("--index counts from 0, so it is below --of {}", options.of));
    const Result<FarmPlan> plan = readPlan(options.folder);
    if (!plan) return fail(options.folder, plan.error());
    const WorkShare share{uint32_t(options.index), uint32_t(options.of)};
    noteWorkerCount(*plan, share.count);
    std::optional<ProgressDisplay> display(std::in_place, options.quiet ? ProgressStyle::Quiet : options.progress);
    const Progress progress = display->progress();
    const std::vector<FarmWork> works = farmWork(plan->bakes(), share);
    std::vector<std::string> notes;
    for (std::size_t s = 0; s < works.size(); ++s) {
        if (works[s].share.count == 0) continue;
        const PlannedScene& scene = plan->scenes[s];
        const Result<BakeReport> report = workOnScene(options, *plan, scene, works[s], progress);
        if (!report) {
            display.reset();
            return fail(plan->pathOf(scene.scene), report.error());
        }
        notes.insert(notes.end(), report->warnings.begin(), report->warnings.end());
    }
    display.reset();
    for (const std::string& note : notes) warn(options.folder, note);
    return kOk;
}

Command addWork(CLI::App& parent)
{
    auto options = std::make_shared<WorkOptions>();
    CLI::App& app = *parent.add_subcommand("work", "Do one worker's share of a plan");
    app.add_option("DIR", options->folder, "the plan's folder")->required()->type_name(" ");
    addInt(app, "--index", options->index, 0, int(kMostFarmProcesses), "number of this worker, from 0 (default 0)");
    addInt(app, "--of", options->of, 1, int(kMostFarmProcesses), "number of workers (default 1)");
    addChoice<FarmStage>(app, "--stage", options->stage,
                         {{"all", FarmStage::All}, {"cache", FarmStage::Cache}, {"tiles", FarmStage::Tiles}},
                         "cache: validity, the radiance cache and probes, which workers share part by part; tiles: "
                         "lightmaps and masks, which need the cache complete (default all)");
    addInt(app, "--threads", options->threads, 0, 4096, "0 = all cores (default 0)");
    addProgress(app, options->progress);
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight farm work plan --index 3 --of 16");
    return {&app, [options] { return runWork(*options); }};
}

// --- join and status

struct JoinOptions {
    fs::path folder;
    fs::path output;
    std::string scene;
    int of = 0;
    BakeOptions bake; ///< only for parsing
};

Result<uint32_t> workersOf(const FarmPlan& plan, int asked)
{
    if (asked > 0) return uint32_t(asked);
    Result<uint32_t> workers = lastWorkerCount(plan);
    if (workers && *workers == 0) *workers = 1;
    return workers;
}

/// What keeps a plan from being joined, as a sentence; empty when nothing does.
std::string incomplete(const FarmPlan& plan, uint32_t workers)
{
    for (const PlannedScene& scene : plan.scenes) {
        if (!isFarmCacheComplete(plan.pathOf(scene.cache), scene.bake))
            return fmt::format("the cache stage of {} is not complete: run halflight farm work --stage cache again",
                               scene.name);
    }
    const std::vector<uint32_t> missing = workersToRepeat(plan, workers, true);
    if (missing.empty()) return {};
    return fmt::format("tiles are missing or broken, those of workers {} of {}: run halflight farm work --index with "
                       "these again",
                       arrayList(missing), workers);
}

/// Error when the plan's copy of a scene was changed, so that its tiles are of another, or when this machine would give
/// other bytes than the plan's.
Status checkScene(const BakeLine& line, const PlannedScene& planned)
{
    BakeOptions options = line.options;
    Result<Scene> scene = readBakeScene(options);
    if (!scene) return scene.error();
    applyOptions(options, *scene);
    if (Status status = checkFarmInputs(*scene, options.bake, planned.bake); !status) return status;
    const Result<IntegratorFactory> integrators = integratorsOn(options.device, *scene, options.bake);
    if (!integrators) return integrators.error();
    return checkFarmIdentity(options.bake, planned.bake, *integrators);
}

int runJoin(const JoinOptions& options)
{
    Result<FarmPlan> plan = readPlan(options.folder);
    if (!plan) return fail(options.folder, plan.error());
    const bool several = plan->scenes.size() > 1;
    if (!options.scene.empty()) {
        std::erase_if(plan->scenes, [&](const PlannedScene& s) { return s.name != options.scene; });
        if (plan->scenes.empty())
            return wrongUsage("farm join", fmt::format("the plan has no scene '{}'", options.scene));
    }
    const bool single = !options.bake.reportFile.empty() || !options.bake.sidecarDirectory.empty() ||
                        !options.bake.bake.imagesDirectory.empty();
    if (single && plan->scenes.size() > 1)
        return wrongUsage("farm join", "--report, --sidecar and --write-images are of one scene: name it with --scene");
    // Tiles of workers are those of the whole plan.
    const Result<FarmPlan> whole = readPlan(options.folder);
    if (!whole) return fail(options.folder, whole.error());
    const Result<uint32_t> workers = workersOf(*whole, options.of);
    if (!workers) return fail(options.folder, workers.error());
    if (const std::string sentence = incomplete(*whole, *workers);
        !sentence.empty() && (options.scene.empty() || !incomplete(*plan, 1).empty()))
        return fail(options.folder, Error{ErrorCode::FileInvalid, sentence});
    const bool intoFolder = several && options.scene.empty();
    OutputFolders folders;
    if (intoFolder) {
        if (Status status = folders.make(options.output); !status) return fail(options.output, status.error());
    }
    for (const PlannedScene& scene : plan->scenes) {
        const fs::path output = intoFolder ? options.output / (scene.name + ".glb") : options.output;
        BakeLine line(plan->bakeArguments(scene, output.string()));
        if (Status status = checkScene(line, scene); !status) return fail(line.options.scene, status.error());
        line.options.bake.threads = options.bake.bake.threads;
        line.options.bake.mixedIdentities = scene.bake.identity == kMixedIdentities;
        line.options.reportFile = options.bake.reportFile;
        line.options.sidecarDirectory = options.bake.sidecarDirectory;
        line.options.bake.imagesDirectory = options.bake.bake.imagesDirectory;
        line.options.json = options.bake.json;
        line.options.progress = options.bake.progress;
        line.options.quiet = options.bake.quiet;
        line.options.alsoRead = filesOfPlan(*whole);
        if (const int code = runBake(*line.app, line.options); code != kOk) return code;
    }
    return kOk;
}

Command addJoin(CLI::App& parent)
{
    auto options = std::make_shared<JoinOptions>();
    CLI::App& app = *parent.add_subcommand("join", "Check all tiles, then denoise, stitch, encode and write");
    app.add_option("DIR", options->folder, "the plan's folder")->required()->type_name(" ");
    app.add_option("-o,--output", options->output,
                   "the baked file: .glb, or .gltf with its files beside it; for several scenes a folder")
        ->required()
        ->type_name("OUT");
    app.add_option("--scene", options->scene, "only this one of several")->type_name("NAME");
    addInt(app, "--of", options->of, 1, int(kMostFarmProcesses),
           "number of workers, for the list of missing ones (default the last's)");
    addInt(app, "--threads", options->bake.bake.threads, 0, 4096, "0 = all cores (default 0)");
    addProgress(app, options->bake.progress);
    app.option_defaults()->group("Output");
    addReportOptions(app, options->bake);
    app.footer("Example: halflight farm join plan -o baked.glb");
    return {&app, [options] { return runJoin(*options); }};
}

struct StatusOptions {
    fs::path folder;
    int of = 0;
    bool missing = false;
    bool json = false;
};

int runStatus(const StatusOptions& options)
{
    const Result<FarmPlan> plan = readPlan(options.folder);
    if (!plan) return fail(options.folder, plan.error());
    const Result<uint32_t> workers = workersOf(*plan, options.of);
    if (!workers) return fail(options.folder, workers.error());
    const std::vector<uint32_t> missing = workersToRepeat(*plan, *workers, false);
    if (options.missing) {
        print("{}\n", arrayList(missing));
        return kOk;
    }
    nlohmann::json scenes = nlohmann::json::array();
    for (const PlannedScene& scene : plan->scenes) {
        const fs::path cache = plan->pathOf(scene.cache);
        const std::size_t done = scene.bake.tiles - missingFarmTiles(cache, scene.bake, false).size();
        const bool prepared = isFarmCacheComplete(cache, scene.bake);
        scenes.push_back(
            {{"name", scene.name}, {"tiles", scene.bake.tiles}, {"done", done}, {"cacheComplete", prepared}});
        if (!options.json)
            print("{}: cache stage {}, {} of {} tiles\n", scene.name, prepared ? "complete" : "not complete", done,
                  scene.bake.tiles);
    }
    if (options.json) {
        printJson(nlohmann::json{{"scenes", scenes}, {"workers", *workers}, {"missing", arrayList(missing)}}.dump(2));
    } else if (!missing.empty()) {
        print("missing: {} of {} workers\n", arrayList(missing), *workers);
    }
    return kOk;
}

Command addStatus(CLI::App& parent)
{
    auto options = std::make_shared<StatusOptions>();
    CLI::App& app = *parent.add_subcommand("status", "Tell how far a plan is");
    app.add_option("DIR", options->folder, "the plan's folder")->required()->type_name(" ");
    addInt(app, "--of", options->of, 1, int(kMostFarmProcesses),
           "number of workers, for the list of missing ones (default the last's)");
    app.add_flag("--missing", options->missing, "print only the missing workers, as job arrays take them: 3,17-19");
    app.add_flag("--json", options->json, "print JSON");
    return {&app, [options] { return runStatus(*options); }};
}

} // namespace

Command addFarmCommand(CLI::App& parent)
{
    CLI::App& app = *parent.add_subcommand("farm", "Bake with many processes or machines: plan, work, join, status");
    app.require_subcommand(1);
    const std::vector<Command> commands = {addFarmPlan(app), addWork(app), addJoin(app), addStatus(app)};
    app.footer("halflight farm plan scene.glb -o plan; halflight farm work plan --index I --of N for each I below N; "
               "halflight farm join plan -o baked.glb");
    return {&app, [commands] {
                for (const Command& command : commands) {
                    if (command.app->parsed()) return command.run();
                }
                return int(kWrongUsage);
            }};
}

} // namespace halflight::cli
