// halflight view: a window onto a scene, with bakes in the background.

#include "bake_options.h"
#include "interrupt.h"
#include "render_options.h"
#include "terminal.h"

#include "halflight/scene/gltf.h"
#ifdef HALFLIGHT_VIEW
#include "halflight/view/view.h"
#endif

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

namespace halflight::cli {

namespace {

struct ViewCommandOptions {
    RenderOptions render;
    BakeOptions bake;
    bool bakeAtStart = false;
    std::filesystem::path screenshots = ".";
    int frames = 0;
    std::vector<int> loseDeviceAt;
};

#ifdef HALFLIGHT_VIEW
int runView(const ViewCommandOptions& given)
{
    ViewCommandOptions options = given;
    RenderOptions& render = options.render;
    applyRenderOptions(render);
    if (render.samples > 0) render.render.supersampling = int(std::lround(std::sqrt(double(render.samples))));
    ReadOptions read;
    read.settingsFile = render.settingsFile;
    read.emissionUnit = render.emissionUnit;

    ViewOptions view;
    view.file = render.file;
    view.settingsFile = render.settingsFile;
    view.changeLights = [&](const Scene& scene) { return changedLights(scene, render.lights); };
    view.loader.read = [&](const std::filesystem::path& file, const std::atomic<bool>& cancel) {
        ReadOptions cancellable = read;
        cancellable.cancel = &cancel;
        return readBakedScene(file, cancellable);
    };
    view.loader.camera = [&](const Scene& scene, float aspect, bool isFirst) {
        return chooseCamera(scene, isFirst ? render.camera : CameraChoice(), aspect);
    };
    view.device = render.device;
    view.render = render.render;
    view.mode = render.mode;
    view.exposureEv = render.exposureEv;
    view.toneMapping = render.toneMapping;
    view.shadowDistanceGiven = render.shadowDistanceGiven;
    view.bake = options.bake.bake;
    view.bakeAtStart = options.bakeAtStart;
    view.screenshots = options.screenshots;
    view.frames = options.frames;
    view.loseDeviceAt = options.loseDeviceAt;
    view.cancel = &listenForInterrupts();
    view.say = [](const std::string& line) {
        print("{}\n", printable(line));
        std::fflush(stdout); // others follow what the window does
    };
    const Status status = viewScene(view);
    return status ? kOk : fail(render.file, status.error());
}
#else
int runView(const ViewCommandOptions& options)
{
    return fail(options.render.file,
                Error{ErrorCode::Unsupported, "this build of halflight has no window: SDL2 or Dear ImGui was not found "
                                              "when it was made (libsdl2-dev, libimgui-dev); halflight render draws "
                                              "pictures without one"});
}
#endif

} // namespace

Command addViewCommand(CLI::App& parent)
{
    auto options = std::make_shared<ViewCommandOptions>();
    CLI::App& app = *parent.add_subcommand("view", "Open a window onto a baked or plain glTF file, and bake it there");
#ifndef HALFLIGHT_VIEW
    app.group(""); // not in --help
#endif
    addViewOptions(app, options->render);
    app.option_defaults()->group("Bake");
    app.add_flag("--bake", options->bakeAtStart, "bake at once, and show the light as it comes");
    addChoice<Quality>(app, "--quality", options->bake.bake.quality,
                       choicesOf({Quality::Preview, Quality::Medium, Quality::High, Quality::Ultra}),
                       "of the bake (default medium)");
    addInt(app, "--lightmap-size", options->bake.bake.lightmapSize, 64, 8192,
           "texels along a side of a lightmap page (default: by the quality)");
    app.add_option("--cache", options->bake.bake.cacheDirectory,
                   "folder of finished tiles: later bakes compute only what a change reaches")
        ->type_name("DIR");
    app.option_defaults()->group("Run");
    app.add_option("--screenshots", options->screenshots, "folder of screenshots (default: the current one)")
        ->type_name("DIR");
    addInt(app, "--frames", options->frames, 1, 1 << 30, "end after so many frames");
    app.add_option("--lose-device", options->loseDeviceAt, "for tests: fail after so many frames")
        ->delimiter(',')
        ->check(CLI::Validator(
            [](std::string& text) {
                const bool isWhole = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
                return isWhole ? std::string() : fmt::format("must be whole numbers, not '{}'", text);
            },
            std::string()))
        ->group("");
    app.footer("Example: halflight view scene.glb --bake --quality preview");
    return {&app, [options] { return runView(*options); }};
}

} // namespace halflight::cli
