#include "bake/reflections/specular_points.h"

#include "bake/geometry/surfaces_along.h"

#include "halflight/base/mathematics.h"
#include "halflight/shading/directional.h"
#include "halflight/shading/indirect.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace halflight {
namespace {

/// Most points: about one for each square metre of a house's walls.
constexpr std::size_t kMostPoints = 1600;
/// Directions that each is seen from: as many heights above the surface, from grazing to upright.
constexpr std::size_t kViews = 8;
/// Views count from which this share of the scene's size is free: cameras do not touch walls.
constexpr float kFreeShare = 0.01f;
/// What is darker than this share of the mean counts as black.
constexpr float kBlackShare = 0.01f;

struct ChosenTexel {
    SurfacePoint point;
    const Texel* texel = nullptr;
};

std::vector<ChosenTexel> spreadTexels(const CachedIntegrator& cached)
{
    const std::vector<Texel>& texels = cached.map.texels;
    const std::size_t count = std::min(texels.size(), kMostPoints);
    std::vector<ChosenTexel> chosen;
    std::array<SurfacePoint, kMaxTexelPoints> points;
    for (std::size_t i = 0; i < count; ++i) {
        const Texel& texel = texels[(2 * i + 1) * texels.size() / (2 * count)];
        const int n = texelPoints(cached.geometry, cached.map, texel, points);
        for (int k = 0; k < n; ++k) {
            if (((texel.validPoints >> k) & 1) == 0) continue;
            chosen.push_back({points[std::size_t(k)], &texel});
            break;
        }
    }
    return chosen;
}

/// Directions spread evenly over the hemisphere, turned about the normal from point to point.
std::array<vec3, kViews> viewsOf(const SurfacePoint& point, uint32_t index)
{
    vec3 tangent;
    vec3 bitangent;
    shading::orthonormalBasis(point.normal, tangent, bitangent);
    std::array<vec3, kViews> views;
    for (std::size_t v = 0; v < kViews; ++v) {
        const float height = (float(v) + 0.5f) / float(kViews);
        const float turn = std::fmod(float(v) / std::numbers::phi_v<float> + unitFloat(hashPcg(index)), 1.0f);
        const float r = std::sqrt(1.0f - height * height);
        views[v] = r * math::cos(2.0f * kPi * turn) * tangent + r * math::sin(2.0f * kPi * turn) * bitangent +
                   height * point.normal;
    }
    return views;
}

/// What the renderer makes of the lightmap there.
struct LightmapLight {
    vec3 irradiance{0.0f};
    std::optional<vec3> meanDirection;

    LightmapLight(const LightmapPages& pages, const Texel& texel)
        : irradiance(pages.irradiance[texel.page](texel.x, texel.y))
    {
        if (pages.directions.empty()) return;
        const u8vec4 stored = pages.directions[texel.page](texel.x, texel.y);
        meanDirection = shading::decodeMeanDirection(vec3(stored) / 255.0f);
    }
    [[nodiscard]] SpecularView seen(const SpecularEstimate& surface, vec3 normal, vec3 view) const
    {
        const vec3 f0 = shading::specularF0Of(surface.baseColor, surface.metallic, surface.specular);
        const float f90 = shading::specularF90Of(surface.metallic, surface.specular);
        const float nDotV = std::max(glm::dot(normal, view), 1.0e-4f);
        const vec3 lobe = shading::specularLookup(view, normal, surface.roughness);
        const float scale = meanDirection ? shading::directionalSpecularScale(*meanDirection, normal, normal, view,
                                                                              lobe, surface.roughness)
                                          : 1.0f;
        SpecularView result;
        result.direction = view;
        result.share = shading::environmentSpecular(f0, f90, surface.roughness, nDotV);
        result.own = luminance(result.share * irradiance) * (scale / kPi);
        const vec3 albedo = shading::diffuseAlbedoOf(surface.baseColor, surface.metallic);
        result.diffuse =
            luminance(shading::diffuseRadiance(albedo * shading::diffuseShare(f0, f90, nDotV), irradiance));
        return result;
    }
};

} // namespace

Result<std::vector<SpecularPoint>> specularPoints(const CachedIntegrator& cached, const LightmapPages& pages,
                                                  float sceneSizeMeters, const Progress& progress)
{
    const std::vector<ChosenTexel> chosen = spreadTexels(cached);
    std::vector<SurfacePoint> points;
    std::vector<vec3> views;
    std::vector<Segment> ways;
    for (const ChosenTexel& at : chosen) {
        points.push_back(at.point);
        const vec3 start = at.point.position + at.point.geometricNormal * (1.0e-5f * sceneSizeMeters);
        for (const vec3 view : viewsOf(at.point, uint32_t(points.size()))) {
            views.push_back(view);
            ways.push_back({start, start + view * (kFreeShare * sceneSizeMeters)});
        }
    }
    const Result<SurfacesAlong> hits = surfacesAlong(cached.integrator, ways);
    if (!hits) return hits.error();
    std::vector<SpecularEstimate> estimates(points.size());
    if (Status s = cached.integrator.specularLight(points, views, estimates, progress); !s) return s.error();
    std::vector<SpecularPoint> result;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const LightmapLight light(pages, *chosen[i].texel);
        SpecularPoint point{
            points[i].position, points[i].normal, estimates[i].roughness, luminance(light.irradiance) / kPi, {}};
        for (std::size_t v = 0; v < kViews; ++v) {
            const vec3 view = views[i * kViews + v];
            if ((*hits)[i * kViews + v] || glm::dot(view, points[i].geometricNormal) <= 0.0f) continue;
            point.views.push_back(light.seen(estimates[i], points[i].normal, view));
            point.views.back().truth = luminance(estimates[i].radiance[v]);
        }
        if (!point.views.empty()) result.push_back(std::move(point));
    }
    return result;
}

SpecularError::SpecularError(std::span<const SpecularPoint> points)
{
    double sum = 0.0;
    std::size_t count = 0;
    for (const SpecularPoint& point : points) {
        for (const SpecularView& view : point.views) sum += double(view.truth + view.diffuse);
        count += point.views.size();
    }
    floor_ = std::max(kBlackShare * float(sum / double(std::max<std::size_t>(count, 1))), 1.0e-12f);
}

} // namespace halflight
