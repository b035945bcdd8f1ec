#pragma once
// Points of lightmapped surfaces, with what their specular lobes send to views: traced, and as the lightmap alone has
// it.

#include "bake/cache/cached_integrator.h"

#include <algorithm>
#include <span>
#include <vector>

namespace halflight {

/// A view of a point. All light is luminance in nits.
struct SpecularView {
    vec3 direction{0.0f}; ///< to the view, unit
    vec3 share{0.0f};     ///< of the lobe's surroundings that arrive: shading::environmentSpecular()
    float truth = 0.0f;   ///< traced
    float own = 0.0f;     ///< what the renderer makes of the lightmap without reflection probes
    float diffuse = 0.0f; ///< what the surface sends there besides
};

struct SpecularPoint {
    vec3 position{0.0f};
    vec3 normal{0.0f};
    float roughness = 1.0f;
    float local = 0.0f; ///< luminance of irradiance over pi
    std::vector<SpecularView> views;

    /// The lobe takes something from reflection probes (shading::reflectedSurroundings()).
    [[nodiscard]] bool reflectsProbes() const
    {
        return roughness < 1.0f && std::any_of(views.begin(), views.end(),
                                               [](const SpecularView& view) { return view.share != vec3(0.0f); });
    }
};

/// Finished pages of a lightmap.
struct LightmapPages {
    std::span<const ImageRgb32f> irradiance; ///< lux
    std::span<const ImageRgba8> directions;  ///< none, or by page
};

/// Points spread evenly over all texels, and the mean of what they send to views, which is their error's unit. Points
/// without a free view are left out.
Result<std::vector<SpecularPoint>> specularPoints(const CachedIntegrator& cached, const LightmapPages& pages,
                                                  float sceneSizeMeters, const Progress& progress);

/// How far what points send to a view is off, 0…1: the square of the difference over the sum.
class SpecularError {
public:
    explicit SpecularError(std::span<const SpecularPoint> points);
    /// 1 / nits²: what a squared difference counts.
    [[nodiscard]] float weight(const SpecularView& view, float predicted) const
    {
        const float sum = view.truth + predicted + view.diffuse + floor_;
        return 1.0f / (sum * sum);
    }
    [[nodiscard]] float at(const SpecularView& view, float predicted) const
    {
        const float difference = predicted - view.truth;
        return difference * difference * weight(view, predicted);
    }

private:
    float floor_ = 0.0f; ///< nits: what is darker counts as black
};

} // namespace halflight
