#include "scene/format/picture_references.h"

#include <string>

namespace halflight {

std::vector<Json> pictureReferences(const Json& root)
{
    std::vector<Json> references;
    for (const std::string_view list : kPictureLists) {
        for (const Json& reference : member(root, std::string(list).c_str()))
            if (reference.contains("index")) references.push_back(reference); // mask pages may have none
    }
    for (const Json& group : member(root, "groups")) {
        for (const char* list : {"lightmaps", "lightmapDirections"})
            for (const Json& reference : member(group, list))
                if (reference.contains("index")) references.push_back(reference);
        if (const Json& picture = member(member(group, "reflections"), "picture"); picture.is_object())
            references.push_back(picture);
    }
    if (const Json& picture = member(member(root, "sky"), "picture"); picture.is_object())
        references.push_back(picture);
    if (const Json& picture = member(member(root, "reflectionProbes"), "picture"); picture.is_object())
        references.push_back(picture);
    return references;
}

int pictureImage(const Json& document, int texture)
{
    const Json& json = element(document, "textures", texture);
    for (const char* name : {kKtx2Extension, "EXT_texture_webp"}) {
        if (const int source = integerOf(extensionOf(json, name), "source"); source >= 0) return source;
    }
    return integerOf(json, "source");
}

} // namespace halflight
