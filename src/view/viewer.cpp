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
namespace {

/// Frames whose times are shown.
constexpr std::size_t kShownFrames = 120;

Statistics statisticsOf(const BakedScene& baked)
{
    Statistics s;
    s.objects = baked.scene.objects.size();
    for (const Object& object : baked.scene.objects)
        if (object.mesh >= 0)
            for (const MeshPart& part : baked.scene.meshes[std::size_t(object.mesh)].parts)
                s.triangles += part.indices.size() / 3;
    s.lightmapPages = baked.lightmaps.size();
    std::size_t bytes = 0;
    for (const auto& page : baked.lightmaps) bytes += page.texelCount() * sizeof(uint32_t);
    for (const auto* pages : {&baked.lightmapDirections, &baked.shadowmasks})
        for (const ImageRgba8& page : *pages) bytes += page.texelCount() * sizeof(u8vec4);
    s.lightmapMegabytes = double(bytes) / 1.0e6;
    if (!baked.lightmaps.empty()) s.pageSize = baked.lightmaps[0].size();
    s.probes = baked.probes.probes.size();
    s.reflectionProbes = baked.reflections.probes.size();
    return s;
}

std::vector<RunMode> modesOf(const BakedScene& baked)
{
    std::vector<RunMode> modes;
    for (const RunMode mode : {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask,
                               RunMode::DistanceShadowmask, RunMode::Subtractive})
        if (checkRunMode(baked, mode)) modes.push_back(mode);
    return modes;
}

/// Lights and objects without vertices and pixels: what the user's changes are compared with.
Scene outlineOf(const Scene& scene)
{
    Scene outline;
    outline.lights = scene.lights;
    outline.objects = scene.objects;
    return outline;
}

} // namespace

Viewer::Viewer(const ViewOptions& options)
    : options_(options), file_(options.file), desktop_("halflight", options.render.size)
{
    state_.settings = options.render;
    state_.settings.supersampling = std::max(options.render.supersampling, 1);
    state_.followsShadowDistance = !options.shadowDistanceGiven;
    state_.bake = options.bake;
}

Viewer::~Viewer()
{
    session_.reset();
    reference_.reset();
    earlierRenderer_.reset();
    if (renderer_) renderer_->waitIdle();
}

void Viewer::say(const std::string& line) const
{
    if (options_.say) options_.say(line);
}

Status Viewer::open(const std::filesystem::path& file, bool keepsView)
{
    Result<BakedScene> baked = options_.loader.read(file);
    if (!baked) return baked.error();
    file_ = file;
    std::error_code unknown;
    fileTime_ = std::filesystem::last_write_time(file, unknown);
    session_.reset();
    earlier_.reset();
    earlierRenderer_.reset();
    state_.hasEarlier = false;
    referenceScene_.reset();
    beforeBake_.reset();
    irradiance_.clear();
    state_.bakeStatus = {};
    bakeWarnings_.clear();
    fileWarnings_ = baked->scene.warnings;
    scene_ = baked->scene;
    bounds_ = objectBounds(scene_);
    atLoad_ = outlineOf(baked->scene);
    state_.title = file.filename().string();
    state_.bakeOutput = (file.stem().string() + "_baked.glb");
    state_.selectedLight = state_.selectedObject = -1;
    SDL_SetWindowTitle(desktop_.window(), ("halflight: " + state_.title).c_str());
    hasCamera_ = hasCamera_ && keepsView;
    const bool keepsMode = hasCamera_ && checkRunMode(*baked, state_.settings.mode);
    const RunMode mode = keepsMode ? state_.settings.mode : options_.mode.value_or(defaultRunMode(*baked));
    if (Status status = checkRunMode(*baked, mode); !status) return status;
    state_.settings.mode = mode;
    state_.otherMode = RunMode::Realtime; // what a bake is compared with
    return show(std::move(*baked));
}

Status Viewer::show(BakedScene baked)
{
    if (Status status = renderer_->load(baked); !status) return status;
    state_.modes = modesOf(baked);
    state_.statistics = statisticsOf(baked);
    const auto fits = [&](RunMode mode) {
        return std::find(state_.modes.begin(), state_.modes.end(), mode) != state_.modes.end();
    };
    if (!fits(state_.settings.mode)) state_.settings.mode = defaultRunMode(baked);
    if (!fits(state_.otherMode)) state_.otherMode = RunMode::Realtime;
    if (!hasCamera_) {
        int width = 0;
        int height = 0;
        SDL_Vulkan_GetDrawableSize(desktop_.window(), &width, &height);
        const float aspect = float(std::max(width, 1)) / float(std::max(height, 1));
        const Result<Camera> camera = options_.loader.camera(baked.scene, aspect);
        if (!camera) return camera.error();
        const Bounds bounds = baked.scene.bounds();
        const float pivot = bounds.empty() ? 1.0f : 0.4f * glm::length(bounds.size());
        state_.navigator = Navigator(*camera, pivot);
        state_.speed = bounds.empty() ? 1.0f : std::clamp(0.1f * glm::length(bounds.size()), 0.05f, 10.0f);
        hasCamera_ = true;
        if (options_.exposureEv)
            state_.exposureEv = *options_.exposureEv;
        else
            state_.requests.expose = true;
    }
    shown_ = std::move(baked);
    return {};
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
    buildPanels();
    const std::optional<Swapchain::Frame> frame = swapchain_->begin();
    if (!frame) {
        constexpr int kPauseMilliseconds = 20; // nothing is to be seen
        SDL_Delay(kPauseMilliseconds);
        return {};
    }
    size_ = frame->size;
    if (Status status = drawScene(*frame); !status) return status;
    ui_->draw(frame->commands, frame->view, frame->size, *ImGui::GetDrawData(), frame->slot);
    swapchain_->end();
    ++frames_;
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
                                                   h.queueFamily, h.queue, h.samplerAnisotropy}});
    swapchain_ = std::make_unique<Swapchain>(*device_, desktop_.window());
    ui_ = std::make_unique<UiRenderer>(*device_, swapchain_->format());
    state_.device = renderer_->deviceName() + ", " + renderer_->driver();
}

Status Viewer::recover(const Error& failure)
{
    constexpr std::chrono::seconds kSoon(10);
    const bool again = failedBefore_ && Clock::now() - lastFailure_ < kSoon;
    failedBefore_ = true;
    lastFailure_ = Clock::now();
    if (again || !shown_) return failure;
    say("the device failed, another is made: " + failure.message);
    for (const std::string& message : renderer_->validationMessages()) messages_.push_back(message);
    earlierRenderer_.reset();
    pathTraced_.reset();
    ui_.reset();
    swapchain_.reset();
    device_.reset();
    renderer_.reset();
    startDevice();
    BakedScene shown = std::move(*shown_);
    return show(std::move(shown));
}

void Viewer::watchFile()
{
    constexpr std::chrono::seconds kEvery(1);
    if (session_ || Clock::now() - lastLook_ < kEvery) return;
    lastLook_ = Clock::now();
    std::error_code absent;
    const auto time = std::filesystem::last_write_time(file_, absent);
    if (absent || time == fileTime_) return;
    fileTime_ = time;
    state_.requests.reload = true;
}

Status Viewer::turn()
{
    handleEvents();
    const Clock::time_point now = Clock::now();
    const float seconds = std::chrono::duration<float>(now - lastFrame_).count();
    lastFrame_ = now;
    std::vector<float>& times = state_.frameMilliseconds;
    times.push_back(1000.0f * seconds);
    if (times.size() > kShownFrames) times.erase(times.begin());
    fly(seconds);
    followReference();
    try {
        if (Status status = drawFrame(); !status) return status;
        if (Status status = answerRequests(); !status) return status;
        if (Status status = pollBake(); !status) return status;
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what(), ""};
    }
    watchFile();
    leaveTimeToBackground();
    return {};
}

Status Viewer::run()
{
    startDevice();
    if (Status status = open(options_.file); !status) return status;
    state_.requests.bake = options_.bakeAtStart;
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
