#pragma once

#include "gpu/vulkan.h"

namespace halflight::gpu {

/// Features asked of every device, chained for vkGetPhysicalDeviceFeatures2 and vkCreateDevice.
struct Features {
    VkPhysicalDeviceVulkan13Features v13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &v13};
    VkPhysicalDeviceVulkan11Features v11{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES, .pNext = &v12};
    VkPhysicalDeviceFeatures2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v11};
    Features() = default;
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;
};

} // namespace halflight::gpu
