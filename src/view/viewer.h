#pragma once
// The window's loop: input, panels, frames, bakes in the background.

#include "halflight/bake/bake_session.h"
#include "halflight/render/vulkan_target.h"
#include "halflight/view/view.h"
#include "view/gamepad.h"
#include "view/gizmo.h"
#include "view/panel_input.h"
#include "view/picture_size.h"
#include "view/reference_picture.h"
#include "view/swapchain.h"
#include "view/ui_renderer.h"
#include "view/view_state.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <vector>

union SDL_Event;
struct SDL_Window;

namespace halflight::view {

/// SDL, its window and the panels' context, in this order; they go in the other.
class Desktop {
public:
    /// Throws gpu::Failure without a display.
    Desktop(const std::string& title, ivec2 size);
    ~Desktop();
    Desktop(const Desktop&) = delete;
    Desktop& operator=(const Desktop&) = delete;

    [[nodiscard]] SDL_Window* window() const { return window_; }
    [[nodiscard]] Gamepad& gamepad() { return *gamepad_; }
    [[nodiscard]] std::vector<std::string> vulkanExtensions() const;

private:
    void close();
    void scalePanels() const;
    SDL_Window* window_ = nullptr;
    std::optional<Gamepad> gamepad_{std::in_place}; ///< ends before SDL
    bool hasContext_ = false;
};

/// Size of a picture as wide for its height as `size`, in which the longer side has so few pixels that the picture has
/// the mean of a large one soon.
ivec2 smallPicture(vec2 size);

/// Reads the first file while the window is made. Its end ends the reading, too.
struct FirstFile {
    explicit FirstFile(const ViewOptions& options);
    ~FirstFile() { ends = true; }
    FirstFile(const FirstFile&) = delete;
    FirstFile& operator=(const FirstFile&) = delete;

    std::atomic<bool> ends = false; ///< the window closes: threads end soon
    std::filesystem::file_time_type time;
    std::future<Result<BakedScene>> read;
};

class Viewer {
public:
    explicit Viewer(const ViewOptions& options);
    ~Viewer();

    Status run();

private:
    using Clock = std::chrono::steady_clock;
    /// The user may go on at once: some of a second between two keys.
    static constexpr std::chrono::milliseconds kAfterInput{500};

    void startDevice();
    /// One turn of the loop.
    Status turn();
    /// Begins anew with another device, after one that failed; the failure itself, if that happens again soon.
    Status recover(const Error& failure);
    void watchFile();
    /// Reads and uploads a file on another thread; what is shown stays until then. `keepsView`: the same file again;
    /// camera, exposure and mode stay.
    void open(const std::filesystem::path& file, bool keepsView = false);
    struct Opening {
        std::filesystem::path file;
        bool keepsView = false;
        bool isFirst = false; ///< nothing is shown yet
        ivec2 size{1};        ///< of the window, pixels
        Clock::time_point start;
        std::filesystem::file_time_type fileTime;
    };
    /// What that thread makes of a file.
    struct Opened {
        BakedScene baked;
        Camera camera;
        std::shared_ptr<Renderer::Uploaded> uploaded; ///< of the first file nothing: the renderer has it
        std::optional<float> exposureEv;              ///< of the first file: automaticExposure()
        double pictureSeconds = 0.0;                  ///< of the first file: time of its coarse picture
        std::unique_ptr<BakeSession> session;         ///< of the first file, with ViewOptions::bakeAtStart
        std::optional<BakedScene> light;              ///< its light of probes; the renderer has it
    };
    enum class OpeningStage { Read, Upload, FirstPicture };
    Result<Opened> openOnThread(const Opening& opening, const BakeSettings& settings);
    static void takeEarlyLight(Opened& opened);
    /// Draws the coarse picture that the first frame shows, and exposes it.
    Result<float> drawFirstPicture(const Opening& opening, const Opened& opened, RunMode mode) const;
    /// Shows the file once that thread has ended. An error where nothing is shown yet.
    Status pollOpening();
    Status showFile(const Opening& opening, Opened opened);
    /// `exposureEv`: none, automaticExposure() after the next frame.
    void place(const Camera& camera, std::optional<float> exposureEv);
    void forgetBakes();
    /// Uploads a scene and shows it; the window waits.
    Status show(BakedScene baked);
    /// Uploads a scene on another thread and shows it when that has ended; then calls `then`. One at a time.
    void showLater(BakedScene baked, std::function<void()> then);
    struct Showing {
        BakedScene baked;
        std::function<void()> then;
    };
    Status pollShowing();
    void waitForThreads();
    /// The renderer has the scene.
    void takeShown(BakedScene baked);
    void collectWarnings();
    void handleEvents();
    void handleEvent(const SDL_Event& event);
    void drag(vec2 pixels, uint32_t buttons);
    void click(vec2 place);
    void fly(float seconds);
    /// Few frames while nobody moves anything: the processor is left to work in the background.
    void waitAtRest();
    /// Not drawn: only for what mouse and keys change in them.
    void buildPanels(bool isDrawn);
    void drawCompared();
    void drawGizmo();
    bool dragGizmo(vec2 mouse);
    [[nodiscard]] bool wantsEarlier() const;
    Status followEarlier();
    void followReference();
    Status drawFrame();
    Status drawScene(const Swapchain::Frame& frame);
    Status drawOther(const Swapchain::Frame& frame, RenderSettings settings, VulkanTarget target);
    /// Of the window's next frame.
    PictureDetail chooseDetail(ivec2 size);
    void firstPictureIsShown();
    [[nodiscard]] RenderSettings settingsFor(ivec2 size) const;
    Status answerRequests();
    void applyEdits();
    void showRequested(const Requests& requests);
    void moveObject(std::size_t index, const mat4& place);
    void frameSelection();
    void showSubject(std::size_t warning);
    void saveBake();
    void writeSettings();
    Status expose();
    Status takeScreenshot();
    void startBake(std::unique_ptr<BakeSession> session);
    Status pollBake();
    void endBake(Result<BakeResult> result, double seconds);
    Status showProgress();
    void lightIsShown(const char* name);
    void say(const std::string& line) const;
    [[nodiscard]] double secondsSinceStart() const;
    /// Shows a line at the bottom of the window for some seconds.
    void note(const std::string& line);
    void tell(const std::string& line); ///< both
    void drawNotice() const;
    [[nodiscard]] std::string currentCommand() const;

    const Clock::time_point start_ = Clock::now();
    const ViewOptions& options_;
    std::filesystem::path file_;
    FirstFile first_;
    ViewState state_;
    ivec2 size_{0}; ///< of the last frame, pixels
    Desktop desktop_;
    std::unique_ptr<Renderer> renderer_;
    std::unique_ptr<gpu::Device> device_; ///< the renderer's
    std::unique_ptr<Swapchain> swapchain_;
    std::unique_ptr<UiRenderer> ui_;

    Scene scene_;                ///< what the next bake bakes: the file's with the user's changes
    std::vector<Bounds> bounds_; ///< of its objects
    Scene atLoad_;               ///< lights and objects of the file
    std::vector<std::string> fileWarnings_;
    std::vector<std::string> bakeWarnings_;
    std::vector<std::string> frameWarnings_;
    bool hasCamera_ = false;
    std::unique_ptr<BakeSession> session_;
    std::optional<BakedScene> beforeBake_;      ///< shown again when a bake is cancelled
    RunMode modeBefore_ = RunMode::Realtime;    ///< the bake
    std::optional<BakedScene> shown_;           ///< what is on the device, to go back to and to save
    std::vector<ImageRgb32f> irradiance_;       ///< of the finished bake
    std::optional<BakedScene> earlier_;         ///< what was shown before the last finished bake
    std::unique_ptr<Renderer> earlierRenderer_; ///< draws it, while it is compared with
    std::future<Result<std::unique_ptr<Renderer>>> earlierLoading_; ///< makes it
    std::optional<ReferencePicture> reference_;
    std::shared_ptr<const Scene> referenceScene_;         ///< what it shows; null when scene_ has changed
    std::optional<ReferencePicture::Picture> pathTraced_; ///< the last one of this view
    Clock::time_point lastEdit_;                          ///< of scene_
    Clock::time_point lastInput_;                         ///< by keys, mouse or gamepad
    float pathTracedEv_ = 0.0f;                           ///< its exposure on the screen
    ToneMapping pathTracedTone_ = ToneMapping::Neutral;
    Gizmo gizmo_;
    PanelInput panelInput_;
    std::vector<std::string> messages_;          ///< of the validation layer, of devices before
    std::optional<int> failedAt_;                ///< frame at which the device failed last
    std::filesystem::file_time_type fileTime_{}; ///< of file_, as it was read
    std::optional<Opening> opening_;             ///< is being read
    std::optional<Opening> openNext_;            ///< is read after it, in its place
    std::vector<SDL_Event> early_;               ///< keys and clicks before anything was shown
    std::string notice_;                         ///< what note() shows
    Clock::time_point noticeTime_;
    Clock::time_point lastLook_ = Clock::now(); ///< at file_
    int frames_ = 0;
    PictureDetails details_;
    RenderSettings drawnSettings_;   ///< of the last frame, as panels have them
    Camera drawnCamera_;             ///< of the last frame
    Clock::time_point drawnEdit_;    ///< lastEdit_ of the last frame
    bool texturesAreCoarse_ = false; ///< of the first file, until the others are uploaded
    bool drewPicture_ = false;       ///< the last frame, and did not show the one before once more
    bool inPicture_ = false;         ///< the mouse was pressed there, not in a panel
    bool dragged_ = false;           ///< since then, or an arrow was taken
    bool compared_ = false;          ///< the last frame showed two modes
    Clock::time_point lastFrame_ = Clock::now();
    Clock::time_point lastTiles_; ///< when some were shown
    int screenshots_ = 0;
    std::atomic<OpeningStage> openingStage_ = OpeningStage::Read;
    std::atomic<bool> ready_ = false; ///< what opens a file has ended
    std::optional<Showing> showing_;
    // The first to go, which waits for the ends of their threads.
    std::future<Result<std::shared_ptr<Renderer::Uploaded>>> uploading_; ///< showing_
    std::future<Result<Opened>> reading_;                                ///< opening_
};

} // namespace halflight::view
