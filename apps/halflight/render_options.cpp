#include "render_options.h"

#include "emission_option.h"
#include "exposure_option.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace halflight::cli {

namespace {

// "1280x720".
bool parseSize(const std::string& text, ivec2& size)
{
    if (text.find_first_not_of("0123456789x") != std::string::npos) return false; // sscanf() takes spaces and signs
    int end = 0;
    return std::sscanf(text.c_str(), "%5dx%5d%n", &size.x, &size.y, &end) == 2 && std::size_t(end) == text.size() &&
           size.x >= 16 && size.x <= 8192 && size.y >= 16 && size.y <= 8192;
}

// "0.1,0.3,0.6".
bool parseSplits(const std::string& text, std::vector<float>& splits)
{
    splits.clear();
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        double split = 0.0;
        const double before = splits.empty() ? 0.0 : double(splits.back());
        if (!parseNumber(text.substr(begin, end - begin), split) || !(split > before && split < 1.0)) return false;
        splits.push_back(float(split));
        begin = end + 1;
    }
    return splits.size() <= 3;
}

void addPictureOptions(CLI::App& app, RenderOptions& options, const std::string& samples)
{
    app.option_defaults()->group("Picture");
    Choices<std::optional<RunMode>> modes = {{"auto", std::nullopt}};
    for (const RunMode mode : {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask,
                               RunMode::DistanceShadowmask, RunMode::Subtractive})
        modes.emplace_back(nameOf(mode), mode);
    addChoice<std::optional<RunMode>>(app, "--mode", options.mode, modes,
                                      "lighting mode (default auto: as baked; realtime when not baked)");
    addChoice<DebugView>(app, "--view", options.render.view,
                         choicesOf({DebugView::Lit, DebugView::Shadowmask, DebugView::Lightmap, DebugView::Probes,
                                    DebugView::Cascades, DebugView::Fade, DebugView::Overlap, DebugView::Texels}),
                         "the picture, or what is behind it (default lit)");
    addChoice<RenderPath>(app, "--path", options.render.path, choicesOf({RenderPath::Forward, RenderPath::Deferred}),
                          "light surfaces as they are drawn, or from a G-buffer (default forward)");
    addChoice<bool>(app, "--proxy-volumes", options.render.proxyVolumes, {{"on", true}, {"off", false}},
                    "large objects are lit by the probes around each point; off: by one sample each (default on)");
    addChoice<bool>(app, "--directional", options.render.directionalLightmaps, {{"on", true}, {"off", false}},
                    "use the lightmap's directions where the bake has them (default on)");
    addChoice<bool>(app, "--reflection-probes", options.render.reflectionProbes, {{"on", true}, {"off", false}},
                    "glossy surfaces reflect the bake's pictures of the rooms, in files that have some (default on)");
    addChoice<bool>(app, "--specular", options.render.specular, {{"on", true}, {"off", false}},
                    "off: surfaces in view are diffuse, to judge a bake alone (default on)");
    addLights(app, options.lights,
              "change a light since its bake: intensity, color, direction, position, range, strength, inner-cone, "
              "outer-cone (degrees), depth-bias, slope-bias, normal-bias; may be repeated");
    addGroups(app, options.groups,
              "weight of one of the bake's light groups, one number or three for red, green and blue (default: as the "
              "file has it); may be repeated");
    addSky(app, options.groups);
    const auto checkSize = [](std::string& text) {
        ivec2 ignored;
        if (parseSize(text, ignored)) return std::string();
        return fmt::format("must be WIDTHxHEIGHT with both from 16 to 8192, not '{}'", text);
    };
    app.add_option_function<std::string>(
           "--size", [&options](const std::string& text) { parseSize(text, options.render.size); },
           "width and height in pixels (default 1280x720)")
        ->check(CLI::Validator(checkSize, std::string()))
        ->type_name("WxH");
    const auto checkSamples = [](std::string& text) {
        return text == "1" || text == "4" || text == "9" || text == "16"
                   ? std::string()
                   : fmt::format("must be 1, 4, 9 or 16, not '{}'", text);
    };
    app.add_option("--samples", options.samples,
                   "samples of a pixel, each lit, on a regular grid: antialiasing (default " + samples + ")")
        ->check(CLI::Validator(checkSamples, std::string()))
        ->type_name("1|4|9|16");
    addExposure(
        app, options.exposureEv, options.exposureGiven,
        "EV: radiance is multiplied by 2^-EV; auto puts the picture's log average at middle grey, up to 2 stops "
        "darker where over 2 % would be burnt, and prints the EV (default auto; .png only)");
    addChoice<ToneMapping>(app, "--tone-mapping", options.toneMapping,
                           choicesOf({ToneMapping::Neutral, ToneMapping::Aces, ToneMapping::Agx, ToneMapping::None}),
                           "how what is brighter than white is shown: Khronos PBR Neutral; ACES or AgX, as engines and "
                           "Blender have them; none: cut off (default neutral; .png only)")
        ->each([&options](const std::string&) { options.toneMappingGiven = true; });
}

void addCameraOptions(CLI::App& app, RenderOptions& options)
{
    app.option_defaults()->group("Camera (default: the file's first, else a view of the whole scene)");
    CLI::Option* name = app.add_option("--camera", options.camera.name, "one of the file's cameras")->type_name("NAME");
    CLI::Option* eye = addPosition(app, "--eye", options.eye, "camera position");
    CLI::Option* target = addPosition(app, "--target", options.camera.target, "what it looks at");
    eye->needs(target)->excludes(name)->each([&options](const std::string&) { options.eyeGiven = true; });
    target->needs(eye);
    addFloat(app, "--fov", options.fovDegrees, 1.0f, 170.0f, "DEGREES", "vertical field of view");
}

void addShadowOptions(CLI::App& app, RenderOptions& options)
{
    ShadowSettings& shadows = options.render.shadows;
    app.option_defaults()->group("Realtime shadows");
    addFloat(app, "--shadow-distance", shadows.distanceMeters, 0.01f, 100000.0f, "METERS",
             "no realtime shadow from here on (default: beyond all that is in view, at most 2000)")
        ->each([&options](const std::string&) { options.shadowDistanceGiven = true; });
    addFloat(app, "--shadow-fade-range", shadows.fadeRangeMeters, 0.01f, 100000.0f, "METERS",
             "they fade over this range before it (default 1)");
    addInt(app, "--cascades", options.cascades, 1, 4, "cascades of directional lights (default 4, or by the splits)");
    const auto checkSplits = [](std::string& text) {
        std::vector<float> splits;
        if (parseSplits(text, splits)) return std::string();
        return fmt::format("must be one to three ascending numbers above 0 and below 1, not '{}'", text);
    };
    app.add_option_function<std::string>(
           "--cascade-splits",
           [&options](const std::string& text) {
               parseSplits(text, options.cascadeSplits);
               std::copy(options.cascadeSplits.begin(), options.cascadeSplits.end(),
                         options.render.shadows.cascadeSplits.begin());
           },
           "where cascades end, as shares of the shadow distance, one fewer than there are cascades (default: by the "
           "logarithm of the distance for the most part)")
        ->check(CLI::Validator(checkSplits, std::string()))
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
        ->type_name("A,B,C");
    addChoice<ShadowFilter>(app, "--shadow-filter", shadows.filter,
                            choicesOf({ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft}),
                            "edge of a shadow (default pcf)");
    addChoice<bool>(app, "--penumbrae", shadows.penumbrae, {{"on", true}, {"off", false}},
                    "realtime shadows are as soft as the light's size makes them; off: as the filter is (default on)");
    addFloat(app, "--shadow-depth-bias", shadows.depthBias, 0.0f, 100.0f, "TEXELS",
             "receivers move towards the light by this (default 0.1)");
    addFloat(app, "--shadow-slope-bias", shadows.slopeBias, 0.0f, 100.0f, "X", "slope-scaled depth bias (default 1.5)");
    addVec3(app, "--shadow-color", options.shadowColor, 0.0f, 1.0e9f, "R,G,B",
            "lower limit of subtractive shadows in lux, instead of the file's")
        ->each([&options](const std::string&) { options.render.subtractiveShadowColor = vec3(0.0f); });
    addFloat(app, "--shadow-normal-bias", shadows.normalBiasTexels, 0.0f, 8.0f, "TEXELS",
             "receivers move along their normal by this (default 0.5)");
}

/// `forFiles`: of which files, after a comma.
void addRunOptions(CLI::App& app, RenderOptions& options, const std::string& forFiles)
{
    app.option_defaults()->group("Run");
    app.add_option("--settings", options.settingsFile, "light and object settings by name pattern" + forFiles)
        ->type_name("FILE.toml");
    addEmissionUnit(app, options.emissionUnit);
    addChoice<bool>(app, "--device", options.device.preferCpu, {{"auto", false}, {"cpu", true}},
                    "Vulkan device: the best one, or the CPU driver (default auto)");
    app.add_flag("--validation", options.device.validation,
                 "turn the Vulkan validation layer on and fail when it complains");
}

} // namespace

void applyRenderOptions(RenderOptions& options)
{
    if (options.eyeGiven) options.camera.eye = options.eye;
    if (!options.cascadeSplits.empty()) options.cascades = int(options.cascadeSplits.size()) + 1;
    if (options.cascades > 0) options.render.shadows.cascades = options.cascades;
    if (options.render.subtractiveShadowColor) options.render.subtractiveShadowColor = options.shadowColor;
    options.camera.verticalFovRadians = glm::radians(options.fovDegrees);
}

void addViewOptions(CLI::App& app, RenderOptions& options)
{
    app.add_option("FILE", options.file, "the file, .glb or .gltf")->required()->type_name(" ");
    addPictureOptions(app, options, "1");
    addCameraOptions(app, options);
    addShadowOptions(app, options);
    addRunOptions(app, options, "");
}

void addRenderOptions(CLI::App& app, RenderOptions& options)
{
    app.add_option("FILE", options.file, "the file, .glb or .gltf")->required()->type_name(" ");
    app.add_option("-o,--output", options.output, ".png: the displayed picture; .exr: linear radiance")
        ->required()
        ->type_name("IMAGE");
    addPictureOptions(app, options, "4; 1 in views");
    addCameraOptions(app, options);
    addShadowOptions(app, options);

    app.option_defaults()->group("Reference");
    CLI::Option* reference = addInt(app, "--reference", options.referenceSamples, 1, 1 << 20,
                                    "path trace with N samples per pixel instead: the truth that a bake is judged by");
    app.add_flag("--reference-diffuse", options.referenceDiffuse,
                 "surfaces behind those that the camera sees are diffuse, as in bakes without glossy bounces")
        ->needs(reference);
    addFloat(app, "--reference-clamp", options.referenceClamp, 0.0f, 1.0e9f, "NITS",
             "limit of what one path brings by way of two or more surfaces: less noise, too dark (default 0: none)")
        ->needs(reference);
    addInt(app, "--bounces", options.bounces, 0, kAllBounces,
           "at most so many bounces in the reference (default: all light)")
        ->needs(reference);
    addUint(app, "--seed", options.seed, "random numbers of the reference (default 1)")->needs(reference);
    addInt(app, "--threads", options.threads, 0, 4096, "of the reference, 0 = all cores (default 0)")->needs(reference);

    addRunOptions(app, options, ", for plain files");
    app.add_flag("--timings", options.render.timings,
                 "measure the passes on the GPU and print a table: milliseconds, draw calls, instances, triangles");
    app.add_flag("--json", options.json, "print a summary as JSON on standard output");
    app.add_flag("-q,--quiet", options.quiet, "print errors only");
    app.footer("Example: halflight render baked.glb -o picture.png --mode distance-shadowmask --shadow-distance 20");
}

} // namespace halflight::cli
