#pragma once
// What a program shares with the renderer that draws by Vulkan itself: its device, or the renderer's, and its images.

#include "halflight/base/math.h"

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <memory>
#include <mutex>

namespace halflight {

/// A Vulkan 1.3 device with these features enabled: dynamicRendering, synchronization2, runtimeDescriptorArray,
/// descriptorBindingPartiallyBound, descriptorBindingVariableDescriptorCount, shaderSampledImageArrayDynamicIndexing.
struct VulkanHandles {
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    uint32_t queueFamily = 0; ///< a family that can draw and run compute shaders
    VkQueue queue = VK_NULL_HANDLE;
    bool samplerAnisotropy = false; ///< the feature is enabled
    /// Held for each use of the queue and while the device is waited for, since Vulkan lets one thread at a time do
    /// that. Null in handles given to a renderer: it makes one. A renderer's handles() always have it.
    std::shared_ptr<std::mutex> queueMutex;
};

/// A colour image to draw the displayed picture into, in layout COLOR_ATTACHMENT_OPTIMAL before and after: a
/// swapchain's, say. Formats that encode sRGB are given linear colour, others encoded one.
struct VulkanTarget {
    VkImageView view = VK_NULL_HANDLE; ///< at least as large as `size`; its texel (0, 0) is the picture's top left
    VkFormat format = VK_FORMAT_UNDEFINED;
    ivec2 size{0};  ///< pixels in which the picture is shown, interpolated where they are more; 0: its own
    ivec2 begin{0}; ///< pixels begin <= p < end of those are drawn, the others stay
    ivec2 end{0};   ///< 0: to the end
};

} // namespace halflight
