#pragma once
// The path-traced picture of a view, which gets better while the view stays as it is.

#include "halflight/base/image.h"
#include "halflight/scene/scene.h"

#include <chrono>
#include <memory>
#include <optional>

namespace halflight::view {

class ReferencePicture {
public:
    /// `rest`: a view rests when it has not changed for so long.
    explicit ReferencePicture(std::chrono::milliseconds rest = std::chrono::milliseconds(250));
    ~ReferencePicture();
    ReferencePicture(const ReferencePicture&) = delete;
    ReferencePicture& operator=(const ReferencePicture&) = delete;

    /// What is to be seen: `scene` counts as another one when the pointer differs. Begins anew where something does,
    /// and says so; while the view moves nothing is traced. `specular` is RenderSettings::specular. Never waits.
    bool follow(const std::shared_ptr<const Scene>& scene, const Camera& camera, ivec2 size, bool specular);
    /// Traces nothing until follow() is called again. Never waits.
    void pause();
    /// Whether samples are being added.
    [[nodiscard]] bool works() const;
    /// Whether a scene is being prepared, which cannot be interrupted.
    [[nodiscard]] bool prepares() const;
    /// Ends the work; waits until it has, which takes as long as Embree builds the scene.
    void stop();

    struct Picture {
        ImageRgba32f radiance; ///< as of Renderer::render(); at first smaller than asked for
        int samples = 0;       ///< per pixel
    };
    /// The picture, once after each change.
    std::optional<Picture> take();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace halflight::view
