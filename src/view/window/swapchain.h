#pragma once
// An SDL window's surface: images to draw into, one frame after the other.

#include "gpu/resources.h"
#include "halflight/render/renderer.h"

#include <array>
#include <optional>
#include <vector>

struct SDL_Window;

namespace halflight::view {

/// Vulkan functions of window systems, which src/gpu does not need.
struct PresentFunctions {
    PFN_vkDestroySurfaceKHR DestroySurfaceKHR = nullptr;
    PFN_vkGetPhysicalDeviceSurfaceSupportKHR GetPhysicalDeviceSurfaceSupportKHR = nullptr;
    PFN_vkGetPhysicalDeviceSurfaceCapabilitiesKHR GetPhysicalDeviceSurfaceCapabilitiesKHR = nullptr;
    PFN_vkGetPhysicalDeviceSurfaceFormatsKHR GetPhysicalDeviceSurfaceFormatsKHR = nullptr;
    PFN_vkGetPhysicalDeviceSurfacePresentModesKHR GetPhysicalDeviceSurfacePresentModesKHR = nullptr;
    PFN_vkCreateSwapchainKHR CreateSwapchainKHR = nullptr;
    PFN_vkDestroySwapchainKHR DestroySwapchainKHR = nullptr;
    PFN_vkGetSwapchainImagesKHR GetSwapchainImagesKHR = nullptr;
    PFN_vkAcquireNextImageKHR AcquireNextImageKHR = nullptr;
    PFN_vkQueuePresentKHR QueuePresentKHR = nullptr;
    PFN_vkCreateSemaphore CreateSemaphore = nullptr;
    PFN_vkDestroySemaphore DestroySemaphore = nullptr;
    PFN_vkGetDeviceProcAddr GetDeviceProcAddr = nullptr;
};

class Swapchain {
public:
    /// Throws gpu::Failure where the device cannot draw into the window.
    Swapchain(gpu::Device& device, SDL_Window* window);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    struct Frame {
        VkCommandBuffer commands = VK_NULL_HANDLE; ///< recording
        VkImageView view = VK_NULL_HANDLE;         ///< in layout COLOR_ATTACHMENT_OPTIMAL, black
        ivec2 size{0};                             ///< pixels
        int slot = 0;                              ///< 0 … kFramesInFlight - 1, in turn
    };
    /// Waits for the frame kFramesInFlight before. Nothing while the window has no pixels (minimized).
    std::optional<Frame> begin();
    /// Submits the frame and shows it.
    void end();
    /// Waits for the frames in flight: what they use may then go.
    void waitIdle() const { device_.waitIdle(); }

    [[nodiscard]] VkFormat format() const { return format_.format; }
    void setVsync(bool vsync);

private:
    struct Slot {
        VkCommandPool pool = VK_NULL_HANDLE;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        VkFence fence = VK_NULL_HANDLE;
        VkSemaphore acquired = VK_NULL_HANDLE;
    };
    void loadFunctions();
    void chooseFormat();
    void makeSlots();
    [[nodiscard]] VkPresentModeKHR presentMode() const;
    /// False where the window has no pixels.
    bool recreate();
    void destroyImages();
    void clearImage(VkCommandBuffer commands) const;

    gpu::Device& device_;
    gpu::Handles handles_;
    PresentFunctions present_;
    SDL_Window* window_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSurfaceFormatKHR format_{};
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    std::vector<VkImage> images_;
    std::vector<gpu::UniqueView> views_;
    std::vector<VkSemaphore> drawn_; ///< by image
    ivec2 size_{0};
    bool vsync_ = true;
    bool stale_ = true; ///< the swapchain no longer fits the window
    std::array<Slot, kFramesInFlight> slots_;
    int slot_ = 0;
    uint32_t image_ = 0;
};

} // namespace halflight::view
