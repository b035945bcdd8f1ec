#include "scene/format/strip.h"

#include "scene/document/texture_coordinates.h"
#include "scene/format/lightmap_layout.h"

#include <map>
#include <set>
#include <string>

namespace halflight {

namespace {

// Removes the listed elements where they are the last of their array (the writer puts them there): no index shifts.
template<typename Element>
void removeLast(Json& json, const char* array, std::vector<Element>& elements, const std::vector<std::size_t>& indices)
{
    std::size_t first = elements.size();
    for (std::size_t i = indices.size(); i-- > 0 && indices[i] + 1 == first;) first = indices[i];
    if (first == elements.size()) return;
    Json& list = json[array];
    list.erase(list.begin() + std::ptrdiff_t(first), list.end());
    elements.erase(elements.begin() + std::ptrdiff_t(first), elements.end());
    if (list.empty()) json.erase(array);
}

std::vector<std::size_t> indicesOf(const Json& list, std::size_t limit)
{
    std::vector<std::size_t> indices;
    if (!list.is_array()) return indices;
    for (const Json& item : list) {
        if (item.is_number_unsigned() && item.get<uint64_t>() < limit) indices.push_back(item.get<std::size_t>());
    }
    return indices;
}

void stripMaterials(SourceDocument& document)
{
    auto& model = document.model;
    const Json record = member(extensionOf(document.json, "HALFLIGHT_mixed_lighting"), "mozLightmap");
    const Json& materials = member(record, "materials");
    std::map<int, int> sourceOf; // clone -> the material it is a clone of
    std::vector<std::size_t> clones;
    if (materials.is_array()) {
        for (const Json& item : materials) {
            const Json& clone = member(item, "material");
            const Json& source = member(item, "source");
            if (!clone.is_number_unsigned() || clone.get<uint64_t>() >= model.materials.size()) continue;
            const bool hasSource = source.is_number_unsigned() && source.get<uint64_t>() < model.materials.size();
            sourceOf[clone.get<int>()] = hasSource ? source.get<int>() : -1;
            clones.push_back(clone.get<std::size_t>());
        }
    }
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
        for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
            auto& primitive = model.meshes[m].primitives[p];
            const auto it = sourceOf.find(primitive.material);
            if (it == sourceOf.end()) continue;
            primitive.material = it->second;
            Json& json = document.json["meshes"][m]["primitives"][p];
            if (it->second >= 0) {
                json["material"] = it->second;
            } else {
                json.erase("material");
            }
        }
    }
    const auto images = indicesOf(member(record, "images"), model.images.size());
    for (const std::size_t image : images) {
        if (model.images[image].bufferView >= 0) document.strippedViews.push_back(model.images[image].bufferView);
    }
    removeLast(document.json, "materials", model.materials, clones);
    removeLast(document.json, "textures", model.textures, indicesOf(member(record, "textures"), model.textures.size()));
    removeLast(document.json, "images", model.images, images);
}

// Where a mesh had gaps below its lightmap coordinates, the writer filled them with the same accessor.
void stripStandIns(SourceDocument& document)
{
    auto& model = document.model;
    std::set<int> texCoords;
    for (const Json& node : member(document.json, "nodes")) {
        const Json& n = member(member(extensionOf(node, "HALFLIGHT_node"), "lightmap"), "texCoord");
        if (n.is_number_unsigned() && n.get<uint64_t>() <= 16) texCoords.insert(n.get<int>());
    }
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
        for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
            auto& primitive = model.meshes[m].primitives[p];
            const Json& material = element(document.json, "materials", primitive.material);
            for (const int n : texCoords) {
                const auto lightmap = primitive.attributes.find("TEXCOORD_" + std::to_string(n));
                if (lightmap == primitive.attributes.end()) continue;
                const int accessor = lightmap->second;
                for (int k = 0; k < n; ++k) {
                    const std::string name = "TEXCOORD_" + std::to_string(k);
                    const auto other = primitive.attributes.find(name);
                    if (other == primitive.attributes.end() || other->second != accessor || readsTexCoord(material, k))
                        continue;
                    primitive.attributes.erase(other);
                    document.json["meshes"][m]["primitives"][p]["attributes"].erase(name);
                }
            }
        }
    }
}

// Nodes whose meshes differed only in their lightmap materials share one mesh again.
void mergeMeshes(SourceDocument& document)
{
    auto& model = document.model;
    std::map<std::string, int> firstOf;
    std::vector<int> canonical(model.meshes.size());
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
        canonical[m] = firstOf.try_emplace(document.json["meshes"][m].dump(), int(m)).first->second;
    }
    std::vector<bool> used(model.meshes.size(), false);
    for (std::size_t n = 0; n < model.nodes.size(); ++n) {
        if (model.nodes[n].mesh < 0) continue;
        Json& json = document.json["nodes"][n];
        if (extensionOf(json, "HALFLIGHT_node").is_object()) {
            model.nodes[n].mesh = canonical[std::size_t(model.nodes[n].mesh)];
            json["mesh"] = std::size_t(model.nodes[n].mesh);
        }
        used[std::size_t(model.nodes[n].mesh)] = true;
    }
    std::vector<std::size_t> duplicates;
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
        if (!used[m] && canonical[m] != int(m)) duplicates.push_back(m);
    }
    removeLast(document.json, "meshes", model.meshes, duplicates);
}

} // namespace

void stripEarlierBake(SourceDocument& document)
{
    if (!extensionOf(document.json, "HALFLIGHT_mixed_lighting").is_object()) return;
    stripMaterials(document);
    stripStandIns(document);
    mergeMeshes(document);
    document.stretchedLayouts = stretchedLayouts(document);
}

} // namespace halflight
