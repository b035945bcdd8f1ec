#include "view/scene/live_bake.h"

#include "halflight/scene/gltf.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <filesystem>
#include <utility>

namespace halflight::view {

void LiveBake::start(std::unique_ptr<BakeSession> session)
{
    session_ = std::move(session);
    time_ = Clock::now();
    before_ = shown_.baked();
    beforeTime_ = shown_.time();
    modeBefore_ = state_.settings.mode;
    resultBefore_ = status_.hasResult;
    status_ = {};
    status_.running = true;
    notices_.setWarnings(Notices::About::Bake, {});
}

void LiveBake::goOn()
{
    if (session_) session_->goOn();
}

void LiveBake::cancel()
{
    if (!session_) return;
    session_->cancel();
    status_.cancelled = true;
    notices_.note("the bake ends; Escape once more quits");
}

void LiveBake::forget()
{
    session_.reset();
    before_.reset();
    uploadedLight_ = nullptr;
    end_.reset();
    irradiance_.clear();
    groupIrradiance_.clear();
    savedAs_.clear();
    status_ = {};
    notices_.setWarnings(Notices::About::Bake, {});
}

Status LiveBake::poll(Renderer& renderer, float aspect, double pictureSeconds)
{
    if (!session_) return {};
    status_.session = session_->state();
    session_->setView(state_.navigator.camera(), aspect);
    if (shown_.isUploading()) return {};
    if (Status status = showProgress(renderer, pictureSeconds); !status) return status;
    if (shown_.isUploading() || !status_.session.finished) return {};
    Result<BakeResult> result = session_->takeResult();
    session_.reset();
    end(renderer, std::move(result), status_.session.seconds);
    return {};
}

/// First light, then what has changed of it.
Status LiveBake::showProgress(Renderer& renderer, double pictureSeconds)
{
    const char* name = "light of probes";
    std::optional<BakedScene> light = session_->takeProbeLight();
    if (std::optional<BakedScene> ofTexels = session_->takeLight()) {
        light = std::move(ofTexels);
        name = "first light";
    }
    if (light) {
        uploadedLight_ = name;
        renderer.prepareForward(true); // most bakes have a mask; earlier, it would delay the light on few cores
        shown_.showLater(renderer, std::move(*light), time_);
        return {};
    }
    // Uploads wait for the frames in flight, so that some tiles come at once. Where the CPU draws, pictures of new
    // tiles take an eighth of the bake's time at most.
    const std::chrono::duration<double> pause(std::max(0.3, 8.0 * pictureSeconds));
    if (!status_.firstLight || Clock::now() - lastTiles_ < pause) return {};
    lastTiles_ = Clock::now();
    const std::vector<LightTile> tiles = session_->takeTiles();
    std::vector<LightmapRectangle> rectangles;
    for (const LightTile& tile : tiles) rectangles.push_back({tile.page, tile.offset, &tile.texels});
    return renderer.updateLightmaps(rectangles);
}

void LiveBake::end(Renderer& renderer, Result<BakeResult> result, double seconds)
{
    BakedScene before = *std::exchange(before_, std::nullopt);
    if (!result) {
        const bool cancelled = result.error().code == ErrorCode::Cancelled;
        end_ = End{false, modeBefore_, cancelled ? "cancelled" : result.error().text()};
        shown_.showLater(renderer, std::move(before), beforeTime_);
        return;
    }
    comparison_.keepEarlier(std::move(before));
    notices_.setWarnings(Notices::About::Bake, result->report.warnings);
    irradiance_ = std::move(result->irradiance);
    groupIrradiance_ = std::move(result->groupIrradiance);
    savedAs_.clear();
    // As before the bake, if that was a baked mode which the file has.
    const bool fits = modeBefore_ != RunMode::Realtime && checkRunMode(result->baked, modeBefore_);
    end_ = End{true, fits ? modeBefore_ : defaultRunMode(result->baked),
               fmt::format("baked in {:.1f} s, with {} samples per texel", seconds, result->report.quality.samples)};
    shown_.showLater(renderer, std::move(result->baked), time_);
}

void LiveBake::uploadIsShown()
{
    if (end_)
        endIsShown();
    else if (uploadedLight_)
        lightIsShown(std::exchange(uploadedLight_, nullptr));
}

void LiveBake::lightIsShown(const char* name)
{
    notices_.say(fmt::format("{} after {:.2f} s", name, session_->state().seconds));
    status_.firstLight = true;
    state_.settings.mode = RunMode::BakedIndirect; // mixed lights have no mask before the end
    lastTiles_ = Clock::now();
}

void LiveBake::endIsShown()
{
    const End end = *std::exchange(end_, std::nullopt);
    state_.settings.mode = end.mode;
    if (end.hasResult) comparison_.offerEarlier();
    status_ = {};
    status_.hasResult = end.hasResult || resultBefore_; // what comes back may still be saved
    status_.outcome = end.outcome;
    notices_.tell(end.hasResult ? end.outcome : "bake: " + end.outcome);
}

std::string LiveBake::write(FilesInUse files)
{
    const std::filesystem::path file = state_.bakeOutput;
    if (file.extension() != ".glb" && file.extension() != ".gltf") return file.string() + ": must end in .glb or .gltf";
    addBakedFiles(files, "the bake", file);
    std::filesystem::path culprit;
    if (const Status unused = files.check(culprit); !unused)
        return fmt::format("{}: {}", culprit.string(), unused.error().message);
    WriteOptions write;
    write.irradiance = irradiance_;
    write.groupIrradiance = groupIrradiance_;
    if (const Status written = writeBakedScene(file, shown_.baked(), write); !written)
        return fmt::format("{}: {}", file.string(), written.error().message);
    savedAs_ = file.string();
    return "saved " + savedAs_;
}

void LiveBake::save(FilesInUse files)
{
    report(write(std::move(files)));
}

void LiveBake::report(const std::string& outcome)
{
    status_.outcome = outcome;
    notices_.tell(outcome);
}

} // namespace halflight::view
