#include "view/panels/panel_input.h"

#include <SDL.h>
#include <imgui.h>
#if __has_include(<backends/imgui_impl_sdl2.h>)
#include <backends/imgui_impl_sdl2.h>
#else
#include <backends/imgui_impl_sdl.h>
#endif

#include <cfloat>

namespace halflight::view {
namespace {

bool isPress(const SDL_Event& event)
{
    switch (event.type) {
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP:
    case SDL_MOUSEWHEEL:
    case SDL_KEYDOWN:
    case SDL_KEYUP:
    case SDL_TEXTINPUT:
        return true;
    default:
        return false;
    }
}

} // namespace

bool PanelInput::endsFrame(const SDL_Event& event) const
{
    return (isPress(event) && since_ != Since::Nothing) || (event.type == SDL_MOUSEMOTION && since_ == Since::Presses);
}

void PanelInput::take(const SDL_Event& event)
{
    ImGui_ImplSDL2_ProcessEvent(&event);
    switch (event.type) {
    case SDL_MOUSEMOTION:
        mouse_ = vec2(event.motion.x, event.motion.y);
        break;
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP: {
        mouse_ = vec2(event.button.x, event.button.y);
        const unsigned bit = SDL_BUTTON(event.button.button);
        buttons_ = event.type == SDL_MOUSEBUTTONDOWN ? buttons_ | bit : buttons_ & ~bit;
        break;
    }
    case SDL_KEYDOWN:
    case SDL_KEYUP:
        modifiers_ = event.key.keysym.mod;
        break;
    case SDL_WINDOWEVENT:
        if (event.window.event == SDL_WINDOWEVENT_LEAVE && buttons_ == 0) mouse_ = vec2(-kInfinity);
        if (event.window.event == SDL_WINDOWEVENT_FOCUS_LOST) buttons_ = modifiers_ = 0;
        break;
    default:
        break;
    }
    if (isPress(event))
        since_ = Since::Presses;
    else if (event.type == SDL_MOUSEMOTION)
        since_ = Since::Moves;
}

void PanelInput::beginFrame()
{
    since_ = Since::Nothing;
#if IMGUI_VERSION_NUM < 18700 // newer ones keep a queue of events
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = mouse_.x > -kInfinity ? ImVec2(mouse_.x, mouse_.y) : ImVec2(-FLT_MAX, -FLT_MAX);
    io.MouseDown[0] = (buttons_ & SDL_BUTTON_LMASK) != 0;
    io.MouseDown[1] = (buttons_ & SDL_BUTTON_RMASK) != 0;
    io.MouseDown[2] = (buttons_ & SDL_BUTTON_MMASK) != 0;
    io.KeyCtrl = (modifiers_ & KMOD_CTRL) != 0;
    io.KeyShift = (modifiers_ & KMOD_SHIFT) != 0;
    io.KeyAlt = (modifiers_ & KMOD_ALT) != 0;
#endif
}

} // namespace halflight::view
