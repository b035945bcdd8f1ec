#pragma once
// Three arrows along the world's axes, by which a dynamic object is dragged.

#include "view/state/navigation.h"

#include <array>
#include <optional>

namespace halflight::view {

class Gizmo {
public:
    /// In a picture of `size` points, from its top left.
    struct Shape {
        vec2 center{0.0f};
        std::array<vec2, 3> tips{};
    };
    /// Where the arrows of a place are; they have one length in the picture. Nothing where they are not in front of the
    /// camera.
    static std::optional<Shape> shapeOf(const Camera& camera, vec3 place, vec2 size);
    /// The arrow within some points of the mouse; -1 none.
    static int arrowAt(const Shape& shape, vec2 mouse);

    /// Draws the arrows of a place in this frame of the panels; the one that is held, or is under the mouse, stands
    /// out.
    void draw(const Camera& camera, vec3 place) const;
    /// Takes hold of an arrow.
    void grab(const Camera& camera, vec3 place, int arrow, vec2 mouse, vec2 size);
    void release() { arrow_ = -1; }
    [[nodiscard]] int arrow() const { return arrow_; } ///< that is held; -1 none
    /// Where the mouse drags the place to. Looking along the arrow, nowhere.
    [[nodiscard]] vec3 dragged(const Camera& camera, vec2 mouse, vec2 size) const;

private:
    [[nodiscard]] std::optional<float> along(const Camera& camera, vec2 mouse, vec2 size) const;

    vec3 place_{0.0f};
    int arrow_ = -1;
    float grabbedAt_ = 0.0f; ///< metres along the arrow
};

/// The edges of a box in the world, in this frame of the panels.
void drawBounds(const Camera& camera, const Bounds& bounds);

} // namespace halflight::view
