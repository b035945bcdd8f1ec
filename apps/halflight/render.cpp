// halflight render: a baked (or plain) glTF file in, a picture out.

#include "camera.h"
#include "console.h"
#include "interrupt.h"
#include "light_override.h"
#include "terminal.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/parallel.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

namespace halflight::cli {

namespace {

using Json = nlohmann::ordered_json;

struct RenderOptions {
    std::filesystem::path file;
    std::filesystem::path output;
    std::filesystem::path settingsFile;
    std::optional<RunMode> mode; ///< empty = auto
    RenderSettings render;
    RendererOptions device;
    std::vector<LightOverride> lights;
    int cascades = 0;                 ///< 0 = not given
    std::vector<float> cascadeSplits; ///< empty = not given
    CameraChoice camera;
    dvec3 eye{0.0};
    bool eyeGiven = false;
    vec3 shadowColor{0.0f}; ///< counts when settings have one
    float fovDegrees = 0.0f;
    std::optional<float> exposureEv; ///< empty = auto
    bool exposureGiven = false;
    int referenceSamples = 0;
    int bounces = 8;
    uint32_t seed = 1;
    int threads = 0;
    bool quiet = false;
    bool json = false;
};

/// A picture and what there is to say about it.
struct Picture {
    ImageRgba32f radiance;
    Json summary;
    std::vector<std::string> warnings;
};

std::string_view nameOf(RunMode mode)
{
    switch (mode) {
    case RunMode::Realtime:
        return "realtime";
    case RunMode::BakedIndirect:
        return "baked-indirect";
    case RunMode::Shadowmask:
        return "shadowmask";
    case RunMode::DistanceShadowmask:
        return "distance-shadowmask";
    case RunMode::Subtractive:
        return "subtractive";
    }
    return "?";
}

// Every light of that name.
Status changeLights(Renderer& renderer, const std::vector<LightOverride>& changes)
{
    for (const LightOverride& change : changes) {
        bool found = false;
        for (int i = 0; i < int(renderer.scene().lights.size()); ++i) {
            const Light& light = renderer.scene().lights[std::size_t(i)];
            if (light.name != change.name) continue;
            found = true;
            if (Status status = renderer.setLight(i, overridden(light, change, renderer.scene().originMeters)); !status)
                return status;
        }
        if (found) continue;
        std::string names;
        for (const Light& light : renderer.scene().lights) names += (names.empty() ? "" : ", ") + light.name;
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("no light is named '{}'; there are: {}", change.name, names.empty() ? "none" : names),
                     ""};
    }
    return {};
}

/// What the frame did with a light; empty reasons are left out.
Json jsonOf(const LightRow& row, const Light& light)
{
    Json json = {{"name", light.name},
                 {"type", nameOf(light.type)},
                 {"mode", nameOf(light.mode)},
                 {"bakedAs", nameOf(light.baking.bakeType)},
                 {"channel", light.baking.occlusionMaskChannel},
                 {"inFrame", row.frameLight >= 0}};
    if (!row.notInFrame.empty()) json["reason"] = row.notInFrame;
    json["bakedShadow"] = {{"used", row.bakedChannel >= 0}};
    if (!row.noBakedShadow.empty()) json["bakedShadow"]["reason"] = row.noBakedShadow;
    json["realtimeShadow"] = {
        {"used", row.realtimeShadow}, {"cascades", row.cascades},           {"tiles", row.tiles},
        {"texels", row.tileTexels},   {"staticCasters", row.staticCasters}, {"dynamicCasters", row.dynamicCasters}};
    if (!row.noRealtimeShadow.empty()) json["realtimeShadow"]["reason"] = row.noRealtimeShadow;
    return json;
}

Result<Picture> renderPicture(const RenderOptions& options, const BakedScene& baked, const Camera& camera)
{
    RenderSettings settings = options.render;
    settings.mode = options.mode.value_or(defaultRunMode(baked));
    settings.lightRows = options.json;
    if (Status status = checkRunMode(baked, settings.mode); !status) return status.error();

    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(options.device);
    if (!renderer) return renderer.error();
    if (Status status = (*renderer)->load(baked); !status) return status.error();
    if (Status status = changeLights(**renderer, options.lights); !status) return status.error();
    Result<RenderedFrame> frame = (*renderer)->render(camera, settings);
    if (!frame) return frame.error();

    const std::vector<std::string> messages = (*renderer)->validationMessages();
    for (const std::string& message : messages) say(printable(message) + "\n");
    if (!messages.empty()) {
        return Error{ErrorCode::DeviceFailed,
                     fmt::format("the Vulkan validation layer had {} complaints", messages.size())};
    }

    Picture picture;
    const FramePlan& plan = frame->plan;
    const auto count = [&](auto member) { return std::count_if(plan.lights.begin(), plan.lights.end(), member); };
    picture.summary["device"] = (*renderer)->deviceName();
    picture.summary["driver"] = (*renderer)->driver();
    picture.summary["mode"] = nameOf(settings.mode);
    picture.summary["path"] = settings.path == RenderPath::Deferred ? "deferred" : "forward";
    picture.summary["gBufferTargets"] = frame->gBufferTargets;
    picture.summary["lights"] = {
        {"inView", count([](const FrameLight& light) { return !light.overflowed; })},
        {"bakedShadows", count([](const FrameLight& light) { return light.hasBaked; })},
        {"realtimeShadows", count([](const FrameLight& light) { return light.hasRealtimeShadow; })}};
    picture.summary["lights"]["rows"] = Json::array();
    for (const LightRow& row : frame->lights)
        picture.summary["lights"]["rows"].push_back(jsonOf(row, (*renderer)->scene().lights[std::size_t(row.light)]));
    picture.summary["passes"] = Json::array();
    for (const PassReport& pass : frame->passes) {
        Json& entry = picture.summary["passes"].emplace_back();
        entry = {
            {"name", pass.name}, {"draws", pass.draws}, {"instances", pass.instances}, {"triangles", pass.triangles}};
        if (frame->timed) entry["milliseconds"] = pass.milliseconds;
    }
    if (options.render.timings && !frame->timed) {
        picture.warnings.emplace_back("the Vulkan device has no timestamps, so passes are counted but not timed");
    }
    picture.warnings.insert(picture.warnings.end(), plan.warnings.begin(), plan.warnings.end());
    picture.radiance = std::move(frame->radiance);
    return picture;
}

Result<Picture> tracePicture(const RenderOptions& options, const Scene& scene, const Camera& camera)
{
    const ThreadLimit limit(options.threads);
    ProgressDisplay display(options.quiet);
    Result<ImageRgb32f> traced = renderReference(scene, camera, options.render.size, options.referenceSamples,
                                                 options.bounces, options.seed, display.progress());
    if (traced && interrupted()) return Error{ErrorCode::Cancelled, "interrupted"};
    if (!traced) return traced.error();
    Picture picture;
    picture.radiance = ImageRgba32f(traced->width(), traced->height());
    std::transform(traced->texels().begin(), traced->texels().end(), picture.radiance.texels().begin(),
                   [](vec3 radiance) { return vec4(radiance, 1.0f); });
    picture.summary["device"] = "cpu";
    picture.summary["mode"] = "reference";
    picture.summary["samples"] = options.referenceSamples;
    picture.summary["bounces"] = options.bounces;
    return picture;
}

// Views of values from 0 to 1 are shown as they are; those of light are exposed like the picture.
bool showsLight(DebugView view)
{
    return view == DebugView::Lit || view == DebugView::Lightmap || view == DebugView::Probes;
}

ImageRgba8 plainPicture(const ImageRgba32f& values)
{
    ImageRgba8 picture(values.width(), values.height());
    std::transform(values.texels().begin(), values.texels().end(), picture.texels().begin(),
                   [](vec4 value) { return u8vec4(glm::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f); });
    return picture;
}

Status writePicture(const RenderOptions& options, Picture& picture)
{
    if (lowerExtension(options.output) == ".exr") {
        if (options.exposureGiven)
            picture.warnings.emplace_back("--exposure has no effect on .exr, which holds radiance");
        return writeExr(options.output, picture.radiance);
    }
    if (!showsLight(options.render.view)) return writePng(options.output, plainPicture(picture.radiance));
    const float ev = options.exposureEv ? *options.exposureEv : automaticExposure(picture.radiance);
    picture.summary["exposure"] = ev;
    return writePng(options.output, displayedPicture(picture.radiance, ev));
}

Json jsonOf(const dvec3& v)
{
    return Json::array({v.x, v.y, v.z});
}

void describeView(const RenderOptions& options, const Scene& scene, const Camera& camera, Json& summary)
{
    const dvec3 eye = scene.originMeters + dvec3(camera.worldFromCamera[3]);
    summary["size"] = {options.render.size.x, options.render.size.y};
    summary["camera"] = {{"name", camera.name},
                         {"eye", jsonOf(eye)},
                         {"target", jsonOf(eye - dvec3(camera.worldFromCamera[2]))},
                         {"verticalFovDegrees", glm::degrees(camera.verticalFovRadians)}};
}

void printPasses(const Json& passes)
{
    print("{:<20} {:>10} {:>7} {:>10} {:>12}\n", "pass", "ms", "draws", "instances", "triangles");
    for (const Json& pass : passes) {
        const std::string time = pass.contains("milliseconds")
                                     ? fmt::format("{:.3f}", pass["milliseconds"].get<double>())
                                     : std::string("-");
        print("{:<20} {:>10} {:>7} {:>10} {:>12}\n", pass["name"].get<std::string>(), time, pass["draws"].get<int>(),
              pass["instances"].get<int64_t>(), pass["triangles"].get<int64_t>());
    }
}

void printSummary(const RenderOptions& options, const Json& summary)
{
    print("{}: {} x {}, {}", options.output.string(), options.render.size.x, options.render.size.y,
          summary["mode"].get<std::string>());
    if (summary.contains("exposure")) {
        print(", --exposure {:.3f}{}", summary["exposure"].get<float>(), options.exposureEv ? "" : " (automatic)");
    }
    print(", {}\n", summary["device"].get<std::string>());
    if (summary.contains("lights")) {
        const Json& lights = summary["lights"];
        print("lights in view {}, with baked shadows {}, with realtime shadows {}\n", lights["inView"].dump(),
              lights["bakedShadows"].dump(), lights["realtimeShadows"].dump());
    }
    if (options.render.timings && summary.contains("passes")) printPasses(summary["passes"]);
}

// Empty when the options go together.
std::string contradiction(const RenderOptions& options)
{
    const std::string extension = lowerExtension(options.output);
    if (extension != ".png" && extension != ".exr") {
        return fmt::format("--output must end in .png or .exr, not '{}'", options.output.string());
    }
    if (options.cascades > 0 && !options.cascadeSplits.empty() &&
        options.cascadeSplits.size() + 1 != std::size_t(options.cascades)) {
        return fmt::format("--cascades {} needs {} --cascade-splits, not {}", options.cascades, options.cascades - 1,
                           options.cascadeSplits.size());
    }
    if (options.eyeGiven && options.eye == options.camera.target) return "--eye and --target are the same point";
    if (options.referenceSamples > 0 &&
        (options.render.timings || !options.lights.empty() || options.mode || options.render.view != DebugView::Lit ||
         options.render.path != RenderPath::Forward)) {
        return "--reference is path traced and knows no --mode, --view, --path, --light or --timings";
    }
    return {};
}

/// Adds what is not said yet. The reader puts "is stale: " before what a frame says of a changed light, too.
void addNew(std::vector<std::string>& warnings, const std::vector<std::string>& more)
{
    for (const std::string& warning : more) {
        const bool said = std::any_of(warnings.begin(), warnings.end(),
                                      [&](const std::string& earlier) { return earlier.ends_with(warning); });
        if (!said) warnings.push_back(warning);
    }
}

int runRender(RenderOptions options)
{
    if (const std::string sentence = contradiction(options); !sentence.empty()) return wrongUsage("render", sentence);
    if (Status status = checkReplacesNone({"--output", options.output},
                                          {{"the scene", options.file}, {"the settings file", options.settingsFile}});
        !status) {
        return fail(options.output, status.error());
    }
    if (Status status = checkOutput(options.output); !status) return fail(options.output, status.error());
    if (options.eyeGiven) options.camera.eye = options.eye;
    if (!options.cascadeSplits.empty()) options.cascades = int(options.cascadeSplits.size()) + 1;
    if (options.cascades > 0) options.render.shadows.cascades = options.cascades;
    if (options.render.subtractiveShadowColor) options.render.subtractiveShadowColor = options.shadowColor;
    options.camera.verticalFovRadians = glm::radians(options.fovDegrees);

    ReadOptions readOptions;
    readOptions.settingsFile = options.settingsFile;
    const Result<BakedScene> baked = readBakedScene(options.file, readOptions);
    if (!baked) return fail(options.file, baked.error());
    std::vector<std::string> warnings;
    addNew(warnings, baked->scene.warnings);
    const auto sayFrom = [&](std::size_t first) {
        for (std::size_t i = first; i < warnings.size() && !options.quiet; ++i) warn(options.file, warnings[i]);
    };
    sayFrom(0);
    const float aspect = float(options.render.size.x) / float(options.render.size.y);
    const Result<Camera> camera = chooseCamera(baked->scene, options.camera, aspect);
    if (!camera) return fail(options.file, camera.error());

    Result<Picture> picture = options.referenceSamples > 0 ? tracePicture(options, baked->scene, *camera)
                                                           : renderPicture(options, *baked, *camera);
    if (!picture) return fail(options.file, picture.error());
    describeView(options, baked->scene, *camera, picture->summary);
    if (!commitOutput()) return fail(options.file, Error{ErrorCode::Cancelled, "interrupted"});
    if (Status status = writePicture(options, *picture); !status) return fail(options.output, status.error());

    const std::size_t said = warnings.size();
    addNew(warnings, picture->warnings);
    sayFrom(said);
    if (options.json) {
        Json summary = {{"file", options.file.string()}, {"output", options.output.string()}};
        summary.update(picture->summary);
        summary["warnings"] = warnings;
        printJson(summary.dump(2, ' ', false, Json::error_handler_t::replace));
    } else if (!options.quiet) {
        printSummary(options, picture->summary);
    }
    return kOk;
}

// "1280x720".
bool parseSize(const std::string& text, ivec2& size)
{
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

void addPictureOptions(CLI::App& app, RenderOptions& options)
{
    app.option_defaults()->group("Picture");
    addChoice<std::optional<RunMode>>(app, "--mode", options.mode,
                                      {{"auto", std::nullopt},
                                       {"realtime", RunMode::Realtime},
                                       {"baked-indirect", RunMode::BakedIndirect},
                                       {"shadowmask", RunMode::Shadowmask},
                                       {"distance-shadowmask", RunMode::DistanceShadowmask},
                                       {"subtractive", RunMode::Subtractive}},
                                      "lighting mode (default auto: as baked; realtime when not baked)");
    addChoice<DebugView>(app, "--view", options.render.view,
                         {{"lit", DebugView::Lit},
                          {"shadowmask", DebugView::Shadowmask},
                          {"lightmap", DebugView::Lightmap},
                          {"probes", DebugView::Probes},
                          {"cascades", DebugView::Cascades},
                          {"fade", DebugView::Fade},
                          {"overlap", DebugView::Overlap}},
                         "the picture, or what is behind it (default lit)");
    addChoice<RenderPath>(app, "--path", options.render.path,
                          {{"forward", RenderPath::Forward}, {"deferred", RenderPath::Deferred}},
                          "light surfaces as they are drawn, or from a G-buffer (default forward)");
    addChoice<bool>(app, "--proxy-volumes", options.render.proxyVolumes, {{"on", true}, {"off", false}},
                    "large objects are lit by the probes around each point; off: by one sample each (default on)");
    addChoice<bool>(app, "--directional", options.render.directionalLightmaps, {{"on", true}, {"off", false}},
                    "use the lightmap's directions where the bake has them (default on)");
    const auto checkLight = [](std::string& text) {
        const Result<LightOverride> change = parseLightOverride(text);
        return change ? std::string() : change.error().message;
    };
    app.add_option_function<std::vector<std::string>>(
           "--light",
           [&options](const std::vector<std::string>& texts) {
               for (const std::string& text : texts) options.lights.push_back(*parseLightOverride(text));
           },
           "change a light since its bake: intensity, color, direction, position, range, strength, inner-cone, "
           "outer-cone (degrees), depth-bias, slope-bias, normal-bias; may be repeated")
        ->check(CLI::Validator(checkLight, std::string()))
        ->type_size(1)
        ->allow_extra_args(false)
        ->type_name("NAME:KEY=VALUE,…");
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
    const auto checkExposure = [](std::string& text) {
        double ev = 0.0;
        if (text == "auto" || (parseNumber(text, ev) && ev >= -40.0 && ev <= 40.0)) return std::string();
        return fmt::format("must be auto or a number from -40 to 40, not '{}'", text);
    };
    app.add_option_function<std::string>(
           "--exposure",
           [&options](const std::string& text) {
               double ev = 0.0;
               options.exposureEv = parseNumber(text, ev) ? std::optional(float(ev)) : std::nullopt;
               options.exposureGiven = true;
           },
           "EV: radiance is multiplied by 2^-EV; auto puts the picture's log average at middle grey and prints the EV "
           "(default auto; .png only)")
        ->check(CLI::Validator(checkExposure, std::string()))
        ->type_name("EV|auto");
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
             "no realtime shadow from here on (default 60)");
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
    addChoice<CascadeBlend>(
        app, "--cascade-blend", shadows.cascadeBlend,
        {{"hard", CascadeBlend::Hard}, {"dithered", CascadeBlend::Dithered}, {"soft", CascadeBlend::Soft}},
        "where one cascade ends and the next begins (default soft)");
    addChoice<bool>(app, "--point-shadows", shadows.pointShadows, {{"on", true}, {"off", false}},
                    "realtime shadows of point lights; off leaves them the baked ones (default on)");
    addChoice<ShadowFilter>(app, "--shadow-filter", shadows.filter,
                            {{"hard", ShadowFilter::Hard}, {"pcf", ShadowFilter::Pcf}, {"soft", ShadowFilter::Soft}},
                            "edge of a shadow (default pcf)");
    addInt(app, "--shadow-map-size", shadows.directionalMapSize, 128, 8192, "texels of a cascade (default 2048)");
    addInt(app, "--shadow-atlas-size", shadows.atlasSize, 256, 8192,
           "texels of the atlas of spot and point lights (default 4096)");
    addFloat(app, "--shadow-depth-bias", shadows.depthBias, 0.0f, 100.0f, "TEXELS",
             "receivers move towards the light by this (default 0.1)");
    addFloat(app, "--shadow-slope-bias", shadows.slopeBias, 0.0f, 100.0f, "X", "slope-scaled depth bias (default 1.5)");
    addVec3(app, "--shadow-color", options.shadowColor, 0.0f, 1.0e9f, "R,G,B",
            "lower limit of subtractive shadows in lux, instead of the file's")
        ->each([&options](const std::string&) { options.render.subtractiveShadowColor = vec3(0.0f); });
    addFloat(app, "--shadow-normal-bias", shadows.normalBiasTexels, 0.0f, 8.0f, "TEXELS",
             "receivers move along their normal by this (default 1.2)");
}

} // namespace

Command addRenderCommand(CLI::App& parent)
{
    auto options = std::make_shared<RenderOptions>();
    CLI::App& app = *parent.add_subcommand("render", "Render a picture of a baked or plain glTF file");
    app.add_option("FILE", options->file, "the file, .glb or .gltf")->required()->type_name(" ");
    app.add_option("-o,--output", options->output, ".png: the displayed picture; .exr: linear radiance")
        ->required()
        ->type_name("IMAGE");
    addPictureOptions(app, *options);
    addCameraOptions(app, *options);
    addShadowOptions(app, *options);

    app.option_defaults()->group("Reference");
    CLI::Option* reference = addInt(app, "--reference", options->referenceSamples, 1, 1 << 20,
                                    "path trace with N samples per pixel instead, by the bake's integrator");
    addInt(app, "--bounces", options->bounces, 0, 64, "bounces of the reference (default 8)")->needs(reference);
    addUint(app, "--seed", options->seed, "random numbers of the reference (default 1)")->needs(reference);
    addInt(app, "--threads", options->threads, 0, 4096, "of the reference, 0 = all cores (default 0)")
        ->needs(reference);

    app.option_defaults()->group("Run");
    app.add_option("--settings", options->settingsFile, "light and object settings by name pattern, for plain files")
        ->type_name("FILE.toml");
    addChoice<bool>(app, "--device", options->device.preferCpu, {{"auto", false}, {"cpu", true}},
                    "Vulkan device: the best one, or the CPU driver (default auto)");
    app.add_flag("--validation", options->device.validation,
                 "turn the Vulkan validation layer on and fail when it complains");
    app.add_flag("--timings", options->render.timings,
                 "measure the passes on the GPU and print a table: milliseconds, draw calls, instances, triangles");
    app.add_flag("--json", options->json, "print a summary as JSON on standard output");
    app.add_flag("-q,--quiet", options->quiet, "print errors only");
    app.footer("Example: halflight render baked.glb -o picture.png --mode distance-shadowmask --shadow-distance 20");
    return {&app, [options] { return runRender(*options); }};
}

} // namespace halflight::cli
