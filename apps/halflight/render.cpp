// halflight render: a baked (or plain) glTF file in, a picture out.

#include "interrupt.h"
#include "json_values.h"
#include "render_options.h"
#include "terminal.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/files_in_use.h"
#include "halflight/base/parallel.h"
#include "halflight/render/compose.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

namespace halflight::cli {

namespace {

/// A picture and what there is to say about it.
struct Picture {
    ImageRgba32f radiance;
    Json summary;
    std::vector<std::string> warnings;
};

std::string_view nameOf(ReferenceSurfaces surfaces)
{
    switch (surfaces) {
    case ReferenceSurfaces::Full:
        return "full";
    case ReferenceSurfaces::DiffuseView:
        return "diffuse-view";
    case ReferenceSurfaces::DiffuseBounces:
        return "diffuse-bounces";
    case ReferenceSurfaces::Diffuse:
        return "diffuse";
    }
    return "?";
}

Status changeLights(Renderer& renderer, const std::vector<LightOverride>& changes)
{
    const auto changed = changedLights(renderer.scene(), changes);
    if (!changed) return changed.error();
    for (const auto& [index, light] : *changed)
        if (Status status = renderer.setLight(index, light); !status) return status;
    return {};
}

Status changeGroups(Renderer& renderer, const std::vector<GroupWeight>& changes)
{
    for (const GroupWeight& change : changes)
        if (Status status = renderer.setLightGroup(change.name, change.weight); !status) return status;
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
    if (light.baking.coloredMask) json["coloredMask"] = true;
    if (!row.notInFrame.empty()) json["reason"] = row.notInFrame;
    json["bakedShadow"] = {{"used", row.bakedChannel >= 0}};
    if (!row.noBakedShadow.empty()) json["bakedShadow"]["reason"] = row.noBakedShadow;
    json["realtimeShadow"] = {
        {"used", row.realtimeShadow}, {"cascades", row.cascades},           {"tiles", row.tiles},
        {"texels", row.tileTexels},   {"staticCasters", row.staticCasters}, {"dynamicCasters", row.dynamicCasters}};
    if (!row.noRealtimeShadow.empty()) json["realtimeShadow"]["reason"] = row.noRealtimeShadow;
    return json;
}

/// Side of the regular grid of samples in a pixel.
int supersamplingOf(const RenderOptions& options)
{
    if (options.samples > 0) return int(std::lround(std::sqrt(double(options.samples))));
    // A picture of 16 million pixels and four samples fills 1 GiB of radiance.
    constexpr int64_t kMostPixels = 4096 * 4096;
    const bool small = int64_t(options.render.size.x) * options.render.size.y <= kMostPixels;
    return options.render.view == DebugView::Lit && small ? 2 : 1;
}

/// Share of the picture's pixels that show surfaces beyond the shadow distance, counted in a small picture.
Result<double> shareBeyondShadows(Renderer& renderer, const Camera& camera, RenderSettings settings)
{
    constexpr int kSide = 160; // pixels: shares to a hundredth of a percent
    settings.view = DebugView::Fade;
    settings.size = glm::max(settings.size * kSide / std::max(settings.size.x, settings.size.y), ivec2(1));
    settings.supersampling = 1;
    settings.timings = false;
    settings.lightRows = false;
    const Result<RenderedFrame> frame = renderer.render(camera, settings);
    if (!frame) return frame.error();
    const std::vector<vec4>& texels = frame->radiance.texels();
    return double(std::count_if(texels.begin(), texels.end(), [](vec4 fade) { return fade.x >= 1.0f; })) /
           double(texels.size());
}

/// Where realtime shadows end, and a warning where that is within the picture. Distance shadowmask is made for it.
Status describeShadows(const RenderOptions& options, const RenderSettings& settings, float farthest, Renderer& renderer,
                       const Camera& camera, Picture& picture)
{
    const float distance = settings.shadows.distanceMeters;
    Json& shadows = picture.summary["shadows"];
    shadows = {{"distance", distance}, {"given", options.shadowDistanceGiven}, {"farthestInView", farthest}};
    if (farthest <= distance) {
        shadows["shareBeyond"] = 0.0;
        return {};
    }
    const Result<double> share = shareBeyondShadows(renderer, camera, settings);
    if (!share) return share.error();
    shadows["shareBeyond"] = *share;
    if (*share == 0.0 || settings.mode == RunMode::DistanceShadowmask || settings.view != DebugView::Lit) return {};
    picture.warnings.push_back(
        fmt::format("realtime shadows end {:.4g} m from the camera, and {:.2g} % of the picture lies beyond: "
                    "--shadow-distance {:.4g} reaches all of it",
                    distance, 100.0 * *share, std::ceil(farthest + settings.shadows.fadeRangeMeters)));
    return {};
}

Result<Picture> renderPicture(const RenderOptions& options, const BakedScene& baked, const Camera& camera)
{
    RenderSettings settings = options.render;
    settings.mode = options.mode.value_or(defaultRunMode(baked));
    settings.lightRows = options.json;
    settings.supersampling = supersamplingOf(options);
    if (Status status = checkRunMode(baked, settings.mode); !status) return status.error();
    const float farthest = farthestInView({camera, settings.size}, objectBounds(baked.scene));
    if (!options.shadowDistanceGiven) settings.shadows = shadowsReaching(farthest, settings.shadows);

    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(options.device);
    if (!renderer) return renderer.error();
    if (Status status = (*renderer)->load(baked); !status) return status.error();
    if (Status status = changeGroups(**renderer, options.groups); !status) return status.error();
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
    picture.summary["samples"] = settings.supersampling * settings.supersampling;
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
    if (Status status = describeShadows(options, settings, farthest, **renderer, camera, picture); !status)
        return status.error();
    return picture;
}

Result<Picture> tracePicture(const RenderOptions& options, const Scene& scene, const Camera& camera)
{
    const ThreadLimit limit(options.threads);
    ProgressDisplay display(options.quiet ? ProgressStyle::Quiet : ProgressStyle::Auto);
    ReferenceSettings settings;
    settings.samplesPerPixel = options.referenceSamples;
    settings.bounces = options.bounces;
    settings.seed = options.seed;
    settings.clampNits = options.referenceClamp;
    settings.surfaces = referenceSurfaces(options.render.specular, !options.referenceDiffuse);
    Result<ImageRgb32f> traced = renderReference(scene, camera, options.render.size, settings, display.progress());
    if (traced && interrupted()) return cancelledError();
    if (!traced) return traced.error();
    Picture picture;
    picture.radiance = ImageRgba32f(traced->width(), traced->height());
    std::transform(traced->texels().begin(), traced->texels().end(), picture.radiance.texels().begin(),
                   [](vec3 radiance) { return vec4(radiance, 1.0f); });
    picture.summary["device"] = "cpu";
    picture.summary["mode"] = "reference";
    picture.summary["samples"] = options.referenceSamples;
    picture.summary["bounces"] = options.bounces;
    picture.summary["surfaces"] = nameOf(settings.surfaces);
    return picture;
}

Status writePicture(const RenderOptions& options, Picture& picture)
{
    if (lowerExtension(options.output) == ".exr") {
        if (options.exposureGiven)
            picture.warnings.emplace_back("--exposure has no effect on .exr, which holds radiance");
        if (options.toneMappingGiven)
            picture.warnings.emplace_back("--tone-mapping has no effect on .exr, which holds radiance");
        return writeExr(options.output, picture.radiance);
    }
    if (!showsLight(options.render.view)) return writePng(options.output, plainPicture(picture.radiance));
    const float ev = options.exposureEv ? *options.exposureEv : automaticExposure(picture.radiance);
    picture.summary["exposure"] = ev;
    return writePng(options.output, displayedPicture(picture.radiance, ev, options.toneMapping));
}

void describeView(const RenderOptions& options, const Scene& scene, const Camera& camera, Json& summary)
{
    const dvec3 eye = scene.originMeters + dvec3(camera.worldFromCamera[3]);
    summary["size"] = {options.render.size.x, options.render.size.y};
    summary["camera"] = {{"name", camera.name},
                         {"eye", jsonArray(eye)},
                         {"target", jsonArray(eye - dvec3(camera.worldFromCamera[2]))},
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
        print("lights in view {}, with baked shadows {}, with realtime shadows {} to {:.4g} m\n",
              lights["inView"].dump(), lights["bakedShadows"].dump(), lights["realtimeShadows"].dump(),
              summary["shadows"]["distance"].get<float>());
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
         options.render.path != RenderPath::Forward || options.samples > 0 || options.shadowDistanceGiven)) {
        return "--reference N path traces with N samples; --mode, --view, --path, --light, --samples, "
               "--shadow-distance and --timings do not go with it";
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
    FilesInUse files;
    std::filesystem::path culprit;
    addReadFiles(files, options.file, options.settingsFile);
    files.writes("--output", options.output);
    if (Status status = files.check(culprit); !status) return fail(culprit, status.error());
    if (Status status = checkOutput(options.output); !status) return fail(options.output, status.error());
    applyRenderOptions(options);

    ReadOptions readOptions;
    readOptions.settingsFile = options.settingsFile;
    readOptions.emissionUnit = options.emissionUnit;
    Result<BakedScene> baked = readBakedScene(options.file, readOptions);
    if (!baked) return fail(options.file, baked.error());
    const Result<std::vector<vec3>> weights = groupWeights(*baked, options.groups);
    if (!weights) return fail(options.file, weights.error());
    if (options.referenceSamples > 0) { // it traces the members of groups, and reads no baked light
        composeMembers(baked->scene, baked->groups, *weights, baked->scene);
        baked->scene.sky = composedSky(baked->scene.sky, baked->groups, *weights);
    }
    addExternalFiles(files, externalFiles(baked->scene));
    if (Status status = files.check(culprit); !status) return fail(culprit, status.error());
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
    if (!commitOutput()) return fail(options.file, cancelledError());
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

} // namespace

Command addRenderCommand(CLI::App& parent)
{
    auto options = std::make_shared<RenderOptions>();
    CLI::App& app = *parent.add_subcommand("render", "Render a picture of a baked or plain glTF file");
    addRenderOptions(app, *options);
    return {&app, [options] { return runRender(*options); }};
}

} // namespace halflight::cli
