// halflight-view: the window.

#include "interrupt.h"
#include "program.h"
#include "terminal.h"
#include "view_command.h"
#include "view_texts.h"

#include "halflight/scene/gltf.h"
#include "halflight/view/view.h"

#include <cmath>
#include <cstdio>

namespace halflight::cli {

namespace {

int openWindow(const ViewCommandOptions& given)
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
    view.integrators = [choice = options.bake.device](const Scene& scene, const BakeSettings& bake) {
        return integratorsOn(choice, scene, bake);
    };
    view.bakeAtStart = options.bakeAtStart;
    view.screenshots = options.screenshots;
    view.frames = options.frames;
    view.loseDeviceAt = options.loseDeviceAt;
    view.cancel = &listenForInterrupts();
    view.commandLine = commandLine;
    view.settingsText = settingsFile;
    view.say = [](const std::string& line) {
        print("{}\n", printable(line));
        std::fflush(stdout); // others follow what the window does
    };
    const Status status = viewScene(view);
    return status ? kOk : fail(render.file, status.error());
}

} // namespace

} // namespace halflight::cli

int main(int argc, char** argv)
{
    return halflight::cli::leavingWith(halflight::cli::runProgram(argc, argv, halflight::cli::openWindow));
}
