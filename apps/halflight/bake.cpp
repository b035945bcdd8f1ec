// halflight bake: scene in, baked glTF out.

#include "bake_device.h"
#include "bake_export.h"
#include "bake_options.h"
#include "console.h"
#include "interrupt.h"
#include "terminal.h"

#include "halflight/bake/bake.h"
#include "halflight/base/encoded_image.h"
#include "halflight/base/file.h"
#include "halflight/base/log.h"
#include "halflight/scene/gltf.h"
#include "halflight/scene/sidecar.h"
#include "halflight/scene/sky_picture.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

namespace halflight::cli {

namespace {

// In the cache, a file named after all that went into a bake tells what came out: the output's hash.
class FinishedBake {
public:
    FinishedBake(const BakeOptions& options, const Scene& scene, const IntegratorFactory& integrators)
        : output_(options.output),
          file_(options.bake.cacheDirectory / (hashOf(options, scene, integrators).hex() + ".done"))
    {}
    [[nodiscard]] bool isUpToDate() const
    {
        const Result<std::vector<std::byte>> noted = readFile(file_);
        const std::string hash = outputHash();
        return noted && !hash.empty() && noted->size() == hash.size() &&
               std::memcmp(noted->data(), hash.data(), hash.size()) == 0;
    }
    [[nodiscard]] Status note() const { return writeFileAtomically(file_, outputHash()); }

private:
    /// Empty where the processor lacks the instruction set; the bake says so.
    static std::string identityOf(const BakeSettings& settings, const IntegratorFactory& integrators)
    {
        if (settings.mixedIdentities) return kMixedIdentities;
        const Result<std::string> identity = integrators.identity(settings.isa);
        return identity ? *identity : std::string();
    }
    static Hash128 hashOf(const BakeOptions& options, const Scene& scene, const IntegratorFactory& integrators)
    {
        return Hasher()
            .add(bakeHash(scene, options.bake))
            .add(std::string_view(identityOf(options.bake, integrators)))
            .add(uint8_t(options.write.lightmapFormat))
            .add(options.write.skyWidth)
            .hash();
    }
    [[nodiscard]] std::string outputHash() const
    {
        const Result<std::vector<std::byte>> bytes = readFile(output_);
        return bytes ? Hasher().bytes(bytes->data(), bytes->size()).hash().hex() : std::string();
    }
    std::filesystem::path output_;
    std::filesystem::path file_;
};

} // namespace

std::string contradiction(const CLI::App& app, const BakeOptions& options)
{
    const std::string extension = lowerExtension(options.output);
    if (extension != ".glb" && extension != ".gltf")
        return fmt::format("--output must end in .glb or .gltf, not '{}'", options.output.string());
    if (options.bake.noiseTarget > 0.0f && options.bake.integrator == IntegratorKind::Path)
        return "--noise needs --integrator cache";
    if (options.bake.seconds > 0.0) {
        if (options.bake.samples > 0 || options.bake.noiseTarget > 0.0f)
            return "--time chooses the samples, so --samples and --noise do not go with it";
        if (!options.bake.cacheDirectory.empty())
            return "--time and --cache do not go together: what the cache holds takes no time, so the bake would "
                   "choose other samples each time; give --samples N, which a bake with --time prints";
    }
    if (options.write.lightmapFormat == LightmapFormat::Webp && !decodesWebp())
        return "--lightmap-format webp needs a build with libwebp, and this one has none";
    if (!options.bake.only.empty() && options.bake.cacheDirectory.empty())
        return "--only needs --cache, with the last bake of all objects";
    if (options.exportStyle && app.count("--groups") > 0 && options.bake.groups != GroupChoice::Off)
        return "exports hold no light groups, so --groups does not go with them";
    return exportContradiction(app, options);
}

namespace {

// The output, and the rest of the report.
Status writeOutput(const BakeOptions& options, bool isFormatGiven, BakeResult& result, const Progress& progress,
                   std::optional<ExportSummary>& exported)
{
    if (options.exportStyle) {
        exported.emplace();
        const Status status = writeExport(options, result, progress, *exported);
        for (std::string& warning : exportWarnings(*exported)) result.report.warnings.push_back(std::move(warning));
        return status;
    }
    WriteOptions write = options.write;
    write.written = &result.report.written;
    write.irradiance = result.irradiance;
    write.groupIrradiance = result.groupIrradiance;
    write.progress = progress;
    write.mayReplace = commitOutput;
    if (Status status = writeBakedScene(options.output, result.baked, write); !status) return status;
    if (options.sidecarDirectory.empty()) return {};
    SidecarOptions sidecar;
    sidecar.write = write;
    if (isFormatGiven) sidecar.format = write.lightmapFormat;
    return writeSidecar(options.sidecarDirectory, options.output, result.baked, sidecar, result.report.warnings);
}

/// What the user learns of a bake whose files are written: the report's file, warnings, a summary.
int reportBake(const BakeOptions& options, const BakeResult& result, const std::optional<ExportSummary>& exported)
{
    const std::string report = reportJson(result.report);
    const std::string json = exported ? withExport(report, *exported) : report;
    if (!options.reportFile.empty()) {
        if (Status status = writeFileAtomically(options.reportFile, json); !status) {
            return fail(options.reportFile, status.error());
        }
    }
    // A picture that cannot be written names its own file.
    if (!result.images) return fail({}, result.images.error());
    if (!options.quiet) {
        for (const std::string& warning : result.report.warnings) warn(options.scene, warning);
        for (const std::string& warning : lightWarnings(result.report)) warn(options.scene, warning);
    }
    if (options.json) {
        printJson(json);
    } else if (!options.quiet) {
        printBakeSummary(options, result.report);
        if (exported) printExport(*exported);
    }
    return kOk;
}

} // namespace

Result<Scene> readBakeScene(const BakeOptions& options)
{
    ReadOptions read;
    read.settingsFile = options.settingsFile;
    read.emissionUnit = options.emissionUnit;
    return readScene(options.scene, read);
}

void applyOptions(BakeOptions& options, Scene& scene)
{
    if (options.exportStyle) prepareExport(options.bake, scene);
    if (options.skyGiven) {
        Sky sky{options.skyNits, options.skyNits, options.skyNits};
        sky.group = scene.sky.group;
        sky.changes = scene.sky.changes;
        scene.sky = std::move(sky);
    }
    if (!scene.sky.picture || !scene.sky.pictureOfBake) return;
    scene.warnings.push_back(fmt::format("the sky is the picture of {} x {} texels that an earlier bake kept in the "
                                         "file, in which a small sun is blurred; name the original ([sky] image in "
                                         "a settings file), or bake the source scene",
                                         scene.sky.picture->width(), scene.sky.picture->height()));
}

int runBake(const CLI::App& app, const BakeOptions& given)
{
    if (const std::string sentence = contradiction(app, given); !sentence.empty()) return wrongUsage("bake", sentence);
    BakeOptions options = given;
    const auto began = std::chrono::steady_clock::now();
    // A sidecar is for readers that know four channels.
    if (!options.sidecarDirectory.empty() && app.count("--mask-layers") == 0) options.bake.mostMaskLayers = 1;
    // Viewers of exports know no groups, nor do most readers of sidecars: they get the lights as they are.
    if (options.exportStyle || (!options.sidecarDirectory.empty() && app.count("--groups") == 0))
        options.bake.groups = GroupChoice::Off;
    const std::string extension = lowerExtension(options.output);
    std::filesystem::path culprit;
    if (Status status = checkBakePaths(options, culprit); !status) return fail(culprit, status.error());

    removeTemporaryOf(options.output);
    // The display is up before the scene is read, so that Ctrl-C is heard from the start.
    std::optional<ProgressDisplay> display(std::in_place, options.quiet ? ProgressStyle::Quiet : options.progress);
    const Progress progress = display->progress();
    Result<Scene> scene = readBakeScene(options);
    if (!scene) {
        display.reset();
        return fail(options.scene, scene.error());
    }
    if (Status status = filesOfBake(options, &*scene).check(culprit); !status) {
        display.reset();
        return fail(culprit, status.error());
    }
    OutputFolders folders;
    for (const std::filesystem::path& folder :
         {options.bake.imagesDirectory, options.bake.cacheDirectory, options.sidecarDirectory}) {
        if (Status status = folders.make(folder); !status) {
            display.reset();
            return fail(folder, status.error());
        }
    }
    applyOptions(options, *scene);
    const Result<IntegratorFactory> integrators = integratorsOn(options.device, *scene, options.bake);
    if (!integrators) {
        display.reset();
        return fail("--device " + options.device.device, integrators.error());
    }
    std::optional<FinishedBake> finished;
    // A .gltf is more than one file, of which any may have changed since.
    const bool isWhole = options.bake.only.empty() && !options.exportStyle;
    if (!options.bake.cacheDirectory.empty() && extension == ".glb" && isWhole) {
        finished.emplace(options, *scene, *integrators);
        const bool onlyOutput = options.reportFile.empty() && options.bake.imagesDirectory.empty() &&
                                options.sidecarDirectory.empty() && !options.json;
        if (onlyOutput && finished->isUpToDate()) {
            display.reset();
            if (!options.quiet) {
                print("{} is up to date: the scene and the settings are those it was baked with; nothing to do\n",
                      options.output.string());
            }
            return kOk;
        }
    }

    if (options.bake.seconds > 0.0) { // reading has taken a part of them
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - began;
        options.bake.seconds = std::max(options.bake.seconds - taken.count(), kLeastSeconds);
    }
    Result<BakeResult> result = bake(std::move(*scene), options.bake, *integrators, progress);
    if (result && interrupted()) result = cancelledError();
    if (!result) {
        display.reset();
        return fail(options.scene, result.error());
    }
    progress("write", 0.0);
    std::optional<ExportSummary> exported;
    const Status written = writeOutput(options, app.count("--lightmap-format") > 0, *result, progress, exported);
    display.reset();
    if (!written) return fail(options.output, written.error());
    if (finished) {
        if (Status status = finished->note(); !status)
            result->report.warnings.push_back(cacheWarning(options.bake.cacheDirectory, status.error()));
    }

    return reportBake(options, *result, exported);
}

} // namespace halflight::cli
