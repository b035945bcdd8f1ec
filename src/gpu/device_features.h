#pragma once

#include "gpu/vulkan.h"

#include <string>

namespace halflight::gpu {

/// Features asked of a device, chained for vkGetPhysicalDeviceFeatures2 and vkCreateDevice. Those of ray tracing are at
/// the end, and chained where they are asked for.
struct Features {
    VkPhysicalDeviceAccelerationStructureFeaturesKHR trees{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR rays{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR, .pNext = &trees};
    VkPhysicalDeviceVulkan13Features v13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &v13};
    VkPhysicalDeviceVulkan11Features v11{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES, .pNext = &v12};
    VkPhysicalDeviceFeatures2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v11};
    explicit Features(bool rayTracing)
    {
        if (rayTracing) v13.pNext = &rays;
    }
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;
};

/// The sentence where there is no device at all.
std::string noDevice();

} // namespace halflight::gpu
