#pragma once
// The window's loop: mouse and keys, frames, and answers to what the panels ask for.

#include "view/gizmo.h"
#include "view/panels/panel_input.h"
#include "view/scene/comparison.h"
#include "view/scene/edited_scene.h"
#include "view/scene/file_loader.h"
#include "view/scene/live_bake.h"
#include "view/scene/scene_picture.h"
#include "view/scene/shown_scene.h"
#include "view/state/notices.h"
#include "view/state/requests.h"
#include "view/state/shown.h"
#include "view/window/desktop.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

union SDL_Event;

namespace halflight::view {

/// Wires the parts of `halflight view`. All of its functions run on one thread; the parts' own threads begin and end
/// within them.
class Viewer {
public:
    explicit Viewer(const ViewOptions& options);
    ~Viewer();

    Status run();

private:
    using Clock = std::chrono::steady_clock;
    /// The user may go on at once: some of a second between two keys.
    static constexpr std::chrono::milliseconds kAfterInput{500};

    [[nodiscard]] Renderer& renderer() const { return *device_->renderer; }
    [[nodiscard]] float aspect() const; ///< of the last frame
    void startDevice();
    /// One turn of the loop.
    Status turn();
    /// Begins anew with another device, after one that failed; the failure itself, if that happens again soon.
    Status recover(const Error& failure);
    /// Few frames while nobody moves anything: the processor is left to work in the background.
    void waitAtRest();

    /// An error where nothing is shown yet.
    Status pollFile();
    Status showFile(FileLoader::Opened opened);
    /// Reads the file again, which is another one on the disk, unless a bake would be lost.
    void reloadChanged();
    /// Whether what is shown may go: a bake that runs or is not saved goes when it is asked for twice, by `key`.
    bool mayDropBake(const std::string& key);
    /// `exposureEv`: none, automaticExposure() after the next frame.
    void place(const Camera& camera, std::optional<float> exposureEv);
    void lookThrough(const Camera& camera);
    Status pollUpload();

    void handleEvents();
    void handleEvent(const SDL_Event& event);
    void drag(vec2 place, vec2 pixels, uint32_t buttons);
    void click(vec2 place);
    void fly(float seconds);
    /// The place of the selected object if that is a dynamic one.
    [[nodiscard]] std::optional<vec3> selectedDynamic() const;
    bool grabArrow(vec2 mouse);

    /// Not drawn: only for what mouse and keys change in them.
    void buildPanels(bool isDrawn);
    void drawNotice() const;
    Status drawFrame();
    void firstPictureIsShown();

    [[nodiscard]] Shown shown() const;
    /// Choices and changes of the scene hold at once; the rest waits for answerRequests().
    void take(Answer answer);
    void change(const SceneChange& change);
    /// Those of the frame, in their order. What has to wait is asked for again.
    Status answerRequests();
    Status answer(Action action);
    Status answer(const LookThrough& request);
    Status answer(const ShowSubject& request);
    void saveBake();
    void copyCommand();
    void frameSelection();
    void writeSettings();
    Status expose();
    Status takeScreenshot();
    [[nodiscard]] ViewText currentCommand() const;

    const ViewOptions& options_;
    Notices notices_;
    ViewState state_;
    WindowReport window_;
    std::vector<Request> requests_; ///< of this frame
    bool quits_ = false;
    FirstFile first_;
    Desktop desktop_;
    EditedScene edited_;
    ScenePicture picture_;
    std::optional<WindowDevice> device_; ///< from startDevice() on; another one after recover()
    // What has threads that use the device, the file or the window. They go before those, the last one first, and each
    // waits for the ends of its threads.
    FileLoader files_;
    ShownScene shown_;
    Comparison comparison_;
    LiveBake bake_;

    Gizmo gizmo_;
    PanelInput panelInput_;
    std::vector<SDL_Event> early_;  ///< keys and clicks before anything was shown
    bool inPicture_ = false;        ///< the mouse was pressed there, not in a panel
    vec2 pressed_{0.0f};            ///< where
    bool dragged_ = false;          ///< since then, or an arrow was taken
    Clock::time_point lastInput_;   ///< by keys, mouse or gamepad
    Clock::time_point askedToDrop_; ///< a bake
    Clock::time_point lastFrame_ = Clock::now();
    ivec2 size_{0}; ///< of the last frame, pixels
    int frames_ = 0;
    int screenshots_ = 0;
    std::optional<int> failedAt_;       ///< frame at which the device failed last
    std::vector<std::string> messages_; ///< of the validation layer, of devices before
};

} // namespace halflight::view
