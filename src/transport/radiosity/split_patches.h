#pragma once
// Search for patches and elements that an occluder crosses.

#include "transport/radiosity/patch_pass.h"

namespace halflight {

/// Outermost of texelPoints()'s points in seven directions, and the distance of the texel's border relative to theirs.
struct RimPoint {
    int point = 0;
    float toBorder = 1.0f;
};
using RimPoints = std::array<RimPoint, 7>;
const RimPoints& rimPoints();

/// A thin wall on a patch separates two parts with different light, so the patch has no single radiance. The search
/// traces rays along the surface, a tenth of a patch above it.
class OccluderSearch {
public:
    explicit OccluderSearch(const PatchPass& pass) : pass_(pass), tracer_(pass.input().paths.surfaces()) {}

    /// Appends to occluded() the patches or elements of the items that an occluder crosses.
    void search(std::span<const uint32_t> items);
    [[nodiscard]] const std::vector<PatchId>& occluded() const { return occluded_; }
    [[nodiscard]] uint64_t rays() const { return rays_; }

private:
    static constexpr std::size_t kTargets = 8;
    using Targets = std::array<vec3, kTargets>;
    void searchPatch(const TexelGroup& group, int lane);
    void searchElements(const TexelGroup& group, int lane);
    bool borderOfElement(const TexelGroup& group, int lane, const SurfacePoint& point, vec3 above,
                         Targets& targets) const;
    bool between(vec3 from, const Targets& targets);

    const PatchPass& pass_;
    const RayTracer& tracer_;
    std::vector<PatchId> occluded_;
    PatchId previousPatch_ = kNoPatch;
    vec3 previous_{0.0f}; ///< point above the previous texel
    uint64_t rays_ = 0;
};

} // namespace halflight
