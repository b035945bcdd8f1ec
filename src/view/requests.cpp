// What panels and keys ask for, and bakes in the background.
#include "view/viewer.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/encoded_image.h"
#include "halflight/base/file.h"
#include "halflight/scene/gltf.h"

#include <SDL.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace halflight::view {

void Viewer::moveObject(std::size_t index, const mat4& place)
{
    Object& object = scene_.objects[index];
    object.worldFromObject = place;
    if (object.mesh < 0) return;
    bounds_[index] = {};
    for (const MeshPart& part : scene_.meshes[std::size_t(object.mesh)].parts)
        for (const vec3& position : part.positions) bounds_[index].extend(vec3(place * vec4(position, 1.0f)));
}

/// Lights and objects as panels and arrows have them now.
void Viewer::applyEdits()
{
    Requests& requests = state_.requests;
    if (requests.light) {
        const auto& [index, light] = *requests.light;
        scene_.lights[std::size_t(index)] = light;
        if (Status status = renderer_->setLight(index, light); !status) frameWarnings_.push_back(status.error().text());
    }
    if (requests.switches) {
        Object& object = scene_.objects[std::size_t(requests.switches->object)];
        object.castShadows = requests.switches->castShadows;
        object.receiveShadows = requests.switches->receiveShadows;
        (void)renderer_->setObjectShadows(requests.switches->object, object.castShadows, object.receiveShadows);
    }
    if (requests.move) {
        const auto& [index, place] = *requests.move;
        if (renderer_->setObjectTransform(index, place)) moveObject(std::size_t(index), place);
    }
    if (requests.light || requests.switches || requests.move) {
        state_.bakeStatus.outOfDate = true;
        referenceScene_.reset();
        lastEdit_ = Clock::now();
    }
    requests.light.reset();
    requests.switches.reset();
    requests.move.reset();
}

/// The view of a warning or of a camera.
void Viewer::showRequested(const Requests& requests)
{
    if (requests.warning && *requests.warning < state_.warnings.size()) showSubject(*requests.warning);
    if (requests.camera) {
        const Camera& camera = scene_.cameras[std::size_t(*requests.camera)];
        const Bounds bounds = scene_.bounds();
        state_.navigator = Navigator(camera, bounds.empty() ? 1.0f : 0.4f * glm::length(bounds.size()));
    }
}

/// Selects the object or light that a warning names, and looks at it.
void Viewer::showSubject(std::size_t warning)
{
    const Subject subject = subjectOf(state_.warnings[warning], scene_);
    const float aspect = float(std::max(size_.x, 1)) / float(std::max(size_.y, 1));
    if (subject.object >= 0) {
        state_.selectedObject = subject.object;
        frameSelection();
    } else if (subject.light >= 0) {
        state_.selectedLight = subject.light;
        const Light& light = scene_.lights[std::size_t(subject.light)];
        if (light.type == LightType::Directional) return; // it is nowhere
        Bounds around;
        constexpr float kMeters = 1.0f; // of the light's surroundings
        around.extend(light.position() - kMeters);
        around.extend(light.position() + kMeters);
        state_.navigator.frame(around, aspect);
    }
}

void Viewer::frameSelection()
{
    Bounds all;
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
        if (bounds_[i].empty() || (state_.selectedObject >= 0 && std::size_t(state_.selectedObject) != i)) continue;
        all.extend(bounds_[i].min);
        all.extend(bounds_[i].max);
    }
    state_.navigator.frame(all, float(std::max(size_.x, 1)) / float(std::max(size_.y, 1)));
}

std::string Viewer::currentCommand() const
{
    return commandLine(state_, file_.string(), size_, scene_.originMeters, scene_.lights, atLoad_.lights);
}

ivec2 smallPicture(vec2 size)
{
    constexpr float kSide = 256.0f;
    return glm::max(ivec2(size * (kSide / std::max(size.x, size.y))), ivec2(1));
}

Status Viewer::expose()
{
    if (size_.x < 1) return {};
    RenderSettings settings = settingsFor(size_);
    settings.size = smallPicture(vec2(size_));
    settings.supersampling = 1;
    settings.view = DebugView::Lit;
    const Result<RenderedFrame> frame = renderer_->render(state_.navigator.camera(), settings);
    if (!frame) return frame.error();
    state_.exposureEv = automaticExposure(frame->radiance);
    return {};
}

Status Viewer::takeScreenshot()
{
    const RenderSettings settings = settingsFor(size_);
    const Result<RenderedFrame> frame = renderer_->render(state_.navigator.camera(), settings);
    if (!frame) return frame.error();
    std::filesystem::path file;
    do {
        file = options_.screenshots / fmt::format("screenshot_{:03}.png", ++screenshots_);
    } while (std::filesystem::exists(file));
    ImageRgba8 picture = displayedPicture(frame->radiance, state_.exposureEv, state_.toneMapping);
    if (!showsLight(settings.view)) {
        std::transform(frame->radiance.texels().begin(), frame->radiance.texels().end(), picture.texels().begin(),
                       [](vec4 value) { return u8vec4(glm::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f); });
    }
    if (Status status = writePng(file, picture); !status) {
        tell(status.error().text());
        return {};
    }
    say(fmt::format("{}: {}", file.string(), currentCommand()));
    note("saved " + file.string());
    return {};
}

void Viewer::saveBake()
{
    WriteOptions write;
    write.irradiance = irradiance_;
    const Status written = writeBakedScene(state_.bakeOutput, *shown_, write);
    state_.bakeStatus.outcome = written ? "saved " + state_.bakeOutput : written.error().text();
    tell(state_.bakeStatus.outcome);
    std::error_code absent; // where it replaced the file that is shown, nothing is to be read again
    if (std::filesystem::equivalent(state_.bakeOutput, file_, absent))
        fileTime_ = std::filesystem::last_write_time(file_, absent);
}

void Viewer::writeSettings()
{
    const std::string text = settingsFile(scene_, atLoad_);
    const std::string name = file_.stem().string() + ".toml";
    const Status written = text.empty() ? Status() : writeFileAtomically(name, text);
    state_.bakeStatus.outcome = text.empty() ? "nothing was changed"
                                : written    ? "wrote " + name
                                             : written.error().text();
    tell(state_.bakeStatus.outcome);
}

Status Viewer::answerRequests()
{
    const Requests requests = std::exchange(state_.requests, {});
    showRequested(requests);
    if (requests.frameSelection) frameSelection();
    if (requests.reload) open(file_, true);
    if (requests.toggleFullScreen) {
        const bool full = (SDL_GetWindowFlags(desktop_.window()) & SDL_WINDOW_FULLSCREEN_DESKTOP) != 0;
        SDL_SetWindowFullscreen(desktop_.window(), full ? 0 : SDL_WINDOW_FULLSCREEN_DESKTOP);
    }
    if (requests.copyCommand) {
        SDL_SetClipboardText(currentCommand().c_str());
        note("copied the command line");
    }
    if (requests.bake && showing_)
        state_.requests.bake = true; // of what is shown then
    else if (requests.bake && !session_)
        startBake(std::make_unique<BakeSession>(scene_, state_.bake, makeEmbreeIntegrator));
    if (requests.cancelBake && session_) {
        session_->cancel();
        state_.bakeStatus.cancelled = true;
        note("the bake ends; Escape once more quits");
    }
    if (requests.save && shown_ && state_.bakeStatus.hasResult) saveBake();
    if (requests.writeSettings) writeSettings();
    if (requests.expose && size_.x < 1)
        state_.requests.expose = true; // after the first frame
    else if (requests.expose)
        if (Status status = expose(); !status) return status;
    if (requests.screenshot && texturesAreCoarse_)
        state_.requests.screenshot = true; // of all texels
    else if (requests.screenshot)
        if (Status status = takeScreenshot(); !status) return status;
    if (requests.quit) state_.requests.quit = true;
    return {};
}

void Viewer::startBake(std::unique_ptr<BakeSession> session)
{
    session_ = std::move(session);
    beforeBake_ = shown_;
    modeBefore_ = state_.settings.mode;
    state_.bakeStatus = {};
    state_.bakeStatus.running = true;
    bakeWarnings_.clear();
}

void Viewer::lightIsShown(const char* name)
{
    say(fmt::format("{} after {:.2f} s", name, session_->state().seconds));
    state_.bakeStatus.firstLight = true;
    state_.settings.mode = RunMode::BakedIndirect; // mixed lights have no mask before the end
    lastTiles_ = Clock::now();
}

/// First light, then what has changed of it.
Status Viewer::showProgress()
{
    BakeStatus& status = state_.bakeStatus;
    const char* name = "light of probes";
    std::optional<BakedScene> light = session_->takeProbeLight();
    if (std::optional<BakedScene> ofTexels = session_->takeLight()) {
        light = std::move(ofTexels);
        name = "first light";
    }
    if (light) {
        renderer_->prepareForward(true); // most bakes have a mask; earlier, it would delay the light on few cores
        showLater(std::move(*light), [this, name] {
            if (session_) lightIsShown(name);
        });
        return {};
    }
    // Uploads wait for the frames in flight, so that some tiles come at once. Where the CPU draws, pictures of new
    // tiles take an eighth of the bake's time at most.
    const std::chrono::duration<double> pause(std::max(0.3, 8.0 * details_.seconds()));
    if (!status.firstLight || Clock::now() - lastTiles_ < pause) return {};
    lastTiles_ = Clock::now();
    const std::vector<LightTile> tiles = session_->takeTiles();
    std::vector<LightmapRectangle> rectangles;
    for (const LightTile& tile : tiles) rectangles.push_back({tile.page, tile.offset, &tile.texels});
    status.tiles += tiles.size();
    return renderer_->updateLightmaps(rectangles);
}

Status Viewer::pollBake()
{
    if (!session_) return {};
    state_.bakeStatus.session = session_->state();
    session_->setView(state_.navigator.camera(), float(std::max(size_.x, 1)) / float(std::max(size_.y, 1)));
    if (showing_) return {};
    if (Status shown = showProgress(); !shown) return shown;
    if (showing_ || !state_.bakeStatus.session.finished) return {};
    const double seconds = state_.bakeStatus.session.seconds;
    Result<BakeResult> result = session_->takeResult();
    session_.reset();
    endBake(std::move(result), seconds);
    return {};
}

void Viewer::endBake(Result<BakeResult> result, double seconds)
{
    if (!result) {
        const std::string outcome = result.error().code == ErrorCode::Cancelled ? "cancelled" : result.error().text();
        BakedScene before = std::move(*beforeBake_);
        beforeBake_.reset();
        showLater(std::move(before), [this, outcome] {
            state_.settings.mode = modeBefore_;
            state_.bakeStatus = {};
            state_.bakeStatus.outcome = outcome;
            tell("bake: " + outcome);
        });
        return;
    }
    earlierLoading_ = {};
    earlierRenderer_.reset();
    earlier_ = std::exchange(beforeBake_, std::nullopt);
    bakeWarnings_ = result->report.warnings;
    irradiance_ = std::move(result->irradiance);
    // As before the bake, if that was a baked mode which the file has.
    const bool fits = modeBefore_ != RunMode::Realtime && checkRunMode(result->baked, modeBefore_);
    const RunMode mode = fits ? modeBefore_ : defaultRunMode(result->baked);
    showLater(std::move(result->baked), [this, mode, seconds] {
        state_.settings.mode = mode;
        state_.hasEarlier = true;
        state_.bakeStatus = {};
        state_.bakeStatus.hasResult = true;
        state_.bakeStatus.outcome = fmt::format("baked in {:.1f} s", seconds);
        tell(state_.bakeStatus.outcome);
    });
}

} // namespace halflight::view
