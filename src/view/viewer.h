#pragma once
// The window's loop: input, panels, frames, bakes in the background.

#include "halflight/bake/bake_session.h"
#include "halflight/render/vulkan_target.h"
#include "halflight/view/view.h"
#include "view/gizmo.h"
#include "view/panel_input.h"
#include "view/reference_picture.h"
#include "view/swapchain.h"
#include "view/ui_renderer.h"
#include "view/view_state.h"

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <vector>

union SDL_Event;
struct SDL_Window;
struct _SDL_GameController; // NOLINT: SDL_GameController, as SDL declares it

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
    /// A gamepad that was plugged in, by SDL's index of it.
    void takeGamepad(int index);
    /// What its sticks and triggers ask for, each -1 … 1: to the right, up and forward; then turns to the left and up.
    /// All zero without one.
    struct Sticks {
        vec3 fly{0.0f};
        vec2 look{0.0f};
    };
    [[nodiscard]] Sticks sticks() const;
    [[nodiscard]] std::vector<std::string> vulkanExtensions() const;

private:
    void close();
    SDL_Window* window_ = nullptr;
    _SDL_GameController* gamepad_ = nullptr;
    bool hasContext_ = false;
};

/// A stick or a trigger, -32768 … 32767 as SDL has it, as -1 … 1: nothing in the fifth about its rest.
float stickValue(int value);

class Viewer {
public:
    explicit Viewer(const ViewOptions& options);
    ~Viewer();

    Status run();

private:
    using Clock = std::chrono::steady_clock;

    void startDevice();
    /// One turn of the loop.
    Status turn();
    /// Begins anew with another device, after one that failed; the failure itself, if that happens again soon.
    Status recover(const Error& failure);
    void watchFile();
    /// Reads a file on another thread; what is shown stays until then. `keepsView`: the same file again; camera,
    /// exposure and mode stay.
    void open(const std::filesystem::path& file, bool keepsView = false);
    /// Shows the file once it was read. An error where nothing is shown yet.
    Status pollOpening();
    struct Opening {
        std::filesystem::path file;
        bool keepsView = false;
        Clock::time_point start;
        std::filesystem::file_time_type fileTime;
        bool isRead = false; ///< the next frame shows it
    };
    Status showFile(const Opening& opening, BakedScene baked);
    [[nodiscard]] Result<Camera> firstCamera(const Scene& scene) const;
    void place(const Camera& camera, bool exposes);
    void forgetBakes();
    /// Uploads a scene.
    Status show(BakedScene baked);
    void collectWarnings();
    void handleEvents();
    void handleEvent(const SDL_Event& event);
    void drag(vec2 pixels, uint32_t buttons);
    void click(vec2 place);
    void fly(float seconds);
    void leaveTimeToBackground();
    /// Not drawn: only for what mouse and keys change in them.
    void buildPanels(bool isDrawn);
    void drawCompared();
    void drawGizmo();
    bool dragGizmo(vec2 mouse);
    [[nodiscard]] bool wantsEarlier() const;
    Status loadEarlier();
    void followReference();
    Status drawFrame();
    Status drawScene(const Swapchain::Frame& frame);
    Status drawOther(const Swapchain::Frame& frame, RenderSettings settings, VulkanTarget target);
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
    void startBake();
    Status pollBake();
    Status showProgress();
    void say(const std::string& line) const;
    /// Shows a line at the bottom of the window for some seconds.
    void note(const std::string& line);
    void tell(const std::string& line); ///< both
    void drawNotice() const;
    [[nodiscard]] std::string currentCommand() const;

    const ViewOptions& options_;
    std::filesystem::path file_;
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
    bool announcesEarlier_ = false;             ///< the next frame waits for that renderer
    std::optional<ReferencePicture> reference_;
    std::shared_ptr<const Scene> referenceScene_;         ///< what it shows; null when scene_ has changed
    std::optional<ReferencePicture::Picture> pathTraced_; ///< the last one of this view
    Clock::time_point lastEdit_;                          ///< of scene_
    Clock::time_point lastInput_;                         ///< by keys, mouse or gamepad
    float pathTracedEv_ = 0.0f;                           ///< its exposure on the screen
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
    bool inPicture_ = false; ///< the mouse was pressed there, not in a panel
    bool dragged_ = false;   ///< since then, or an arrow was taken
    bool compared_ = false;  ///< the last frame showed two modes
    Clock::time_point lastFrame_ = Clock::now();
    Clock::time_point lastTiles_; ///< when some were shown
    int screenshots_ = 0;
    std::future<Result<BakedScene>> reading_; ///< of opening_; the first to go, which waits for the end
};

} // namespace halflight::view
