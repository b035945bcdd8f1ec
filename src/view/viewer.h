#pragma once
// The window's loop: input, panels, frames, bakes in the background.

#include "halflight/bake/bake_session.h"
#include "halflight/view/view.h"
#include "view/swapchain.h"
#include "view/ui_renderer.h"
#include "view/view_state.h"

#include <chrono>
#include <memory>
#include <optional>

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
    [[nodiscard]] std::vector<std::string> vulkanExtensions() const;

private:
    void close();
    SDL_Window* window_ = nullptr;
    bool hasContext_ = false;
};

class Viewer {
public:
    explicit Viewer(const ViewOptions& options);
    ~Viewer();

    Status run();

private:
    using Clock = std::chrono::steady_clock;

    Status open(const std::filesystem::path& file);
    /// Shows a scene: uploads it, keeps the camera unless there is none yet.
    Status show(BakedScene baked);
    void collectWarnings();
    void handleEvents();
    void handleEvent(const SDL_Event& event);
    void drag(vec2 pixels, uint32_t buttons);
    void click(vec2 place);
    void fly(float seconds);
    void buildPanels();
    Status drawFrame();
    Status drawScene(const Swapchain::Frame& frame);
    [[nodiscard]] RenderSettings settingsFor(ivec2 size) const;
    Status answerRequests();
    void changeScene(const Requests& requests);
    void moveObject(std::size_t index, const mat4& place);
    void frameSelection();
    Status expose();
    Status takeScreenshot();
    void startBake();
    Status pollBake();
    void say(const std::string& line) const;
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
    std::optional<BakedScene> beforeBake_; ///< shown again when a bake is cancelled
    std::optional<BakedScene> shown_;      ///< what is on the device, to go back to and to save
    std::vector<ImageRgb32f> irradiance_;  ///< of the finished bake
    int frames_ = 0;
    bool dragged_ = false;
    bool compared_ = false; ///< the last frame showed two modes
    Clock::time_point lastFrame_ = Clock::now();
    int screenshots_ = 0;
};

} // namespace halflight::view
