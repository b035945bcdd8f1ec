// From a file to what the window shows.
#include "view/viewer.h"

#include <SDL.h>
#include <SDL_vulkan.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace halflight::view {
namespace {

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

void Viewer::open(const std::filesystem::path& file, bool keepsView)
{
    std::error_code unknown;
    const Opening opening{file, keepsView, Clock::now(), std::filesystem::last_write_time(file, unknown)};
    if (opening_) {
        openNext_ = opening;
        return;
    }
    opening_ = opening;
    reading_ = std::async(std::launch::async, [file, &read = options_.loader.read] { return read(file); });
}

Status Viewer::pollOpening()
{
    if (!opening_ || reading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    if (!std::exchange(opening_->isRead, true)) return {}; // a frame says so before the window waits for the device
    Result<BakedScene> baked = reading_.get();
    const Opening opening = *std::exchange(opening_, std::nullopt);
    if (openNext_) {
        const Opening next = *std::exchange(openNext_, std::nullopt);
        open(next.file, next.keepsView);
        return {};
    }
    if (opening.file == file_) fileTime_ = opening.fileTime; // a file that cannot be read is not tried again
    const Status status = baked ? showFile(opening, std::move(*baked)) : Status(baked.error());
    lastFrame_ = Clock::now(); // no time in which the camera flies
    if (status || !shown_ || status.error().code == ErrorCode::DeviceFailed) return status;
    fileWarnings_.push_back(status.error().text());
    tell(fmt::format("{}: {}", opening.file.filename().string(), status.error().text()));
    return {};
}

/// What a file is seen with at first.
Result<Camera> Viewer::firstCamera(const Scene& scene) const
{
    int width = 0;
    int height = 0;
    SDL_Vulkan_GetDrawableSize(desktop_.window(), &width, &height);
    return options_.loader.camera(scene, float(std::max(width, 1)) / float(std::max(height, 1)), !shown_);
}

void Viewer::place(const Camera& camera, bool exposes)
{
    const Bounds bounds = scene_.bounds();
    const float pivot = bounds.empty() ? 1.0f : 0.4f * glm::length(bounds.size());
    state_.navigator = Navigator(camera, pivot);
    state_.speed = bounds.empty() ? 1.0f : std::clamp(0.1f * glm::length(bounds.size()), 0.05f, 10.0f);
    hasCamera_ = true;
    if (exposes)
        state_.requests.expose = true;
    else
        state_.exposureEv = *options_.exposureEv;
}

Status Viewer::showFile(const Opening& opening, BakedScene baked)
{
    const bool isFirst = !shown_;
    const bool keepsView = hasCamera_ && opening.keepsView;
    RunMode mode = state_.settings.mode;
    if (!keepsView || !checkRunMode(baked, mode)) mode = options_.mode.value_or(defaultRunMode(baked));
    if (!isFirst && !checkRunMode(baked, mode)) mode = defaultRunMode(baked);
    if (Status status = checkRunMode(baked, mode); !status) return status;
    const Result<Camera> camera = firstCamera(baked.scene);
    if (!camera) return camera.error();
    if (Status status = show(std::move(baked)); !status) return status;
    forgetBakes();
    file_ = opening.file;
    fileTime_ = opening.fileTime;
    scene_ = shown_->scene;
    fileWarnings_ = scene_.warnings;
    bounds_ = objectBounds(scene_);
    atLoad_ = outlineOf(scene_);
    state_.title = file_.filename().string();
    state_.bakeOutput = file_.stem().string() + "_baked.glb";
    state_.selectedLight = state_.selectedObject = -1;
    gizmo_.release();
    const bool quits = state_.requests.quit;
    state_.requests = {}; // of lights and objects that are gone
    state_.requests.quit = quits;
    SDL_SetWindowTitle(desktop_.window(), ("halflight: " + state_.title).c_str());
    state_.settings.mode = mode;
    state_.otherMode = RunMode::Realtime; // what a bake is compared with
    if (isFirst) state_.requests.bake = options_.bakeAtStart;
    if (!keepsView) place(*camera, !isFirst || !options_.exposureEv);
    return {};
}

/// Of the file before.
void Viewer::forgetBakes()
{
    session_.reset();
    earlier_.reset();
    earlierRenderer_.reset();
    state_.hasEarlier = false;
    referenceScene_.reset();
    beforeBake_.reset();
    irradiance_.clear();
    state_.bakeStatus = {};
    bakeWarnings_.clear();
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
    shown_ = std::move(baked);
    return {};
}

} // namespace halflight::view
