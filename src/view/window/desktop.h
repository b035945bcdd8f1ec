#pragma once
// The window of the desktop, and the Vulkan device that draws into it.

#include "view/window/gamepad.h"
#include "view/window/swapchain.h"
#include "view/window/ui_renderer.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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
    [[nodiscard]] ivec2 pixels() const; ///< at least 1
    void toggleFullScreen() const;
    [[nodiscard]] Gamepad& gamepad() { return *gamepad_; }
    [[nodiscard]] std::vector<std::string> vulkanExtensions() const;

private:
    void close();
    void scalePanels() const;
    SDL_Window* window_ = nullptr;
    std::optional<Gamepad> gamepad_{std::in_place}; ///< ends before SDL
    bool hasContext_ = false;
};

/// A device, and what draws into the window by it; they go in the other order, once the device has done its work.
struct WindowDevice {
    /// Throws gpu::Failure where no device can draw into the window.
    WindowDevice(const Desktop& desktop, const RendererOptions& options);
    ~WindowDevice();
    WindowDevice(const WindowDevice&) = delete;
    WindowDevice& operator=(const WindowDevice&) = delete;

    const std::unique_ptr<Renderer> renderer; ///< never null
    gpu::Device device;                       ///< the renderer's
    Swapchain swapchain;
    UiRenderer ui;
};

} // namespace halflight::view
