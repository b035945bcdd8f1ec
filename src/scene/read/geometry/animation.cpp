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

void addPointer(AnimatedThings& things, const SourceDocument& document, const std::string& pointer)
{
    addNode(things, targetIn(pointer, "/nodes/"));
    if (const Target mesh = targetIn(pointer, "/meshes/"); mesh.index >= 0 && mesh.member.starts_with("weights")) {
        for (std::size_t n = 0; n < things.morphedNodes.size(); ++n) {
            const auto& node = document.model.nodes[n];
            if (node.mesh == mesh.index && node.weights.empty()) things.morphedNodes[n] = true;
        }
    }
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
    things.movedNodes.resize(document.model.nodes.size());
    things.morphedNodes.resize(document.model.nodes.size());
    // From the JSON: tinygltf drops channels that name no node.
    for (const Json& animation : member(document.json, "animations")) {
        for (const Json& channel : member(animation, "channels")) {
            const Json& target = member(channel, "target");
            const Json& path = member(target, "path");
            const Json& node = member(target, "node");
            if (path.is_string() && node.is_number_unsigned() && node.get<uint64_t>() < things.movedNodes.size())
                addNode(things, {node.get<int>(), path.get<std::string>()});
            const Json& pointer = member(extensionOf(target, "KHR_animation_pointer"), "pointer");
            if (pointer.is_string()) addPointer(things, document, pointer.get<std::string>());
        }
    }
    return things;
}

} // namespace halflight
