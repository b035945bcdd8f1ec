#include "camera.h"

#include "halflight/render/frame.h"

#include <algorithm>
#include <cmath>

namespace halflight::cli {

Camera lookAt(vec3 eye, vec3 target, float verticalFovRadians, const Bounds& bounds)
{
    const vec3 back = glm::normalize(eye - target);
    const vec3 up = std::abs(back.y) < 0.999f ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, -1.0f);
    const vec3 right = glm::normalize(glm::cross(up, back));
    Camera camera;
    camera.worldFromCamera =
        mat4(vec4(right, 0.0f), vec4(glm::cross(back, right), 0.0f), vec4(back, 0.0f), vec4(eye, 1.0f));
    camera.verticalFovRadians = verticalFovRadians;
    return withPlanesFor(bounds, camera);
}

Result<Camera> chooseCamera(const Scene& scene, const CameraChoice& choice, float aspect)
{
    Camera camera;
    if (choice.eye) {
        camera = lookAt(vec3(*choice.eye - scene.originMeters), vec3(choice.target - scene.originMeters), kPi / 3.0f,
                        scene.bounds());
    } else if (!choice.name.empty()) {
        const auto named = [&](const Camera& candidate) { return candidate.name == choice.name; };
        const auto found = std::find_if(scene.cameras.begin(), scene.cameras.end(), named);
        if (found == scene.cameras.end()) {
            std::string names;
            for (const Camera& candidate : scene.cameras) {
                names += (names.empty() ? "its cameras are '" : "', '") + candidate.name;
            }
            return Error{ErrorCode::InvalidArgument, "has no camera '" + choice.name + "'; " +
                                                         (names.empty() ? "it has no camera at all" : names + "'")};
        }
        camera = *found;
    } else if (!scene.cameras.empty()) {
        camera = scene.cameras.front();
    } else {
        camera = automaticCamera(scene, aspect);
    }
    if (choice.verticalFovRadians > 0.0f) camera.verticalFovRadians = choice.verticalFovRadians;
    return camera;
}

} // namespace halflight::cli
