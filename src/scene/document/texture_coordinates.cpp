#include "scene/document/texture_coordinates.h"

#include <set>
#include <string>

namespace halflight {
namespace {

// All "texCoord" values of a material's texture slots, those of extensions too; not the lightmap's own.
void collectTexCoords(const Json& json, std::set<uint64_t>& used)
{
    if (json.is_object()) {
        if (json.contains("index") && !json.contains("texCoord")) used.insert(0);
        for (const auto& [key, value] : json.items()) {
            if (key == "texCoord" && value.is_number_unsigned()) used.insert(value.get<uint64_t>());
            if (key != "MOZ_lightmap" && key != "extras") collectTexCoords(value, used);
        }
    } else if (json.is_array()) {
        for (const Json& value : json) collectTexCoords(value, used);
    }
}

} // namespace

bool readsTexCoord(const Json& material, int n)
{
    std::set<uint64_t> used;
    collectTexCoords(material, used);
    return used.count(uint64_t(n)) != 0;
}

} // namespace halflight
