#include "view/viewer.h"

#include "view/panels.h"

#include <SDL.h>
#include <SDL_vulkan.h>
#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace halflight::view {
FirstFile::FirstFile(const ViewOptions& options)
{
    std::error_code unknown;
    time = std::filesystem::last_write_time(options.file, unknown);
    read = std::async(std::launch::async, [&] { return options.loader.read(options.file, ends); });
}

Viewer::Viewer(const ViewOptions& options)
    : options_(options), file_(options.file), first_(options), desktop_("halflight", options.render.size)
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
    session_.reset();
    reference_.reset();
    waitForThreads();
    earlierRenderer_.reset();
    if (renderer_) renderer_->waitIdle();
}

void Viewer::say(const std::string& line) const
{
    if (options_.say) options_.say(line);
}

double Viewer::secondsSinceStart() const
{
    return std::chrono::duration<double>(Clock::now() - start_).count();
}

void Viewer::note(const std::string& line)
{
    notice_ = line;
    noticeTime_ = Clock::now();
}

void Viewer::tell(const std::string& line)
{
    say(line);
    note(line);
}

void Viewer::collectWarnings()
{
    state_.warnings = fileWarnings_;
    for (const auto* more : {&bakeWarnings_, &frameWarnings_})
        state_.warnings.insert(state_.warnings.end(), more->begin(), more->end());
}

Status Viewer::drawFrame()
{
    swapchain_->setVsync(state_.vsync);
    buildPanels(true);
    const std::optional<Swapchain::Frame> frame = swapchain_->begin();
    if (!frame) {
        constexpr int kPauseMilliseconds = 20; // nothing is to be seen
        SDL_Delay(kPauseMilliseconds);
        return {};
    }
    size_ = frame->size;
    drewPicture_ = false;
    const Clock::time_point start = Clock::now();
    if (Status status = drawScene(*frame); !status) return status;
    ui_->draw(frame->commands, frame->view, frame->size, *ImGui::GetDrawData(), frame->slot);
    swapchain_->end();
    if (!shown_) return {};
    if (drewPicture_ && details_.wantsTime()) {
        swapchain_->waitIdle();
        details_.drew(std::chrono::duration<double>(Clock::now() - start).count());
    }
    if (frames_++ == 0) firstPictureIsShown();
    const std::vector<int>& lost = options_.loseDeviceAt;
    if (std::find(lost.begin(), lost.end(), frames_) != lost.end()) gpu::check(VK_ERROR_DEVICE_LOST, "show a frame");
    return {};
}

void Viewer::startDevice()
{
    RendererOptions options = options_.device;
    options.instanceExtensions = desktop_.vulkanExtensions();
    options.deviceExtensions.emplace_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(options);
    if (!renderer) throw gpu::Failure(renderer.error().message);
    renderer_ = std::move(*renderer);
    const VulkanHandles h = renderer_->handles();
    device_ = std::make_unique<gpu::Device>(
        gpu::DeviceOptions{.handles = gpu::Handles{h.getInstanceProcAddr, h.instance, h.physicalDevice, h.device,
                                                   h.queueFamily, h.queue, h.samplerAnisotropy, h.queueMutex}});
    swapchain_ = std::make_unique<Swapchain>(*device_, desktop_.window());
    ui_ = std::make_unique<UiRenderer>(*device_, swapchain_->format());
    state_.device = renderer_->deviceName() + ", " + renderer_->driver();
}

Status Viewer::recover(const Error& failure)
{
    constexpr int kSoon = 100; // frames: some devices need a minute for the first one
    const bool again = failedAt_ && frames_ - *failedAt_ < kSoon;
    failedAt_ = frames_;
    if (again || !shown_) return failure;
    say("the device failed, another is made: " + failure.message);
    for (const std::string& message : renderer_->validationMessages()) messages_.push_back(message);
    waitForThreads();
    const std::optional<Opening> opening = std::exchange(opening_, std::nullopt);
    std::optional<Showing> showing = std::exchange(showing_, std::nullopt);
    earlierRenderer_.reset();
    pathTraced_.reset();
    ui_.reset();
    swapchain_.reset();
    device_.reset();
    renderer_.reset();
    startDevice();
    BakedScene shown = std::move(*shown_);
    if (Status status = show(std::move(shown)); !status) return status;
    if (showing) showLater(std::move(showing->baked), std::move(showing->then));
    if (opening) open(opening->file, opening->keepsView);
    return {};
}

/// What they made is dropped.
void Viewer::waitForThreads()
{
    earlierLoading_ = {};
    uploading_ = {};
    reading_ = {};
}

void Viewer::watchFile()
{
    constexpr std::chrono::seconds kEvery(1);
    if (session_ || opening_ || Clock::now() - lastLook_ < kEvery) return;
    lastLook_ = Clock::now();
    std::error_code absent;
    const auto time = std::filesystem::last_write_time(file_, absent);
    if (absent || time == fileTime_) return;
    state_.requests.reload = true;
}

Status Viewer::turn()
{
    handleEvents();
    const Clock::time_point now = Clock::now();
    const float seconds = std::chrono::duration<float>(now - lastFrame_).count();
    lastFrame_ = now;
    addFrame(state_.frameMilliseconds, 1000.0f * seconds);
    fly(seconds);
    followReference();
    try {
        if (Status status = pollOpening(); !status) return status;
        if (Status status = pollShowing(); !status) return status;
        if (Status status = followEarlier(); !status) return status;
        if (Status status = drawFrame(); !status) return status;
        if (Status status = answerRequests(); !status) return status;
        if (Status status = pollBake(); !status) return status;
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what(), ""};
    }
    watchFile();
    waitAtRest();
    return {};
}

Status Viewer::run()
{
    startDevice();
    renderer_->prepareForward(false); // while the file is read
    open(options_.file);
    lastFrame_ = Clock::now();
    while (!state_.requests.quit && !(options_.cancel != nullptr && options_.cancel->load()) &&
           (options_.frames == 0 || frames_ < options_.frames)) {
        Status status = turn();
        if (!status && status.error().code == ErrorCode::DeviceFailed) {
            status = recover(status.error());
            if (!status) writeSettings(); // what the user changed is not lost
        }
        if (!status) return status;
    }
    renderer_->waitIdle();
    const std::vector<std::string> last = renderer_->validationMessages();
    messages_.insert(messages_.end(), last.begin(), last.end());
    for (const std::string& message : messages_) say(message);
    if (!messages_.empty())
        return Error{ErrorCode::DeviceFailed,
                     fmt::format("the Vulkan validation layer had {} complaints", messages_.size()), ""};
    say(fmt::format("{} frames", frames_));
    return {};
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
