#include "scene/document/compact.h"

#include "scene/document/references.h"

#include <string_view>
#include <vector>

namespace halflight {
namespace {

using Visit = FunctionRef<void(Json&)>;

void visitMember(Json& object, const char* key, Visit visit)
{
    if (Json* index = find(object, key); index != nullptr && index->is_number_integer()) visit(*index);
}

// The calls below visit each reference to an element of an array.

void visitMeshes(Json& document, Visit visit)
{
    each(find(document, "nodes"), [&](Json& node) { visitMember(node, "mesh", visit); });
}

void visitMaterials(Json& document, Visit visit)
{
    eachPrimitive(document, [&](Json& primitive) {
        visitMember(primitive, "material", visit);
        Json* extensions = find(primitive, "extensions");
        Json* variants = extensions != nullptr ? find(*extensions, "KHR_materials_variants") : nullptr;
        if (variants == nullptr) return;
        each(find(*variants, "mappings"), [&](Json& mapping) { visitMember(mapping, "material", visit); });
    });
}

// Members named ...Texture, those of extensions included.
void visitTextureInfos(Json& json, Visit visit)
{
    if (!json.is_object()) return;
    for (auto& [key, value] : json.items()) {
        if (std::string_view(key).ends_with("Texture")) visitMember(value, "index", visit);
        visitTextureInfos(value, visit);
    }
}

void visitTextures(Json& document, Visit visit)
{
    each(find(document, "materials"), [&](Json& material) { visitTextureInfos(material, visit); });
}

void visitImages(Json& document, Visit visit)
{
    each(find(document, "textures"), [&](Json& texture) {
        visitMember(texture, "source", visit);
        each(find(texture, "extensions"), [&](Json& extension) { visitMember(extension, "source", visit); });
    });
}

void visitSamplers(Json& document, Visit visit)
{
    each(find(document, "textures"), [&](Json& texture) { visitMember(texture, "sampler", visit); });
}

void compactArray(Json& document, const char* array, bool onlyLast, void (*visitReferences)(Json&, Visit))
{
    Json* list = find(document, array);
    if (list == nullptr) return;
    std::vector<bool> used(list->size(), false);
    visitReferences(document, [&](Json& index) {
        const auto i = index.get<std::size_t>();
        if (i < used.size()) used[i] = true;
    });
    if (onlyLast) {
        while (!used.empty() && !used.back()) {
            used.pop_back();
            list->erase(list->size() - 1);
        }
        if (list->empty()) document.erase(array);
        return;
    }
    std::vector<std::size_t> place(used.size(), 0);
    Json kept = Json::array();
    for (std::size_t i = 0; i < used.size(); ++i) {
        place[i] = kept.size();
        if (used[i]) kept.push_back(std::move((*list)[i]));
    }
    *list = std::move(kept);
    if (list->empty()) document.erase(array);
    visitReferences(document, [&](Json& index) {
        if (const auto i = index.get<std::size_t>(); i < place.size()) index = place[i];
    });
}

} // namespace

void compactDocument(Json& document, bool onlyLast)
{
    compactArray(document, "meshes", onlyLast, visitMeshes);
    compactArray(document, "materials", onlyLast, visitMaterials);
    compactArray(document, "textures", onlyLast, visitTextures);
    compactArray(document, "images", onlyLast, visitImages);
    compactArray(document, "samplers", onlyLast, visitSamplers);
}

} // namespace halflight
