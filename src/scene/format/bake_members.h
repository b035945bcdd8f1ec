#pragma once
// Members of the bake's extensions.

#include "scene/document/document.h"

namespace halflight {

inline const std::string kBakePath = "/extensions/HALFLIGHT_mixed_lighting";

/// The index of an accessor with `count` elements.
inline Result<int> accessorIndex(const SourceDocument& document, const Json& object, const char* key, std::size_t count,
                                 const std::string& path)
{
    const Json& index = member(object, key);
    if (!isIndexInto(document.json, "accessors", index))
        return invalid(path, std::string(key) + " refers to an accessor that does not exist");
    if (elementCount(document, index.get<int>()) != count)
        return invalid(path, std::string(key) + " does not have " + std::to_string(count) + " elements");
    return index.get<int>();
}

template<typename Vec> bool readVector(const Json& json, Vec& out)
{
    if (!json.is_array() || json.size() != std::size_t(Vec::length())) return false;
    for (int c = 0; c < Vec::length(); ++c) {
        if (!json[std::size_t(c)].is_number()) return false;
        out[c] = json[std::size_t(c)].get<typename Vec::value_type>();
    }
    return true;
}

} // namespace halflight
