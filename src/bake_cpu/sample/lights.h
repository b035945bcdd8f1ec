#pragma once
// Punctual lights with their constants, and rays towards them.

#include "bake_cpu/sample/light_tree.h"

#include "halflight/scene/scene.h"
#include "halflight/shading/light.h"

#include <vector>

namespace halflight {

/// Irradiance on a surface with a normal from an unoccluded light.
inline vec3 irradianceOn(vec3 normal, const shading::LightSample& light)
{
    return light.illuminance * std::max(glm::dot(normal, light.direction), 0.0f);
}

struct PunctualLight {
    int type = shading::kLightPoint;
    vec3 colorIntensity{0.0f};
    vec3 position{0.0f};
    vec3 axis{0.0f};
    vec3 tangent{0.0f}; ///< with bitangent and axis an orthonormal basis
    vec3 bitangent{0.0f};
    float range = 0.0f;
    float reach = 0.0f; ///< metres covered by the light's mask channel; 0 = unlimited
    vec2 spotConstants{0.0f};
    float cosOuterCone = -1.0f;
    float radius = 0.0f;           ///< metres; point and spot
    float tanAngularRadius = 0.0f; ///< directional
    bool castShadows = true;
    float shadowStrength = 1.0f;
    float indirectMultiplier = 1.0f;
    bool directAtTexels = false; ///< the lightmap contains its direct light
    bool directAtProbes = false; ///< the probes contain its direct light
    bool bounces = false;        ///< its bounced light is baked
    int channel = -1;
    /// Subtractive's main light. Its mask is the transmitted fraction of the light that a texel would receive. A later
    /// stage adds its direct light from the stored mask.
    bool maskOfLight = false;

    /// Illuminance and direction at an unoccluded point.
    [[nodiscard]] shading::LightSample at(vec3 point) const
    {
        return shading::sampleLight(type, colorIntensity, position, axis, range, spotConstants, point);
    }
    [[nodiscard]] vec3 irradianceAt(vec3 point, vec3 normal) const { return irradianceOn(normal, at(point)); }
    /// Whether a point is within range, reach and cone. A light with intensity 0 has a mask too, because it may be
    /// switched on at run time (spec S29).
    [[nodiscard]] bool reaches(vec3 point) const
    {
        const shading::LightSample light =
            shading::sampleLight(type, vec3(1.0f), position, axis, range, spotConstants, point);
        return light.illuminance.x > 0.0f && (reach <= 0.0f || light.distance <= reach);
    }
};

enum class LightUse {
    Bake,      ///< by each light's baking output
    Reference, ///< every light, fully
};
std::vector<PunctualLight> punctualLights(const Scene& scene, LightUse use);

/// Ray from `origin` to a point of the light's sphere or of the sun's disc; `disc` is in the unit disc.
struct LightRay {
    vec3 direction{0.0f};
    float distance = 0.0f;
};
LightRay sampleLightRay(const PunctualLight& light, vec3 origin, vec2 disc);

/// Tree over the point and spot lights that bounce; `itemLights` receives the light of each item.
LightTree punctualTree(const std::vector<PunctualLight>& lights, std::vector<uint32_t>& itemLights);

} // namespace halflight
