#include "scene/document/fallback_buffers.h"

#include <algorithm>
#include <set>

namespace halflight {

namespace {

bool namesMeshopt(const Json& object)
{
    return std::any_of(kMeshoptExtensions.begin(), kMeshoptExtensions.end(),
                       [&](const char* name) { return extensionOf(object, name).is_object(); });
}

} // namespace

bool isFallbackBuffer(const Json& buffer)
{
    return !buffer.contains("uri") && namesMeshopt(buffer);
}

void markFallbackBuffers(Json& json, bool hasBinary)
{
    std::set<uint64_t> compressed;
    std::set<uint64_t> plain;
    for (const Json& view : member(json, "bufferViews")) {
        const Json& buffer = member(view, "buffer");
        if (buffer.is_number_unsigned()) (namesMeshopt(view) ? compressed : plain).insert(buffer.get<uint64_t>());
    }
    const Json& buffers = member(json, "buffers");
    for (const uint64_t i : compressed) {
        if (!buffers.is_array() || i >= buffers.size() || plain.contains(i) || (i == 0 && hasBinary)) continue;
        Json& buffer = json["buffers"][i];
        if (buffer.is_object() && !buffer.contains("uri") && member(buffer, "extensions").is_null())
            buffer["extensions"][kMeshoptExtensions[0]]["fallback"] = true;
    }
}

} // namespace halflight
