#include "halflight/scene/group_bytes.h"

#include "scene/document/document.h"
#include "scene/format/picture_references.h"

namespace halflight {

std::vector<uint64_t> bytesOfGroups(const Scene& scene)
{
    std::vector<uint64_t> bytes;
    if (!scene.source) return bytes;
    const Json& document = scene.source->json;
    const auto bytesOfPicture = [&](const Json& reference) -> uint64_t {
        const Json& index = member(reference, "index");
        if (!index.is_number_integer()) return 0; // a page without light
        const Json& image = element(document, "images", pictureImage(document, index.get<int>()));
        const Json& length = member(element(document, "bufferViews", integerOf(image, "bufferView")), "byteLength");
        return length.is_number_unsigned() ? length.get<uint64_t>() : 0;
    };
    for (const Json& group : member(extensionOf(document, "HALFLIGHT_mixed_lighting"), "groups")) {
        uint64_t& sum = bytes.emplace_back(0);
        for (const char* list : {"lightmaps", "lightmapDirections"})
            for (const Json& reference : member(group, list)) sum += bytesOfPicture(reference);
        sum += bytesOfPicture(member(member(group, "reflections"), "picture"));
        const Json& accessor = element(document, "accessors", integerOf(group, "radiance"));
        const Json& count = member(accessor, "count");
        if (count.is_number_unsigned()) sum += count.get<uint64_t>() * sizeof(vec3);
    }
    return bytes;
}

} // namespace halflight
