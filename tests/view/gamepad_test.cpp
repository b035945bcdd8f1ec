// A gamepad flies: SDL's virtual one, which needs no hardware.
#include "view/window/gamepad.h"

#include <SDL.h>
#include <gtest/gtest.h>

namespace halflight::view::gamepad_test {
namespace {

/// One that is plugged in, its triggers not pressed.
class VirtualGamepad {
public:
    VirtualGamepad()
        : joystick_(SDL_JoystickOpen(SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER,
                                                               SDL_CONTROLLER_AXIS_MAX, SDL_CONTROLLER_BUTTON_MAX, 0)))
    {
        set(SDL_CONTROLLER_AXIS_TRIGGERLEFT, SDL_JOYSTICK_AXIS_MIN);
        set(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, SDL_JOYSTICK_AXIS_MIN);
    }
    ~VirtualGamepad() { pullOut(); }
    VirtualGamepad(const VirtualGamepad&) = delete;
    VirtualGamepad& operator=(const VirtualGamepad&) = delete;

    void set(int axis, int value)
    {
        EXPECT_EQ(SDL_JoystickSetVirtualAxis(joystick_, axis, Sint16(value)), 0) << SDL_GetError();
        SDL_GameControllerUpdate();
    }
    void pullOut()
    {
        if (joystick_ == nullptr) return;
        int index = 0;
        while (SDL_JoystickGetDeviceInstanceID(index) != SDL_JoystickInstanceID(joystick_)) ++index;
        SDL_JoystickClose(joystick_);
        joystick_ = nullptr;
        EXPECT_EQ(SDL_JoystickDetachVirtual(index), 0) << SDL_GetError();
    }

private:
    SDL_Joystick* joystick_;
};

class GamepadView : public testing::Test {
protected:
    void SetUp() override
    {
        SDL_SetMainReady();
        SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1"); // this test has no window
        ASSERT_EQ(SDL_Init(SDL_INIT_GAMECONTROLLER), 0) << SDL_GetError();
    }
    void TearDown() override { SDL_Quit(); }
};

TEST_F(GamepadView, SticksAndTriggersFlyAndLook)
{
    VirtualGamepad device;
    Gamepad gamepad;
    EXPECT_EQ(gamepad.sticks().fly, vec3(0.0f)) << "none was found yet";
    gamepad.update();
    EXPECT_EQ(gamepad.sticks().fly, vec3(0.0f)) << "at rest";
    EXPECT_EQ(gamepad.sticks().look, vec2(0.0f));

    constexpr int kMost = SDL_JOYSTICK_AXIS_MAX;
    device.set(SDL_CONTROLLER_AXIS_LEFTX, kMost);
    device.set(SDL_CONTROLLER_AXIS_LEFTY, -kMost);
    EXPECT_EQ(gamepad.sticks().fly, vec3(1.0f, 0.0f, 1.0f)) << "to the right and forward";
    device.set(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, kMost);
    EXPECT_EQ(gamepad.sticks().fly, vec3(1.0f, 1.0f, 1.0f)) << "up";
    device.set(SDL_CONTROLLER_AXIS_TRIGGERLEFT, kMost);
    EXPECT_EQ(gamepad.sticks().fly, vec3(1.0f, 0.0f, 1.0f)) << "up and down";
    device.set(SDL_CONTROLLER_AXIS_RIGHTX, -kMost);
    device.set(SDL_CONTROLLER_AXIS_RIGHTY, kMost / 10);
    EXPECT_EQ(gamepad.sticks().look, vec2(1.0f, 0.0f)) << "to the left; a stick that does not quite return";
}

TEST_F(GamepadView, AnotherOneIsTakenOnceItIsPulledOut)
{
    VirtualGamepad first;
    VirtualGamepad second;
    Gamepad gamepad;
    gamepad.update();
    second.set(SDL_CONTROLLER_AXIS_LEFTX, SDL_JOYSTICK_AXIS_MAX);
    EXPECT_EQ(gamepad.sticks().fly.x, 0.0f) << "the first one moves the camera";
    first.set(SDL_CONTROLLER_AXIS_LEFTX, SDL_JOYSTICK_AXIS_MAX);
    EXPECT_EQ(gamepad.sticks().fly.x, 1.0f);
    first.pullOut();
    gamepad.update();
    EXPECT_EQ(gamepad.sticks().fly.x, 1.0f) << "the second one";
    second.pullOut();
    gamepad.update();
    EXPECT_EQ(gamepad.sticks().fly.x, 0.0f);
}

TEST(Sticks, HaveNoValueAboutTheirRest)
{
    EXPECT_EQ(stickValue(6000), 0.0f);
    EXPECT_EQ(stickValue(-6000), 0.0f);
    EXPECT_EQ(stickValue(32767), 1.0f);
    EXPECT_EQ(stickValue(-32768), -1.0f);
    EXPECT_NEAR(stickValue(19660), 0.5f, 1e-3f);
}

} // namespace
} // namespace halflight::view::gamepad_test
