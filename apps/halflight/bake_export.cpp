#include "bake_export.h"

#include "console.h"
#include "exposure_option.h"
#include "interrupt.h"
#include "terminal.h"

#include "halflight/bake_cpu/surface_pictures.h"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>

namespace halflight::cli {

namespace {

constexpr int kLargestPage = 4096; // that a scale chosen here makes
constexpr std::size_t kNamesInWarning = 4;

// Textures show only on pictures finer than the lightmap.
int chooseScale(const BakeOptions& options, const Scene& scene, int pageSize)
{
    if (options.exportScale > 0) return options.exportScale;
    const bool textured = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
        return bool(m.baseColorTexture) || bool(m.emissiveTexture);
    });
    int scale = 1;
    while (textured && scale < 4 && 2 * scale * pageSize <= kLargestPage) scale *= 2;
    return scale;
}

} // namespace

void addExportOptions(CLI::App& app, BakeOptions& options)
{
    addChoiceByIndex(
        app, "--export", {"unlit", "emissive"},
        [&options](std::size_t i) { options.exportStyle = i == 0 ? ExportStyle::Unlit : ExportStyle::Emissive; },
        "write core glTF for viewers that read no lightmap instead of a baked file: light times albedo as the base "
        "colour of unlit materials, or as emission of black ones; every light is baked into it");
    addExposure(
        app, options.exposureEv, options.exposureGiven,
        "of --export; EV: radiance is multiplied by 2^-EV; auto lets one texel in twenty be brighter than white "
        "and prints the EV (default auto)");
    addChoice<int>(
        app, "--export-scale", options.exportScale, {{"auto", 0}, {"1", 1}, {"2", 2}, {"4", 4}},
        "of --export: texels of its pictures per lightmap texel, along each side (default auto: up to 4 where "
        "surfaces are textured, for pages of 4096 at most)");
}

std::string exportContradiction(const CLI::App& app, const BakeOptions& options)
{
    if (!options.exportStyle) {
        for (const char* name : {"--exposure", "--export-scale"}) {
            if (app.count(name) > 0) return fmt::format("{} is of --export unlit|emissive, which is not given", name);
        }
        return {};
    }
    if (lowerExtension(options.output) != ".glb")
        return fmt::format("--export writes a .glb, so --output must end in it, not '{}'", options.output.string());
    if (app.count("--mode") > 0)
        return "--export bakes all light into its pictures, so --mode has nothing to choose: leave one of them out";
    if (app.count("--sidecar") > 0)
        return "--sidecar binds its pictures to a baked file, which --export does not write: leave one of them out";
    for (const char* name :
         {"--lightmap-format", "--shadowmask-encoding", "--mask-layers", "--subtractive-mask", "--directional"}) {
        if (app.count(name) > 0)
            return fmt::format(
                "--export writes neither lightmaps nor masks, so {} has no effect: leave one of them out", name);
    }
    return {};
}

void prepareExport(BakeSettings& settings, Scene& scene)
{
    settings.mode = MixedLightingMode::BakedIndirect; // no light is left that is mixed
    settings.reflectionProbes = false;                // core glTF has none
    settings.directional = false;
    for (Light& light : scene.lights) light.mode = LightMode::Baked;
}

Status writeExport(const BakeOptions& options, BakeResult& result, const Progress& progress, ExportSummary& summary)
{
    summary.style = *options.exportStyle;
    summary.scale = chooseScale(options, result.baked.scene, result.report.pageSize);
    summary.pageSize = summary.scale * result.report.pageSize;
    const auto pictures = surfacePictures(result.baked.scene, result.irradiance, summary.scale, progress);
    if (!pictures) return pictures.error();
    summary.automatic = !options.exposureEv;
    summary.exposureEv = options.exposureEv ? *options.exposureEv : surfaceExposure(*pictures);
    if (summary.style == ExportStyle::Emissive) summary.strength = surfaceStrength(*pictures, summary.exposureEv);
    const DisplayedSurfaces displayed = displayedSurfaces(*pictures, summary.exposureEv, summary.strength);
    summary.clipped = displayed.clipped;
    ExportOptions write;
    write.style = summary.style;
    write.strength = summary.strength;
    write.exposureEv = summary.exposureEv;
    write.mayReplace = commitOutput;
    return halflight::writeExport(options.output, std::move(result.baked), displayed.pages, write, summary.written);
}

std::vector<std::string> exportWarnings(const ExportSummary& summary)
{
    std::vector<std::string> warnings = summary.written.warnings;
    const std::vector<std::string>& others = summary.written.others;
    if (others.empty()) return warnings;
    std::string names;
    for (std::size_t i = 0; i < std::min(others.size(), kNamesInWarning); ++i)
        names += fmt::format("{}'{}'", i > 0 ? ", " : "", others[i]);
    if (others.size() > kNamesInWarning) names += fmt::format(" and {} more", others.size() - kNamesInWarning);
    const bool one = others.size() == 1;
    warnings.push_back(
        fmt::format("{} without lightmap texels (dynamic, or lightmap scale 0) {} of the source and {} the "
                    "file's lights, without bounced light and sky: {}",
                    one ? "an object" : "objects", one ? "keeps the materials" : "keep the materials",
                    one ? "takes" : "take", names));
    return warnings;
}

void printExport(const ExportSummary& summary)
{
    const auto mb = [](uint64_t bytes) { return fmt::format("{:.2f} MB", double(bytes) * 1e-6); };
    print("export     {}, {} objects, pictures of {} x {} ({} per lightmap texel)\n", nameOf(summary.style),
          summary.written.surfaces, summary.pageSize, summary.pageSize, summary.scale);
    print("           --exposure {:.3f}{}, {:.2f} % of the texels clipped", summary.exposureEv,
          summary.automatic ? " (automatic)" : "", 100.0 * summary.clipped);
    if (summary.style == ExportStyle::Emissive) print(", strength {:.3g}", summary.strength);
    print("\nfile       {}, {} of it pictures\n", mb(summary.written.bytes), mb(summary.written.pictures));
}

std::string withExport(const std::string& report, const ExportSummary& summary)
{
    nlohmann::json json = nlohmann::json::parse(report);
    json["export"] = {{"style", nameOf(summary.style)},
                      {"exposure", summary.exposureEv},
                      {"strength", summary.strength},
                      {"clipped", summary.clipped},
                      {"scale", summary.scale},
                      {"surfaces", summary.written.surfaces},
                      {"keptObjects", summary.written.others},
                      {"bytes", summary.written.bytes},
                      {"pictureBytes", summary.written.pictures}};
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace halflight::cli
