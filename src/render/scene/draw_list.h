#pragma once
// What one pass draws: mesh parts with runs of instances.

#include "render/scene/gpu_scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

struct Draw {
    const DrawPart* part = nullptr;
    bool mirrored = false;
    uint32_t firstInstance = 0; ///< into the frame's instance list
    uint32_t instanceCount = 0;
};

/// Draws of all passes share one list of instances (object indices), uploaded once a frame.
class DrawLists {
public:
    explicit DrawLists(const GpuScene& scene) : scene_(scene) {}

    /// Opaque and masked parts of the objects, objects that share a mesh as instances of one draw.
    std::vector<Draw> solid(std::span<const uint32_t> objects);
    /// Closed parts of glass that take light on the way through them.
    std::vector<Draw> volumes(std::span<const uint32_t> objects);
    /// All parts of the objects that throw shadows, blended ones too.
    std::vector<Draw> casters(std::span<const uint32_t> objects);
    /// Blended parts, farthest first from `eye`.
    std::vector<Draw> blended(std::span<const uint32_t> objects, vec3 eye);

    [[nodiscard]] const std::vector<uint32_t>& instances() const { return instances_; }

private:
    template<typename Filter> std::vector<Draw> drawsOf(std::span<const uint32_t> objects, const Filter& isDrawn);

    const GpuScene& scene_;
    std::vector<uint32_t> instances_;
};

/// Objects whose bounds meet the frustum.
std::vector<uint32_t> objectsInView(std::span<const Bounds> bounds, const mat4& clipFromWorld);

} // namespace halflight
