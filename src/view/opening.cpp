// From a file to what the window shows.
#include "view/viewer.h"

#include "halflight/bake_cpu/embree_integrator.h"

#include <SDL.h>
#include <SDL_vulkan.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <thread>
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
    ivec2 size(1);
    SDL_Vulkan_GetDrawableSize(desktop_.window(), &size.x, &size.y);
    const Opening opening{.file = file,
                          .keepsView = keepsView,
                          .isFirst = !shown_,
                          .size = glm::max(size, ivec2(1)),
                          .start = first_.read.valid() ? start_ : Clock::now(),
                          .fileTime =
                              first_.read.valid() ? first_.time : std::filesystem::last_write_time(file, unknown)};
    if (opening_) {
        openNext_ = opening;
        return;
    }
    opening_ = opening;
    openingStage_ = OpeningStage::Read;
    ready_ = false;
    reading_ = std::async(std::launch::async, [this, opening, settings = state_.bake] {
        Result<Opened> opened = openOnThread(opening, settings);
        ready_ = true;
        SDL_Event wakes{};
        wakes.type = SDL_USEREVENT;
        SDL_PushEvent(&wakes);
        return opened;
    });
}

/// While the first file is opened, the window draws nothing but its panels, and the renderer is this thread's.
Result<Viewer::Opened> Viewer::openOnThread(const Opening& opening, const BakeSettings& settings)
{
    Result<BakedScene> read = first_.read.valid() ? first_.read.get() : options_.loader.read(opening.file, first_.ends);
    if (!read) return read.error();
    const Error ended{ErrorCode::Cancelled, "interrupted", ""};
    if (first_.ends) return ended;
    Opened opened;
    opened.baked = std::move(*read);
    const RunMode mode = options_.mode.value_or(defaultRunMode(opened.baked));
    if (Status status = checkRunMode(opened.baked, mode); !status && opening.isFirst) return status.error();
    const float aspect = float(opening.size.x) / float(opening.size.y);
    Result<Camera> camera = options_.loader.camera(opened.baked.scene, aspect, opening.isFirst);
    if (!camera) return camera.error();
    opened.camera = std::move(*camera);
    if (opening.isFirst && options_.bakeAtStart)
        opened.session = std::make_unique<BakeSession>(opened.baked.scene, settings, makeEmbreeIntegrator, true);
    openingStage_ = OpeningStage::Upload;
    if (opened.session) takeEarlyLight(opened);
    if (first_.ends) return ended;
    auto uploaded = renderer_->upload(opened.light ? *opened.light : opened.baked,
                                      opening.isFirst ? TextureDetail::Coarse : TextureDetail::Full, &first_.ends);
    if (!uploaded) return uploaded.error();
    if (!opening.isFirst) {
        opened.uploaded = std::move(*uploaded);
        return opened;
    }
    if (first_.ends) return ended;
    openingStage_ = OpeningStage::FirstPicture;
    if (Status status = renderer_->show(*uploaded); !status) return status.error();
    const Clock::time_point start = Clock::now();
    const Result<float> exposure = drawFirstPicture(opening, opened, opened.light ? RunMode::BakedIndirect : mode);
    if (!exposure) return exposure.error();
    opened.exposureEv = *exposure;
    opened.pictureSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    return opened;
}

/// The first picture has the light of probes where that comes soon.
void Viewer::takeEarlyLight(Opened& opened)
{
    constexpr std::chrono::milliseconds kPatience(2000);
    constexpr std::chrono::milliseconds kLook(5);
    const Clock::time_point end = Clock::now() + kPatience;
    while (!(opened.light = opened.session->takeProbeLight()) && Clock::now() < end &&
           !opened.session->state().finished)
        std::this_thread::sleep_for(kLook);
}

Result<float> Viewer::drawFirstPicture(const Opening& opening, const Opened& opened, RunMode mode) const
{
    RenderSettings settings = options_.render;
    settings.mode = mode;
    settings.size = pictureSize(opening.size, PictureDetail::Coarse);
    settings.keepsPicture = !settings.timings;
    const Camera camera = Navigator(opened.camera, 1.0f).camera();
    if (!options_.shadowDistanceGiven) {
        const float farthest = farthestInView({camera, settings.size}, objectBounds(opened.baked.scene));
        settings.shadows = shadowsReaching(farthest, settings.shadows);
    }
    const Result<RenderedFrame> frame = renderer_->render(camera, settingsOf(settings, PictureDetail::Coarse));
    if (!frame) return frame.error();
    return automaticExposure(frame->radiance);
}

Status Viewer::pollOpening()
{
    if (!opening_ || !ready_) return {};
    Result<Opened> opened = reading_.get();
    const Opening opening = *std::exchange(opening_, std::nullopt);
    if (openNext_) {
        const Opening next = *std::exchange(openNext_, std::nullopt);
        open(next.file, next.keepsView);
        return {};
    }
    if (opening.file == file_) fileTime_ = opening.fileTime; // a file that cannot be read is not tried again
    const Status status = opened ? showFile(opening, std::move(*opened)) : Status(opened.error());
    lastFrame_ = Clock::now(); // no time in which the camera flies
    if (status || !shown_ || status.error().code == ErrorCode::DeviceFailed) return status;
    fileWarnings_.push_back(status.error().text());
    tell(fmt::format("{}: {}", opening.file.filename().string(), status.error().text()));
    return {};
}

void Viewer::place(const Camera& camera, std::optional<float> exposureEv)
{
    const Bounds bounds = scene_.bounds();
    const float pivot = bounds.empty() ? 1.0f : 0.4f * glm::length(bounds.size());
    state_.navigator = Navigator(camera, pivot);
    state_.speed = bounds.empty() ? 1.0f : std::clamp(0.1f * glm::length(bounds.size()), 0.05f, 10.0f);
    hasCamera_ = true;
    if (exposureEv)
        state_.exposureEv = *exposureEv;
    else
        state_.requests.expose = true;
}

Status Viewer::showFile(const Opening& opening, Opened opened)
{
    const bool isFirst = !shown_;
    const bool keepsView = hasCamera_ && opening.keepsView;
    RunMode mode = state_.settings.mode;
    if (!keepsView || !checkRunMode(opened.baked, mode)) mode = options_.mode.value_or(defaultRunMode(opened.baked));
    if (!checkRunMode(opened.baked, mode)) mode = defaultRunMode(opened.baked);
    forgetBakes();
    details_.forget();
    if (isFirst) details_.drew(opened.pictureSeconds);
    texturesAreCoarse_ = isFirst;
    if (opened.uploaded)
        if (Status status = renderer_->show(opened.uploaded); !status) return status;
    takeShown(std::move(opened.baked));
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
    if (!keepsView) place(opened.camera, isFirst && options_.exposureEv ? options_.exposureEv : opened.exposureEv);
    if (opened.session) startBake(std::move(opened.session));
    if (opened.light) {
        takeShown(std::move(*opened.light));
        lightIsShown("light of probes");
    }
    return {};
}

/// What waited for it begins: all texels of textures, and the bake.
void Viewer::firstPictureIsShown()
{
    say(fmt::format("first picture after {:.2f} s", secondsSinceStart()));
    if (session_) session_->goOn();
    if (texturesAreCoarse_) showLater(*shown_, [this] { texturesAreCoarse_ = false; });
}

/// Of the file before.
void Viewer::forgetBakes()
{
    session_.reset();
    if (uploading_.valid()) uploading_.wait();
    uploading_ = {};
    showing_.reset();
    earlierLoading_ = {};
    earlierRenderer_.reset();
    earlier_.reset();
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
    takeShown(std::move(baked));
    return {};
}

void Viewer::showLater(BakedScene baked, std::function<void()> then)
{
    showing_.emplace(Showing{std::move(baked), std::move(then)});
    uploading_ = std::async(std::launch::async,
                            [this] { return renderer_->upload(showing_->baked, TextureDetail::Full, &first_.ends); });
}

Status Viewer::pollShowing()
{
    if (!showing_ || uploading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    const auto uploaded = uploading_.get();
    Showing showing = *std::exchange(showing_, std::nullopt);
    if (!uploaded) return uploaded.error();
    if (Status status = renderer_->show(*uploaded); !status) return status;
    takeShown(std::move(showing.baked));
    showing.then();
    return {};
}

void Viewer::takeShown(BakedScene baked)
{
    state_.modes = modesOf(baked);
    state_.statistics = statisticsOf(baked);
    const auto fits = [&](RunMode mode) {
        return std::find(state_.modes.begin(), state_.modes.end(), mode) != state_.modes.end();
    };
    if (!fits(state_.settings.mode)) state_.settings.mode = defaultRunMode(baked);
    if (!fits(state_.otherMode)) state_.otherMode = RunMode::Realtime;
    shown_ = std::move(baked);
}

} // namespace halflight::view
