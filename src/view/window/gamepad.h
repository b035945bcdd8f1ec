#pragma once
// A gamepad, whose sticks and triggers move the camera.

#include "halflight/base/math.h"

struct _SDL_GameController; // NOLINT: SDL_GameController, as SDL declares it

namespace halflight::view {

/// A stick or a trigger, -32768 … 32767 as SDL has it, as -1 … 1: nothing in the fifth about its rest.
float stickValue(int value);

/// What sticks and triggers ask for, each -1 … 1: to the right, up and forward; then turns to the left and up.
struct Sticks {
    vec3 fly{0.0f};
    vec2 look{0.0f};
};

/// The first one that is plugged in, until it is pulled out; then another one. SDL's game controllers end after it.
class Gamepad {
public:
    Gamepad() = default;
    ~Gamepad();
    Gamepad(const Gamepad&) = delete;
    Gamepad& operator=(const Gamepad&) = delete;

    /// One was plugged in or pulled out.
    void update();
    /// All zero without one.
    [[nodiscard]] Sticks sticks() const;

private:
    _SDL_GameController* controller_ = nullptr;
};

} // namespace halflight::view
