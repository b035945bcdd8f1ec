#pragma once
// Mouse and keys for the panels: every press, move and release in its order, however long a picture takes.

#include "halflight/base/math.h"

union SDL_Event;

namespace halflight::view {

class PanelInput {
public:
    /// Whether the panels must be built before this event comes: Dear ImGui has one state of mouse and keys a frame, in
    /// which a press and its release, or a move and the press after it, are one.
    [[nodiscard]] bool endsFrame(const SDL_Event& event) const;
    /// Passes it to Dear ImGui.
    void take(const SDL_Event& event);
    /// Mouse and keys as the events so far left them. Between ImGui_ImplSDL2_NewFrame(), which asks for the state of
    /// this moment, and ImGui::NewFrame().
    void beginFrame();

private:
    enum class Since { Nothing, Moves, Presses };
    Since since_ = Since::Nothing; ///< the last frame
    vec2 mouse_{-kInfinity};       ///< infinite outside the window
    unsigned buttons_ = 0;         ///< SDL's bits of those that are down
    unsigned modifiers_ = 0;       ///< SDL's bits of Ctrl, Shift, Alt, of the last key
};

} // namespace halflight::view
