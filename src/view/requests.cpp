// What panels and keys ask for.
#include "view/viewer.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/files_in_use.h"
#include "halflight/scene/gltf.h"

#include <SDL.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace halflight::view {

Shown Viewer::shown() const
{
    return {state_,  edited_.scene(), shown_.report(), bake_.status(), picture_.report(), comparison_.report(),
            window_, edited_.groups()};
}

void Viewer::take(Answer answer)
{
    state_ = std::move(answer.choices);
    for (const SceneChange& made : answer.changes) change(made);
    requests_.insert(requests_.end(), answer.requests.begin(), answer.requests.end());
}

void Viewer::change(const SceneChange& change)
{
    edited_.change(change, renderer(), notices_);
    // A weight is no change of what was baked.
    if (!std::holds_alternative<ChangeGroup>(change)) bake_.sceneChanged();
}

/// Selects the object or light that a warning names, and looks at it.
Status Viewer::answer(const ShowSubject& request)
{
    if (request.warning >= window_.warnings.size()) return {};
    const Subject subject = subjectOf(window_.warnings[request.warning], edited_.scene());
    if (subject.object >= 0) {
        state_.selectedObject = subject.object;
        frameSelection();
    } else if (subject.light >= 0) {
        state_.selectedLight = subject.light;
        const Light& light = edited_.scene().lights[std::size_t(subject.light)];
        if (light.type == LightType::Directional) return {}; // it is nowhere
        Bounds around;
        constexpr float kMeters = 1.0f; // of the light's surroundings
        around.extend(light.position() - kMeters);
        around.extend(light.position() + kMeters);
        state_.navigator.frame(around, aspect());
    }
    return {};
}

void Viewer::frameSelection()
{
    state_.navigator.frame(edited_.boundsOf(state_.selectedObject), aspect());
}

/// What is left out is a clause after a mention of the command line.
ViewText Viewer::currentCommand() const
{
    const BakeStatus& status = bake_.status();
    const Scene& ofResult = status.outOfDate ? shown_.baked().scene : edited_.scene();
    const Scene atLoad = edited_.atLoadWithWeights();
    ViewedPicture picture{.scene = edited_.scene(), .atLoad = status.hasResult ? ofResult : atLoad};
    for (const GroupReport& group : edited_.groups())
        if (group.weight != group.saved) picture.groups.push_back({group.name, group.weight});
    picture.file = status.hasResult ? bake_.file() : files_.file().string();
    if (!status.hasResult) picture.settingsFile = options_.settingsFile.string();
    picture.camera = state_.navigator.camera();
    picture.ahead = state_.navigator.target();
    picture.render = state_.settings;
    picture.render.size = size_;
    picture.exposureEv = state_.exposureEv;
    picture.toneMapping = state_.toneMapping;
    picture.shadowDistanceGiven = !state_.followsShadowDistance;
    ViewText command = options_.commandLine ? options_.commandLine(picture) : ViewText();
    if (!command.leftOut.empty()) command.leftOut = "; the command line cannot say " + command.leftOut;
    if (bake_.hasUnsaved()) command.leftOut = "; its command line needs the saved bake (Ctrl-S)";
    if (bake_.runs()) command.leftOut = "; the command line has no light of the bake that runs";
    return command;
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
    const ViewText command = currentCommand();
    notices_.say(fmt::format("{}: {}", file.string(), command.text));
    notices_.note("saved " + file.string() + command.leftOut);
    return {};
}

void Viewer::writeSettings()
{
    ViewText changes;
    if (options_.settingsText) changes = options_.settingsText(edited_.scene(), edited_.atLoad());
    bake_.report(edited_.writeSettings(changes, options_.settingsFile, files_.file()));
}

void Viewer::saveBake()
{
    if (!bake_.status().hasResult) return;
    FilesInUse read;
    addReadFiles(read, files_.file(), options_.settingsFile);
    addExternalFiles(read, externalFiles(edited_.atLoad()));
    bake_.save(std::move(read));
}

void Viewer::copyCommand()
{
    const ViewText command = currentCommand();
    SDL_SetClipboardText(command.text.c_str());
    notices_.note("copied the command line" + command.leftOut);
}

Status Viewer::answerRequests()
{
    for (const Request& request : std::exchange(requests_, {}))
        if (Status status = std::visit([&](const auto& asked) { return answer(asked); }, request); !status)
            return status;
    return {};
}

Status Viewer::answer(const LookThrough& request)
{
    lookThrough(edited_.scene().cameras[std::size_t(request.camera)]);
    return {};
}

Status Viewer::answer(Action action)
{
    switch (action) {
    case Action::Leave:
        if (bake_.runs() && !bake_.status().cancelled)
            bake_.cancel();
        else
            quits_ = true;
        break;
    case Action::Screenshot:
        if (!shown_.isCoarse()) return takeScreenshot();
        requests_.push_back(action); // of all texels
        break;
    case Action::Expose:
        if (size_.x > 0) return expose();
        requests_.push_back(action); // after the first frame
        break;
    case Action::FrameSelection:
        frameSelection();
        break;
    case Action::Reload:
        if (!shown_.any() || mayDropBake("F5")) files_.open(renderer(), files_.file(), true);
        break;
    case Action::CopyCommand:
        copyCommand();
        break;
    case Action::Bake:
        if (shown_.isUploading())
            requests_.push_back(action); // of what is shown then
        else if (!bake_.runs())
            bake_.start(std::make_unique<BakeSession>(*edited_.snapshot(), state_.bake, options_.integrators));
        break;
    case Action::CancelBake:
        bake_.cancel();
        break;
    case Action::Save:
        saveBake();
        break;
    case Action::WriteSettings:
        writeSettings();
        break;
    case Action::ToggleFullScreen:
        desktop_.toggleFullScreen();
        break;
    }
    return {};
}

} // namespace halflight::view
