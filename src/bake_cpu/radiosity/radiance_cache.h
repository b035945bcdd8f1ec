#pragma once
// Reflected radiance of patches, looked up by hit: the result of the radiosity stage.

#include "bake_cpu/radiosity/patch_layout.h"
#include "bake_cpu/sample/path_tracer.h"

#include <array>
#include <vector>

namespace halflight {

struct PatchRadiance {
    vec3 radiance{0.0f};           ///< reflected, after all bounces
    float minDistance = kInfinity; ///< metres; shorter rays use an element or a path instead
    [[nodiscard]] bool usableAt(float distance) const { return distance >= minDistance; }
};

/// Constant radiance per patch and element. The final gather reads it (Reichert 1992, "A Two-Pass Radiosity Method
/// Driven by Lights and Viewer Position").
class RadianceCache {
public:
    /// Radiance after `bounces` - 1, - 2 and - 3 reflections, by patch, for paths that have been reflected already.
    static constexpr int kLevels = 3;
    using Levels = std::array<std::vector<vec3>, kLevels>;
    static_assert(kLevels == 3, "archive() names them");

    RadianceCache() = default;
    /// `converged`: more bounces add nothing, so that the radiance serves paths of any length.
    RadianceCache(PatchLayout layout, std::vector<PatchRadiance> patches, Levels levels, int bounces, bool converged)
        : layout_(std::move(layout)), patches_(std::move(patches)), levels_(std::move(levels)), bounces_(bounces),
          converged_(converged)
    {}

    template<typename Archive> void archive(Archive& a)
    {
        layout_.archive(a);
        a(patches_, levels_[0], levels_[1], levels_[2], bounces_, converged_);
    }
    [[nodiscard]] const PatchLayout& layout() const { return layout_; }
    /// By patch and element.
    [[nodiscard]] const PatchRadiance* patches() const { return patches_.data(); }

    /// Radiance of a patch, or of its element at a point, for a ray of some length; null if the ray is too short.
    [[nodiscard]] const vec3* find(FaceId face, vec2 barycentric, PatchId patch, float distance) const
    {
        if (patches_[patch].usableAt(distance)) return &patches_[patch].radiance;
        const PatchId element = layout_.elementAt(face, barycentric, patch);
        if (element == kNoPatch) return nullptr;
        return patches_[element].usableAt(distance) ? &patches_[element].radiance : nullptr;
    }
    /// Radiance after at most `reflections` reflections at a hit of a ray of some length.
    [[nodiscard]] CachedRadiance radianceAt(FaceId face, vec2 barycentric, float distance, int reflections) const;
    /// radianceAt() for paths. The cache outlives it.
    [[nodiscard]] RadianceLookup lookup() const
    {
        return {this, [](const void* cache, FaceId face, vec2 barycentric, float distance, int reflections) {
                    return static_cast<const RadianceCache*>(cache)->radianceAt(face, barycentric, distance,
                                                                                reflections);
                }};
    }

private:
    PatchLayout layout_;
    std::vector<PatchRadiance> patches_;
    Levels levels_;
    int bounces_ = 0;
    bool converged_ = false;
};

inline CachedRadiance RadianceCache::radianceAt(FaceId face, vec2 barycentric, float distance, int reflections) const
{
    const int fewer = converged_ ? 0 : bounces_ - reflections;
    if (fewer < 0 || fewer > kLevels || !layout_.hasPatches(face)) return {};
    const PatchId patch = layout_.patchAt(face, barycentric);
    const vec3* light = nullptr;
    if (fewer == 0) {
        light = find(face, barycentric, patch, distance);
    } else if (!levels_[std::size_t(fewer - 1)].empty() && patches_[patch].usableAt(distance)) {
        light = &levels_[std::size_t(fewer - 1)][patch];
    }
    if (light == nullptr) return {};
    return {true, layout_.emissive(face), *light};
}

} // namespace halflight
