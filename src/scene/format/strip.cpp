#include "scene/format/strip.h"

#include "scene/document/references.h"
#include "scene/document/texture_coordinates.h"
#include "scene/format/lightmap_layout.h"

#include <set>
#include <string>

namespace halflight {

namespace {

// Where a mesh had gaps below its lightmap coordinates, the writer filled them with the same accessor.
void stripStandIns(SourceDocument& document)
{
    std::set<int> texCoords;
    for (const Json& node : member(document.json, "nodes")) {
        const Json& n = member(member(extensionOf(node, "HALFLIGHT_node"), "lightmap"), "texCoord");
        if (n.is_number_unsigned() && n.get<uint64_t>() <= 16) texCoords.insert(n.get<int>());
    }
    eachPrimitive(document.json, [&](Json& primitive) {
        const Json& material = element(document.json, "materials", integerOf(primitive, "material"));
        for (const int n : texCoords) {
            const int accessor = attributeOf(primitive, "TEXCOORD_" + std::to_string(n));
            for (int k = 0; accessor >= 0 && k < n; ++k) {
                const std::string name = "TEXCOORD_" + std::to_string(k);
                if (attributeOf(primitive, name) == accessor && !readsTexCoord(material, k))
                    primitive["attributes"].erase(name);
            }
        }
    });
}

} // namespace

void stripEarlierBake(SourceDocument& document)
{
    if (!extensionOf(document.json, "HALFLIGHT_mixed_lighting").is_object()) return;
    stripStandIns(document);
    document.stretchedLayouts = stretchedLayouts(document);
}

} // namespace halflight
