#pragma once
// The scene as the user has changed it.

#include "view/notices.h"
#include "view/view_state.h"

#include <chrono>
#include <memory>
#include <vector>

namespace halflight::view {

/// What the next bake bakes: the file's scene with the user's changes to lights and objects. Its indices are those of
/// the scene that is shown.
class EditedScene {
public:
    using Clock = std::chrono::steady_clock;

    /// A file's, before any change.
    void beginFile(const Scene& scene);
    /// Makes the changes that panels and arrows ask for, here and in what the renderer draws, and takes them off
    /// `requests`. Whether there were some.
    bool change(Requests& requests, Renderer& renderer, Notices& notices);

    [[nodiscard]] const Scene& scene() const { return scene_; }
    /// Lights and objects of the file, without vertices and pixels.
    [[nodiscard]] const Scene& atLoad() const { return atLoad_; }
    [[nodiscard]] const std::vector<Bounds>& bounds() const { return bounds_; } ///< of each object
    [[nodiscard]] Bounds boundsOf(int object) const;                            ///< of all for -1
    [[nodiscard]] Clock::time_point lastChange() const { return lastChange_; }
    /// A copy, the same one until the next change.
    std::shared_ptr<const Scene> snapshot();

private:
    void move(std::size_t index, const mat4& place);

    Scene scene_;
    std::vector<Bounds> bounds_;
    Scene atLoad_;
    Clock::time_point lastChange_;
    std::shared_ptr<const Scene> snapshot_; ///< null where scene_ has changed since
};

} // namespace halflight::view
