// What panels and keys ask for.
#include "view/viewer.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/encoded_image.h"
#include "halflight/base/files_in_use.h"
#include "halflight/scene/gltf.h"
#include "view/state/changes.h"

#include <SDL.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace halflight::view {

/// Selects the object or light that a warning names, and looks at it.
void Viewer::showSubject(std::size_t warning)
{
    const Subject subject = subjectOf(readings_.warnings[warning], edited_.scene());
    if (subject.object >= 0) {
        state_.selectedObject = subject.object;
        frameSelection();
    } else if (subject.light >= 0) {
        state_.selectedLight = subject.light;
        const Light& light = edited_.scene().lights[std::size_t(subject.light)];
        if (light.type == LightType::Directional) return; // it is nowhere
        Bounds around;
        constexpr float kMeters = 1.0f; // of the light's surroundings
        around.extend(light.position() - kMeters);
        around.extend(light.position() + kMeters);
        state_.navigator.frame(around, aspect());
    }
}

void Viewer::frameSelection()
{
    state_.navigator.frame(edited_.boundsOf(state_.selectedObject), aspect());
}

std::string Viewer::currentCommand() const
{
    if (readings_.bakeStatus.hasResult)
        return commandLine(state_, {bake_.file(), ""}, size_, edited_.scene(), shown_.baked().scene);
    return commandLine(state_, {files_.file().string(), options_.settingsFile.string()}, size_, edited_.scene(),
                       edited_.atLoad());
}

/// For people, after a mention of the command line.
std::string Viewer::leftOutOfCommand() const
{
    if (bake_.runs()) return "; the command line has no light of the bake that runs";
    if (bake_.hasUnsaved()) return "; its command line needs the saved bake (Ctrl-S)";
    const bool changed = !readings_.bakeStatus.hasResult || readings_.bakeStatus.outOfDate;
    const Scene& before = readings_.bakeStatus.hasResult ? shown_.baked().scene : edited_.atLoad();
    const std::string leftOut = leftOutOfCommandLine(state_, edited_.scene(), changed ? before : edited_.scene());
    return leftOut.empty() ? "" : "; the command line cannot say " + leftOut;
}

Status Viewer::expose()
{
    if (size_.x < 1) return {};
    RenderSettings settings = settingsOfFrame(state_, edited_.bounds(), size_);
    settings.size = smallPicture(vec2(size_));
    settings.supersampling = 1;
    settings.view = DebugView::Lit;
    const Result<RenderedFrame> frame = renderer().render(state_.navigator.camera(), settings);
    if (!frame) return frame.error();
    state_.exposureEv = automaticExposure(frame->radiance);
    return {};
}

Status Viewer::takeScreenshot()
{
    const RenderSettings settings = settingsOfFrame(state_, edited_.bounds(), size_);
    const Result<RenderedFrame> frame = renderer().render(state_.navigator.camera(), settings);
    if (!frame) return frame.error();
    std::filesystem::path file;
    do {
        file = options_.screenshots / fmt::format("screenshot_{:03}.png", ++screenshots_);
    } while (std::filesystem::exists(file));
    const ImageRgba8 picture = showsLight(settings.view)
                                   ? displayedPicture(frame->radiance, state_.exposureEv, state_.toneMapping)
                                   : plainPicture(frame->radiance);
    if (Status status = writePng(file, picture); !status) {
        notices_.tell(status.error().text());
        return {};
    }
    notices_.say(fmt::format("{}: {}", file.string(), currentCommand()));
    notices_.note("saved " + file.string() + leftOutOfCommand());
    return {};
}

void Viewer::writeSettings()
{
    readings_.bakeStatus.outcome = edited_.writeSettings(options_.settingsFile, files_.file());
    notices_.tell(readings_.bakeStatus.outcome);
}

Status Viewer::answerRequests()
{
    const Requests requests = std::exchange(state_.requests, {});
    if (requests.warning && *requests.warning < readings_.warnings.size()) showSubject(*requests.warning);
    if (requests.camera) lookThrough(edited_.scene().cameras[std::size_t(*requests.camera)]);
    if (requests.frameSelection) frameSelection();
    if (requests.reload && (!shown_.any() || mayDropBake("F5"))) files_.open(renderer(), files_.file(), true);
    if (requests.toggleFullScreen) desktop_.toggleFullScreen();
    if (requests.copyCommand) {
        SDL_SetClipboardText(currentCommand().c_str());
        notices_.note("copied the command line" + leftOutOfCommand());
    }
    if (requests.bake && shown_.isUploading())
        state_.requests.bake = true; // of what is shown then
    else if (requests.bake && !bake_.runs())
        bake_.start(std::make_unique<BakeSession>(edited_.scene(), state_.bake, embreeIntegrators()));
    if (requests.cancelBake) bake_.cancel();
    if (requests.save && readings_.bakeStatus.hasResult) {
        FilesInUse read;
        addReadFiles(read, files_.file(), options_.settingsFile);
        addExternalFiles(read, externalFiles(edited_.atLoad()));
        bake_.save(std::move(read));
    }
    if (requests.writeSettings) writeSettings();
    if (requests.expose && size_.x < 1)
        state_.requests.expose = true; // after the first frame
    else if (requests.expose)
        if (Status status = expose(); !status) return status;
    if (requests.screenshot && shown_.isCoarse())
        state_.requests.screenshot = true; // of all texels
    else if (requests.screenshot)
        if (Status status = takeScreenshot(); !status) return status;
    if (requests.quit) state_.requests.quit = true;
    return {};
}

} // namespace halflight::view
