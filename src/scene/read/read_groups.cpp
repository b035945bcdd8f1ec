#include "scene/read/read_groups.h"

#include "halflight/scene/light_groups.h"
#include "halflight/scene/turning_lights.h"
#include "scene/format/bake_members.h"
#include "scene/read/read_baked.h"
#include "scene/read/read_reflections.h"

#include <algorithm>

namespace halflight {
namespace {

std::string pathOfGroup(std::size_t group)
{
    return kBakePath + "/groups/" + std::to_string(group);
}

} // namespace

Status readGroups(const Json& root, BakedScene& baked)
{
    const Json& groups = member(root, "groups");
    if (groups.is_null()) {
        for (Light& light : baked.scene.lights) {
            light.baking.group = -1;
            light.baking.turning = {};
        }
        for (Material& material : baked.scene.materials) material.bakedGroup = -1;
        return {};
    }
    if (!groups.is_array() || groups.size() > kMostLightGroups || member(root, "version") != kLayeredVersion)
        return invalid(kBakePath, "groups is no list of at most " + std::to_string(kMostLightGroups) +
                                      ", or the version has no groups");
    for (std::size_t g = 0; g < groups.size(); ++g) {
        BakedGroup group;
        group.name = stringOf(groups[g], "name");
        const bool taken = std::ranges::find(baked.groups, group.name, &BakedGroup::name) != baked.groups.end();
        if (group.name.empty() || taken) return invalid(pathOfGroup(g), "has no name of its own");
        if (!readVector(member(groups[g], "weight"), group.weight))
            return invalid(pathOfGroup(g), "weight is not three numbers");
        if (const Json& color = member(groups[g], "shadowColor");
            !color.is_null() && !readVector(color, group.shadowColor))
            return invalid(pathOfGroup(g), "shadowColor is not three numbers");
        const Json& peak = member(groups[g], "peak");
        group.peakLux = peak.is_number() ? peak.get<float>() : 0.0f;
        group.sky = member(groups[g], "sky") == true;
        group.direct = !groups[g].contains("lightmapEncoding");
        baked.groups.push_back(std::move(group));
    }
    for (const Light& light : baked.scene.lights)
        if (light.baking.group >= int(groups.size()))
            return invalid(kBakePath, "light \"" + light.name + "\" is in a light group that the file lacks");
    for (const Light& light : baked.scene.lights) {
        const TurningLight& turning = light.baking.turning;
        const std::size_t end = std::size_t(std::max(turning.group, 0)) + turning.directions.size();
        if (turns(light) && (turning.directions.empty() || end > groups.size() || light.baking.group >= 0))
            return invalid(kBakePath, "light \"" + light.name + "\" turns by light groups that the file lacks");
    }
    for (const Material& material : baked.scene.materials)
        if (material.bakedGroup >= int(groups.size()))
            return invalid(kBakePath, "material \"" + material.name + "\" is in a light group that the file lacks");
    return {};
}

Status readGroupProbes(const SourceDocument& document, const Json& root, BakedScene& baked)
{
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const std::size_t count = baked.probes.probes.size();
        const Json& record = root["groups"][g];
        if (count == 0 && !record.contains("radiance")) continue;
        const auto index = accessorIndex(document, record, "radiance", 9 * count, pathOfGroup(g));
        if (!index) return index.error();
        const auto values = readVectors<3>(document, *index);
        if (!values) return values.error();
        baked.groups[g].radiance.resize(count);
        for (std::size_t i = 0; i < 9 * count; ++i) baked.groups[g].radiance[i / 9][i % 9] = (*values)[i];
    }
    return {};
}

Status readGroupReflections(const SourceDocument& document, const Json& root, BakedScene& baked)
{
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const Json& json = member(root["groups"][g], "reflections");
        if (json.is_null()) continue;
        if (Status s = readReflectionPicture(document, json, baked.reflections.probes.size(),
                                             pathOfGroup(g) + "/reflections", baked.groups[g].reflections);
            !s)
            return s;
    }
    return {};
}

} // namespace halflight
