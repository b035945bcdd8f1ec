#pragma once
// Light groups in a file: their pages, and their probes.

#include "halflight/scene/gltf.h"
#include "scene/write/write_pictures.h"

namespace halflight {

/// Adds the pages of the groups to the document and names them in "groups" of `root`. Nothing without groups.
Status writeGroupPictures(PictureWriter& pictures, const BakedScene& baked, const WriteOptions& options, Json& root,
                          WrittenBytes& written);

/// Adds the radiance of the groups' probes to the same records.
void writeGroupProbes(DocumentPatcher& patcher, const BakedScene& baked, Json& root, WrittenBytes& written);

} // namespace halflight
