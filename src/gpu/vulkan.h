#pragma once
// Vulkan 1.3 without the C++ bindings (they cost seconds per source file): the C header, a table of the functions used,
// and errors as exceptions. Nothing thrown here leaves the modules that use src/gpu: they catch Failure at their public
// functions and return ErrorCode::DeviceFailed.

#ifndef VK_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#endif
#include <vulkan/vulkan_core.h>

#include <stdexcept>
#include <string>

namespace halflight::gpu {

/// What went wrong with the device, as one sentence.
struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// DeviceOptions::mostBytes do not suffice.
struct LimitReached : Failure {
    using Failure::Failure;
};

/// The result's name, e.g. "VK_ERROR_DEVICE_LOST".
std::string resultName(VkResult result);

/// Throws Failure unless `result` is VK_SUCCESS. `action` completes the sentence "the Vulkan driver could not …".
void check(VkResult result, const char* action);

// Functions by how they are looked up. A function that a source file needs is added here, and nowhere else.
#define HALFLIGHT_VULKAN_GLOBAL_FUNCTIONS(X)                                                                           \
    X(CreateInstance) X(EnumerateInstanceVersion) X(EnumerateInstanceLayerProperties)
#define HALFLIGHT_VULKAN_INSTANCE_FUNCTIONS(X)                                                                         \
    X(DestroyInstance)                                                                                                 \
    X(EnumeratePhysicalDevices)                                                                                        \
    X(GetPhysicalDeviceProperties)                                                                                     \
    X(GetPhysicalDeviceProperties2)                                                                                    \
    X(GetPhysicalDeviceFeatures2)                                                                                      \
    X(GetPhysicalDeviceFormatProperties)                                                                               \
    X(GetPhysicalDeviceImageFormatProperties)                                                                          \
    X(GetPhysicalDeviceMemoryProperties)                                                                               \
    X(GetPhysicalDeviceQueueFamilyProperties)                                                                          \
    X(EnumerateDeviceExtensionProperties)                                                                              \
    X(CreateDevice)                                                                                                    \
    X(GetDeviceProcAddr)                                                                                               \
    X(CreateDebugUtilsMessengerEXT)                                                                                    \
    X(DestroyDebugUtilsMessengerEXT)
#define HALFLIGHT_VULKAN_DEVICE_FUNCTIONS(X)                                                                           \
    X(DestroyDevice)                                                                                                   \
    X(DeviceWaitIdle)                                                                                                  \
    X(GetDeviceQueue)                                                                                                  \
    X(QueueSubmit2)                                                                                                    \
    X(AllocateMemory)                                                                                                  \
    X(FreeMemory)                                                                                                      \
    X(MapMemory)                                                                                                       \
    X(CreateBuffer)                                                                                                    \
    X(DestroyBuffer)                                                                                                   \
    X(GetBufferMemoryRequirements)                                                                                     \
    X(BindBufferMemory)                                                                                                \
    X(GetBufferDeviceAddress)                                                                                          \
    X(CreateAccelerationStructureKHR)                                                                                  \
    X(DestroyAccelerationStructureKHR)                                                                                 \
    X(GetAccelerationStructureBuildSizesKHR)                                                                           \
    X(GetAccelerationStructureDeviceAddressKHR)                                                                        \
    X(CreateImage)                                                                                                     \
    X(DestroyImage)                                                                                                    \
    X(GetImageMemoryRequirements)                                                                                      \
    X(BindImageMemory)                                                                                                 \
    X(CreateImageView)                                                                                                 \
    X(DestroyImageView)                                                                                                \
    X(CreateSampler)                                                                                                   \
    X(DestroySampler)                                                                                                  \
    X(CreateShaderModule)                                                                                              \
    X(DestroyShaderModule)                                                                                             \
    X(CreateDescriptorSetLayout)                                                                                       \
    X(DestroyDescriptorSetLayout)                                                                                      \
    X(CreateDescriptorPool)                                                                                            \
    X(DestroyDescriptorPool)                                                                                           \
    X(AllocateDescriptorSets)                                                                                          \
    X(UpdateDescriptorSets)                                                                                            \
    X(CreatePipelineLayout)                                                                                            \
    X(DestroyPipelineLayout)                                                                                           \
    X(CreateGraphicsPipelines)                                                                                         \
    X(CreateComputePipelines)                                                                                          \
    X(CreateRayTracingPipelinesKHR)                                                                                    \
    X(GetRayTracingShaderGroupHandlesKHR)                                                                              \
    X(DestroyPipeline)                                                                                                 \
    X(CreateQueryPool)                                                                                                 \
    X(DestroyQueryPool)                                                                                                \
    X(GetQueryPoolResults)                                                                                             \
    X(CreateCommandPool)                                                                                               \
    X(DestroyCommandPool)                                                                                              \
    X(ResetCommandPool)                                                                                                \
    X(AllocateCommandBuffers)                                                                                          \
    X(BeginCommandBuffer)                                                                                              \
    X(EndCommandBuffer)                                                                                                \
    X(CreateFence)                                                                                                     \
    X(DestroyFence)                                                                                                    \
    X(ResetFences)                                                                                                     \
    X(WaitForFences)                                                                                                   \
    X(CmdPipelineBarrier2)                                                                                             \
    X(CmdCopyBuffer)                                                                                                   \
    X(CmdCopyBufferToImage)                                                                                            \
    X(CmdCopyImageToBuffer)                                                                                            \
    X(CmdBeginRendering)                                                                                               \
    X(CmdEndRendering)                                                                                                 \
    X(CmdBindPipeline)                                                                                                 \
    X(CmdBindDescriptorSets)                                                                                           \
    X(CmdBindVertexBuffers)                                                                                            \
    X(CmdBindIndexBuffer)                                                                                              \
    X(CmdPushConstants)                                                                                                \
    X(CmdSetViewport)                                                                                                  \
    X(CmdSetScissor)                                                                                                   \
    X(CmdSetCullMode)                                                                                                  \
    X(CmdSetFrontFace)                                                                                                 \
    X(CmdSetDepthBias)                                                                                                 \
    X(CmdBuildAccelerationStructuresKHR)                                                                               \
    X(CmdDispatch)                                                                                                     \
    X(CmdTraceRaysKHR)                                                                                                 \
    X(CmdDraw)                                                                                                         \
    X(CmdDrawIndexed)                                                                                                  \
    X(CmdResetQueryPool)                                                                                               \
    X(CmdWriteTimestamp2)

/// Entry points, filled by Device. Called as vk.CmdDraw(…).
struct Functions {
    PFN_vkGetInstanceProcAddr GetInstanceProcAddr = nullptr;
#define HALFLIGHT_VULKAN_MEMBER(name) PFN_vk##name name = nullptr;
    HALFLIGHT_VULKAN_GLOBAL_FUNCTIONS(HALFLIGHT_VULKAN_MEMBER)
    HALFLIGHT_VULKAN_INSTANCE_FUNCTIONS(HALFLIGHT_VULKAN_MEMBER)
    HALFLIGHT_VULKAN_DEVICE_FUNCTIONS(HALFLIGHT_VULKAN_MEMBER)
#undef HALFLIGHT_VULKAN_MEMBER
};

} // namespace halflight::gpu
