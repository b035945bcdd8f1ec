#pragma once
#include "scene/patcher.h"

#include "halflight/scene/gltf.h"

namespace halflight {

/// What writeBakedScene() writes, in memory. `imagePrefix`: see DocumentPatcher::finish().
Result<FinishedDocument> bakedDocument(const BakedScene& baked, const WriteOptions& options,
                                       const std::string& imagePrefix, WrittenBytes& written);

} // namespace halflight
