#include "halflight/scene/object_names.h"

#include "scene/document/document.h"

namespace halflight {
namespace {

/// By node of the scene's file, the one above it or -1.
std::vector<int> parentsOf(const Scene& scene)
{
    if (!scene.source) return {};
    const auto& nodes = scene.source->model.nodes;
    std::vector<int> parents(nodes.size(), -1);
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (const int child : nodes[n].children) parents[std::size_t(child)] = int(n);
    return parents;
}

} // namespace

std::vector<std::size_t> objectsNamed(const Scene& scene, std::string_view name)
{
    const std::vector<int> parents = parentsOf(scene);
    const auto isNode = [&](int node) {
        return node >= 0 && node < int(parents.size()) && scene.source->model.nodes[std::size_t(node)].name == name;
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
