#pragma once
// What a user chooses in the window. The viewer reads it each frame.

#include "halflight/bake/bake.h"
#include "halflight/render/renderer.h"
#include "view/state/navigation.h"

#include <string>
#include <vector>

namespace halflight::view {

/// What is right of the line.
enum class Compare { Mode, BeforeBake, Reference };

/// What the user chose.
struct ViewState {
    RenderSettings settings;           ///< its size is set for each frame
    bool followsShadowDistance = true; ///< shadows reach all that is in view
    float exposureEv = 0.0f;
    ToneMapping toneMapping = ToneMapping::Neutral;
    bool panels = true;
    bool vsync = true;
    bool compares = false; ///< right of `split`
    Compare compareWith = Compare::Mode;
    RunMode otherMode = RunMode::Realtime;
    float split = 0.5f; ///< share of the width
    float speed = 2.0f; ///< of flying, m/s
    int selectedLight = -1;
    int selectedObject = -1;
    BakeSettings bake;
    std::string bakeOutput; ///< the file that Save writes
    Navigator navigator;
    bool showsSelected = false; ///< an object was clicked: its section opens
};

/// The object or light that a text names first, as whole words; of names at one place the longest.
struct Subject {
    int object = -1;
    int light = -1;
};
Subject subjectOf(const std::string& text, const Scene& scene);
/// One sentence on what the view's colours mean.
const char* legendOf(DebugView view);

/// The state's settings for a picture of this size. `bounds`: of the scene's objects.
RenderSettings settingsOfFrame(const ViewState& state, const std::vector<Bounds>& bounds, ivec2 size);

} // namespace halflight::view
