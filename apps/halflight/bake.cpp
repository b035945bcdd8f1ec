// halflight bake: scene in, baked glTF out.

#include "bake_export.h"
#include "bake_options.h"
#include "console.h"
#include "interrupt.h"
#include "terminal.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
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
        return Hasher()
            .add(bakeHash(scene, options.bake))
            .add(uint8_t(options.write.mozLightmap))
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

// What is wrong with the options together, as a sentence; empty when nothing is.
std::string contradiction(const CLI::App& app, const BakeOptions& options)
{
    const std::string extension = lowerExtension(options.output);
    if (extension != ".glb" && extension != ".gltf")
        return fmt::format("--output must end in .glb or .gltf, not '{}'", options.output.string());
    if (options.bake.noiseTarget > 0.0f && options.bake.integrator == IntegratorKind::Path)
        return "--noise needs --integrator cache";
    if (options.bake.denoiser == Denoiser::OpenImage && !hasOpenImageDenoise())
        return "--denoise oidn needs a build with Open Image Denoise, and this one has none";
    if (options.write.lightmapFormat == LightmapFormat::Webp && !decodesWebp())
        return "--lightmap-format webp needs a build with libwebp, and this one has none";
    return exportContradiction(app, options);
}

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
    write.progress = progress;
    write.mayReplace = commitOutput;
    if (Status status = writeBakedScene(options.output, result.baked, write); !status) return status;
    if (options.sidecarDirectory.empty()) return {};
    SidecarOptions sidecar;
    sidecar.write = write;
    if (isFormatGiven) sidecar.format = write.lightmapFormat;
    return writeSidecar(options.sidecarDirectory, options.output, result.baked, sidecar, result.report.warnings);
}

int runBake(const CLI::App& app, const BakeOptions& given)
{
    if (const std::string sentence = contradiction(app, given); !sentence.empty()) return wrongUsage("bake", sentence);
    BakeOptions options = given;
    const std::string extension = lowerExtension(options.output);
    std::filesystem::path culprit;
    if (Status status = checkBakePaths(options, culprit); !status) return fail(culprit, status.error());

    removeTemporaryOf(options.output);
    // The display is up before the scene is read, so that Ctrl-C is heard from the start.
    std::optional<ProgressDisplay> display(std::in_place, options.quiet ? ProgressStyle::Quiet : options.progress);
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
    for (const std::filesystem::path& folder :
         {options.bake.imagesDirectory, options.bake.cacheDirectory, options.sidecarDirectory}) {
        if (Status status = makeFolder(folder); !status) {
            display.reset();
            return fail(folder, status.error());
        }
    }
    if (options.exportStyle) prepareExport(options.bake, *scene);
    if (options.skyGiven) scene->sky = Sky{options.skyNits, options.skyNits, options.skyNits};

    if (scene->sky.picture && scene->sky.pictureOfBake) {
        scene->warnings.push_back(
            fmt::format("the sky is the picture of {} x {} texels that an earlier bake kept in the "
                        "file, in which a small sun is blurred; name the original ([sky] image in "
                        "a settings file), or bake the source scene",
                        scene->sky.picture->width(), scene->sky.picture->height()));
    }

    std::optional<FinishedBake> finished;
    // A .gltf is more than one file, of which any may have changed since.
    if (!options.bake.cacheDirectory.empty() && extension == ".glb" && !options.exportStyle) {
        finished.emplace(options, *scene);
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

    Result<BakeResult> result = bake(std::move(*scene), options.bake, makeEmbreeIntegrator, progress);
    if (result && interrupted()) result = Error{ErrorCode::Cancelled, "interrupted"};
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

    const std::string report = reportJson(result->report);
    const std::string json = exported ? withExport(report, *exported) : report;
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
        printBakeSummary(options, result->report);
        if (exported) printExport(*exported);
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
    addChoice<ProbeLayout>(app, "--probe-layout", bake.probeLayout,
                           {{"refined", ProbeLayout::Refined}, {"grid", ProbeLayout::Grid}},
                           "probes where light changes and on floors, or a regular grid alone, for engines that read "
                           "nothing else (default refined)");
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

    addChoice<ProgressStyle>(app, "--progress", options->progress,
                             {{"auto", ProgressStyle::Auto}, {"lines", ProgressStyle::Lines}},
                             "auto: a bar on a terminal, one line a stage elsewhere; lines: 'progress: STAGE PERCENT "
                             "%', ten a second at most, for programs (default auto)");

    app.option_defaults()->group("Output");
    addChoice<LightmapFormat>(
        app, "--lightmap-format", options->write.lightmapFormat,
        {{"rgb9e5", LightmapFormat::Rgb9e5}, {"half", LightmapFormat::Half}, {"webp", LightmapFormat::Webp}},
        "how lightmaps are stored: RGB9E5 or half floats in KTX2, or 8 bits a channel by a curve in lossless WebP; "
        "the report has the error of each page (default rgb9e5)");
    addInt(app, "--sky-width", options->write.skyWidth, 16, kMostSkyTexels,
           "texels in a row of the sky's picture in the file, at most (default 512)");
    addExportOptions(app, *options);
    app.add_option("--sidecar", options->sidecarDirectory,
                   "also write the bake as pictures and one JSON that binds them by node name, for tools that drop "
                   "extensions; lightmaps as EXR, or as --lightmap-format says")
        ->type_name("DIR");
    app.add_flag("--moz-lightmap", options->write.mozLightmap,
                 "write MOZ_lightmap materials too, for loaders that know them; much larger files");
    app.add_option("--report", options->reportFile, "write what the bake did: lights, charts, rays, seconds, warnings")
        ->type_name("FILE.json");
    app.add_option("--write-images", bake.imagesDirectory, "write lightmaps, shadowmasks and probes as plain files too")
        ->type_name("DIR");
    app.add_flag("--json", options->json, "print the report as JSON on standard output");
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight bake scene.glb -o baked.glb --quality preview");
    return {&app, [options, &app] { return runBake(app, *options); }};
}

} // namespace halflight::cli
