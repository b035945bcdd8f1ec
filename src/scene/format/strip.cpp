#include "scene/format/strip.h"

#include "scene/document/texture_coordinates.h"
#include "scene/format/lightmap_layout.h"

#include <set>
#include <string>

namespace halflight {

namespace {

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

} // namespace

void stripEarlierBake(SourceDocument& document)
{
    if (!extensionOf(document.json, "HALFLIGHT_mixed_lighting").is_object()) return;
    stripStandIns(document);
    document.stretchedLayouts = stretchedLayouts(document);
}

} // namespace halflight
