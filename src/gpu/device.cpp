#include "gpu/device.h"
#include "gpu/device_features.h"

namespace halflight::gpu {

Device::Device(const DeviceOptions& options) : fails_(options.fails)
{
    try {
        if (options.handles) {
            use(*options.handles);
        } else {
            createInstance(options);
            pickPhysicalDevice(options);
            createDevice(options);
        }
        prepareCommands(options.rayTracing && !options.handles, options.mostBytes);
    } catch (...) {
        destroy();
        throw;
    }
}

Device::~Device()
{
    destroy();
}

void Device::createDevice(const DeviceOptions& options)
{
    Features features(options.rayTracing);
    features.v13.synchronization2 = VK_TRUE;
    if (options.rayTracing) {
        features.v12.bufferDeviceAddress = VK_TRUE;
        features.v12.scalarBlockLayout = VK_TRUE;
        features.v13.maintenance4 = VK_TRUE; // sizes of groups in shaders; every Vulkan 1.3 device has it
        features.trees.accelerationStructure = VK_TRUE;
        features.rays.rayTracingPipeline = VK_TRUE;
    } else {
        features.v13.dynamicRendering = VK_TRUE;
        features.v12.runtimeDescriptorArray = VK_TRUE;
        features.v12.descriptorBindingPartiallyBound = VK_TRUE;
        features.v12.descriptorBindingVariableDescriptorCount = VK_TRUE;
        features.all.features.shaderSampledImageArrayDynamicIndexing = VK_TRUE;
        features.all.features.samplerAnisotropy = anisotropy_;
    }
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queueInfo{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                            .queueFamilyIndex = queueFamily_,
                                            .queueCount = 1,
                                            .pQueuePriorities = &priority};
    std::vector<const char*> extensions;
    for (const std::string& name : options.deviceExtensions) extensions.push_back(name.c_str());
    if (options.rayTracing)
        extensions.insert(extensions.end(),
                          {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
                           VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME});
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .pNext = &features.all,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queueInfo,
                                  .enabledExtensionCount = uint32_t(extensions.size()),
                                  .ppEnabledExtensionNames = extensions.data()};
    check(table_.CreateDevice(physical_, &info, nullptr, &device_), "create a device");
    loadDeviceFunctions();
    vk.GetDeviceQueue(device_, queueFamily_, 0, &queue_);
}

void Device::use(const Handles& handles)
{
    owned_ = false;
    table_.GetInstanceProcAddr = handles.getInstanceProcAddr;
    instance_ = handles.instance;
    physical_ = handles.physicalDevice;
    device_ = handles.device;
    queueFamily_ = handles.queueFamily;
    queue_ = handles.queue;
    if (handles.queueMutex) queueMutex_ = handles.queueMutex;
    anisotropy_ = handles.samplerAnisotropy;
    loadInstanceFunctions();
    loadDeviceFunctions();
    table_.GetPhysicalDeviceProperties(physical_, &properties_);
    uint32_t count = 0;
    table_.GetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    table_.GetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
    if (queueFamily_ >= count) throw Failure("the queue family does not exist");
    timestampBits_ = families[queueFamily_].timestampValidBits;
}

void Device::loadDeviceFunctions()
{
#define HALFLIGHT_VULKAN_LOAD(name)                                                                                    \
    table_.name = reinterpret_cast<PFN_vk##name>(table_.GetDeviceProcAddr(device_, "vk" #name));
    HALFLIGHT_VULKAN_DEVICE_FUNCTIONS(HALFLIGHT_VULKAN_LOAD)
#undef HALFLIGHT_VULKAN_LOAD
}

void Device::prepareCommands(bool addresses, VkDeviceSize mostBytes)
{
    VkPhysicalDeviceMemoryProperties memoryProperties;
    vk.GetPhysicalDeviceMemoryProperties(physical_, &memoryProperties);
    memory_ = std::make_unique<Memory>(vk, device_, memoryProperties, addresses, mostBytes, fails_);

    const VkCommandPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                           .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                           .queueFamilyIndex = queueFamily_};
    check(vk.CreateCommandPool(device_, &poolInfo, nullptr, &commandPool_), "create a command pool");
    const VkCommandBufferAllocateInfo commandInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = commandPool_,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = 1};
    check(vk.AllocateCommandBuffers(device_, &commandInfo, &commands_), "create a command buffer");
    const VkFenceCreateInfo fenceInfo{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(vk.CreateFence(device_, &fenceInfo, nullptr, &fence_), "create a fence");
}

void Device::destroy()
{
    if (device_) {
        {
            const auto lock = lockQueue();
            vk.DeviceWaitIdle(device_);
        }
        if (fence_) vk.DestroyFence(device_, fence_, nullptr);
        if (commandPool_) vk.DestroyCommandPool(device_, commandPool_, nullptr);
        memory_.reset();
        if (owned_) vk.DestroyDevice(device_, nullptr);
    }
    if (messenger_) vk.DestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
    if (instance_ && owned_) vk.DestroyInstance(instance_, nullptr);
    closeLoader();
    device_ = VK_NULL_HANDLE;
    messenger_ = VK_NULL_HANDLE;
    instance_ = VK_NULL_HANDLE;
}

VkFormatFeatureFlags Device::optimalFeatures(VkFormat format) const
{
    VkFormatProperties properties;
    vk.GetPhysicalDeviceFormatProperties(physical_, format, &properties);
    return properties.optimalTilingFeatures;
}

bool Device::hasStorageView(VkFormat format, VkFormat storageFormat) const
{
    if ((optimalFeatures(storageFormat) & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) == 0) return false;
    VkImageFormatProperties properties;
    const VkResult result = vk.GetPhysicalDeviceImageFormatProperties(
        physical_, format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL,
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_STORAGE_BIT,
        VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT, &properties);
    return result == VK_SUCCESS;
}

/// Fills a structure of properties that is chained.
template<typename Properties> Properties Device::chained(Properties properties) const
{
    VkPhysicalDeviceProperties2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &properties};
    vk.GetPhysicalDeviceProperties2(physical_, &all);
    return properties;
}

VkPhysicalDeviceRayTracingPipelinePropertiesKHR Device::rayLimits() const
{
    return chained(VkPhysicalDeviceRayTracingPipelinePropertiesKHR{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR});
}

VkPhysicalDeviceAccelerationStructurePropertiesKHR Device::treeLimits() const
{
    return chained(VkPhysicalDeviceAccelerationStructurePropertiesKHR{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR});
}

std::string Device::driver() const
{
    const auto driver =
        chained(VkPhysicalDeviceDriverProperties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES});
    return std::string(driver.driverName) + " " + driver.driverInfo;
}

void waitForEarlier(const Device& device, VkCommandBuffer commands, VkPipelineStageFlags2 stage, VkAccessFlags2 writes)
{
    const VkMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                   .srcStageMask = stage,
                                   .srcAccessMask = writes,
                                   .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
    const VkDependencyInfo dependency{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    device.vk.CmdPipelineBarrier2(commands, &dependency);
}

void Device::execute(FunctionRef<void(VkCommandBuffer)> record)
{
    const std::lock_guard turn(executing_);
    if (fails_ && fails_()) check(VK_ERROR_DEVICE_LOST, "submit commands");
    check(vk.ResetCommandPool(device_, commandPool_, 0), "reset a command pool");
    const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    check(vk.BeginCommandBuffer(commands_, &begin), "begin recording commands");
    waitForEarlier(*this, commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT);
    record(commands_);
    check(vk.EndCommandBuffer(commands_), "record commands");
    const VkCommandBufferSubmitInfo commandInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                                .commandBuffer = commands_};
    const VkSubmitInfo2 submit{
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commandInfo};
    {
        const auto lock = lockQueue();
        check(vk.QueueSubmit2(queue_, 1, &submit, fence_), "submit commands");
    }
    check(vk.WaitForFences(device_, 1, &fence_, VK_TRUE, ~0ull), "finish its commands");
    check(vk.ResetFences(device_, 1, &fence_), "reset a fence");
}

void Device::waitIdle() const
{
    const auto lock = lockQueue();
    check(vk.DeviceWaitIdle(device_), "finish its commands");
}

Handles Device::handles() const
{
    return {table_.GetInstanceProcAddr, instance_, physical_, device_, queueFamily_, queue_, anisotropy_, queueMutex_};
}

std::vector<std::string> Device::validationMessages() const
{
    const std::lock_guard lock(messages_->mutex);
    return messages_->texts;
}

} // namespace halflight::gpu
