#pragma once
// Lights of the scene (punctual and area lights) with their constants, and rays towards them.

#include "transport/sample/light_tree.h"

#include "halflight/bake/integrator.h"
#include "halflight/scene/scene.h"
#include "halflight/shading/light_rays.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace halflight {

/// Irradiance on a surface with a normal from an unoccluded light.
inline vec3 irradianceOn(vec3 normal, const shading::LightSample& light)
{
    return light.illuminance * std::max(glm::dot(normal, light.direction), 0.0f);
}

using shading::LightRay;

/// A light of the scene. Lights with a radius or an angle light a surface as if they were a point, and their size shows
/// in shadows alone; area lights (isArea()) are surfaces in both.
struct PunctualLight : shading::LightSource {
    PunctualLight() : LightSource{}
    {
        type = shading::kLightPoint;
        castShadows = 1;
        shadowStrength = indirectMultiplier = 1.0f;
    }

    float cosOuterCone = -1.0f;
    float area = 1.0f;           ///< m2 of an area light; 1 for others
    bool directAtTexels = false; ///< the lightmap contains its direct light
    bool directAtProbes = false; ///< the probes contain its direct light
    bool bounces = false;        ///< its bounced light is baked
    int channel = -1;
    bool coloredMask = false; ///< BakingOutput::coloredMask
    int component = 0;        ///< LightComponents
    /// Subtractive's main light. Its mask is the transmitted fraction of the light that a texel would receive. A later
    /// stage adds its direct light from the stored mask.
    bool maskOfLight = false;

    [[nodiscard]] bool isArea() const { return shading::isAreaLight(type); }
    /// From a point to the middle of the light; the length is no distance for a directional light.
    [[nodiscard]] vec3 towards(vec3 point) const
    {
        return type == shading::kLightDirectional ? -axis : position - point;
    }
    /// Illuminance and direction at an unoccluded point; not of area lights.
    [[nodiscard]] shading::LightSample at(vec3 point) const { return shading::lightAt(*this, point); }
    /// Unoccluded irradiance.
    [[nodiscard]] vec3 irradianceAt(vec3 point, vec3 normal) const
    {
        if (!isArea()) return irradianceOn(normal, at(point));
        const vec3 toCenter = position - point;
        return radianceAt(point) * shading::areaIrradiance(type, normal, toCenter, halfWidth, halfHeight);
    }
    /// Radiance of an area light as a point receives it: by the range's window.
    [[nodiscard]] vec3 radianceAt(vec3 point) const { return shading::areaRadianceAt(*this, point); }
    /// About the steradians of an area light that reaches a point, at least those of its middle. More than 0.
    [[nodiscard]] float roughSolidAngle(vec3 point) const
    {
        const vec3 toCenter = position - point;
        const float distance = std::max(glm::length(toCenter), 1.0e-6f);
        const float size = 0.5f * std::sqrt(area) / distance;
        const float facing = std::min(-glm::dot(axis, toCenter) / distance + size, 1.0f);
        return std::min(4.0f * size * size * facing, 2.0f * kPi);
    }
    /// Unoccluded irradiance by the part of the light that `ray` from the point stands for; its mean over the unit disc
    /// is irradianceAt().
    [[nodiscard]] vec3 irradianceBy(const LightRay& ray, vec3 point, vec3 normal) const
    {
        return shading::irradianceByRay(*this, ray, point, normal);
    }
    [[nodiscard]] bool reaches(vec3 point) const { return shading::lightReaches(*this, point); }
};

enum class LightUse {
    Bake,      ///< by each light's baking output
    Reference, ///< every light, fully
};
std::vector<PunctualLight> punctualLights(const Scene& scene, LightUse use, const LightComponents& components = {});

using shading::sampleLightRay;

/// Tree over the lights of a component that bounce, without directional ones; `itemLights` receives the light of each
/// item.
LightTree punctualTree(const std::vector<PunctualLight>& lights, int component, std::vector<uint32_t>& itemLights);

} // namespace halflight
