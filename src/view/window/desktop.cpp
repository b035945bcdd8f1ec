#include "view/window/desktop.h"

#include "halflight/render/vulkan_target.h"
#include "view/panels/panels.h"

#include <SDL.h>
#include <SDL_vulkan.h>
#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif

#include <cmath>
#include <utility>

namespace halflight::view {
namespace {

std::unique_ptr<Renderer> rendererFor(const Desktop& desktop, RendererOptions options)
{
    options.instanceExtensions = desktop.vulkanExtensions();
    options.deviceExtensions.emplace_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(options);
    if (!renderer) throw gpu::Failure(renderer.error().message);
    return std::move(*renderer);
}

gpu::DeviceOptions optionsOf(const VulkanHandles& h)
{
    return {.handles = gpu::Handles{h.getInstanceProcAddr, h.instance, h.physicalDevice, h.device, h.queueFamily,
                                    h.queue, h.samplerAnisotropy, h.queueMutex}};
}

} // namespace

Desktop::Desktop(const std::string& title, ivec2 size)
{
    SDL_SetMainReady();
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "0");
    if (SDL_Init(SDL_INIT_VIDEO) != 0)
        throw gpu::Failure(std::string("no window can be opened here: ") + SDL_GetError() +
                           "; halflight render draws without one");
    window_ = SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, size.x, size.y,
                               SDL_WINDOW_VULKAN | SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI);
    if (window_ == nullptr) {
        const std::string why = SDL_GetError();
        close();
        throw gpu::Failure("no window can be opened here: " + why);
    }
    (void)SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER); // the window is of use without
    ImGui::CreateContext();
    hasContext_ = true;
    ImGui::GetIO().IniFilename = nullptr; // leaves no file behind
    ImGui::StyleColorsDark();
    scalePanels();
    ImGui_ImplSDL2_InitForVulkan(window_);
}

/// By GDK_SCALE, which desktops set, else by the display. Where the window has fewer units than pixels, the system
/// scales them already.
void Desktop::scalePanels() const
{
    ivec2 units(0);
    ivec2 pixels(0);
    SDL_GetWindowSize(window_, &units.x, &units.y);
    SDL_Vulkan_GetDrawableSize(window_, &pixels.x, &pixels.y);
    if (units != pixels) return;
    float dotsPerInch = 0.0f;
    (void)SDL_GetDisplayDPI(SDL_GetWindowDisplayIndex(window_), &dotsPerInch, nullptr, nullptr); // else it stays 0
    if (const char* asked = SDL_getenv("GDK_SCALE")) dotsPerInch = kUsualDotsPerInch * float(SDL_atof(asked));
    const float scale = panelScale(dotsPerInch);
    if (scale == 1.0f) return;
    constexpr float kFontPixels = 13.0f; // of Dear ImGui's own font
    ImFontConfig font;
    font.SizePixels = std::round(kFontPixels * scale);
    ImGui::GetIO().Fonts->AddFontDefault(&font);
    ImGui::GetStyle().ScaleAllSizes(scale);
}

Desktop::~Desktop()
{
    close();
}

void Desktop::close()
{
    if (hasContext_) {
        ImGui_ImplSDL2_Shutdown();
        ImGui::DestroyContext();
    }
    gamepad_.reset();
    if (window_ != nullptr) SDL_DestroyWindow(window_);
    SDL_Quit();
}

std::vector<std::string> Desktop::vulkanExtensions() const
{
    unsigned count = 0;
    SDL_Vulkan_GetInstanceExtensions(window_, &count, nullptr);
    std::vector<const char*> names(count);
    SDL_Vulkan_GetInstanceExtensions(window_, &count, names.data());
    return {names.begin(), names.end()};
}

ivec2 Desktop::pixels() const
{
    ivec2 size(1);
    SDL_Vulkan_GetDrawableSize(window_, &size.x, &size.y);
    return glm::max(size, ivec2(1));
}

void Desktop::toggleFullScreen() const
{
    const bool full = (SDL_GetWindowFlags(window_) & SDL_WINDOW_FULLSCREEN_DESKTOP) != 0;
    SDL_SetWindowFullscreen(window_, full ? 0 : SDL_WINDOW_FULLSCREEN_DESKTOP);
}

WindowDevice::WindowDevice(const Desktop& desktop, const RendererOptions& options)
    : renderer(rendererFor(desktop, options)), device(optionsOf(renderer->handles())),
      swapchain(device, desktop.window()), ui(device, swapchain.format())
{}

WindowDevice::~WindowDevice()
{
    const auto lock = device.lockQueue();
    device.vk.DeviceWaitIdle(device.handle()); // which fails where the device is lost
}

} // namespace halflight::view
