// halflight optimize: a smaller file for the web, the bake kept.

#include "console.h"
#include "interrupt.h"
#include "json_values.h"
#include "terminal.h"

#include "halflight/base/files_in_use.h"
#include "halflight/scene/gltf.h"
#include "halflight/scene/optimize.h"

#include <spdlog/fmt/fmt.h>

#include <memory>

namespace halflight::cli {

namespace {

struct CommandOptions {
    std::filesystem::path input;
    std::filesystem::path output;
    OptimizeOptions optimize;
    bool json = false;
};

std::string kilobytes(uint64_t bytes)
{
    return grouped((bytes + 500) / 1000) + " kB";
}

void printPart(const char* name, const OptimizeReport::Part& part)
{
    if (part.before > 0) print("{:<10} {:>10} -> {:>10}\n", name, kilobytes(part.before), kilobytes(part.after));
}

void printReport(const CommandOptions& options, const OptimizeReport& report)
{
    print("{}\n\n", options.output.string());
    printPart("geometry", report.geometry);
    printPart("textures", report.textures);
    printPart("lightmaps", report.lightmaps);
    printPart("masks", report.masks);
    printPart("probes", report.probes);
    printPart("file", report.file);
    if (report.lightmaps.before > 0) {
        print("\nlightmap error: {:.2f} % on average, {:.1f} % at most, of each texel's brightest channel\n",
              100.0 * report.lightmapError, 100.0 * report.lightmapErrorMost);
    }
}

Json jsonOf(const CommandOptions& options, const OptimizeReport& report)
{
    Json json = {{"file", options.output.string()}, {"bytes", Json::object()}};
    for (const auto& [name, part] : {std::pair("file", report.file),
                                     {"geometry", report.geometry},
                                     {"textures", report.textures},
                                     {"lightmaps", report.lightmaps},
                                     {"masks", report.masks},
                                     {"probes", report.probes}})
        json["bytes"][name] = {{"before", part.before}, {"after", part.after}};
    json["lightmapError"] = {{"mean", report.lightmapError}, {"most", report.lightmapErrorMost}};
    json["warnings"] = report.warnings;
    return json;
}

int runOptimize(const CommandOptions& options)
{
    if (lowerExtension(options.output) != ".glb") {
        return wrongUsage("optimize", fmt::format("OUT must end in .glb, not '{}'", options.output.string()));
    }
    FilesInUse files;
    std::filesystem::path culprit;
    files.reads("IN", options.input);
    files.writes("OUT", options.output);
    if (Status status = files.check(culprit); !status) return fail(culprit, status.error());
    if (Status status = checkOutput(options.output); !status) return fail(options.output, status.error());
    OptimizeOptions optimize = options.optimize;
    optimize.mayReplace = commitOutput;
    optimize.checkFiles = [&](const std::vector<std::filesystem::path>& external) {
        addExternalFiles(files, external);
        return files.check(culprit);
    };
    OptimizeReport report;
    if (optimize.geometry && !canOptimizeGeometry())
        report.warnings.emplace_back("geometry stays as it is: this build has no meshoptimizer");
    if (optimize.textureQuality > 0 && !canOptimizeTextures())
        report.warnings.emplace_back("textures and masks stay as they are: this build has no libwebp");
    if (Status status = optimizeFile(options.input, options.output, optimize, report); !status)
        return fail(culprit.empty() ? options.input : culprit, status.error());
    if (options.json) {
        printJson(jsonOf(options, report).dump(2));
    } else {
        printReport(options, report);
        for (const std::string& warning : report.warnings) warn(options.input, warning);
    }
    return kOk;
}

} // namespace

Command addOptimizeCommand(CLI::App& parent)
{
    auto options = std::make_shared<CommandOptions>();
    CLI::App& app = *parent.add_subcommand("optimize", "Make a glTF file smaller for the web and keep its bake");
    app.add_option("IN", options->input, "the file, baked or not, .glb or .gltf")->required()->type_name(" ");
    app.add_option("OUT", options->output, "the file to write, .glb")->required()->type_name(" ");
    addChoice<bool>(app, "--geometry", options->optimize.geometry, {{"meshopt", true}, {"keep", false}},
                    "quantize and compress geometry (EXT_meshopt_compression), or keep it (default meshopt)");
    addInt(app, "--texture-quality", options->optimize.textureQuality, 0, 100,
           "of lossy WebP (EXT_texture_webp); masks become lossless WebP; 0 keeps pictures as they are (default 85)");
    using Format = OptimizeOptions::LightmapFormat;
    addChoice<Format>(app, "--lightmap-format", options->optimize.lightmapFormat,
                      {{"webp", Format::Webp}, {"rgb9e5", Format::Rgb9e5}},
                      "8 bits a channel by a curve in lossless WebP, or KTX2 as the bake wrote it (default webp)");
    addInt(app, "--lightmap-bits", options->optimize.lightmapBits, 4, 9,
           "rgb9e5: of the mantissas of texels; 7 errs by 0.8 % at most, 9 keeps them as they are (default 7)");
    app.add_flag("--json", options->json, "print what it did as JSON");
    app.footer("Example: halflight optimize baked.glb small.glb");
    return {&app, [options] { return runOptimize(*options); }};
}

} // namespace halflight::cli
