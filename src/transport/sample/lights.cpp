#include "transport/sample/lights.h"

#include "halflight/base/mathematics.h"
#include "halflight/shading/sampling.h"

#include <algorithm>

namespace halflight {

static_assert(int(LightType::Directional) == shading::kLightDirectional);
static_assert(int(LightType::Disk) == shading::kLightDisk);

std::vector<PunctualLight> punctualLights(const Scene& scene, LightUse use, const LightComponents& components)
{
    std::vector<PunctualLight> lights;
    for (const Light& light : scene.lights) {
        PunctualLight p;
        p.type = int(light.type);
        p.colorIntensity = light.color * light.intensity;
        p.position = light.position();
        p.axis = light.direction();
        shading::orthonormalBasis(-p.axis, p.tangent, p.bitangent);
        p.range = light.rangeMeters;
        p.spotConstants = shading::spotConstants(light.innerConeRadians, light.outerConeRadians);
        p.cosOuterCone = math::cos(light.outerConeRadians);
        p.area = light.area();
        if (isAreaLight(light.type)) {
            p.halfWidth = light.halfWidth();
            p.halfHeight = light.halfHeight();
        }
        p.radius = light.type == LightType::Directional ? 0.0f : light.radiusMeters;
        p.tanAngularRadius = light.type == LightType::Directional ? math::tan(light.angularRadiusRadians) : 0.0f;
        p.castShadows = light.castShadows ? 1 : 0;
        p.shadowStrength = light.shadowStrength;
        if (use == LightUse::Reference) {
            p.directAtTexels = p.directAtProbes = p.bounces = true;
        } else {
            // Spec S6. Subtractive lightmaps contain the direct light of mixed lights. Probes do not: dynamic objects
            // receive it at run time.
            const bool mixed = light.baking.bakeType == LightMode::Mixed;
            const bool baked = light.baking.bakeType == LightMode::Baked;
            const bool subtractive = mixed && light.baking.mixedMode == MixedLightingMode::Subtractive;
            p.maskOfLight = subtractive && light.baking.occlusionMaskChannel >= 0;
            p.directAtTexels = baked || (subtractive && !p.maskOfLight);
            p.directAtProbes = baked;
            p.bounces = baked || mixed;
            p.indirectMultiplier = light.indirectMultiplier;
            p.channel = light.baking.occlusionMaskChannel;
            p.coloredMask = light.baking.coloredMask;
            if (light.type != LightType::Directional) p.reach = light.baking.reachMeters;
        }
        if (components.count > 0) p.component = components.ofLight[lights.size()];
        lights.push_back(p);
    }
    return lights;
}

LightTree punctualTree(const std::vector<PunctualLight>& lights, int component, std::vector<uint32_t>& itemLights)
{
    std::vector<LightItem> items;
    itemLights.clear();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const PunctualLight& light = lights[i];
        const float power = luminance(light.colorIntensity) * light.area * light.indirectMultiplier;
        if (light.component != component || !light.bounces || light.type == shading::kLightDirectional ||
            !(power > 0.0f))
            continue;
        LightItem item;
        if (light.isArea()) {
            for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)})
                item.bounds.extend(light.position + corner.x * light.halfWidth + corner.y * light.halfHeight);
        }
        item.bounds.extend(light.position);
        item.axis = light.axis;
        item.cosSpread = light.type == shading::kLightSpot ? light.cosOuterCone : light.isArea() ? 1.0f : -1.0f;
        item.power = power;
        item.range = light.range;
        items.push_back(item);
        itemLights.push_back(uint32_t(i));
    }
    return LightTree(items);
}

} // namespace halflight
