// The options of `halflight bake`, and of commands that bake in parts.

#include "bake_options.h"

#include "bake_device.h"
#include "bake_export.h"
#include "console.h"
#include "emission_option.h"

#include "halflight/scene/sky_picture.h"

namespace halflight::cli {

namespace {

void addSampling(CLI::App& app, BakeSettings& bake)
{
    addChoice<MixedLightingMode>(
        app, "--mode", bake.mode,
        choicesOf({MixedLightingMode::BakedIndirect, MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive}),
        "mixed lighting mode (default shadowmask)");
    addChoice<Quality>(app, "--quality", bake.quality,
                       choicesOf({Quality::Preview, Quality::Medium, Quality::High, Quality::Ultra}),
                       "samples and lightmap size in one word (default medium)");
    addChoice<IntegratorKind>(app, "--integrator", bake.integrator,
                              {{"cache", IntegratorKind::Cache}, {"path", IntegratorKind::Path}},
                              "rays that end in a radiance cache, or whole unbiased paths: the slow reference (default "
                              "cache)");
    addInt(app, "--samples", bake.samples, 1, 1 << 20,
           "rays or paths per texel, about (default by quality); with --noise, the most");
    addPercent(app, "--noise", bake.noiseTarget, 0.1f, 100.0f,
               "noise at which a texel has enough samples, such as 2% (default: --samples on average)");
    addSeconds(app, "--time", bake.seconds, kLeastSeconds, 100.0 * 3600.0,
               "time that the bake may take, such as 30s, 5m or 1.5h: it measures, and chooses --samples");
    addInt(app, "--shadow-samples", bake.shadowSamples, 1, 1 << 16,
           "shadow rays per texel and light, for masks and baked light (default by quality)");
    addInt(app, "--bounces", bake.bounces, 0, kAllBounces, "most bounces, 0 = direct light only (default: all light)");
    addChoice<bool>(app, "--glossy-bounces", bake.glossyBounces, {{"on", true}, {"off", false}},
                    "light goes from surface to surface by glTF's BRDF, highlights included; off: as between diffuse "
                    "surfaces, a little faster (default on)");
}

void addTexels(CLI::App& app, BakeSettings& bake)
{
    addFloat(app, "--texels-per-meter", bake.texelsPerMeter, 0.001f, 10000.0f, "X",
             "lightmap density; as many pages as that takes (default: by the scene's size, and what fits one page)");
    addInt(app, "--lightmap-size", bake.lightmapSize, 64, 8192,
           "width of a page in texels; alone, the density is what fits one (default: by quality, cut to what is used)");
    addInt(app, "--padding", bake.paddingTexels, 1, 16, "empty texels between charts (default 2)");
    addChoice<UvMode>(
        app, "--uv", bake.uvMode, {{"auto", UvMode::Auto}, {"keep", UvMode::Keep}, {"unwrap", UvMode::Unwrap}},
        "the file's TEXCOORD_1: keep it where it is valid, keep it or fail, or unwrap anew (default auto)");
    addChoice<TwoSided>(app, "--two-sided", bake.twoSided,
                        {{"auto", TwoSided::Automatic}, {"on", TwoSided::On}, {"off", TwoSided::Off}},
                        "texels for each side of double-sided sheets: where both can be seen and their light differs, "
                        "of all such sheets, or of none (default auto)");
}

void addResults(CLI::App& app, BakeOptions& options)
{
    BakeSettings& bake = options.bake;
    addChoice<Denoiser>(app, "--denoise", bake.denoiser, {{"on", Denoiser::BuiltIn}, {"off", Denoiser::Off}},
                        "denoise the lightmap (default on)");
    addChoice<std::optional<bool>>(app, "--directional", bake.directional, {{"on", true}, {"off", false}},
                                   "keep the mean direction of lightmap light too, so that normal maps, gloss and "
                                   "metal respond to it (default on; at preview where a tenth is metal)");
    addChoice<MaskEncoding>(app, "--shadowmask-encoding", bake.maskEncoding,
                            {{"attenuation", MaskEncoding::Attenuation}, {"distance-field", MaskEncoding::Distance}},
                            "what shadowmask texels hold; distance fields keep hard edges crisp at half the density, "
                            "for lights with narrow penumbrae (default attenuation)");
    addChoice<int>(app, "--mask-layers", bake.mostMaskLayers, {{"auto", kMostMaskLayers}, {"1", 1}},
                   "how many lights a place may have with baked shadows of their own: four for each mask layer, in as "
                   "many layers as the lights need, up to four, or in 1, which is what a sidecar holds (default auto)");
    addChoice<bool>(app, "--subtractive-mask", bake.subtractiveMask, {{"on", true}, {"off", false}},
                    "subtractive: store the main light's own mask, so that dynamic shadows take away only light that "
                    "arrives (default on)");
    addFloat(app, "--probe-spacing", bake.probeSpacingMeters, 0.01f, 10000.0f, "METERS",
             "distance between light probes (default by the scene's size)");
    addChoice<ProbeLayout>(app, "--probe-layout", bake.probeLayout,
                           {{"refined", ProbeLayout::Refined}, {"grid", ProbeLayout::Grid}},
                           "probes where light changes and on floors, or a regular grid alone, for engines that read "
                           "nothing else (default refined)");
    addChoice<bool>(app, "--reflection-probes", bake.reflectionProbes, {{"on", true}, {"off", false}},
                    "pictures of the rooms for glossy surfaces to reflect (default on)");
    addChoice<GroupChoice>(app, "--groups", bake.groups,
                           choicesOf({GroupChoice::Authored, GroupChoice::Each, GroupChoice::Off}),
                           "light groups, whose light the file holds by itself: as the scene names them, each light "
                           "and emissive material alone, or none (default authored)");
    addVec3(app, "--sky", options.skyNits, 0.0f, 1.0e6f, "R,G,B",
            "radiance of a uniform sky in nits, instead of the scene's own")
        ->each([&options](const std::string&) { options.skyGiven = true; });
    addEmissionUnit(app, options.emissionUnit);
    app.add_option("--settings", options.settingsFile, "light and object settings by name pattern")
        ->type_name("FILE.toml");
}

} // namespace

void addLightOptions(CLI::App& app, BakeOptions& options)
{
    app.option_defaults()->group("Bake");
    addSampling(app, options.bake);
    addTexels(app, options.bake);
    addResults(app, options);
    addUint(app, "--seed", options.bake.seed, "of the random numbers (default 1)");
    addChoice<InstructionSet>(
        app, "--isa", options.bake.isa,
        choicesOf({InstructionSet::Automatic, InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512}),
        "the processor's instructions that trace rays; light differs within its noise, in other bytes (default auto: "
        "avx2 where it is there, else sse2)");
}

void addFormatOptions(CLI::App& app, BakeOptions& options)
{
    app.option_defaults()->group("Output");
    addChoice<LightmapFormat>(
        app, "--lightmap-format", options.write.lightmapFormat,
        {{"rgb9e5", LightmapFormat::Rgb9e5}, {"half", LightmapFormat::Half}, {"webp", LightmapFormat::Webp}},
        "how lightmaps are stored: RGB9E5 or half floats in KTX2, or 8 bits a channel by a curve in lossless WebP; "
        "the report has the error of each page (default rgb9e5)");
    addInt(app, "--sky-width", options.write.skyWidth, 16, kMostSkyTexels,
           "texels in a row of the sky's picture in the file, at most (default 512)");
    addExportOptions(app, options);
}

void addRunOptions(CLI::App& app, BakeOptions& options)
{
    app.option_defaults()->group("Run");
    addDeviceOptions(app, "--device", options.device);
    addInt(app, "--threads", options.bake.threads, 0, 4096, "0 = all cores; changes no byte of the result (default 0)");
}

CLI::Option* addProgress(CLI::App& app, ProgressStyle& style)
{
    return addChoice<ProgressStyle>(
        app, "--progress", style, {{"auto", ProgressStyle::Auto}, {"lines", ProgressStyle::Lines}},
        "auto: a bar on a terminal, one line a stage elsewhere; lines: 'progress: STAGE PERCENT "
        "%', ten a second at most, for programs (default auto)");
}

void addReportOptions(CLI::App& app, BakeOptions& options)
{
    app.add_option("--sidecar", options.sidecarDirectory,
                   "also write the bake as pictures and one JSON that binds them by node name, for tools that drop "
                   "extensions; lightmaps as EXR, or as --lightmap-format says")
        ->type_name("DIR");
    app.add_option("--report", options.reportFile, "write what the bake did: lights, charts, rays, seconds, warnings")
        ->type_name("FILE.json");
    app.add_option("--write-images", options.bake.imagesDirectory,
                   "write lightmaps, shadowmasks and probes as plain files too")
        ->type_name("DIR");
    app.add_flag("--json", options.json, "print the report as JSON on standard output");
    app.add_flag("-q,--quiet", options.quiet, "print errors only");
}

CLI::App& addBakeApp(CLI::App& parent, BakeOptions& options)
{
    CLI::App& app = *parent.add_subcommand("bake", "Bake lightmaps, shadowmasks and probes into a glTF file");
    app.add_option("SCENE", options.scene, "the scene, .glb or .gltf")->required()->type_name(" ");
    app.add_option("-o,--output", options.output, "the baked file to write: .glb, or .gltf with its files beside it")
        ->required()
        ->type_name("OUT.glb");
    addLightOptions(app, options);
    addRunOptions(app, options);
    app.add_option(
           "--cache", options.bake.cacheDirectory,
           "keep finished tiles in this folder: an interrupted bake goes on where it stopped, a changed scene is "
           "baked anew only where the change shows; several bakes may share it")
        ->type_name("DIR");
    app.add_option(
           "--only", options.bake.only,
           "bake these objects alone; all others keep the light of the last bake in the --cache, which must have "
           "the same layout and settings; a node without a mesh stands for the objects below it; may be given again")
        ->type_name("NAME[,NAME]")
        ->allow_extra_args(false);
    addProgress(app, options.progress);
    addFormatOptions(app, options);
    addReportOptions(app, options);
    app.footer("Example: halflight bake scene.glb -o baked.glb --quality preview");
    return app;
}

Command addBakeCommand(CLI::App& parent)
{
    auto options = std::make_shared<BakeOptions>();
    CLI::App& app = addBakeApp(parent, *options);
    return {&app, [options, &app] { return runBake(app, *options); }};
}

} // namespace halflight::cli
