#pragma once
// What the user asks for with panels, keys and mouse, as values.

#include "view/state/view_state.h"

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

namespace halflight::view {

enum class Action {
    Leave, ///< cancels the bake that runs, else quits
    Screenshot,
    Expose, ///< automatic exposure of this view
    FrameSelection,
    Reload,
    CopyCommand,
    Bake,
    CancelBake,
    Save, ///< if a bake has finished
    WriteSettings,
    ToggleFullScreen
};
struct LookThrough {
    int camera = -1; ///< of the file's cameras
};
struct ShowSubject {
    std::size_t warning = 0; ///< that names the subject
};
using Request = std::variant<Action, LookThrough, ShowSubject>;

struct ChangeLight {
    int light = -1;
    Light value;
};
struct ChangeSwitches {
    int object = -1;
    bool isStatic = true; ///< in the next bake
    bool castShadows = true;
    bool receiveShadows = true;
};
struct MoveObject {
    int object = -1;
    mat4 worldFromObject{1.0f};
};
struct ChangeGroup {
    std::string name; ///< of a light group
    vec3 weight{1.0f};
};
using SceneChange = std::variant<ChangeLight, ChangeSwitches, MoveObject, ChangeGroup>;

/// What panels and keys return.
struct Answer {
    ViewState choices; ///< as the user leaves them
    std::vector<SceneChange> changes;
    std::vector<Request> requests; ///< to be answered after the frame
};

} // namespace halflight::view
