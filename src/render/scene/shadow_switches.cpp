#include "render/scene/shadow_switches.h"

#include "halflight/base/text.h"
#include "halflight/shading/law.h"

#include <algorithm>

namespace halflight {

std::vector<ShadowSwitches> shadowSwitches(const Scene& scene)
{
    std::vector<ShadowSwitches> switches;
    for (const Object& object : scene.objects) switches.push_back({object.castShadows, object.receiveShadows});
    return switches;
}

std::vector<std::string> switchWarnings(const BakedScene& baked, const std::vector<ShadowSwitches>& atBake,
                                        RunMode mode)
{
    if (!baked.isBaked || mode == RunMode::Realtime) return {};
    const auto anyLight = [&](const auto& test) {
        return std::any_of(baked.scene.lights.begin(), baked.scene.lights.end(), test);
    };
    const bool subtractive = mode == RunMode::Subtractive;
    const bool inLightmap = anyLight([&](const Light& light) {
        return light.baking.isBaked && (light.baking.bakeType == LightMode::Baked ||
                                        (subtractive && light.baking.bakeType == LightMode::Mixed));
    });
    const bool inMask = shading::modeUsesBakedShadows(int(mode)) && anyLight([](const Light& light) {
                            return light.baking.isBaked && light.baking.occlusionMaskChannel >= 0;
                        });
    std::vector<std::string> castOff;
    std::vector<std::string> castOn;
    std::vector<std::string> receiveOff;
    std::vector<std::string> receiveOn;
    for (std::size_t i = 0; i < atBake.size(); ++i) {
        const Object& object = baked.scene.objects[i];
        if (!object.isStatic) continue;
        const ShadowSwitches before = atBake[i];
        if (before.cast != object.castShadows && (inLightmap || inMask))
            (before.cast ? castOff : castOn).push_back(object.name);
        if (before.receive == object.receiveShadows || object.lightmap.page < 0) continue;
        if (before.receive && inLightmap) receiveOff.push_back(object.name);
        if (!before.receive && (inLightmap || inMask)) receiveOn.push_back(object.name);
    }
    std::vector<std::string> warnings;
    const auto say = [&](const std::vector<std::string>& names, const char* what) {
        if (!names.empty()) warnings.push_back("objects " + listOf(names) + what);
    };
    say(castOff, ": castShadows was switched off since the bake; their baked shadows stay until another bake");
    say(castOn, ": castShadows was switched on since the bake; baked shadows lack theirs until another bake");
    say(receiveOff,
        ": receiveShadows was switched off since the bake; shadows in their lightmap stay until another bake");
    say(receiveOn, ": receiveShadows was switched on since the bake; they have no baked shadows until another bake");
    return warnings;
}

} // namespace halflight
