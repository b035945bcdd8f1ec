#include "halflight/scene/object_names.h"

#include "scene/read/geometry/nodes.h"

namespace halflight {

std::vector<std::size_t> objectsNamed(const Scene& scene, std::string_view name)
{
    const Json none;
    const Json& nodes = scene.source ? member(scene.source->json, "nodes") : none;
    const std::vector<int> parents = parentsOf(nodes);
    const auto isNode = [&](int node) {
        return node >= 0 && node < int(parents.size()) && stringOf(nodes[std::size_t(node)], "name") == name;
    };
    std::vector<std::size_t> own;
    std::vector<std::size_t> below;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        int node = scene.objects[i].sourceNode;
        if (scene.objects[i].name == name || isNode(node)) own.push_back(i);
        while (node >= 0 && node < int(parents.size()) && !isNode(node)) node = parents[std::size_t(node)];
        if (isNode(node)) below.push_back(i);
    }
    return own.empty() ? below : own;
}

} // namespace halflight
