#include "view/window/swapchain.h"

#include <SDL.h>
#include <SDL_vulkan.h>

#include <algorithm>
#include <string>

namespace halflight::view {
namespace {

void imageBarrier(const gpu::Device& device, VkCommandBuffer commands, VkImage image, const gpu::ImageState& before,
                  const gpu::ImageState& after)
{
    gpu::transition(device, commands, image, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}, before, after);
}

/// Drawing waits for the acquired image in this stage.
constexpr gpu::ImageState kAcquired{VK_IMAGE_LAYOUT_UNDEFINED, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                    VK_ACCESS_2_NONE};
constexpr gpu::ImageState kPresented{VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE};

} // namespace

Swapchain::Swapchain(gpu::Device& device, SDL_Window* window)
    : device_(device), handles_(device.handles()), window_(window)
{
    loadFunctions();
    if (!SDL_Vulkan_CreateSurface(window, handles_.instance, &surface_))
        throw gpu::Failure(std::string("the window has no Vulkan surface: ") + SDL_GetError());
    VkBool32 supported = VK_FALSE;
    present_.GetPhysicalDeviceSurfaceSupportKHR(handles_.physicalDevice, handles_.queueFamily, surface_, &supported);
    if (!supported) throw gpu::Failure("the Vulkan device cannot draw into the window; try --device cpu");
    chooseFormat();
    makeSlots();
}

Swapchain::~Swapchain()
{
    {
        const auto lock = device_.lockQueue();
        device_.vk.DeviceWaitIdle(device_.handle());
    }
    destroyImages();
    if (swapchain_) present_.DestroySwapchainKHR(device_.handle(), swapchain_, nullptr);
    for (const Slot& slot : slots_) {
        if (slot.acquired) present_.DestroySemaphore(device_.handle(), slot.acquired, nullptr);
        if (slot.fence) device_.vk.DestroyFence(device_.handle(), slot.fence, nullptr);
        if (slot.pool) device_.vk.DestroyCommandPool(device_.handle(), slot.pool, nullptr);
    }
    if (surface_) present_.DestroySurfaceKHR(handles_.instance, surface_, nullptr);
}

void Swapchain::loadFunctions()
{
#define HALFLIGHT_LOAD(name)                                                                                           \
    present_.name = reinterpret_cast<PFN_vk##name>(handles_.getInstanceProcAddr(handles_.instance, "vk" #name));       \
    if (!present_.name) throw gpu::Failure("the Vulkan loader has no vk" #name);
    HALFLIGHT_LOAD(DestroySurfaceKHR)
    HALFLIGHT_LOAD(GetPhysicalDeviceSurfaceSupportKHR)
    HALFLIGHT_LOAD(GetPhysicalDeviceSurfaceCapabilitiesKHR)
    HALFLIGHT_LOAD(GetPhysicalDeviceSurfaceFormatsKHR)
    HALFLIGHT_LOAD(GetPhysicalDeviceSurfacePresentModesKHR)
    HALFLIGHT_LOAD(GetDeviceProcAddr)
#undef HALFLIGHT_LOAD
#define HALFLIGHT_LOAD(name)                                                                                           \
    present_.name = reinterpret_cast<PFN_vk##name>(present_.GetDeviceProcAddr(handles_.device, "vk" #name));           \
    if (!present_.name) throw gpu::Failure("the Vulkan device has no vk" #name);
    HALFLIGHT_LOAD(CreateSwapchainKHR)
    HALFLIGHT_LOAD(DestroySwapchainKHR)
    HALFLIGHT_LOAD(GetSwapchainImagesKHR)
    HALFLIGHT_LOAD(AcquireNextImageKHR)
    HALFLIGHT_LOAD(QueuePresentKHR)
    HALFLIGHT_LOAD(CreateSemaphore)
    HALFLIGHT_LOAD(DestroySemaphore)
#undef HALFLIGHT_LOAD
}

void Swapchain::chooseFormat()
{
    uint32_t count = 0;
    present_.GetPhysicalDeviceSurfaceFormatsKHR(handles_.physicalDevice, surface_, &count, nullptr);
    std::vector<VkSurfaceFormatKHR> formats(count);
    present_.GetPhysicalDeviceSurfaceFormatsKHR(handles_.physicalDevice, surface_, &count, formats.data());
    // Panels are blended in encoded colours, so the format must not encode.
    const auto fits = [](const VkSurfaceFormatKHR& format) {
        return format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM;
    };
    const auto found = std::find_if(formats.begin(), formats.end(), fits);
    if (found == formats.end()) throw gpu::Failure("the window has no surface of 8 bits a channel");
    format_ = *found;
}

void Swapchain::makeSlots()
{
    const gpu::Functions& vk = device_.vk;
    for (Slot& slot : slots_) {
        const VkCommandPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                               .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                               .queueFamilyIndex = handles_.queueFamily};
        gpu::check(vk.CreateCommandPool(device_.handle(), &poolInfo, nullptr, &slot.pool), "create a command pool");
        const VkCommandBufferAllocateInfo commandInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                      .commandPool = slot.pool,
                                                      .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                      .commandBufferCount = 1};
        gpu::check(vk.AllocateCommandBuffers(device_.handle(), &commandInfo, &slot.commands), "create commands");
        const VkFenceCreateInfo fenceInfo{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO,
                                          .flags = VK_FENCE_CREATE_SIGNALED_BIT};
        gpu::check(vk.CreateFence(device_.handle(), &fenceInfo, nullptr, &slot.fence), "create a fence");
        const VkSemaphoreCreateInfo semaphoreInfo{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
        gpu::check(present_.CreateSemaphore(device_.handle(), &semaphoreInfo, nullptr, &slot.acquired),
                   "create a semaphore");
    }
}

VkPresentModeKHR Swapchain::presentMode() const
{
    if (vsync_) return VK_PRESENT_MODE_FIFO_KHR;
    uint32_t count = 0;
    present_.GetPhysicalDeviceSurfacePresentModesKHR(handles_.physicalDevice, surface_, &count, nullptr);
    std::vector<VkPresentModeKHR> modes(count);
    present_.GetPhysicalDeviceSurfacePresentModesKHR(handles_.physicalDevice, surface_, &count, modes.data());
    for (const VkPresentModeKHR mode : {VK_PRESENT_MODE_MAILBOX_KHR, VK_PRESENT_MODE_IMMEDIATE_KHR})
        if (std::find(modes.begin(), modes.end(), mode) != modes.end()) return mode;
    return VK_PRESENT_MODE_FIFO_KHR;
}

void Swapchain::setVsync(bool vsync)
{
    stale_ = stale_ || vsync != vsync_;
    vsync_ = vsync;
}

void Swapchain::destroyImages()
{
    views_.clear();
    for (VkSemaphore semaphore : drawn_) present_.DestroySemaphore(device_.handle(), semaphore, nullptr);
    drawn_.clear();
}

bool Swapchain::recreate()
{
    VkSurfaceCapabilitiesKHR limits{};
    gpu::check(present_.GetPhysicalDeviceSurfaceCapabilitiesKHR(handles_.physicalDevice, surface_, &limits),
               "look at the window");
    VkExtent2D extent = limits.currentExtent;
    if (extent.width == ~0u) { // the window takes the size of its images
        int width = 0;
        int height = 0;
        SDL_Vulkan_GetDrawableSize(window_, &width, &height);
        extent.width = std::clamp(uint32_t(width), limits.minImageExtent.width, limits.maxImageExtent.width);
        extent.height = std::clamp(uint32_t(height), limits.minImageExtent.height, limits.maxImageExtent.height);
    }
    if (extent.width == 0 || extent.height == 0) return false;

    device_.waitIdle();
    destroyImages();
    const uint32_t most = limits.maxImageCount > 0 ? limits.maxImageCount : ~0u;
    VkSwapchainKHR earlier = swapchain_;
    const VkSwapchainCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                        .surface = surface_,
                                        .minImageCount = std::min(limits.minImageCount + 1, most),
                                        .imageFormat = format_.format,
                                        .imageColorSpace = format_.colorSpace,
                                        .imageExtent = extent,
                                        .imageArrayLayers = 1,
                                        .imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                                        .imageSharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                        .preTransform = limits.currentTransform,
                                        .compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR,
                                        .presentMode = presentMode(),
                                        .clipped = VK_TRUE,
                                        .oldSwapchain = earlier};
    gpu::check(present_.CreateSwapchainKHR(device_.handle(), &info, nullptr, &swapchain_), "create a swapchain");
    if (earlier) present_.DestroySwapchainKHR(device_.handle(), earlier, nullptr);
    uint32_t count = 0;
    present_.GetSwapchainImagesKHR(device_.handle(), swapchain_, &count, nullptr);
    images_.resize(count);
    present_.GetSwapchainImagesKHR(device_.handle(), swapchain_, &count, images_.data());
    for (VkImage image : images_) {
        const VkImageViewCreateInfo viewInfo{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                             .image = image,
                                             .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                             .format = format_.format,
                                             .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
        VkImageView view = VK_NULL_HANDLE;
        gpu::check(device_.vk.CreateImageView(device_.handle(), &viewInfo, nullptr, &view), "create an image view");
        views_.emplace_back(device_, view);
        const VkSemaphoreCreateInfo semaphoreInfo{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
        gpu::check(present_.CreateSemaphore(device_.handle(), &semaphoreInfo, nullptr, &drawn_.emplace_back()),
                   "create a semaphore");
    }
    size_ = {int(extent.width), int(extent.height)};
    stale_ = false;
    return true;
}

std::optional<Swapchain::Frame> Swapchain::begin()
{
    Slot& slot = slots_[std::size_t(slot_)];
    gpu::check(device_.vk.WaitForFences(device_.handle(), 1, &slot.fence, VK_TRUE, ~0ull), "finish a frame");
    constexpr int kTries = 3; // the window may change again meanwhile; the next frame tries again
    VkResult acquired = VK_ERROR_OUT_OF_DATE_KHR;
    for (int i = 0; i < kTries && acquired == VK_ERROR_OUT_OF_DATE_KHR; ++i) {
        if ((stale_ || i > 0) && !recreate()) return std::nullopt;
        acquired =
            present_.AcquireNextImageKHR(device_.handle(), swapchain_, ~0ull, slot.acquired, VK_NULL_HANDLE, &image_);
    }
    if (acquired == VK_ERROR_OUT_OF_DATE_KHR) return std::nullopt;
    if (acquired == VK_SUBOPTIMAL_KHR)
        stale_ = true;
    else
        gpu::check(acquired, "acquire an image of the window");

    gpu::check(device_.vk.ResetFences(device_.handle(), 1, &slot.fence), "reset a fence");
    gpu::check(device_.vk.ResetCommandPool(device_.handle(), slot.pool, 0), "reset a command pool");
    const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    gpu::check(device_.vk.BeginCommandBuffer(slot.commands, &begin), "begin recording commands");
    clearImage(slot.commands);
    return Frame{slot.commands, views_[image_].get(), size_, slot_};
}

void Swapchain::clearImage(VkCommandBuffer commands) const
{
    imageBarrier(device_, commands, images_[image_], kAcquired, gpu::state::kColorAttachment);
    const VkRenderingAttachmentInfo attachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                               .imageView = views_[image_].get(),
                                               .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                               .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, {uint32_t(size_.x), uint32_t(size_.y)}},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &attachment};
    device_.vk.CmdBeginRendering(commands, &rendering);
    device_.vk.CmdEndRendering(commands);
    imageBarrier(device_, commands, images_[image_], gpu::state::kColorAttachment, gpu::state::kColorAttachment);
}

void Swapchain::end()
{
    Slot& slot = slots_[std::size_t(slot_)];
    imageBarrier(device_, slot.commands, images_[image_], gpu::state::kColorAttachment, kPresented);
    gpu::check(device_.vk.EndCommandBuffer(slot.commands), "record commands");
    const VkCommandBufferSubmitInfo commandInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                                .commandBuffer = slot.commands};
    const VkSemaphoreSubmitInfo wait{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                     .semaphore = slot.acquired,
                                     .stageMask = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT};
    const VkSemaphoreSubmitInfo signal{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                       .semaphore = drawn_[image_],
                                       .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    const VkSubmitInfo2 submit{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                               .waitSemaphoreInfoCount = 1,
                               .pWaitSemaphoreInfos = &wait,
                               .commandBufferInfoCount = 1,
                               .pCommandBufferInfos = &commandInfo,
                               .signalSemaphoreInfoCount = 1,
                               .pSignalSemaphoreInfos = &signal};
    const auto lock = device_.lockQueue();
    gpu::check(device_.vk.QueueSubmit2(handles_.queue, 1, &submit, slot.fence), "submit commands");
    const VkPresentInfoKHR info{.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                                .waitSemaphoreCount = 1,
                                .pWaitSemaphores = &drawn_[image_],
                                .swapchainCount = 1,
                                .pSwapchains = &swapchain_,
                                .pImageIndices = &image_};
    const VkResult presented = present_.QueuePresentKHR(handles_.queue, &info);
    if (presented == VK_ERROR_OUT_OF_DATE_KHR || presented == VK_SUBOPTIMAL_KHR)
        stale_ = true;
    else
        gpu::check(presented, "show a frame");
    slot_ = (slot_ + 1) % kFramesInFlight;
}

} // namespace halflight::view
