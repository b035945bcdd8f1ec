// The choice of a physical device.
#include "gpu/device.h"
#include "gpu/device_features.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <optional>
#include <utility>

namespace halflight::gpu {
namespace {

#ifdef _WIN32
constexpr const char* kDriver = "the graphics card's driver has it";
constexpr const char* kNewerDriver = "a newer driver of the graphics card is the cure";
#else
constexpr const char* kDriver = "mesa-vulkan-drivers has one for the CPU";
constexpr const char* kNewerDriver =
    "a newer driver is the cure: on Debian 12, apt install -t bookworm-backports mesa-vulkan-drivers";
#endif

int preference(VkPhysicalDeviceType type, bool preferCpu)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return preferCpu ? 5 : 1;
    default:
        return 0;
    }
}

/// Name of the first feature for drawing that this device lacks, or null.
const char* missingForDrawing(const Features& f)
{
    if (!f.v13.dynamicRendering) return "dynamicRendering";
    if (!f.v13.synchronization2) return "synchronization2";
    if (!f.v12.runtimeDescriptorArray) return "runtimeDescriptorArray";
    if (!f.v12.descriptorBindingPartiallyBound) return "descriptorBindingPartiallyBound";
    if (!f.v12.descriptorBindingVariableDescriptorCount) return "descriptorBindingVariableDescriptorCount";
    if (!f.all.features.shaderSampledImageArrayDynamicIndexing) return "shaderSampledImageArrayDynamicIndexing";
    return nullptr;
}

/// The same for tracing rays.
const char* missingForRays(const Features& f)
{
    if (!f.rays.rayTracingPipeline) return "ray-tracing pipelines";
    if (!f.trees.accelerationStructure) return "acceleration structures";
    if (!f.v12.bufferDeviceAddress) return "bufferDeviceAddress";
    if (!f.v12.scalarBlockLayout) return "scalarBlockLayout";
    if (!f.v13.synchronization2) return "synchronization2";
    return nullptr;
}

bool hasExtension(const Functions& vk, VkPhysicalDevice device, const char* name)
{
    uint32_t count = 0;
    vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> found(count);
    vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, found.data());
    return std::any_of(found.begin(), found.end(),
                       [&](const auto& extension) { return std::strcmp(extension.extensionName, name) == 0; });
}

std::optional<uint32_t> queueFamilyWith(const Functions& vk, VkPhysicalDevice device, VkQueueFlags flags,
                                        uint32_t& timestampBits)
{
    uint32_t count = 0;
    vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    for (uint32_t i = 0; i < count; ++i) {
        if ((families[i].queueFlags & flags) == flags) {
            timestampBits = families[i].timestampValidBits;
            return i;
        }
    }
    return std::nullopt;
}

std::string lower(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

/// Whether a user's name of a device is part of its name or of its driver's. Mesa's driver for the CPU has two.
bool isNamed(const VkPhysicalDeviceProperties& device, const VkPhysicalDeviceDriverProperties& driver,
             const std::string& name)
{
    std::string names = std::string(device.deviceName) + " " + driver.driverName;
    if (driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE) names += " lavapipe";
    return lower(names).find(lower(name)) != std::string::npos;
}

} // namespace

std::string noDevice()
{
    return std::string("no Vulkan device found; install a driver (") + kDriver + ")";
}

std::vector<VkPhysicalDevice> Device::physicalDevices() const
{
    uint32_t count = 0;
    table_.EnumeratePhysicalDevices(instance_, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    if (count > 0) table_.EnumeratePhysicalDevices(instance_, &count, devices.data());
    devices.resize(count);
    return devices;
}

/// Why a device does not serve, as what follows its name; empty where it does.
std::string Device::refusalOf(VkPhysicalDevice device, const DeviceOptions& options, Candidate& out) const
{
    VkPhysicalDeviceDriverProperties driver{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    table_.GetPhysicalDeviceProperties(device, &out.properties);
    if (out.properties.apiVersion < VK_API_VERSION_1_3) return "is older than Vulkan 1.3";
    all.pNext = &driver;
    table_.GetPhysicalDeviceProperties2(device, &all);
    out.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    if (!options.name.empty() && !isNamed(out.properties, driver, options.name)) return "has another name";
    if (options.rayTracing && options.name.empty() && out.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU)
        return "is a driver for the CPU";
    const bool knowsRays = hasExtension(table_, device, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME) &&
                           hasExtension(table_, device, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME) &&
                           hasExtension(table_, device, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    if (options.rayTracing && !knowsRays) return "lacks ray-tracing pipelines";
    Features features(options.rayTracing);
    table_.GetPhysicalDeviceFeatures2(device, &features.all);
    const char* missing = options.rayTracing ? missingForRays(features) : missingForDrawing(features);
    if (missing != nullptr) return std::string("lacks ") + missing;
    const VkQueueFlags flags = VkQueueFlags(VK_QUEUE_COMPUTE_BIT) |
                               (options.rayTracing ? VkQueueFlags(0) : VkQueueFlags(VK_QUEUE_GRAPHICS_BIT));
    const auto family = queueFamilyWith(vk, device, flags, out.timestampBits);
    if (!family) return options.rayTracing ? "cannot compute" : "cannot draw and compute";
    out.queueFamily = *family;
    out.anisotropy = features.all.features.samplerAnisotropy;
    return {};
}

std::vector<Device::Description> Device::list(const DeviceOptions& options)
{
    Device shell;
    shell.createInstance(options);
    std::vector<std::pair<int, Description>> all;
    for (VkPhysicalDevice device : shell.physicalDevices()) {
        Candidate candidate;
        Description description;
        description.refusal = shell.refusalOf(device, options, candidate);
        description.name = candidate.properties.deviceName;
        if (!candidate.driver.empty()) description.name += ", " + candidate.driver;
        const int score = description.refusal.empty() ? preference(candidate.properties.deviceType, false) : -1;
        all.emplace_back(score, std::move(description));
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<Description> sorted;
    for (auto& [score, description] : all) sorted.push_back(std::move(description));
    return sorted;
}

void Device::pickPhysicalDevice(const DeviceOptions& options)
{
    int best = -1;
    std::string refused;
    for (VkPhysicalDevice device : physicalDevices()) {
        Candidate candidate;
        if (const std::string why = refusalOf(device, options, candidate); !why.empty()) {
            refused += (refused.empty() ? "" : "; ") + std::string(candidate.properties.deviceName) + " " + why;
            continue;
        }
        const int score = preference(candidate.properties.deviceType, options.preferCpu);
        if (score <= best) continue;
        best = score;
        physical_ = device;
        properties_ = candidate.properties;
        queueFamily_ = candidate.queueFamily;
        timestampBits_ = candidate.timestampBits;
        anisotropy_ = candidate.anisotropy;
    }
    if (best >= 0) return;
    if (refused.empty()) throw Failure(noDevice());
    if (options.rayTracing) throw Failure("no Vulkan device that traces rays found: " + refused);
    throw Failure("no Vulkan device with the needed features found: " + refused + "; " + kNewerDriver);
}

} // namespace halflight::gpu
