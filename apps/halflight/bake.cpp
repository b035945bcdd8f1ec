// halflight bake: scene in, baked glTF out.

#include "console.h"
#include "interrupt.h"
#include "terminal.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/file.h"
#include "halflight/base/log.h"
#include "halflight/scene/gltf.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

namespace halflight::cli {

namespace {

struct BakeOptions {
    std::filesystem::path scene;
    std::filesystem::path output;
    std::filesystem::path settingsFile;
    std::filesystem::path reportFile;
    BakeSettings bake;
    WriteOptions write;
    vec3 skyNits{0.0f};
    bool skyGiven = false;
    int device = 0; ///< one so far: the CPU
    bool quiet = false;
    bool json = false;
};

// Whether a bake with --write-images may write a file of this name: PREFIX_N, or the probes.
bool isImageName(const std::string& name)
{
    if (name == "probes.json") return true;
    for (const auto& [prefix, extension] : {std::pair<std::string_view, std::string_view>{"lightmap_raw_", ".exr"},
                                            {"lightmap_", ".exr"},
                                            {"lightmap_direction_", ".png"},
                                            {"shadowmask_", ".png"}}) {
        if (!name.starts_with(prefix) || !name.ends_with(extension)) continue;
        if (name.size() <= prefix.size() + extension.size()) continue;
        const std::string page = name.substr(prefix.size(), name.size() - prefix.size() - extension.size());
        if (page.find_first_not_of("0123456789") == std::string::npos) return true;
    }
    return false;
}

// The images' number is known only after unwrapping, so all their names count: those that are links to `files`, and
// those of `files` that lie in the folder under such a name.
Status checkImages(const std::filesystem::path& folder, const std::vector<NamedFile>& files,
                   std::filesystem::path& culprit)
{
    if (folder.empty()) return {};
    std::vector<std::filesystem::path> images;
    for (const NamedFile& file : files) {
        if (isImageName(file.path.filename().string())) images.push_back(folder / file.path.filename());
        const Result<std::filesystem::path> target = replacedFile(file.path);
        if (target && isImageName(target->filename().string())) images.push_back(folder / target->filename());
    }
    std::error_code ec;
    for (std::filesystem::directory_iterator entry(folder, ec), end; !ec && entry != end; entry.increment(ec)) {
        if (isImageName(entry->path().filename().string())) images.push_back(entry->path());
    }
    std::sort(images.begin(), images.end()); // a folder has no order of its own
    for (const std::filesystem::path& image : images) {
        culprit = image;
        if (Status status = checkReplacesNone({"--write-images", image}, files); !status) return status;
    }
    return {};
}

// No file that the bake writes may replace one that it reads, or another that it writes.
Status checkPaths(const BakeOptions& options, std::filesystem::path& culprit)
{
    std::vector<NamedFile> files = {{"the scene", options.scene}, {"the settings file", options.settingsFile}};
    for (const NamedFile& output : {NamedFile{"--output", options.output}, NamedFile{"--report", options.reportFile}}) {
        if (output.path.empty()) continue;
        culprit = output.path;
        if (Status status = checkReplacesNone(output, files); !status) return status;
        if (Status status = checkOutput(output.path); !status) return status;
        files.push_back(output);
    }
    return checkImages(options.bake.imagesDirectory, files, culprit);
}

// The files beside a .gltf output may not replace those that the scene's document names.
Status checkFilesBeside(const BakeOptions& options, const Scene& scene)
{
    if (lowerExtension(options.output) != ".gltf") return {};
    const std::string stem = options.output.stem().string();
    for (const std::filesystem::path& file : externalFiles(scene)) {
        const std::string name = file.filename().string();
        const bool takenName = name == stem + ".bin" || name.starts_with(stem + "_image_");
        if (!takenName || !sameFile(file, options.output.parent_path() / name)) continue;
        return Error{ErrorCode::InvalidArgument,
                     "its file " + name + " would replace one of the scene's; choose another name for the output"};
    }
    return {};
}

// A folder that the bake writes into, tried before it begins.
Status makeFolder(const std::filesystem::path& folder)
{
    if (folder.empty()) return {};
    std::error_code ec;
    std::filesystem::create_directories(folder, ec);
    if (ec) return Error{ErrorCode::WriteFailed, "cannot be made into a folder (" + ec.message() + ")"};
    return tryWriting(folder);
}

// Lights that are not what their author asked for, where no other warning speaks of them yet.
std::vector<std::string> lightWarnings(const BakeReport& report)
{
    std::vector<std::string> warnings;
    for (const LightReport& light : report.lights) {
        if (light.bakedAs == light.authoredMode) continue;
        const auto namesLight = [&](const std::string& warning) {
            return warning.find("'" + light.name + "'") != std::string::npos ||
                   warning.find('"' + light.name + '"') != std::string::npos;
        };
        if (std::any_of(report.warnings.begin(), report.warnings.end(), namesLight)) continue;
        warnings.push_back(fmt::format("{} light '{}' was {} baked: {}", nameOf(light.authoredMode), light.name,
                                       light.bakedAs == LightMode::Baked ? "fully" : "not fully", light.reason));
    }
    return warnings;
}

void printLights(const BakeReport& report)
{
    if (report.lights.empty()) return;
    std::size_t width = 5;
    for (const LightReport& light : report.lights) width = std::max(width, printable(light.name).size());
    print("\n{:<{}}  {:<11}  {:<8}  {:<8}  {:<7}  {}\n", "light", width, "type", "mode", "baked as", "channel",
          "reason");
    for (const LightReport& light : report.lights) {
        const std::string line = fmt::format("{:<{}}  {:<11}  {:<8}  {:<8}  {:<7}  {}", printable(light.name), width,
                                             nameOf(light.type), nameOf(light.authoredMode), nameOf(light.bakedAs),
                                             channelName(light.channel), printable(light.reason));
        print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
    }
}

std::string_view densityReason(DensityFrom from)
{
    switch (from) {
    case DensityFrom::Asked:
        return "as asked";
    case DensityFrom::Page:
        return "what fits one page";
    case DensityFrom::Scene:
        return "by the scene's size (--texels-per-meter sets it)";
    }
    return "";
}

void printBytes(const BakeReport& report)
{
    const WrittenBytes& bytes = report.written;
    const auto mb = [](double count) { return fmt::format("{:.2f} MB", count * 1e-6); };
    const double pages = std::max(report.pageCount, 1);
    print("file       {}: lightmap {} a page", mb(double(bytes.file)), mb(double(bytes.lightmaps) / pages));
    if (bytes.lightmapDirections > 0) print(", directions {} a page", mb(double(bytes.lightmapDirections) / pages));
    if (bytes.shadowmasks > 0) print(", mask {} a page", mb(double(bytes.shadowmasks) / pages));
    print(", probes {}\n", mb(double(bytes.probes)));
}

void printSummary(const BakeOptions& options, const BakeReport& report)
{
    print("{}: {} in {}, peak memory {}, {}\n", options.output.string(), nameOf(options.bake.mode),
          clockTime(report.seconds), megabytes(report.peakMemoryBytes), report.integrator);
    printLights(report);

    print("\nlightmap   {} page{} of {} x {}, {:.0f} % filled\n", report.pageCount, report.pageCount == 1 ? "" : "s",
          report.pageSize, report.pageSize, 100.0 * double(report.atlasCoverage));
    print("           {:.4g} texels/m, {}\n", report.texelsPerMeter, densityReason(report.densityFrom));
    print("           {} charts, {} texels, {} of them inside geometry\n", grouped(uint64_t(report.chartCount)),
          grouped(report.coveredTexels), grouped(report.invalidTexels));
    if (report.cache.tiles > 0) {
        const std::size_t baked = report.cache.tiles - report.cache.same - report.cache.unchanged;
        print("cache      {} of {} tiles baked, {} taken as they were, {} not reached by what changed\n",
              grouped(baked), grouped(report.cache.tiles), grouped(report.cache.same), grouped(report.cache.unchanged));
    }
    print("geometry   {} static triangles\n", grouped(report.triangleCount));
    if (const auto& main = report.mainLight) {
        const vec3 color = main->shadowColor;
        print("subtracted {}, {} mask, down to {:.3g}, {:.3g}, {:.3g} lux{}\n", printable(main->name),
              main->mask ? "with its own" : "without a", color.r, color.g, color.b,
              main->colorByBake ? " (chosen by the bake)" : "");
    }
    print("probes     {} of {} valid\n", grouped(uint64_t(report.validProbeCount)),
          grouped(uint64_t(report.probeCount)));
    printBytes(report);
    print("samples    {:.0f} per texel, {} per masked light, at most {} bounces, {} per probe\n",
          report.samplesPerTexel, report.quality.shadowSamples, report.quality.bounces, report.quality.probeSamples);
    if (report.interpolatedTexels > 0) {
        print("           {} texels are interpolated\n", grouped(report.interpolatedTexels));
    }
    print("noise      {:.1f} % before denoising", 100.0 * double(report.noiseReached));
    if (report.quality.noiseTarget > 0.0f) {
        print(", target {:.1f} %; {} texels stopped at {} samples", 100.0 * double(report.quality.noiseTarget),
              grouped(report.texelsAtCap), report.quality.samples);
    }
    print("\n\n");

    print("{:<16} {:>9} {:>10} {:>10}\n", "stage", "seconds", "rays", "rays/s");
    for (const StageReport& stage : report.stages) {
        const bool rate = stage.rays > 0 && stage.seconds > 0.0;
        const std::string line = fmt::format("{:<16} {:>9.2f} {:>10} {:>10}", stage.name, stage.seconds,
                                             stage.rays > 0 ? withUnit(double(stage.rays)) : "",
                                             rate ? withUnit(double(stage.rays) / stage.seconds) : "");
        print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
    }
}

// In the cache, a file named after all that went into a bake tells what came out: the output's hash.
class FinishedBake {
public:
    FinishedBake(const BakeOptions& options, const Scene& scene)
        : output_(options.output), file_(options.bake.cacheDirectory / (hashOf(options, scene).hex() + ".done"))
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
    static Hash128 hashOf(const BakeOptions& options, const Scene& scene)
    {
        return Hasher().add(bakeHash(scene, options.bake)).add(uint8_t(options.write.mozLightmap)).hash();
    }
    [[nodiscard]] std::string outputHash() const
    {
        const Result<std::vector<std::byte>> bytes = readFile(output_);
        return bytes ? Hasher().bytes(bytes->data(), bytes->size()).hash().hex() : std::string();
    }
    std::filesystem::path output_;
    std::filesystem::path file_;
};

int runBake(const BakeOptions& options)
{
    const std::string extension = lowerExtension(options.output);
    if (extension != ".glb" && extension != ".gltf") {
        return wrongUsage("bake", fmt::format("--output must end in .glb or .gltf, not '{}'", options.output.string()));
    }
    if (options.bake.noiseTarget > 0.0f && options.bake.integrator == IntegratorKind::Path) {
        return wrongUsage("bake", "--noise needs --integrator cache");
    }
    if (options.bake.denoiser == Denoiser::OpenImage && !hasOpenImageDenoise()) {
        return wrongUsage("bake", "--denoise oidn needs a build with Open Image Denoise, and this one has none");
    }
    std::filesystem::path culprit;
    if (Status status = checkPaths(options, culprit); !status) return fail(culprit, status.error());

    removeTemporaryOf(options.output);
    // The display is up before the scene is read, so that Ctrl-C is heard from the start.
    std::optional<ProgressDisplay> display(std::in_place, options.quiet);
    const Progress progress = display->progress();
    ReadOptions readOptions;
    readOptions.settingsFile = options.settingsFile;
    Result<Scene> scene = readScene(options.scene, readOptions);
    if (!scene) {
        display.reset();
        return fail(options.scene, scene.error());
    }
    if (Status status = checkFilesBeside(options, *scene); !status) {
        display.reset();
        return fail(options.output, status.error());
    }
    for (const std::filesystem::path& folder : {options.bake.imagesDirectory, options.bake.cacheDirectory}) {
        if (Status status = makeFolder(folder); !status) {
            display.reset();
            return fail(folder, status.error());
        }
    }
    if (options.skyGiven) scene->sky = {options.skyNits, options.skyNits, options.skyNits};

    std::optional<FinishedBake> finished;
    // A .gltf is more than one file, of which any may have changed since.
    if (!options.bake.cacheDirectory.empty() && extension == ".glb") {
        finished.emplace(options, *scene);
        const bool onlyOutput = options.reportFile.empty() && options.bake.imagesDirectory.empty() && !options.json;
        if (onlyOutput && finished->isUpToDate()) {
            display.reset();
            if (!options.quiet) {
                print("{} is up to date: the scene and the settings are those it was baked with; nothing to do\n",
                      options.output.string());
            }
            return kOk;
        }
    }

    Result<BakeResult> result = bake(std::move(*scene), options.bake, makeEmbreeIntegrator, progress);
    if (result && interrupted()) result = Error{ErrorCode::Cancelled, "interrupted"};
    if (!result) {
        display.reset();
        return fail(options.scene, result.error());
    }
    progress("write", 0.0);
    WriteOptions writeOptions = options.write;
    writeOptions.written = &result->report.written;
    writeOptions.progress = progress;
    writeOptions.mayReplace = commitOutput;
    const Status written = writeBakedScene(options.output, result->baked, writeOptions);
    display.reset();
    if (!written) return fail(options.output, written.error());
    if (finished) {
        if (Status status = finished->note(); !status)
            result->report.warnings.push_back(cacheWarning(options.bake.cacheDirectory, status.error()));
    }

    const std::string json = reportJson(result->report);
    if (!options.reportFile.empty()) {
        if (Status status = writeFileAtomically(options.reportFile, json); !status) {
            return fail(options.reportFile, status.error());
        }
    }
    // A picture that cannot be written names its own file.
    if (!result->images) return fail({}, result->images.error());
    if (!options.quiet) {
        for (const std::string& warning : result->report.warnings) warn(options.scene, warning);
        for (const std::string& warning : lightWarnings(result->report)) warn(options.scene, warning);
    }
    if (options.json) {
        printJson(json);
    } else if (!options.quiet) {
        printSummary(options, result->report);
    }
    return kOk;
}

} // namespace

Command addBakeCommand(CLI::App& parent)
{
    auto options = std::make_shared<BakeOptions>();
    CLI::App& app = *parent.add_subcommand("bake", "Bake lightmaps, shadowmasks and probes into a glTF file");
    app.add_option("SCENE", options->scene, "the scene, .glb or .gltf")->required()->type_name(" ");
    app.add_option("-o,--output", options->output, "the baked file to write: .glb, or .gltf with its files beside it")
        ->required()
        ->type_name("OUT.glb");

    BakeSettings& bake = options->bake;
    app.option_defaults()->group("Bake");
    addChoice<MixedLightingMode>(app, "--mode", bake.mode,
                                 {{"baked-indirect", MixedLightingMode::BakedIndirect},
                                  {"shadowmask", MixedLightingMode::Shadowmask},
                                  {"subtractive", MixedLightingMode::Subtractive}},
                                 "mixed lighting mode (default shadowmask)");
    addChoice<Quality>(app, "--quality", bake.quality,
                       {{"preview", Quality::Preview},
                        {"medium", Quality::Medium},
                        {"high", Quality::High},
                        {"ultra", Quality::Ultra}},
                       "samples and lightmap size in one word (default medium)");
    addChoice<IntegratorKind>(app, "--integrator", bake.integrator,
                              {{"cache", IntegratorKind::Cache}, {"path", IntegratorKind::Path}},
                              "rays that end in a radiance cache, or whole unbiased paths: the slow reference (default "
                              "cache)");
    addInt(app, "--samples", bake.samples, 1, 1 << 20,
           "rays or paths per texel, about (default by quality); with --noise, the most");
    addPercent(app, "--noise", bake.noiseTarget, 0.1f, 100.0f,
               "noise at which a texel has enough samples, such as 2% (default: --samples on average)");
    addChoice<int>(
        app, "--texel-step", bake.texelStep, {{"auto", 0}, {"1", 1}, {"2", 2}, {"4", 4}},
        "2 or 4: trace every so many texels whatever is around them, and those in between only where light can "
        "change (default auto: 2 in large lightmaps, else 1)");
    addInt(app, "--shadow-samples", bake.shadowSamples, 1, 1 << 16,
           "shadow rays per texel and masked light (default by quality)");
    addInt(app, "--bounces", bake.bounces, 0, kAllBounces, "most bounces, 0 = direct light only (default: all light)");
    addFloat(app, "--texels-per-meter", bake.texelsPerMeter, 0.001f, 10000.0f, "X",
             "lightmap density; as many pages as that takes (default: by the scene's size, and what fits one page)");
    addInt(app, "--lightmap-size", bake.lightmapSize, 64, 8192,
           "width of a page in texels; alone, the density is what fits one (default: by quality, cut to what is used)");
    addInt(app, "--padding", bake.paddingTexels, 1, 16, "empty texels between charts (default 2)");
    addChoice<UvMode>(
        app, "--uv", bake.uvMode, {{"auto", UvMode::Auto}, {"keep", UvMode::Keep}, {"unwrap", UvMode::Unwrap}},
        "the file's TEXCOORD_1: keep it where it is valid, keep it or fail, or unwrap anew (default auto)");
    addChoice<Denoiser>(app, "--denoise", bake.denoiser,
                        {{"on", Denoiser::BuiltIn}, {"off", Denoiser::Off}, {"oidn", Denoiser::OpenImage}},
                        "denoise the lightmap; oidn: with Open Image Denoise, in builds that have it (default on)");
    addChoice<bool>(app, "--directional", bake.directional, {{"on", true}, {"off", false}},
                    "keep the mean direction of lightmap light too, so that normal maps respond to it (default off)");
    addChoice<MaskEncoding>(app, "--shadowmask-encoding", bake.maskEncoding,
                            {{"attenuation", MaskEncoding::Attenuation}, {"distance-field", MaskEncoding::Distance}},
                            "what shadowmask texels hold; distance fields keep hard edges crisp at half the density, "
                            "for lights with narrow penumbrae (default attenuation)");
    addChoice<bool>(app, "--subtractive-mask", bake.subtractiveMask, {{"on", true}, {"off", false}},
                    "subtractive: store the main light's own mask, so that dynamic shadows take away only light that "
                    "arrives (default on)");
    addFloat(app, "--probe-spacing", bake.probeSpacingMeters, 0.01f, 10000.0f, "METERS",
             "distance between light probes (default by the scene's size)");
    addVec3(app, "--sky", options->skyNits, 0.0f, 1.0e6f, "R,G,B",
            "radiance of a uniform sky in nits, instead of the scene's own")
        ->each([options](const std::string&) { options->skyGiven = true; });
    app.add_option("--settings", options->settingsFile, "light and object settings by name pattern")
        ->type_name("FILE.toml");

    app.option_defaults()->group("Run");
    addChoice<int>(app, "--device", options->device, {{"auto", 0}, {"cpu", 0}}, "what bakes (default auto)");
    addInt(app, "--threads", bake.threads, 0, 4096, "0 = all cores; changes no byte of the result (default 0)");
    addUint(app, "--seed", bake.seed, "of the random numbers (default 1)");

    app.add_option(
           "--cache", bake.cacheDirectory,
           "keep finished tiles in this folder: an interrupted bake goes on where it stopped, a changed scene is "
           "baked anew only where the change shows")
        ->type_name("DIR");

    app.option_defaults()->group("Output");
    app.add_flag("--moz-lightmap", options->write.mozLightmap,
                 "write MOZ_lightmap materials too, for loaders that know them; much larger files");
    app.add_option("--report", options->reportFile, "write what the bake did: lights, charts, rays, seconds, warnings")
        ->type_name("FILE.json");
    app.add_option("--write-images", bake.imagesDirectory, "write lightmaps, shadowmasks and probes as plain files too")
        ->type_name("DIR");
    app.add_flag("--json", options->json, "print the report as JSON on standard output");
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight bake scene.glb -o baked.glb --quality preview");
    return {&app, [options] { return runBake(*options); }};
}

} // namespace halflight::cli
