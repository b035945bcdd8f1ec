#pragma once
#include "scene/document/document.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// The encoded picture that a reference names: a texture's.
Result<std::vector<std::byte>> pictureBytes(const SourceDocument& document, const Json& reference,
                                            const std::string& path);

/// Lightmaps, directions and masks of the root extension.
Status readPictures(const SourceDocument& document, const Json& root, BakedScene& baked);

} // namespace halflight
