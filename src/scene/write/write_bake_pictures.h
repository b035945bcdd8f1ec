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
/// The same of any pages in units of `unitLux`, from `irradiance` where there are as many pages of it. Pages without
/// texels have no bytes.
Result<EncodedLightmaps> encodePages(const std::vector<Image<uint32_t>>& pages, float unitLux,
                                     std::span<const ImageRgb32f> irradiance, const WriteOptions& options);

/// Pictures of 8 bits a channel as PNG or lossless WebP; those without texels have no bytes.
std::vector<Result<std::vector<std::byte>>> encodeMasks(const std::vector<ImageRgba8>& pages, const Progress& progress);
/// Adds such pictures, and names them in the list `key` of `root`: without bytes as {}.
Status addMasks(PictureWriter& pictures, const char* key, const std::string& name,
                std::vector<Result<std::vector<std::byte>>> encoded, Json& root, uint64_t& bytes);

Error writingCancelled();

} // namespace halflight
