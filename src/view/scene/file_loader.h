#pragma once
// From a file to what the window shows, in the background.

#include "halflight/bake/bake_session.h"
#include "halflight/view/view.h"
#include "view/window/desktop.h"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>

namespace halflight::view {

/// Reads the first file while the window is made. Its end ends the reading, too.
struct FirstFile {
    explicit FirstFile(const ViewOptions& options);
    ~FirstFile() { ends = true; }
    FirstFile(const FirstFile&) = delete;
    FirstFile& operator=(const FirstFile&) = delete;

    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    std::atomic<bool> ends = false; ///< the window closes: threads end soon
    std::filesystem::file_time_type time;
    std::future<Result<BakedScene>> read;
};

/// Reads and uploads a file on another thread, while the one before stays shown; then watches it for changes. Of files
/// that are opened meanwhile only the last one follows. Before the first file is shown, nobody else uses the renderer.
class FileLoader {
public:
    FileLoader(const ViewOptions& options, FirstFile& first, const Desktop& desktop);

    /// `keepsView`: the same file again; camera, exposure and mode stay.
    void open(Renderer& renderer, const std::filesystem::path& file, bool keepsView);
    /// What the thread makes of a file.
    struct Content {
        BakedScene baked;
        Camera camera;
        std::shared_ptr<Renderer::Uploaded> uploaded; ///< of the first file nothing: the renderer shows it
        std::optional<float> exposureEv;              ///< of the first file: automaticExposure()
        std::optional<double> pictureSeconds;         ///< of the first file: time of its coarse picture
        std::unique_ptr<BakeSession> session;         ///< of the first file, with ViewOptions::bakeAtStart
        std::optional<BakedScene> light;              ///< its light of probes, which the renderer shows instead
    };
    struct Opened {
        std::filesystem::path file;
        bool keepsView = false;
        std::filesystem::file_time_type time; ///< as it was read
        Result<Content> content;
    };
    /// The file that has been opened, once; nothing of one that another follows.
    std::optional<Opened> poll(Renderer& renderer);
    [[nodiscard]] bool works() const { return opening_.has_value(); }
    /// Whether poll() has something to do.
    [[nodiscard]] bool isReady() const { return ready_; }
    /// What is being done, for people; empty when nothing is.
    [[nodiscard]] std::string progress() const;

    /// This file is shown, and watched.
    void isShown(const Opened& opened);
    [[nodiscard]] const std::filesystem::path& file() const { return file_; } ///< shown, or the first
    /// Whether it is another one on the disk than was read; looks now and then.
    bool hasChanged();
    /// The window has written a file, which is not read again.
    void wasWritten(const std::filesystem::path& file);

    /// Waits for the thread, whose device has failed.
    void leaveDevice() { reading_ = {}; }
    /// Begins anew with what was being opened.
    void moveTo(Renderer& renderer);

private:
    using Clock = std::chrono::steady_clock;

    enum class Stage { Read, Upload, FirstPicture };
    struct Opening {
        std::filesystem::path file;
        bool keepsView = false;
        bool isFirst = false; ///< nothing is shown yet
        ivec2 size{1};        ///< of the window, pixels
        Clock::time_point start;
        std::filesystem::file_time_type time;
    };
    Result<Content> read(const Opening& opening, Renderer& renderer);
    Result<float> drawFirstPicture(const Opening& opening, const Content& content, RunMode mode,
                                   Renderer& renderer) const;

    const ViewOptions& options_;
    FirstFile& first_;
    const Desktop& desktop_;
    std::filesystem::path file_;
    std::filesystem::file_time_type time_{}; ///< of file_, as it was read
    bool showsFile_ = false;
    Clock::time_point lastLook_ = Clock::now(); ///< at file_
    struct Next {
        std::filesystem::path file;
        bool keepsView = false;
    };
    std::optional<Next> next_;       ///< is opened after opening_, in its place
    std::optional<Opening> opening_; ///< is being read
    std::atomic<Stage> stage_ = Stage::Read;
    std::atomic<bool> ready_ = false;      ///< the thread has ended
    std::future<Result<Content>> reading_; ///< opening_; goes first: waits for the thread's end
};

} // namespace halflight::view
