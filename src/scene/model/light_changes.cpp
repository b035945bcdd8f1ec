// What was changed of a light since its bake, and what of it shows (spec S29).
#include "halflight/scene/turning_lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace halflight {
namespace {

/// Relative, for values that went through a file; radians for cones.
constexpr float kTolerance = 1.0e-3f;

bool differ(float a, float b)
{
    return std::abs(a - b) > kTolerance * std::max(std::abs(a), std::abs(b));
}

bool differ(vec3 a, vec3 b)
{
    return glm::distance(a, b) > kTolerance * std::max(glm::length(a), glm::length(b));
}

std::string number(float value, const char* unit)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g", double(value));
    return text.data() + std::string(unit);
}

std::string rangeText(float rangeMeters)
{
    return rangeMeters > 0.0f ? number(rangeMeters, " m") : "unlimited";
}

/// "colour or intensity, range": values of which a lightmap holds the old ones.
std::string changedValues(const Light& light)
{
    const LightAtBake& was = light.baking.atBake;
    std::string list;
    const auto add = [&](bool changed, const char* what) {
        if (changed) list += (list.empty() ? "" : ", ") + std::string(what);
    };
    add(differ(light.color * light.intensity, was.colorIntensity), "colour or intensity");
    add(light.type != LightType::Directional && differ(light.rangeMeters, was.rangeMeters), "range");
    add(light.type == LightType::Spot &&
            (std::abs(light.outerConeRadians - light.baking.outerConeRadians) > kTolerance ||
             std::abs(light.innerConeRadians - was.innerConeRadians) > kTolerance),
        "cone");
    const vec2 size = lightAtBake(light).sizeMeters;
    add(was.sizeMeters.x >= 0.0f && (differ(size.x, was.sizeMeters.x) || differ(size.y, was.sizeMeters.y)), "size");
    add(light.castShadows != was.castShadows, "shadow switch");
    add(differ(light.shadowStrength, was.shadowStrength), "shadow strength");
    return list;
}

/// A mixed light whose bounced light was baked and no longer fits its direct light; empty where it does.
std::string bouncedLightOf(const Light& light, const std::string& name)
{
    const LightAtBake& was = light.baking.atBake;
    if (!(was.indirectMultiplier > 0.0f)) return {};
    const float before = luminance(was.colorIntensity);
    const float now = luminance(light.color) * light.intensity;
    if (now <= before * kBouncedLightFactor && before <= now * kBouncedLightFactor) return {};
    std::string how;
    if (before <= 0.0f) {
        how = " was dark at its bake";
    } else if (now <= 0.0f) {
        how = " was turned off after the bake";
    } else {
        how = now > before ? " is brighter by a factor of " + number(now / before, "") + " than at its bake"
                           : " is dimmer by a factor of " + number(before / now, "") + " than at its bake";
    }
    return name + how +
           ", and its bounced light stays as baked; bake the scene again, with an indirect multiplier of 0 for lights "
           "that change by much";
}

/// A reach beyond that of the bake; empty where it did not grow.
std::string grownReachOf(const Light& light, const std::string& name)
{
    const LightAtBake& was = light.baking.atBake;
    std::string how;
    std::string beyond;
    const bool farther = was.rangeMeters > 0.0f &&
                         (light.rangeMeters <= 0.0f || light.rangeMeters > was.rangeMeters * (1.0f + kTolerance));
    if (light.type != LightType::Directional && farther) {
        how = "range of " + name + " is " + rangeText(light.rangeMeters) + ", and was " + rangeText(was.rangeMeters);
        beyond = rangeText(was.rangeMeters);
    } else if (light.type == LightType::Spot && light.outerConeRadians > light.baking.outerConeRadians + kTolerance) {
        how = "cone of " + name + " is " + number(glm::degrees(light.outerConeRadians), " degrees") + ", and was " +
              number(glm::degrees(light.baking.outerConeRadians), " degrees");
        beyond = number(glm::degrees(light.baking.outerConeRadians), " degrees");
    } else {
        return {};
    }
    return "the " + how + " at its bake: beyond " + beyond +
           " it has no baked shadow and no bounced light; bake the scene again";
}

/// A light that turns, away from all directions of its bake; empty where it is near one.
std::string turnedAway(const Light& light, const std::string& name)
{
    if (!turns(light)) return {};
    const float away = angleToNearest(light.baking.turning.directions, light.direction());
    if (away <= kMostStepRadians + kTolerance) return {};
    return name + " shines " + number(glm::degrees(away), " degrees") +
           " away from the nearest direction of its bake: its bounced light is that of there, dimmed; bake the scene "
           "again, with this direction among its halflight_directions";
}

} // namespace

LightAtBake lightAtBake(const Light& light)
{
    LightAtBake result;
    result.known = true;
    result.colorIntensity = light.color * light.intensity;
    result.indirectMultiplier = light.indirectMultiplier;
    result.rangeMeters = light.rangeMeters;
    result.innerConeRadians = light.innerConeRadians;
    result.castShadows = light.castShadows;
    result.shadowStrength = light.shadowStrength;
    result.radiusMeters = light.radiusMeters;
    result.angularRadiusRadians = light.angularRadiusRadians;
    if (light.type == LightType::Rectangle) result.sizeMeters = light.sizeMeters;
    if (light.type == LightType::Disk) result.sizeMeters = vec2(light.sizeMeters.x);
    return result;
}

bool directLightIsBaked(const Light& light)
{
    const BakingOutput& baking = light.baking;
    return baking.isBaked &&
           (baking.bakeType == LightMode::Baked ||
            (baking.bakeType == LightMode::Mixed && baking.mixedMode == MixedLightingMode::Subtractive));
}

std::vector<std::string> changesSinceBake(const Light& light, const std::string& name, bool bakedShadows)
{
    const BakingOutput& baking = light.baking;
    std::vector<std::string> sentences;
    if (!baking.isBaked || baking.bakeType == LightMode::Realtime) return sentences;
    if (movedSinceBake(light)) {
        sentences.push_back(name + " was moved after the bake; its baked " +
                            (bakedShadows ? "shadows are" : "light is") + " out of step");
    }
    if (!baking.atBake.known) return sentences;
    if (directLightIsBaked(light)) {
        const std::string values = changedValues(light);
        if (values.empty()) return sentences;
        const bool overflowed = baking.bakeType == LightMode::Baked && light.mode == LightMode::Mixed;
        if (overflowed)
            sentences.push_back("the change of " + name + " (" + values +
                                ") has no effect: no shadowmask channel was left for it, so it is fully baked; bake "
                                "the scene again, with " +
                                (light.type == LightType::Directional
                                     ? "fewer mixed lights"
                                     : "a shorter range or fewer mixed lights around it"));
        else if (baking.bakeType == LightMode::Baked)
            sentences.push_back("the change of " + name + " (" + values +
                                ") has no effect: it is fully baked; bake the scene again, as a mixed light if it is "
                                "to change at run time");
        else
            sentences.push_back("the change of " + name + " (" + values +
                                ") does not show on static objects: subtractive mode bakes its light into the "
                                "lightmap; bake the scene again, or use shadowmask mode");
        return sentences;
    }
    for (const std::string& sentence :
         {bouncedLightOf(light, name), grownReachOf(light, name), turnedAway(light, name)}) {
        if (!sentence.empty()) sentences.push_back(sentence);
    }
    return sentences;
}

} // namespace halflight
