#include "scene/read/check_bake.h"

#include "halflight/base/text.h"
#include "scene/format/at_bake.h"
#include "scene/format/bake_members.h"
#include "scene/format/sky_at_bake.h"
#include "scene/read/geometry/nodes.h"
#include "scene/settings/settings.h"

#include <algorithm>
#include <map>

namespace halflight {

namespace {

constexpr const char* kKeepBake =
    "; use the file that the bake wrote, or a tool that keeps its extensions (docs/format.md, \"Tools\")";

using ObjectsOfNode = std::map<int, std::vector<const Object*>>;

ObjectsOfNode objectsOfNodes(const Scene& scene)
{
    ObjectsOfNode objects;
    for (const Object& object : scene.objects) objects[object.sourceNode].push_back(&object);
    return objects;
}

std::vector<std::string> sentencesOf(const Light& light)
{
    return changesSinceBake(light, "light \"" + light.name + "\"", light.baking.occlusionMaskChannel >= 0);
}

void checkLights(Scene& scene)
{
    std::vector<std::string> changed; // in what no sentence speaks of: a size, say
    for (const Light& light : scene.lights) {
        const std::vector<std::string> sentences = sentencesOf(light);
        for (const std::string& sentence : sentences) scene.warnings.push_back("is stale: " + sentence);
        const bool isBaked = light.baking.isBaked && light.baking.bakeType != LightMode::Realtime;
        if (isBaked && sentences.empty() && shapeChangedSinceBake(light)) changed.push_back(light.name);
    }
    if (changed.empty()) return;
    scene.warnings.push_back("is stale: changed since its bake: lights " + listOf(changed) +
                             "; baked light and shadows are those of before, bake the scene again");
}

const Json& nodeRecord(const SourceDocument& document, int node)
{
    return extensionOf(element(document.json, "nodes", node), "HALFLIGHT_node");
}

void checkObjects(const SourceDocument& document, const glm::dvec3& shift, Scene& scene)
{
    const AtBake atBake(scene);
    std::vector<std::string> changed;
    for (const auto& [node, objects] : objectsOfNodes(scene)) {
        const Json& record = nodeRecord(document, node);
        if (!record.is_object()) continue; // checkLosses() names it
        const auto now = atBake.ofObjects(objects);
        const auto then = SurfaceAtBake::from(member(record, "atBake"), shift);
        if (now.has_value() != then.has_value() || (now && now->differsFrom(*then)))
            changed.push_back(objects.front()->name);
    }
    if (changed.empty()) return;
    scene.warnings.push_back("is stale: changed since its bake: objects " + listOf(changed) +
                             "; their light and shadows are those of before, bake the scene again");
}

// What the file had and has no more.
void checkLosses(const SourceDocument& document, const Json& atBake, BakedScene& baked)
{
    std::size_t lightmapped = 0;
    std::size_t staticNodes = 0;
    std::vector<std::string> unrecorded;
    for (const auto& [node, objects] : objectsOfNodes(baked.scene)) {
        const auto any = [&, &objects = objects](auto has) {
            return std::any_of(objects.begin(), objects.end(), [&](const Object* object) { return has(*object); });
        };
        lightmapped += any([](const Object& object) { return object.lightmap.page >= 0; });
        staticNodes += any([](const Object& object) { return object.isStatic; });
        if (!nodeRecord(document, node).is_object()) unrecorded.push_back(objects.front()->name);
    }
    const auto lights =
        std::size_t(std::count_if(baked.scene.lights.begin(), baked.scene.lights.end(), [](const Light& light) {
            return light.baking.isBaked && light.baking.bakeType != LightMode::Realtime;
        }));
    const auto check = [&](const char* key, std::size_t now, const char* what) {
        const Json& then = member(atBake, key);
        if (!then.is_number_unsigned() || then.get<uint64_t>() <= now) return;
        baked.lost.push_back(std::to_string(then.get<uint64_t>() - now) + " of " +
                             std::to_string(then.get<uint64_t>()) + " " + what);
    };
    check("lightmappedNodes", lightmapped, "objects' places in the lightmap");
    check("staticNodes", staticNodes, "static objects");
    check("bakedLights", lights, "baked lights");
    if (!unrecorded.empty()) {
        baked.lost.push_back("the records of objects " + listOf(unrecorded) +
                             " (or they were added since): probes light them");
    }
}

// Of the root extension: lightmaps, masks, probes. Files of earlier versions have no list of them.
void checkMembers(const Json& root, BakedScene& baked)
{
    const std::vector<std::string> lost = lostMembers(root);
    for (const std::string& name : lost) baked.lost.push_back("its " + name);
    const bool hasMask = std::any_of(baked.scene.lights.begin(), baked.scene.lights.end(), [](const Light& light) {
        return light.baking.isBaked && light.baking.occlusionMaskChannel >= 0;
    });
    if (lost.empty() && baked.mode == MixedLightingMode::Shadowmask && hasMask && !baked.lightmaps.empty() &&
        baked.shadowmasks.empty())
        baked.lost.emplace_back("its shadowmasks");
}

void warnOfLosses(BakedScene& baked)
{
    for (const std::string& lost : baked.lost)
        baked.scene.warnings.push_back("has lost part of its bake: " + lost + kKeepBake);
}

} // namespace

void checkAgainstBake(const SourceDocument& document, const Json& root, const glm::dvec3& shift, BakedScene& baked)
{
    Scene& scene = baked.scene;
    checkLights(scene);
    const Json& atBake = member(root, "atBake");
    if (atBake.is_object()) {
        checkObjects(document, shift, scene);
        if (skyDiffersFrom(scene.sky, member(atBake, "sky")))
            scene.warnings.emplace_back("is stale: the sky changed since its bake; bake the scene again");
        checkLosses(document, atBake, baked);
    }
    checkMembers(root, baked);
    warnOfLosses(baked);
}

void checkLostBake(const SourceDocument& document, BakedScene& baked)
{
    const Json& mark = member(member(activeScene(document), "extras"), kBakeMark);
    const Json& nodes = member(document.json, "nodes");
    const bool hasRecords = std::any_of(nodes.begin(), nodes.end(), [](const Json& node) {
        return !extensionOf(node, "HALFLIGHT_node").is_null() || !extensionOf(node, "HALFLIGHT_light").is_null();
    });
    if (!mark.is_string() && !hasRecords) return;
    baked.lost.push_back("all of it" + (mark.is_string() ? " (" + mark.get<std::string>() + ")" : std::string()));
    warnOfLosses(baked);
}

// Extras of a baked file give way to its record, so what differs from the record comes from a settings file.
void checkSettingsOfBake(const SourceDocument& document, const Json& root, Scene& scene)
{
    const auto add = [&](const std::string& what, const std::vector<std::string>& names) {
        if (names.empty()) return;
        scene.warnings.push_back("settings file: " + what + " of " + listOf(names) +
                                 " has no effect on a baked file; bake the scene again with these settings");
    };
    const auto differs = [](const Json& recorded, float now) {
        return recorded.is_number() && recorded.get<float>() != now;
    };
    std::vector<std::string> mode;
    std::vector<std::string> multiplier;
    std::vector<std::string> added;
    for (const Light& light : scene.lights) {
        const Json& record = extensionOf(element(document.json, "nodes", light.sourceNode), "HALFLIGHT_light");
        if (!record.is_object()) {
            if (light.mode != LightMode::Realtime) added.push_back(light.name);
            continue;
        }
        const Json& recorded = member(record, "mode");
        if (recorded.is_string() && recorded != nameOf(light.mode)) mode.push_back(light.name);
        if (differs(member(record, "indirectMultiplier"), light.indirectMultiplier)) multiplier.push_back(light.name);
    }
    add("mode", mode);
    add("indirect_multiplier", multiplier);
    if (!added.empty()) {
        scene.warnings.push_back("lights " + listOf(added) +
                                 " are not in the bake: they light at run time, without baked shadows and bounced "
                                 "light; bake the scene again");
    }
    std::vector<std::string> density;
    for (const Object& object : scene.objects) {
        const Json& record = extensionOf(document.json["nodes"][std::size_t(object.sourceNode)], "HALFLIGHT_node");
        const Json& scale = member(record, "lightmapScale");
        if (record.is_object() && (scale.is_number() ? scale.get<float>() : 1.0f) != object.lightmapScale)
            density.push_back(object.name);
    }
    add("lightmap_scale", density);
    const Json& probes = member(root, "authoredProbes");
    if (probes.size() != scene.probePositions.size())
        scene.warnings.emplace_back(
            "settings file: probes has no effect on a baked file; bake the scene again with these settings");
}

} // namespace halflight
