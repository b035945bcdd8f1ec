#pragma once
#include "scene/document/patcher.h"

#include "halflight/scene/gltf.h"

namespace halflight {

constexpr const char* kImageInfix = "_image"; // OUT_image_0.png
/// Whether files beside a document of this name hold its buffer and pictures: a .gltf, in any case.
bool isSeparate(const std::filesystem::path& output);

/// What writeBakedScene() writes, in memory. `imagePrefix`: see DocumentPatcher::finish().
Result<FinishedDocument> bakedDocument(const BakedScene& baked, const WriteOptions& options,
                                       const std::string& imagePrefix, WrittenBytes& written);

} // namespace halflight
