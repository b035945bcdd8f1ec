// Settings of one source over those of another, and over what a file says.
#include "scene/settings/settings.h"

namespace halflight {

ObjectSettings mergeSettings(const ObjectSettings& weaker, const ObjectSettings& stronger)
{
    ObjectSettings merged = weaker;
    if (stronger.isStatic) merged.isStatic = stronger.isStatic;
    if (stronger.castShadows) merged.castShadows = stronger.castShadows;
    if (stronger.receiveShadows) merged.receiveShadows = stronger.receiveShadows;
    if (stronger.lightmapScale) merged.lightmapScale = stronger.lightmapScale;
    if (stronger.twoSided) merged.twoSided = stronger.twoSided;
    if (stronger.probeLighting) merged.probeLighting = stronger.probeLighting;
    if (stronger.probeResolution) merged.probeResolution = stronger.probeResolution;
    if (stronger.reflectionProbe) merged.reflectionProbe = stronger.reflectionProbe;
    if (stronger.areaLight) merged.areaLight = stronger.areaLight;
    if (stronger.group) merged.group = stronger.group;
    return merged;
}

SceneSettings mergeSettings(const SceneSettings& weaker, const SceneSettings& stronger)
{
    SceneSettings merged = weaker;
    const bool colored = stronger.skyZenith || stronger.skyHorizon || stronger.skyGround;
    if (colored || stronger.skyImage) {
        merged.skyImage = stronger.skyImage;
        merged.skyOfBake = stronger.skyOfBake;
    }
    if (stronger.skyImage || stronger.skyOfBake) {
        merged.skyZenith = merged.skyHorizon = merged.skyGround = std::nullopt;
        merged.skyRotationDegrees = merged.skyIntensity = std::nullopt;
    }
    if (stronger.skyRotationDegrees) merged.skyRotationDegrees = stronger.skyRotationDegrees;
    if (stronger.skyIntensity) merged.skyIntensity = stronger.skyIntensity;
    if (stronger.skyZenith) merged.skyZenith = stronger.skyZenith;
    if (stronger.skyHorizon) merged.skyHorizon = stronger.skyHorizon;
    if (stronger.skyGround) merged.skyGround = stronger.skyGround;
    if (stronger.skyGroup) merged.skyGroup = stronger.skyGroup;
    if (stronger.skyChanges) merged.skyChanges = stronger.skyChanges;
    if (stronger.emissionUnit) merged.emissionUnit = stronger.emissionUnit;
    if (stronger.shadowColor) merged.shadowColor = stronger.shadowColor;
    if (stronger.probes) merged.probes = stronger.probes;
    return merged;
}

void applySettings(const LightSettings& settings, Light& light)
{
    light.mode = settings.mode.value_or(light.mode);
    light.castShadows = settings.castShadows.value_or(light.castShadows);
    light.shadowStrength = settings.shadowStrength.value_or(light.shadowStrength);
    light.indirectMultiplier = settings.indirectMultiplier.value_or(light.indirectMultiplier);
    light.radiusMeters = settings.radiusMeters.value_or(light.radiusMeters);
    if (settings.angularDiameterDegrees)
        light.angularRadiusRadians = glm::radians(0.5f * *settings.angularDiameterDegrees);
    light.sizeMeters = settings.sizeMeters.value_or(light.sizeMeters);
    const auto assign = [](const std::optional<float>& from, std::optional<float>& to) {
        if (from) to = from;
    };
    assign(settings.shadowBias.depthTexels, light.shadowBias.depthTexels);
    assign(settings.shadowBias.slope, light.shadowBias.slope);
    assign(settings.shadowBias.normalTexels, light.shadowBias.normalTexels);
    light.rangeMeters = settings.rangeMeters.value_or(light.rangeMeters);
    light.intensity = settings.intensity.value_or(light.intensity);
    light.color = settings.color.value_or(light.color);
    light.group = settings.group.value_or(light.group);
    light.directions = settings.directions.value_or(light.directions);
}

void applySettings(const MaterialSettings& settings, Material& material)
{
    material.castShadows = settings.castShadows.value_or(material.castShadows);
    material.receiveShadows = settings.receiveShadows.value_or(material.receiveShadows);
    material.tinted = settings.tinted.value_or(material.tinted);
    material.group = settings.group.value_or(material.group);
}

} // namespace halflight
