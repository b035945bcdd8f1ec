#pragma once
// The window's panels, by Dear ImGui. They return what the user asks for, and know no Vulkan.

#include "view/state/requests.h"
#include "view/state/shown.h"

#include <string>
#include <vector>

namespace halflight::view {

/// One window at the left with a section for each subject. Needs a current ImGui frame.
Answer drawPanels(const Shown& shown);
/// Whether panels are drawn at a place of the window, or an open list may be.
bool overPanels(const ViewState& state, vec2 place);

constexpr float kUsualDotsPerInch = 96.0f; ///< of displays for which panels are made
/// How large panels and their font are on a display of so many dots per inch: 1 at the usual, in quarters.
float panelScale(float dotsPerInch);

/// Keys that are pressed outside of text fields; `key` is SDL's key code for letters, digits and F keys.
Answer answerKey(const Shown& shown, int key, bool control);

/// What the keys do, a line each: "1 … 5  lighting mode".
const std::vector<std::string>& keyHelp();

} // namespace halflight::view
