#pragma once
// The Vulkan device of one renderer or baker: instance, device, one queue, memory, and commands that are recorded,
// submitted and waited for.

#include "halflight/base/function_ref.h"

#include "gpu/memory.h"
#include "gpu/vulkan.h"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace halflight::gpu {

/// A device that somebody else made and keeps. `device` has the features that DeviceOptions asks for enabled.
struct Handles {
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    uint32_t queueFamily = 0; ///< can draw and run compute shaders
    VkQueue queue = VK_NULL_HANDLE;
    bool samplerAnisotropy = false;         ///< the feature is enabled
    std::shared_ptr<std::mutex> queueMutex; ///< held for each use of the queue; null: the Device makes one
};

struct DeviceOptions {
    bool validation = false; ///< Khronos validation layer with synchronization validation
    bool preferCpu = false;  ///< a CPU driver before any GPU
    bool rayTracing = false; ///< for bakes: ray-tracing pipelines and compute shaders in place of drawing
    std::string name;        ///< part of the device's or driver's name; empty: the best one, for rays a GPU alone
    std::vector<std::string> instanceExtensions; ///< enabled besides the device's own
    std::vector<std::string> deviceExtensions;
    VkDeviceSize mostBytes = 0; ///< of the device's own memory that may be taken; 0 = no limit
    /// For tests: asked before memory is taken and before commands are submitted. True: it fails as if the device had
    /// no memory left, or was lost.
    std::function<bool()> fails;
    /// Used instead of a device of its own; the options above then have no effect.
    std::optional<Handles> handles;
};

class Device {
public:
    /// Throws Failure when there is no loader, no driver, or no Vulkan 1.3 device with the features named in
    /// device.cpp.
    explicit Device(const DeviceOptions& options);
    struct Description {
        std::string name;    ///< with its driver's name and version
        std::string refusal; ///< why `options` do not take it, as what follows its name; empty: they may
    };
    /// All devices, the best one first. Throws Failure where there is no loader.
    static std::vector<Description> list(const DeviceOptions& options);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const Functions& vk = table_;

    [[nodiscard]] VkDevice handle() const { return device_; }
    [[nodiscard]] Handles handles() const;
    [[nodiscard]] Memory& memory() const { return *memory_; }
    [[nodiscard]] const VkPhysicalDeviceProperties& properties() const { return properties_; }
    /// The driver's name and version as it gives them: "NVIDIA 570.86.15", "llvmpipe Mesa 25.0.7 (LLVM 15.0.6)".
    [[nodiscard]] std::string driver() const;
    /// Of devices that trace rays.
    [[nodiscard]] VkPhysicalDeviceRayTracingPipelinePropertiesKHR rayLimits() const;
    [[nodiscard]] VkPhysicalDeviceAccelerationStructurePropertiesKHR treeLimits() const;
    [[nodiscard]] VkFormatFeatureFlags optimalFeatures(VkFormat format) const;
    /// Whether shaders can write into sampled images of `format` as if they were of `storageFormat`.
    [[nodiscard]] bool hasStorageView(VkFormat format, VkFormat storageFormat) const;
    [[nodiscard]] bool anisotropy() const { return anisotropy_; }
    [[nodiscard]] bool timestamps() const { return timestampBits_ > 0; }

    /// Records commands, submits them and waits until the device has done them. They begin after all commands that
    /// were submitted to the queue before. Any thread may call it; the calls take turns.
    void execute(FunctionRef<void(VkCommandBuffer)> record);

    /// Waits until the device has done all that was submitted to it.
    void waitIdle() const;
    /// Vulkan lets one thread at a time use the queue.
    [[nodiscard]] std::unique_lock<std::mutex> lockQueue() const { return std::unique_lock(*queueMutex_); }

    /// What the validation layer said so far.
    [[nodiscard]] std::vector<std::string> validationMessages() const;

private:
    Device() = default;
    struct Messages {
        std::mutex mutex;
        std::vector<std::string> texts;
    };
    static VkBool32 VKAPI_PTR onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                        const VkDebugUtilsMessengerCallbackDataEXT*, void*);
    void createInstance(const DeviceOptions& options);
    struct Candidate {
        VkPhysicalDeviceProperties properties{};
        std::string driver; ///< its name and version
        uint32_t queueFamily = 0;
        uint32_t timestampBits = 0;
        bool anisotropy = false;
    };
    [[nodiscard]] std::vector<VkPhysicalDevice> physicalDevices() const;
    std::string refusalOf(VkPhysicalDevice device, const DeviceOptions& options, Candidate& out) const;
    void pickPhysicalDevice(const DeviceOptions& options);
    template<typename Properties> Properties chained(Properties properties) const;
    void createDevice(const DeviceOptions& options);
    void use(const Handles& handles);
    void loadInstanceFunctions();
    void loadDeviceFunctions();
    void prepareCommands(bool addresses, VkDeviceSize mostBytes);
    void destroy();
    void closeLoader();

    Functions table_;
    void* library_ = nullptr;
    std::unique_ptr<Messages> messages_ = std::make_unique<Messages>();
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    uint32_t queueFamily_ = 0;
    uint32_t timestampBits_ = 0;
    bool anisotropy_ = false;
    bool owned_ = true; ///< instance and device are this object's own
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::shared_ptr<std::mutex> queueMutex_ = std::make_shared<std::mutex>();
    std::function<bool()> fails_; ///< DeviceOptions::fails
    std::mutex executing_;        ///< commandPool_, commands_ and fence_
    std::unique_ptr<Memory> memory_;
    VkCommandPool commandPool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
};

/// A barrier: all commands that follow see what was written by commands before, in `stage` and by `writes`.
void waitForEarlier(const Device& device, VkCommandBuffer commands, VkPipelineStageFlags2 stage, VkAccessFlags2 writes);

} // namespace halflight::gpu
