// Which light group emission is of: that of its object's node (spec S33).
#include "halflight/scene/light_groups.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace halflight {

void groupEmission(Scene& scene, const std::vector<std::string>& groups)
{
    using Place = std::pair<int, std::string>;       // a mesh or a material, and a group
    std::map<int, std::set<std::string>> ofMaterial; // groups of its objects
    std::map<int, std::set<std::string>> ofMesh;
    const auto emits = [&](const MeshPart& part) { return materialOf(scene, part).emissiveNits != vec3(0.0f); };
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const int mesh = scene.objects[i].mesh;
        ofMesh[mesh].insert(groups[i]);
        for (const MeshPart& part : scene.meshes[std::size_t(mesh)].parts)
            if (part.material >= 0 && emits(part)) ofMaterial[part.material].insert(groups[i]);
    }
    std::map<Place, int> materials;
    const auto materialIn = [&](int material, const std::string& group) {
        if (scene.materials[std::size_t(material)].group == group) return material;
        const auto [entry, isNew] = materials.try_emplace({material, group}, material);
        if (!isNew) return entry->second;
        if (ofMaterial[material].size() > 1) {
            entry->second = int(scene.materials.size());
            scene.materials.push_back(Material(scene.materials[std::size_t(material)]));
        }
        scene.materials[std::size_t(entry->second)].group = group;
        return entry->second;
    };
    std::map<Place, int> meshes;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const std::string& group = groups[i];
        int& mesh = scene.objects[i].mesh;
        const std::vector<MeshPart>& parts = scene.meshes[std::size_t(mesh)].parts;
        if (group.empty() || std::ranges::none_of(parts, emits)) continue;
        const auto [entry, isNew] = meshes.try_emplace({mesh, group}, mesh);
        if (isNew) {
            if (ofMesh[mesh].size() > 1) {
                entry->second = int(scene.meshes.size());
                scene.meshes.push_back(Mesh(scene.meshes[std::size_t(mesh)]));
            }
            for (MeshPart& part : scene.meshes[std::size_t(entry->second)].parts)
                if (part.material >= 0 && emits(part)) part.material = materialIn(part.material, group);
        }
        mesh = entry->second;
    }
}

} // namespace halflight
