#pragma once
// Light groups in a file: their pages, and their probes.

#include "halflight/scene/gltf.h"
#include "scene/write/write_bake_pictures.h"

namespace halflight {

/// Pictures of one group.
struct EncodedGroup {
    Result<EncodedLightmaps> lightmaps = EncodedLightmaps();
    std::vector<Result<std::vector<std::byte>>> directions;
    Result<std::vector<std::byte>> reflections = std::vector<std::byte>();
};
/// Of all groups at one time.
std::vector<EncodedGroup> encodeGroups(const BakedScene& baked, const WriteOptions& options);

/// Adds these pictures to the document and names them in "groups" of `root`. Nothing without groups.
Status writeGroupPictures(PictureWriter& pictures, const BakedScene& baked, std::vector<EncodedGroup> encoded,
                          Json& root, WrittenBytes& written);

/// Adds the radiance of the groups' probes to the same records.
void writeGroupProbes(DocumentPatcher& patcher, const BakedScene& baked, Json& root, WrittenBytes& written);

} // namespace halflight
