// The window, and what mouse and keys do in it.
#include "view/panels.h"
#include "view/viewer.h"

#include <SDL.h>
#include <SDL_vulkan.h>
#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif

#include <algorithm>
#include <cmath>
#include <utility>

namespace halflight::view {
namespace {

/// Radians of a turn for a pixel of dragging: half a turn across 720 pixels.
constexpr float kRadiansPerPixel = kPi / 720.0f;
/// Distance to the pivot for a notch of the wheel.
constexpr float kDollyPerNotch = 0.85f;
/// A click moves the mouse by fewer pixels than this.
constexpr float kClickPixels = 4.0f;

/// Keys, clicks and turns of the wheel, but for the key that ends the program.
bool needsScene(const SDL_Event& event)
{
    switch (event.type) {
    case SDL_KEYDOWN:
    case SDL_KEYUP:
        return event.key.keysym.sym != SDLK_ESCAPE;
    case SDL_TEXTINPUT:
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP:
    case SDL_MOUSEWHEEL:
        return true;
    default:
        return false;
    }
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

void Viewer::handleEvents()
{
    const auto handle = [&](const SDL_Event& event) {
        if (panelInput_.endsFrame(event)) buildPanels(false);
        // Dear ImGui says a frame later that typing has ended.
        if (event.type == SDL_KEYDOWN && ImGui::GetIO().WantTextInput) buildPanels(false);
        panelInput_.take(event);
        handleEvent(event);
    };
    if (shown_)
        for (const SDL_Event& event : std::exchange(early_, {})) handle(event);
    SDL_Event event;
    while (SDL_PollEvent(&event)) {
        if (event.type != SDL_USEREVENT) lastInput_ = Clock::now();
        if (!shown_ && needsScene(event))
            early_.push_back(event);
        else
            handle(event);
    }
}

void Viewer::handleEvent(const SDL_Event& event)
{
    const ImGuiIO& io = ImGui::GetIO();
    switch (event.type) {
    case SDL_QUIT:
        state_.requests.quit = true;
        break;
    case SDL_DROPFILE: {
        const std::filesystem::path file = event.drop.file;
        SDL_free(event.drop.file);
        open(file);
        break;
    }
    case SDL_KEYDOWN:
        if (!io.WantTextInput)
            handleKey(state_, event.key.keysym.sym, (event.key.keysym.mod & (KMOD_CTRL | KMOD_ALT | KMOD_GUI)) != 0);
        break;
    case SDL_MOUSEWHEEL:
        if (!io.WantCaptureMouse) state_.navigator.dolly(std::pow(kDollyPerNotch, float(event.wheel.y)));
        break;
    case SDL_CONTROLLERDEVICEADDED:
    case SDL_CONTROLLERDEVICEREMOVED:
        desktop_.gamepad().update();
        break;
    case SDL_MOUSEBUTTONDOWN:
        // Dear ImGui's own answer is one of the last frame, when the mouse may have been elsewhere.
        inPicture_ = !overPanels(state_, vec2(event.button.x, event.button.y));
        dragged_ = false;
        if (event.button.button == SDL_BUTTON_LEFT && inPicture_)
            dragged_ = dragGizmo(vec2(event.button.x, event.button.y));
        break;
    case SDL_MOUSEBUTTONUP:
        gizmo_.release();
        if (event.button.button == SDL_BUTTON_LEFT && inPicture_ && !dragged_)
            click(vec2(event.button.x, event.button.y));
        break;
    case SDL_MOUSEMOTION:
        if (gizmo_.arrow() >= 0) {
            const std::size_t object = std::size_t(state_.selectedObject);
            mat4 place = scene_.objects[object].worldFromObject;
            place[3] = vec4(gizmo_.dragged(state_.navigator.camera(), vec2(event.motion.x, event.motion.y),
                                           vec2(io.DisplaySize.x, io.DisplaySize.y)),
                            1.0f);
            state_.requests.move = {int(object), place};
        } else if (inPicture_)
            drag(vec2(event.motion.xrel, event.motion.yrel), event.motion.state);
        break;
    default:
        break;
    }
}

void Viewer::drag(vec2 pixels, uint32_t buttons)
{
    if (buttons == 0) return;
    if (glm::length(pixels) >= kClickPixels) dragged_ = true;
    const vec2 turn = -kRadiansPerPixel * pixels;
    const bool shift = (SDL_GetModState() & KMOD_SHIFT) != 0;
    if ((buttons & SDL_BUTTON_MMASK) != 0 || ((buttons & SDL_BUTTON_LMASK) != 0 && shift))
        state_.navigator.pan(vec2(-pixels.x, pixels.y) * state_.navigator.pixelMeters(size_.y));
    else if ((buttons & SDL_BUTTON_LMASK) != 0)
        state_.navigator.orbit(turn);
    else if ((buttons & SDL_BUTTON_RMASK) != 0)
        state_.navigator.look(turn);
}

void Viewer::click(vec2 place)
{
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    if (!(window.x > 0.0f && window.y > 0.0f)) return;
    state_.selectedObject =
        objectAt(scene_, state_.navigator.camera(), place / vec2(window.x, window.y), window.x / window.y);
}

/// While a bake, the reference or a reader of files works and nobody does anything, every other moment is theirs: on
/// devices that draw with the processor they would wait for pictures that show nothing new. Whatever is done ends the
/// pause.
void Viewer::waitAtRest()
{
    constexpr std::chrono::milliseconds kFrame(66); // progress that moves smoothly
    constexpr std::chrono::milliseconds kMost(250);
    if (!shown_) { // a line of progress is all there is to draw
        if (!ready_) (void)SDL_WaitEventTimeout(nullptr, int(kMost.count()));
        return;
    }
    const bool works =
        session_ || opening_ || showing_ || earlierLoading_.valid() || (reference_ && reference_->works());
    const Clock::time_point now = Clock::now();
    const bool mayWait = works || (!drewPicture_ && options_.frames == 0);
    if (!mayWait || now - lastInput_ < kAfterInput) return;
    const auto drawing = std::chrono::duration_cast<std::chrono::milliseconds>(now - lastFrame_);
    const auto wait = works ? std::max(drawing, kFrame - drawing) : kFrame - drawing;
    if (wait.count() > 0) (void)SDL_WaitEventTimeout(nullptr, int(std::min(wait, kMost).count()));
    lastFrame_ += Clock::now() - now; // no time in which the camera flies
}

void Viewer::fly(float seconds)
{
    if (ImGui::GetIO().WantTextInput) return;
    const Uint8* keys = SDL_GetKeyboardState(nullptr);
    const auto axis = [&](SDL_Scancode positive, SDL_Scancode negative) {
        return float(keys[positive]) - float(keys[negative]);
    };
    vec3 direction(axis(SDL_SCANCODE_D, SDL_SCANCODE_A), axis(SDL_SCANCODE_E, SDL_SCANCODE_Q),
                   axis(SDL_SCANCODE_W, SDL_SCANCODE_S));
    const Sticks sticks = desktop_.gamepad().sticks();
    constexpr float kTurn = 2.0f; // radians a second
    if (sticks.look != vec2(0.0f) || direction + sticks.fly != vec3(0.0f)) lastInput_ = Clock::now();
    if (sticks.look != vec2(0.0f)) state_.navigator.look(kTurn * seconds * sticks.look);
    direction += sticks.fly;
    if (direction == vec3(0.0f)) return;
    const float faster = (SDL_GetModState() & KMOD_SHIFT) != 0 ? 4.0f : 1.0f;
    state_.navigator.fly(direction * (state_.speed * faster * seconds));
}

} // namespace halflight::view
