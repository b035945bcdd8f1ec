#include "view/viewer.h"

#include "view/panels/panels.h"

#include <SDL.h>
#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <new>
#include <utility>

namespace halflight::view {

Viewer::Viewer(const ViewOptions& options)
    : options_(options), notices_(options.say), first_(options), desktop_("halflight", options.render.size),
      picture_(state_, notices_), files_(options, first_, desktop_), shown_(state_, first_.ends), comparison_(state_),
      bake_(state_, shown_, comparison_, notices_)
{
    state_.settings = options.render;
    state_.settings.supersampling = std::max(options.render.supersampling, 1);
    state_.followsShadowDistance = !options.shadowDistanceGiven;
    state_.toneMapping = options.toneMapping;
    state_.bake = options.bake;
}

Viewer::~Viewer()
{
    first_.ends = true;
    SDL_HideWindow(desktop_.window()); // bakes and files that are being read end a moment later
}

float Viewer::aspect() const
{
    return float(std::max(size_.x, 1)) / float(std::max(size_.y, 1));
}

Status Viewer::run()
{
    startDevice();
    renderer().prepareForward(false); // while the file is read
    files_.open(renderer(), options_.file, false);
    lastFrame_ = Clock::now();
    while (!quits_ && !(options_.cancel != nullptr && options_.cancel->load()) &&
           (options_.frames == 0 || frames_ < options_.frames)) {
        Status status = turn();
        if (!status && status.error().code == ErrorCode::DeviceFailed) {
            status = recover(status.error());
            if (!status) writeSettings(); // what the user changed is not lost
        }
        if (!status) return status;
    }
    renderer().waitIdle();
    const std::vector<std::string> last = renderer().validationMessages();
    messages_.insert(messages_.end(), last.begin(), last.end());
    for (const std::string& message : messages_) notices_.say(message);
    if (!messages_.empty())
        return Error{ErrorCode::DeviceFailed,
                     fmt::format("the Vulkan validation layer had {} complaints", messages_.size()), ""};
    notices_.say(fmt::format("{} frames", frames_));
    return {};
}

void Viewer::startDevice()
{
    device_.emplace(desktop_, options_.device);
    window_.device = renderer().deviceName() + ", " + renderer().driver();
}

Status Viewer::recover(const Error& failure)
{
    constexpr int kSoon = 100; // frames: some devices need a minute for the first one
    const bool again = failedAt_ && frames_ - *failedAt_ < kSoon;
    failedAt_ = frames_;
    if (again || !shown_.any()) return failure;
    notices_.say("the device failed, another is made: " + failure.message);
    for (const std::string& message : renderer().validationMessages()) messages_.push_back(message);
    shown_.leaveDevice();
    files_.leaveDevice();
    comparison_.leaveDevice();
    device_.reset();
    startDevice();
    if (Status status = shown_.moveTo(renderer()); !status) return status;
    (void)edited_.repeat(shown_.time(), renderer());
    files_.moveTo(renderer());
    return {};
}

Status Viewer::turn()
{
    handleEvents();
    const Clock::time_point now = Clock::now();
    const float seconds = std::chrono::duration<float>(now - lastFrame_).count();
    lastFrame_ = now;
    addFrame(window_.frameMilliseconds, 1000.0f * seconds);
    fly(seconds);
    comparison_.followReference(edited_, size_, device_->ui);
    try {
        if (Status status = pollFile(); !status) return status;
        if (Status status = pollUpload(); !status) return status;
        if (Status status = comparison_.followEarlier(renderer(), edited_, size_); !status) return status;
        if (Status status = drawFrame(); !status) return status;
        if (Status status = answerRequests(); !status) return status;
        if (Status status = bake_.poll(renderer(), aspect(), picture_.seconds()); !status) return status;
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what(), ""};
    }
    if (!bake_.runs() && files_.hasChanged()) reloadChanged();
    waitAtRest();
    return {};
}

void Viewer::reloadChanged()
{
    if (!bake_.hasUnsaved()) {
        requests_.push_back(Action::Reload);
        return;
    }
    files_.wasWritten(files_.file());
    notices_.tell(files_.file().filename().string() +
                  " has changed; F5 reads it, and loses the bake that is not saved");
}

Status Viewer::pollFile()
{
    std::optional<FileLoader::Opened> opened = files_.poll(renderer());
    if (!opened) return {};
    const std::string name = opened->file.filename().string();
    const Status status = opened->content ? showFile(std::move(*opened)) : Status(opened->content.error());
    lastFrame_ = Clock::now(); // no time in which the camera flies
    if (status || !shown_.any() || status.error().code == ErrorCode::DeviceFailed) return status;
    notices_.addWarning(Notices::About::File, status.error().text());
    notices_.tell(fmt::format("{}: {}", name, status.error().text()));
    return {};
}

Status Viewer::showFile(FileLoader::Opened opened)
{
    FileLoader::Content& content = *opened.content;
    const bool isFirst = !shown_.any();
    const bool keepsView = !isFirst && opened.keepsView;
    std::vector<std::pair<int, Light>> lights;
    if (isFirst && options_.changeLights) {
        auto changed = options_.changeLights(content.baked.scene);
        if (!changed) return changed.error();
        lights = std::move(*changed);
    }
    RunMode mode = state_.settings.mode;
    if (!keepsView || !checkRunMode(content.baked, mode)) mode = options_.mode.value_or(defaultRunMode(content.baked));
    if (!checkRunMode(content.baked, mode)) mode = defaultRunMode(content.baked);
    bake_.forget();
    shown_.dropUpload();
    comparison_.forget();
    picture_.beginFile(content.pictureSeconds);
    if (content.uploaded)
        if (Status status = renderer().show(content.uploaded); !status) return status;
    const TextureDetail textures = isFirst ? TextureDetail::Coarse : TextureDetail::Full;
    shown_.take(std::move(content.baked), textures, Clock::now());
    files_.isShown(opened);
    edited_.beginFile(shown_.baked().scene);
    edited_.showGroups(shown_.baked(), shown_.time());
    notices_.setWarnings(Notices::About::File, edited_.scene().warnings);
    window_.title = opened.file.filename().string();
    state_.bakeOutput = opened.file.stem().string() + "_baked.glb";
    state_.selectedLight = state_.selectedObject = -1;
    gizmo_.release();
    std::erase_if(requests_, [](const Request& request) { // of a scene that is gone
        const auto* action = std::get_if<Action>(&request);
        return action == nullptr || *action != Action::Leave;
    });
    SDL_SetWindowTitle(desktop_.window(), ("halflight: " + window_.title).c_str());
    state_.settings.mode = mode;
    state_.otherMode = RunMode::Realtime; // what a bake is compared with
    if (!keepsView) place(content.camera, isFirst && options_.exposureEv ? options_.exposureEv : content.exposureEv);
    if (!content.session) state_.bake.mode = shown_.baked().isBaked ? shown_.baked().mode : options_.bake.mode;
    for (const auto& [light, value] : lights) edited_.change(ChangeLight{light, value}, renderer(), notices_);
    if (!lights.empty() && !options_.exposureEv) requests_.push_back(Action::Expose);
    if (content.session) bake_.start(std::move(content.session));
    if (content.light) {
        shown_.take(std::move(*content.light), textures, shown_.time());
        bake_.lightIsShown("light of probes");
    }
    return {};
}

bool Viewer::mayDropBake(const std::string& key)
{
    constexpr std::chrono::seconds kAgain(4); // as long as the note is shown
    const Clock::time_point now = Clock::now();
    if ((!bake_.runs() && !bake_.hasUnsaved()) || now - askedToDrop_ < kAgain) return true;
    askedToDrop_ = now;
    notices_.tell(fmt::format("{}; {} once more loses it",
                              bake_.runs() ? "a bake runs" : "the bake is not saved: Ctrl-S saves it", key));
    return false;
}

void Viewer::place(const Camera& camera, std::optional<float> exposureEv)
{
    lookThrough(camera);
    const Bounds bounds = edited_.scene().bounds();
    state_.speed = bounds.empty() ? 1.0f : std::clamp(0.1f * glm::length(bounds.size()), 0.05f, 10.0f);
    if (exposureEv)
        state_.exposureEv = *exposureEv;
    else
        requests_.push_back(Action::Expose);
}

void Viewer::lookThrough(const Camera& camera)
{
    const Bounds bounds = edited_.scene().bounds();
    const float intoNothing = bounds.empty() ? 1.0f : 0.4f * glm::length(bounds.size());
    const float pivot = metersAhead(edited_.scene(), camera, edited_.bounds()).value_or(intoNothing);
    state_.navigator = Navigator(camera, pivot, bounds);
}

Status Viewer::pollUpload()
{
    const Result<bool> isShown = shown_.poll(renderer());
    if (!isShown) return isShown.error();
    if (!*isShown) return {};
    bake_.uploadIsShown();
    edited_.showGroups(shown_.baked(), shown_.time());
    // What changed while it was made or uploaded.
    if (edited_.repeat(shown_.time(), renderer())) bake_.sceneChanged();
    return {};
}

Status Viewer::drawFrame()
{
    device_->swapchain.setVsync(state_.vsync);
    buildPanels(true);
    const std::optional<Swapchain::Frame> frame = device_->swapchain.begin();
    if (!frame) {
        constexpr int kPauseMilliseconds = 20; // nothing is to be seen
        SDL_Delay(kPauseMilliseconds);
        return {};
    }
    size_ = frame->size;
    const Clock::time_point start = Clock::now();
    if (shown_.any()) {
        // A bake needs the processor, and coarse textures show no more.
        const PictureDetail finest = bake_.runs() || shown_.isCoarse() ? PictureDetail::Half : PictureDetail::Full;
        const bool pauses = start - lastInput_ < kAfterInput;
        Status status = picture_.draw(*frame, *device_, edited_, comparison_, {pauses, finest});
        if (!status) return status;
    }
    device_->ui.draw(frame->commands, frame->view, frame->size, *ImGui::GetDrawData(), frame->slot);
    device_->swapchain.end();
    if (!shown_.any()) return {};
    picture_.measure(device_->swapchain, start);
    if (frames_++ == 0) firstPictureIsShown();
    const std::vector<int>& lost = options_.loseDeviceAt;
    if (std::find(lost.begin(), lost.end(), frames_) != lost.end()) gpu::check(VK_ERROR_DEVICE_LOST, "show a frame");
    return {};
}

/// What waited for it begins: all texels of textures, and the bake.
void Viewer::firstPictureIsShown()
{
    const double seconds = std::chrono::duration<double>(Clock::now() - first_.start).count();
    notices_.say(fmt::format("first picture after {:.2f} s", seconds));
    bake_.goOn();
    if (shown_.isCoarse()) shown_.showLater(renderer(), shown_.baked(), shown_.time());
}

void Viewer::buildPanels(bool isDrawn)
{
    ImGui_ImplSDL2_NewFrame();
    panelInput_.beginFrame();
    ImGui::NewFrame();
    if (shown_.any()) {
        window_.warnings = notices_.warnings();
        take(drawPanels(shown()));
        if (state_.compares) comparison_.drawLine();
        if (state_.panels && state_.selectedObject >= 0)
            drawBounds(state_.navigator.camera(), edited_.boundsOf(state_.selectedObject));
        if (const std::optional<vec3> place = selectedDynamic()) gizmo_.draw(state_.navigator.camera(), *place);
    }
    if (isDrawn) drawNotice();
    ImGui::Render();
}

/// What is being done, or was said just now, at the bottom.
void Viewer::drawNotice() const
{
    std::string text = files_.progress();
    if (text.empty() && comparison_.isMakingEarlier()) text = "preparing the light before the bake";
    if (text.empty()) text = notices_.currentNote();
    if (text.empty() && shown_.any()) text = picture_.detailText();
    if (!text.empty()) drawAtBottom(text);
}

} // namespace halflight::view

namespace halflight {

Status viewScene(const ViewOptions& options)
{
    try {
        view::Viewer viewer(options);
        return viewer.run();
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what(), ""};
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::DeviceFailed, "out of memory", ""};
    }
}

} // namespace halflight
