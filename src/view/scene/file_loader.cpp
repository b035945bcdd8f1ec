#include "view/scene/file_loader.h"

#include "halflight/render/frame.h"
#include "view/state/navigation.h"
#include "view/state/picture_size.h"

#include <SDL.h>
#include <spdlog/fmt/fmt.h>

#include <thread>
#include <utility>

namespace halflight::view {
namespace {

/// The light of probes, where that comes soon.
std::optional<BakedScene> earlyLight(BakeSession& session)
{
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds kPatience(2000);
    constexpr std::chrono::milliseconds kLook(5);
    const Clock::time_point end = Clock::now() + kPatience;
    std::optional<BakedScene> light;
    while (!(light = session.takeProbeLight()) && Clock::now() < end && !session.state().finished)
        std::this_thread::sleep_for(kLook);
    return light;
}

} // namespace

FirstFile::FirstFile(const ViewOptions& options)
{
    std::error_code unknown;
    time = std::filesystem::last_write_time(options.file, unknown);
    read = std::async(std::launch::async, [&] { return options.loader.read(options.file, ends); });
}

FileLoader::FileLoader(const ViewOptions& options, FirstFile& first, const Desktop& desktop)
    : options_(options), first_(first), desktop_(desktop), file_(options.file)
{}

void FileLoader::open(Renderer& renderer, const std::filesystem::path& file, bool keepsView)
{
    if (opening_) {
        next_ = Next{file, keepsView};
        return;
    }
    std::error_code unknown;
    const bool isRead = first_.read.valid();
    opening_ = Opening{.file = file,
                       .keepsView = keepsView,
                       .isFirst = !showsFile_,
                       .size = desktop_.pixels(),
                       .start = isRead ? first_.start : Clock::now(),
                       .time = isRead ? first_.time : std::filesystem::last_write_time(file, unknown)};
    stage_ = Stage::Read;
    ready_ = false;
    reading_ = std::async(std::launch::async, [this, opening = *opening_, &renderer] {
        Result<Content> content = read(opening, renderer);
        ready_ = true;
        SDL_Event wakes{};
        wakes.type = SDL_USEREVENT;
        SDL_PushEvent(&wakes);
        return content;
    });
}

/// On the other thread.
Result<FileLoader::Content> FileLoader::read(const Opening& opening, Renderer& renderer)
{
    Result<BakedScene> read = first_.read.valid() ? first_.read.get() : options_.loader.read(opening.file, first_.ends);
    if (!read) return read.error();
    const Error ended = cancelledError();
    if (first_.ends) return ended;
    Content content;
    content.baked = std::move(*read);
    const RunMode mode = options_.mode.value_or(defaultRunMode(content.baked));
    if (Status status = checkRunMode(content.baked, mode); !status && opening.isFirst) return status.error();
    const float aspect = float(opening.size.x) / float(opening.size.y);
    Result<Camera> camera = options_.loader.camera(content.baked.scene, aspect, opening.isFirst);
    if (!camera) return camera.error();
    content.camera = std::move(*camera);
    if (opening.isFirst && options_.bakeAtStart)
        content.session = std::make_unique<BakeSession>(content.baked.scene, options_.bake, options_.integrators, true);
    stage_ = Stage::Upload;
    if (content.session) content.light = earlyLight(*content.session);
    if (first_.ends) return ended;
    auto uploaded = renderer.upload(content.light ? *content.light : content.baked,
                                    opening.isFirst ? TextureDetail::Coarse : TextureDetail::Full, &first_.ends);
    if (!uploaded) return uploaded.error();
    if (!opening.isFirst) {
        content.uploaded = std::move(*uploaded);
        return content;
    }
    if (first_.ends) return ended;
    stage_ = Stage::FirstPicture;
    if (Status status = renderer.show(*uploaded); !status) return status.error();
    const Clock::time_point start = Clock::now();
    const Result<float> exposure =
        drawFirstPicture(opening, content, content.light ? RunMode::BakedIndirect : mode, renderer);
    if (!exposure) return exposure.error();
    content.exposureEv = *exposure;
    content.pictureSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    return content;
}

/// The coarse picture that the first frame shows; its exposure.
Result<float> FileLoader::drawFirstPicture(const Opening& opening, const Content& content, RunMode mode,
                                           Renderer& renderer) const
{
    RenderSettings settings = options_.render;
    settings.mode = mode;
    settings.size = pictureSize(opening.size, PictureDetail::Coarse);
    settings.keepsPicture = !settings.timings;
    const Camera camera = Navigator(content.camera, 1.0f).camera();
    if (!options_.shadowDistanceGiven) {
        const float farthest = farthestInView({camera, settings.size}, objectBounds(content.baked.scene));
        settings.shadows = shadowsReaching(farthest, settings.shadows);
    }
    const Result<RenderedFrame> frame = renderer.render(camera, settingsOf(settings, PictureDetail::Coarse));
    if (!frame) return frame.error();
    return automaticExposure(frame->radiance);
}

std::optional<FileLoader::Opened> FileLoader::poll(Renderer& renderer)
{
    if (!opening_ || !ready_) return std::nullopt;
    const Opening opening = *std::exchange(opening_, std::nullopt);
    Opened opened{opening.file, opening.keepsView, opening.time, reading_.get()};
    if (const auto next = std::exchange(next_, std::nullopt)) {
        open(renderer, next->file, next->keepsView);
        return std::nullopt;
    }
    if (opened.file == file_) time_ = opened.time; // a file that cannot be read is not tried again
    return opened;
}

void FileLoader::isShown(const Opened& opened)
{
    file_ = opened.file;
    time_ = opened.time;
    showsFile_ = true;
}

std::string FileLoader::progress() const
{
    if (!opening_) return "";
    const Stage stage = stage_;
    return fmt::format("{} {}, {:.0f} s",
                       stage == Stage::Read     ? "loading"
                       : stage == Stage::Upload ? "uploading"
                                                : "preparing the picture of",
                       opening_->file.filename().string(),
                       std::chrono::duration<double>(Clock::now() - opening_->start).count());
}

bool FileLoader::hasChanged()
{
    constexpr std::chrono::seconds kEvery(1);
    if (opening_ || Clock::now() - lastLook_ < kEvery) return false;
    lastLook_ = Clock::now();
    std::error_code absent;
    const auto time = std::filesystem::last_write_time(file_, absent);
    return !absent && time != time_;
}

void FileLoader::wasWritten(const std::filesystem::path& file)
{
    std::error_code absent;
    if (std::filesystem::equivalent(file, file_, absent)) time_ = std::filesystem::last_write_time(file_, absent);
}

void FileLoader::moveTo(Renderer& renderer)
{
    if (const auto opening = std::exchange(opening_, std::nullopt)) open(renderer, opening->file, opening->keepsView);
}

} // namespace halflight::view
