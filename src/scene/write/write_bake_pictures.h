#pragma once
#include "scene/write/write_pictures.h"

#include "halflight/scene/gltf.h"

namespace halflight {

/// Adds the pictures of the bake to the document and names them in `root`, the JSON of HALFLIGHT_mixed_lighting. Counts
/// their bytes.
Status writeBakePictures(PictureWriter& pictures, const BakedScene& baked, const WriteOptions& options, Json& root,
                         WrittenBytes& written);

/// An encoded picture for each lightmap page, its bytes and its errors. `encoding`: what lightmapEncoding is to say of
/// Webp, else null.
struct EncodedLightmaps {
    std::vector<std::vector<std::byte>> pages;
    std::vector<WrittenLightmap> written;
    Json encoding;
};
Result<EncodedLightmaps> encodeLightmaps(const BakedScene& baked, const WriteOptions& options);

Error writingCancelled();

} // namespace halflight
