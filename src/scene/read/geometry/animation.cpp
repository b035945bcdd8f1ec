#include "scene/read/geometry/animation.h"

#include <charconv>

namespace halflight {

namespace {

// "/nodes/3/translation" of array "/nodes/": 3 and "translation"; no index where the pointer leads elsewhere.
struct Target {
    int index = -1;
    std::string member;
};
Target targetIn(const std::string& pointer, std::string_view array)
{
    Target target;
    if (!pointer.starts_with(array)) return target;
    const char* end = pointer.data() + pointer.size();
    const auto [rest, error] = std::from_chars(pointer.data() + array.size(), end, target.index);
    if (error != std::errc() || rest == end || *rest != '/') return {};
    target.member.assign(rest + 1, end);
    return target;
}

void addNode(AnimatedThings& things, const Target& target)
{
    if (target.index < 0 || std::size_t(target.index) >= things.movedNodes.size()) return;
    const std::string& member = target.member;
    if (member == "translation" || member == "rotation" || member == "scale" || member == "matrix" ||
        member == "extensions/KHR_node_visibility/visible") {
        things.movedNodes[std::size_t(target.index)] = true;
    }
    if (member.starts_with("weights")) things.morphedNodes[std::size_t(target.index)] = true;
}

void addPointer(AnimatedThings& things, std::set<int>& morphedMeshes, const std::string& pointer)
{
    addNode(things, targetIn(pointer, "/nodes/"));
    if (const Target mesh = targetIn(pointer, "/meshes/"); mesh.index >= 0 && mesh.member.starts_with("weights"))
        morphedMeshes.insert(mesh.index);
    if (const Target light = targetIn(pointer, "/extensions/KHR_lights_punctual/lights/"); light.index >= 0)
        things.lights[light.index].insert(light.member);
    if (const Target light = targetIn(pointer, "/extensions/EXT_lights_area/lights/"); light.index >= 0)
        things.areaLights[light.index].insert(light.member);
    if (const Target material = targetIn(pointer, "/materials/"); material.index >= 0)
        things.materials[material.index].insert(material.member);
}

} // namespace

AnimatedThings animatedThings(const SourceDocument& document)
{
    AnimatedThings things;
    const Json& nodes = member(document.json, "nodes");
    things.movedNodes.resize(nodes.size());
    things.morphedNodes.resize(nodes.size());
    std::set<int> morphedMeshes;
    for (const Json& animation : member(document.json, "animations")) {
        for (const Json& channel : member(animation, "channels")) {
            const Json& target = member(channel, "target");
            addNode(things, {integerOf(target, "node"), stringOf(target, "path")});
            addPointer(things, morphedMeshes, stringOf(extensionOf(target, "KHR_animation_pointer"), "pointer"));
        }
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (morphedMeshes.contains(integerOf(nodes[n], "mesh")) && member(nodes[n], "weights").empty())
            things.morphedNodes[n] = true;
    }
    return things;
}

} // namespace halflight
