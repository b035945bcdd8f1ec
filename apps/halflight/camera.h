#pragma once
// Which camera `halflight render` looks through.

#include "halflight/base/result.h"
#include "halflight/scene/scene.h"

#include <optional>
#include <string>

namespace halflight::cli {

struct CameraChoice {
    std::string name;         ///< --camera; empty = none
    std::optional<dvec3> eye; ///< --eye with --target; both in the file's world
    dvec3 target{0.0};
    float verticalFovRadians = 0.0f; ///< --fov; 0 = the camera's own
};

/// The named camera, the one given by eye and target, else the file's first one, else automaticCamera().
Result<Camera> chooseCamera(const Scene& scene, const CameraChoice& choice, float aspect);

/// At `eye`, looking at `target`, y up as far as possible.
Camera lookAt(vec3 eye, vec3 target, float verticalFovRadians, const Bounds& bounds);

/// A view of the whole scene from outside, which it fills to 2.5 % of the picture's size from the edges, on the side
/// that shows most fronts and lets the eye in deepest (into a box with an open front, say). From inside where the scene
/// is a closed room: walls on nearly all sides of its middle, and outside little but their backs, or things or a light
/// within them that nobody outside sees.
Camera automaticCamera(const Scene& scene, float aspect);

} // namespace halflight::cli
