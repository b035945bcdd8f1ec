#pragma once
// Reflected radiance of patches, looked up by hit: the result of the radiosity stage.

#include "transport/radiosity/patch_layout.h"
#include "transport/sample/path_tracer.h"

#include <array>
#include <span>
#include <vector>

namespace halflight {

/// Light that a patch or element reflects after all bounces. Of its directions the cache has the mean and the first
/// moment: radiance towards d is radiance (1 + tilt . d), which a specular lobe makes differ from direction to
/// direction.
struct PatchRadiance {
    vec3 radiance{0.0f};
    float minDistance = kInfinity; ///< metres; shorter rays use an element or a path instead
    vec3 tilt{0.0f};               ///< shorter than 1; zero for diffuse surfaces
    /// Radiance back along a ray of a unit direction.
    [[nodiscard]] vec3 along(vec3 rayDirection) const
    {
        return shading::patchRadianceAlong(radiance, tilt, rayDirection);
    }
    [[nodiscard]] bool usableAt(float distance) const { return distance >= minDistance; }
};

/// Of PatchRadiance, the light of one component.
struct ComponentRadiance {
    vec3 radiance{0.0f};
    vec3 tilt{0.0f};
    [[nodiscard]] vec3 along(vec3 rayDirection) const
    {
        return shading::patchRadianceAlong(radiance, tilt, rayDirection);
    }
};

/// What of the cache is kept by component; empty where light is estimated as one.
struct ComponentCache {
    std::size_t count = 0;
    std::vector<ComponentRadiance> patches;  ///< by patch and element, and component
    std::array<std::vector<vec3>, 3> levels; ///< as RadianceCache::Levels, by patch and component

    template<typename Archive> void archive(Archive& a) { a(count, patches, levels[0], levels[1], levels[2]); }
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

    void setComponents(ComponentCache components) { components_ = std::move(components); }
    [[nodiscard]] std::size_t componentCount() const { return components_.count; }
    [[nodiscard]] const ComponentCache& components() const { return components_; }
    /// Of a patch or element of patches().
    [[nodiscard]] std::span<const ComponentRadiance> componentsOf(const PatchRadiance& patch) const
    {
        return std::span(components_.patches)
            .subspan(std::size_t(&patch - patches_.data()) * components_.count, components_.count);
    }
    /// Of a hit that radianceAt() finds.
    void componentsAt(const RayEnd& end, int reflections, std::span<vec3> out) const;

    /// `grouped`: there are components.
    template<typename Archive> void archive(Archive& a, bool grouped)
    {
        if (grouped) components_.archive(a);
        layout_.archive(a);
        a(patches_, levels_[0], levels_[1], levels_[2], bounces_, converged_);
    }
    [[nodiscard]] const PatchLayout& layout() const { return layout_; }
    /// By patch and element.
    [[nodiscard]] std::span<const PatchRadiance> patches() const { return patches_; }

    [[nodiscard]] const Levels& levels() const { return levels_; }
    [[nodiscard]] int bounces() const { return bounces_; }
    [[nodiscard]] bool converged() const { return converged_; }

    /// Radiance of a patch, or of its element, at the end of a ray; null if the ray is too short.
    [[nodiscard]] const PatchRadiance* find(const RayEnd& end, PatchId patch) const
    {
        if (patches_[patch].usableAt(end.distance)) return &patches_[patch];
        const PatchId element = layout_.elementAt(end.face, end.barycentric, patch);
        if (element == kNoPatch) return nullptr;
        return patches_[element].usableAt(end.distance) ? &patches_[element] : nullptr;
    }
    /// Radiance back along a ray after at most `reflections` reflections.
    [[nodiscard]] CachedRadiance radianceAt(const RayEnd& end, int reflections) const;
    /// radianceAt() for paths. The cache outlives it.
    [[nodiscard]] RadianceLookup lookup() const
    {
        return {this,
                [](const void* cache, const RayEnd& end, int reflections) {
                    return static_cast<const RadianceCache*>(cache)->radianceAt(end, reflections);
                },
                [](const void* cache, const RayEnd& end, int reflections, std::span<vec3> out) {
                    static_cast<const RadianceCache*>(cache)->componentsAt(end, reflections, out);
                }};
    }

private:
    PatchLayout layout_;
    std::vector<PatchRadiance> patches_;
    Levels levels_;
    ComponentCache components_;
    int bounces_ = 0;
    bool converged_ = false;
};

inline CachedRadiance RadianceCache::radianceAt(const RayEnd& end, int reflections) const
{
    const int fewer = converged_ ? 0 : bounces_ - reflections;
    if (fewer < 0 || fewer > kLevels || !layout_.hasPatches(end.face)) return {};
    const PatchId patch = layout_.patchAt(end.face, end.barycentric);
    if (fewer == 0) {
        const PatchRadiance* light = find(end, patch);
        if (light == nullptr) return {};
        return {true, layout_.emissive(end.face), light->along(end.direction)};
    }
    const std::vector<vec3>& level = levels_[std::size_t(fewer - 1)];
    if (level.empty() || !patches_[patch].usableAt(end.distance)) return {};
    return {true, layout_.emissive(end.face), level[patch]};
}

inline void RadianceCache::componentsAt(const RayEnd& end, int reflections, std::span<vec3> out) const
{
    const int fewer = converged_ ? 0 : bounces_ - reflections;
    const PatchId patch = layout_.patchAt(end.face, end.barycentric);
    if (fewer == 0) {
        const std::span<const ComponentRadiance> light = componentsOf(*find(end, patch));
        for (std::size_t c = 0; c < out.size(); ++c) out[c] = light[c].along(end.direction);
        return;
    }
    const std::vector<vec3>& level = components_.levels[std::size_t(fewer - 1)];
    for (std::size_t c = 0; c < out.size(); ++c) out[c] = level[patch * components_.count + c];
}

} // namespace halflight
