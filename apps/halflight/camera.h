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

/// A view that shows the scene: from inside when its middle is walled in (a room: walls that face inward, or
/// double-sided ones around a light or around things that nobody outside sees), else from outside with the bounds
/// fitted into the picture, from the side that lets the eye in deepest (into a box with an open front, say).
Camera automaticCamera(const Scene& scene, float aspect);

} // namespace halflight::cli
