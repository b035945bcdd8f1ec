#include "scene/write/meshes/variant_groups.h"

#include <algorithm>

namespace halflight {

namespace {

/// Calls body(index) for the material of each variant of a primitive; what it returns takes the material's place.
template<typename Body> void eachVariant(Json& primitive, const Body& body)
{
    if (!member(member(member(primitive, "extensions"), "KHR_materials_variants"), "mappings").is_array()) return;
    for (Json& mapping : primitive["extensions"]["KHR_materials_variants"]["mappings"])
        if (const Json& material = member(mapping, "material"); material.is_number_integer())
            mapping["material"] = body(material.get<int>());
}

} // namespace

VariantGroups::VariantGroups(DocumentPatcher& patcher, const SourceDocument& source, const BakedScene& baked,
                             const std::vector<int>& inFile)
    : patcher_(patcher), baked_(baked), inFile_(inFile)
{
    if (baked.groups.empty()) return;
    for (const Mesh& mesh : baked.scene.meshes)
        for (const MeshPart& part : mesh.parts) {
            if (mesh.sourceMesh < 0 || part.sourcePrimitive < 0 || part.material < 0) continue;
            const Material& material = baked.scene.materials[std::size_t(part.material)];
            own_.insert(material.sourceMaterial);
            Json primitive = member(element(source.json, "meshes", mesh.sourceMesh), "primitives");
            if (std::size_t(part.sourcePrimitive) >= primitive.size()) continue;
            primitive = Json(primitive[std::size_t(part.sourcePrimitive)]);
            eachVariant(primitive, [&](int index) {
                groupsOf_[index].insert(material.bakedGroup);
                return index;
            });
        }
}

bool VariantGroups::isOfOne(int material) const
{
    const auto groups = groupsOf_.find(material);
    return groups != groupsOf_.end() && groups->second.size() == 1 && own_.count(material) == 0;
}

void VariantGroups::setIn(Json& primitive, int sceneMaterial)
{
    if (sceneMaterial < 0) return;
    const Material& own = baked_.scene.materials[std::size_t(sceneMaterial)];
    if (own.bakedGroup < 0) return;
    eachVariant(primitive, [&](int index) {
        return index == own.sourceMaterial ? inFile_[std::size_t(sceneMaterial)] : memberOf(index, own.bakedGroup);
    });
}

int VariantGroups::memberOf(int material, int group)
{
    const auto [entry, isNew] = made_.try_emplace({material, group}, material);
    if (!isNew) return entry->second;
    const std::vector<Material>& materials = baked_.scene.materials;
    const auto found = std::find_if(materials.begin(), materials.end(),
                                    [&](const Material& each) { return each.sourceMaterial == material; });
    if (found == materials.end() || found->emissiveNits == vec3(0.0f)) return material;
    const vec3 weight = baked_.groups[std::size_t(group)].weight;
    vec3 white = found->emissiveNits;
    for (int c = 0; c < 3; ++c)
        if (weight[c] > 0.0f) white[c] /= weight[c];
    Json& json = patcher_.json["materials"][std::size_t(material)];
    Json copy = json;
    Json& record = copy["extensions"][kMaterialExtension];
    if (record.is_null()) record = {{"castShadows", found->castShadows}, {"receiveShadows", found->receiveShadows}};
    record["baking"] = {{"group", group}, {"white", numbers(white)}};
    if (!isOfOne(material)) return entry->second = patcher_.append("materials", std::move(copy));
    json = std::move(copy);
    return material;
}

} // namespace halflight
