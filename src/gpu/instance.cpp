// The loader and the instance.
#include "gpu/device.h"
#include "gpu/device_features.h"

#include <algorithm>
#include <cstring>

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace halflight::gpu {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

#ifdef _WIN32
constexpr const char* kLoader = "vulkan-1.dll";
void* openLoader()
{
    return reinterpret_cast<void*>(LoadLibraryA(kLoader));
}
void* symbol(void* library, const char* name)
{
    return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(library), name));
}
#else
constexpr const char* kLoader = "libvulkan.so.1";
void* openLoader()
{
    for (const char* name : {kLoader, "libvulkan.so", "libvulkan.1.dylib"})
        if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return library;
    return nullptr;
}
void* symbol(void* library, const char* name)
{
    return dlsym(library, name);
}
#endif

/// Keeps the loader and its drivers in memory as long as the process lives, by an instance that is never destroyed:
/// NVIDIA's driver (580.159) takes thread-local storage each time it is loaded, gives none back when it is unloaded
/// with the last instance, and cannot be loaded any more after some twenty times.
void keepDriversLoaded(PFN_vkCreateInstance createInstance)
{
    static const VkInstance kept = [&] {
        openLoader();
        const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                            .apiVersion = VK_API_VERSION_1_3};
        const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                        .pApplicationInfo = &application};
        VkInstance instance = VK_NULL_HANDLE;
        createInstance(&info, nullptr, &instance);
        return instance;
    }();
    (void)kept;
}

} // namespace

VkBool32 VKAPI_PTR Device::onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void* user)
{
    auto& messages = *static_cast<Messages*>(user);
    const std::lock_guard lock(messages.mutex);
    messages.texts.emplace_back(data->pMessage ? data->pMessage : "");
    return VK_FALSE;
}

void Device::createInstance(const DeviceOptions& options)
{
    library_ = openLoader();
    if (!library_)
        throw Failure(std::string("no Vulkan loader found (") + kLoader + "); install it with a Vulkan driver");
    table_.GetInstanceProcAddr = reinterpret_cast<PFN_vkGetInstanceProcAddr>(symbol(library_, "vkGetInstanceProcAddr"));
    if (!table_.GetInstanceProcAddr) throw Failure("the Vulkan loader has no vkGetInstanceProcAddr");
#define HALFLIGHT_VULKAN_LOAD(name)                                                                                    \
    table_.name = reinterpret_cast<PFN_vk##name>(table_.GetInstanceProcAddr(nullptr, "vk" #name));
    HALFLIGHT_VULKAN_GLOBAL_FUNCTIONS(HALFLIGHT_VULKAN_LOAD)
#undef HALFLIGHT_VULKAN_LOAD
    uint32_t version = 0;
    const bool hasVersion = table_.CreateInstance && table_.EnumerateInstanceVersion;
    if (hasVersion && table_.EnumerateInstanceVersion(&version) != VK_SUCCESS) // Wine's, without a driver
        throw Failure(noDevice());
    if (version < VK_API_VERSION_1_1)
        throw Failure("the Vulkan loader is older than 1.1"); // from 1.1 on, a device may have a newer version than it
    keepDriversLoaded(table_.CreateInstance);

    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    for (const std::string& name : options.instanceExtensions) extensions.push_back(name.c_str());
    if (options.validation) {
        uint32_t count = 0;
        table_.EnumerateInstanceLayerProperties(&count, nullptr);
        std::vector<VkLayerProperties> found(count);
        table_.EnumerateInstanceLayerProperties(&count, found.data());
        if (std::none_of(found.begin(), found.end(),
                         [](const auto& layer) { return std::strcmp(layer.layerName, kValidationLayer) == 0; }))
            throw Failure("validation was asked for, but VK_LAYER_KHRONOS_validation is not installed");
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    }

    const VkDebugUtilsMessengerCreateInfoEXT messengerInfo{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = &Device::onMessage,
        .pUserData = messages_.get()};
    const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT validation{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                             .pNext = &messengerInfo,
                                             .enabledValidationFeatureCount = 1,
                                             .pEnabledValidationFeatures = &enabled};
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                        .pApplicationName = "halflight",
                                        .pEngineName = "halflight",
                                        .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                    .pNext = options.validation ? &validation : nullptr,
                                    .pApplicationInfo = &application,
                                    .enabledLayerCount = uint32_t(layers.size()),
                                    .ppEnabledLayerNames = layers.data(),
                                    .enabledExtensionCount = uint32_t(extensions.size()),
                                    .ppEnabledExtensionNames = extensions.data()};
    check(table_.CreateInstance(&info, nullptr, &instance_), "start");
    loadInstanceFunctions();
    if (options.validation)
        check(table_.CreateDebugUtilsMessengerEXT(instance_, &messengerInfo, nullptr, &messenger_),
              "create a debug messenger");
}

void Device::loadInstanceFunctions()
{
#define HALFLIGHT_VULKAN_LOAD(name)                                                                                    \
    table_.name = reinterpret_cast<PFN_vk##name>(table_.GetInstanceProcAddr(instance_, "vk" #name));
    HALFLIGHT_VULKAN_INSTANCE_FUNCTIONS(HALFLIGHT_VULKAN_LOAD)
#undef HALFLIGHT_VULKAN_LOAD
}

void Device::closeLoader()
{
    if (library_ == nullptr) return;
#ifdef _WIN32
    FreeLibrary(static_cast<HMODULE>(library_));
#else
    dlclose(library_);
#endif
    library_ = nullptr;
}

} // namespace halflight::gpu
