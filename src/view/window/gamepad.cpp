#include "view/window/gamepad.h"

#include <SDL.h>

#include <algorithm>
#include <cmath>

namespace halflight::view {

float stickValue(int value)
{
    constexpr float kRest = 0.2f;
    constexpr float kMost = 32767.0f;
    const float v = std::clamp(float(value) / kMost, -1.0f, 1.0f);
    return std::abs(v) < kRest ? 0.0f : std::copysign((std::abs(v) - kRest) / (1.0f - kRest), v);
}

Gamepad::~Gamepad()
{
    if (controller_ != nullptr) SDL_GameControllerClose(controller_);
}

void Gamepad::update()
{
    if (controller_ != nullptr && SDL_GameControllerGetAttached(controller_) != SDL_TRUE) {
        SDL_GameControllerClose(controller_);
        controller_ = nullptr;
    }
    for (int i = 0; controller_ == nullptr && i < SDL_NumJoysticks(); ++i) controller_ = SDL_GameControllerOpen(i);
}

Sticks Gamepad::sticks() const
{
    if (controller_ == nullptr) return {};
    const auto axis = [&](SDL_GameControllerAxis which) {
        return stickValue(SDL_GameControllerGetAxis(controller_, which));
    };
    return {vec3(axis(SDL_CONTROLLER_AXIS_LEFTX),
                 axis(SDL_CONTROLLER_AXIS_TRIGGERRIGHT) - axis(SDL_CONTROLLER_AXIS_TRIGGERLEFT),
                 -axis(SDL_CONTROLLER_AXIS_LEFTY)),
            -vec2(axis(SDL_CONTROLLER_AXIS_RIGHTX), axis(SDL_CONTROLLER_AXIS_RIGHTY))};
}

} // namespace halflight::view
