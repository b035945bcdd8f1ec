// What mouse and keys do in the window.
#include "view/panels/panels.h"
#include "view/viewer.h"

#include <SDL.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace halflight::view {
namespace {

/// Radians of a turn for a pixel of dragging: half a turn across 720 pixels.
constexpr float kRadiansPerPixel = kPi / 720.0f;
/// Distance to the pivot for a notch of the wheel.
constexpr float kDollyPerNotch = 0.85f;
/// With these, a key is a command of its own.
constexpr int kCommandKeys = KMOD_CTRL | KMOD_ALT | KMOD_GUI;
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

void Viewer::handleEvents()
{
    const auto handle = [&](const SDL_Event& event) {
        if (panelInput_.endsFrame(event)) buildPanels(false);
        // Dear ImGui says a frame later that typing has ended.
        if (event.type == SDL_KEYDOWN && ImGui::GetIO().WantTextInput) buildPanels(false);
        panelInput_.take(event);
        handleEvent(event);
    };
    if (shown_.any())
        for (const SDL_Event& event : std::exchange(early_, {})) handle(event);
    SDL_Event event;
    while (SDL_PollEvent(&event)) {
        if (event.type != SDL_USEREVENT) lastInput_ = Clock::now();
        if (!shown_.any() && needsScene(event))
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
        quits_ = true;
        break;
    case SDL_DROPFILE: {
        const std::filesystem::path file = event.drop.file;
        SDL_free(event.drop.file);
        if (mayDropBake("dropping the file")) files_.open(renderer(), file, false);
        break;
    }
    case SDL_KEYDOWN:
        if (event.key.keysym.sym == SDLK_ESCAPE && ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup))
            ImGui::SetWindowFocus(nullptr); // a list that is open closes
        else if (event.key.keysym.sym == SDLK_ESCAPE && !io.WantTextInput && !bake_.runs() && !mayDropBake("Escape"))
            break;
        else if (!io.WantTextInput)
            take(answerKey(shown(), event.key.keysym.sym, (event.key.keysym.mod & kCommandKeys) != 0));
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
        pressed_ = vec2(event.button.x, event.button.y);
        if (event.button.button == SDL_BUTTON_LEFT && inPicture_)
            dragged_ = grabArrow(vec2(event.button.x, event.button.y));
        break;
    case SDL_MOUSEBUTTONUP:
        gizmo_.release();
        if (event.button.button == SDL_BUTTON_LEFT && inPicture_ && !dragged_)
            click(vec2(event.button.x, event.button.y));
        break;
    case SDL_MOUSEMOTION:
        if (gizmo_.arrow() >= 0) {
            const std::size_t object = std::size_t(state_.selectedObject);
            mat4 place = edited_.scene().objects[object].worldFromObject;
            place[3] = vec4(gizmo_.dragged(state_.navigator.camera(), vec2(event.motion.x, event.motion.y),
                                           vec2(io.DisplaySize.x, io.DisplaySize.y)),
                            1.0f);
            change(MoveObject{int(object), place});
        } else if (inPicture_)
            drag(vec2(event.motion.x, event.motion.y), vec2(event.motion.xrel, event.motion.yrel), event.motion.state);
        break;
    default:
        break;
    }
}

void Viewer::drag(vec2 place, vec2 pixels, uint32_t buttons)
{
    if (buttons == 0) return;
    if (glm::distance(place, pressed_) >= kClickPixels) dragged_ = true;
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
    state_.selectedObject = objectAt(edited_.scene(), state_.navigator.camera(), place / vec2(window.x, window.y),
                                     window.x / window.y, edited_.bounds());
    state_.showsSelected = state_.selectedObject >= 0;
}

std::optional<vec3> Viewer::selectedDynamic() const
{
    if (state_.selectedObject < 0) return std::nullopt;
    const Object& object = edited_.scene().objects[std::size_t(state_.selectedObject)];
    return object.isStatic ? std::nullopt : std::optional(vec3(object.worldFromObject[3]));
}

/// Of the selected object, under the mouse.
bool Viewer::grabArrow(vec2 mouse)
{
    const std::optional<vec3> place = selectedDynamic();
    if (!place) return false;
    const vec2 size(ImGui::GetIO().DisplaySize.x, ImGui::GetIO().DisplaySize.y);
    const Camera camera = state_.navigator.camera();
    const std::optional<Gizmo::Shape> shape = Gizmo::shapeOf(camera, *place, size);
    const int arrow = shape ? Gizmo::arrowAt(*shape, mouse) : -1;
    if (arrow >= 0) gizmo_.grab(camera, *place, arrow, mouse, size);
    return arrow >= 0;
}

/// While a bake, the reference or a reader of files works and nobody does anything, every other moment is theirs: on
/// devices that draw with the processor they would wait for pictures that show nothing new. Whatever is done ends the
/// pause.
void Viewer::waitAtRest()
{
    constexpr std::chrono::milliseconds kFrame(66); // progress that moves smoothly
    constexpr std::chrono::milliseconds kMost(250);
    if (!shown_.any()) { // a line of progress is all there is to draw
        if (!files_.isReady()) (void)SDL_WaitEventTimeout(nullptr, int(kMost.count()));
        return;
    }
    const bool works = bake_.runs() || files_.works() || shown_.isUploading() || comparison_.works();
    const Clock::time_point now = Clock::now();
    const bool mayWait = works || (!picture_.isNew() && options_.frames == 0);
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
    const bool command = (SDL_GetModState() & kCommandKeys) != 0; // Ctrl-S saves
    const auto axis = [&](SDL_Scancode positive, SDL_Scancode negative) {
        return command ? 0.0f : float(keys[positive]) - float(keys[negative]);
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
