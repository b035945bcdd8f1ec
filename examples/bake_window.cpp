// A window that bakes a glTF file while one looks around: SDL2, a swapchain, Renderer::record() and BakeSession.
// Usage: bake_window SCENE.glb BAKED.glb [once]      dragging turns; "once" ends when the bake has
#include "halflight/bake/bake_session.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"
#include "halflight/render/vulkan_target.h"
#include "halflight/scene/gltf.h"

#include <SDL.h>
#include <SDL_vulkan.h>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

using namespace halflight;

namespace {

// clang-format off
#define VULKAN_FUNCTIONS(X)                                                                                            \
    X(GetPhysicalDeviceSurfaceSupportKHR)                                                                              \
    X(GetPhysicalDeviceSurfaceCapabilitiesKHR) X(GetPhysicalDeviceSurfaceFormatsKHR) X(CreateSwapchainKHR)             \
        X(DestroySwapchainKHR) X(DestroySurfaceKHR) X(GetSwapchainImagesKHR) X(AcquireNextImageKHR) X(QueuePresentKHR) \
            X(QueueSubmit2) X(CreateImageView) X(DestroyImageView) X(CreateSemaphore) X(DestroySemaphore)              \
                X(CreateCommandPool) X(DestroyCommandPool) X(AllocateCommandBuffers) X(BeginCommandBuffer)             \
                    X(EndCommandBuffer) X(CmdPipelineBarrier2)

void check(VkResult result, const char* what) { if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR) throw std::runtime_error(what); }
void check(const Status& status) { if (!status) throw std::runtime_error(status.error().text()); }
template<typename T> T checked(Result<T> result) { check(result ? Status() : Status(result.error())); return std::move(*result); }

/// The window's images, one frame after the other: two in flight would be faster. The window keeps its size.
class Presenter {
public:
    Presenter(const VulkanHandles& handles, SDL_Window* window) : h(handles)
    {
#define LOAD(name) name = reinterpret_cast<PFN_vk##name>(h.getInstanceProcAddr(h.instance, "vk" #name));
        VULKAN_FUNCTIONS(LOAD)
        if (!SDL_Vulkan_CreateSurface(window, h.instance, &surface)) throw std::runtime_error(SDL_GetError());
        VkBool32 supported = VK_FALSE;
        GetPhysicalDeviceSurfaceSupportKHR(h.physicalDevice, h.queueFamily, surface, &supported);
        if (!supported) throw std::runtime_error("the device cannot draw into the window");
        VkSurfaceCapabilitiesKHR limits{};
        check(GetPhysicalDeviceSurfaceCapabilitiesKHR(h.physicalDevice, surface, &limits), "look at the window");
        uint32_t count = 1;
        GetPhysicalDeviceSurfaceFormatsKHR(h.physicalDevice, surface, &count, &format); // the first one will do
        size = {int(limits.currentExtent.width), int(limits.currentExtent.height)};
        const VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR, nullptr, 0, surface,
            limits.minImageCount + 1, format.format, format.colorSpace, limits.currentExtent, 1,
            VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_SHARING_MODE_EXCLUSIVE, 0, nullptr, limits.currentTransform,
            VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR, VK_PRESENT_MODE_FIFO_KHR, VK_TRUE, {}};
        check(CreateSwapchainKHR(h.device, &info, nullptr, &swapchain), "make a swapchain");
        GetSwapchainImagesKHR(h.device, swapchain, &count, nullptr);
        images.resize(count), views.resize(count);
        GetSwapchainImagesKHR(h.device, swapchain, &count, images.data());
        const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, nullptr, 0};
        for (uint32_t i = 0; i < count; ++i) {
            const VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, nullptr, 0, images[i],
                VK_IMAGE_VIEW_TYPE_2D, format.format, {}, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
            check(CreateImageView(h.device, &view, nullptr, &views[i]), "make a view");
        }
        check(CreateSemaphore(h.device, &semaphore, nullptr, &acquired), "make a semaphore");
        const VkCommandPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr,
            VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, h.queueFamily};
        check(CreateCommandPool(h.device, &poolInfo, nullptr, &pool), "make a command pool");
        const VkCommandBufferAllocateInfo one{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
            VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        check(AllocateCommandBuffers(h.device, &one, &commands), "make a command buffer");
    }
    ~Presenter()
    {
        DestroyCommandPool(h.device, pool, nullptr);
        DestroySemaphore(h.device, acquired, nullptr);
        for (VkImageView view : views) DestroyImageView(h.device, view, nullptr);
        DestroySwapchainKHR(h.device, swapchain, nullptr);
        DestroySurfaceKHR(h.instance, surface, nullptr);
    }

    /// One frame: record(commands, target) draws it, idle() waits until it is drawn.
    template<typename Record, typename Idle> void show(const Record& record, const Idle& idle)
    {
        uint32_t i = 0;
        check(AcquireNextImageKHR(h.device, swapchain, ~0ull, acquired, VK_NULL_HANDLE, &i), "acquire an image");
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
            VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, nullptr};
        check(BeginCommandBuffer(commands, &begin), "record");
        constexpr VkPipelineStageFlags2 kOutput = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
        const auto barrier = [&](VkImageLayout from, VkImageLayout to, VkAccessFlags2 before, VkAccessFlags2 after) {
            const VkImageMemoryBarrier2 image{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2, nullptr, kOutput, before,
                kOutput, after, from, to, VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED, images[i],
                {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
            const VkDependencyInfo info{ VK_STRUCTURE_TYPE_DEPENDENCY_INFO, nullptr, 0, 0, nullptr, 0, nullptr, 1,
                &image};
            CmdPipelineBarrier2(commands, &info);
        };
        constexpr VkAccessFlags2 kDraws = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
            VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
        barrier(VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, 0, kDraws);
        record(commands, VulkanTarget{views[i], format.format});
        barrier(VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, kDraws, 0);
        check(EndCommandBuffer(commands), "record");
        const VkSemaphoreSubmitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO, nullptr, acquired, 0, kOutput, 0};
        const VkCommandBufferSubmitInfo work{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, nullptr, commands, 0};
        const VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2, nullptr, 0, 1, &wait, 1, &work, 0, nullptr};
        check(QueueSubmit2(h.queue, 1, &submit, VK_NULL_HANDLE), "submit");
        idle();
        const VkPresentInfoKHR present{ VK_STRUCTURE_TYPE_PRESENT_INFO_KHR, nullptr, 0, nullptr, 1, &swapchain, &i,
            nullptr};
        check(QueuePresentKHR(h.queue, &present), "show");
    }

    ivec2 size{0};

private:
#define DECLARE(name) PFN_vk##name name = nullptr;
    VULKAN_FUNCTIONS(DECLARE)
    VulkanHandles h;
    VkSurfaceKHR surface{};
    VkSurfaceFormatKHR format{};
    VkSwapchainKHR swapchain{};
    std::vector<VkImage> images;
    std::vector<VkImageView> views;
    VkCommandPool pool{};
    VkCommandBuffer commands{};
    VkSemaphore acquired{};
};

// clang-format on
void run(const char* scenePath, const char* bakedPath, bool once)
{
    SDL_SetMainReady();
    if (SDL_Init(SDL_INIT_VIDEO) != 0) throw std::runtime_error(SDL_GetError());
    SDL_Window* window = SDL_CreateWindow("bake_window", 0, 0, 640, 360, SDL_WINDOW_VULKAN);
    if (window == nullptr) throw std::runtime_error(SDL_GetError());
    const Scene scene = checked(readScene(scenePath));
    RendererOptions options;
    unsigned count = 0;
    SDL_Vulkan_GetInstanceExtensions(window, &count, nullptr);
    std::vector<const char*> names(count);
    SDL_Vulkan_GetInstanceExtensions(window, &count, names.data());
    options.instanceExtensions = {names.begin(), names.end()};
    options.deviceExtensions = {VK_KHR_SWAPCHAIN_EXTENSION_NAME};
    const std::unique_ptr<Renderer> renderer = checked(Renderer::create(options));
    Presenter presenter(renderer->handles(), window);

    BakeSettings settings{.quality = Quality::Preview, .lightmapSize = 128};
    BakeSession session(scene, settings, embreeIntegrators());
    RenderSettings view{.size = presenter.size};
    float yaw = 0.8f, distance = 0.9f * glm::length(scene.bounds().size()), exposure = 0.0f;
    Camera camera;
    const auto load = [&](const BakedScene& baked) {
        check(renderer->load(baked));
        view.mode = defaultRunMode(baked);
        exposure = automaticExposure(checked(renderer->render(camera, view)).radiance);
    };
    for (bool quits = false, first = true, finished = false; !quits; first = false) {
        for (SDL_Event event; SDL_PollEvent(&event) != 0;) {
            if (event.type == SDL_QUIT) quits = true;
            if (event.type == SDL_MOUSEMOTION && event.motion.state != 0) yaw -= 0.005f * float(event.motion.xrel);
        }
        const vec3 center = scene.bounds().center();
        const vec3 away(0.8f * std::sin(yaw), 0.6f, 0.8f * std::cos(yaw));
        camera.worldFromCamera = glm::inverse(glm::lookAt(center + distance * away, center, vec3(0, 1, 0)));
        session.setView(camera, float(view.size.x) / float(view.size.y));
        if (first) load(BakedScene{.scene = scene});
        if (auto light = session.takeLight(); light || (light = session.takeProbeLight())) load(*light);
        for (const LightTile& tile : session.takeTiles()) {
            const LightmapRectangle rectangle{tile.page, tile.offset, &tile.texels};
            check(renderer->updateLightmaps({&rectangle, 1})); // many at once would be faster
        }
        if (!finished && (finished = session.state().finished)) {
            const BakeResult result = checked(session.takeResult());
            load(result.baked);
            check(writeBakedScene(bakedPath, result.baked, {.irradiance = result.irradiance}));
            std::printf("%s\n", bakedPath);
            quits = once;
        }
        const auto record = [&](VkCommandBuffer commands, const VulkanTarget& target) {
            (void)checked(renderer->record(commands, target, camera, view, exposure));
        };
        presenter.show(record, [&] { renderer->waitIdle(); });
    }
}

} // namespace

int main(int count, char** arguments)
{
    if (count < 3) return std::fprintf(stderr, "usage: bake_window SCENE.glb BAKED.glb [once]\n"), 2;
    try {
        run(arguments[1], arguments[2], count > 3 && std::strcmp(arguments[3], "once") == 0);
    } catch (const std::exception& problem) {
        return std::fprintf(stderr, "bake_window: %s\n", problem.what()), 1;
    }
    return 0;
}
