#pragma once
// The textures of a document that hold a bake's pictures.

#include "scene/document/document.h"

#include <string_view>
#include <vector>

namespace halflight {

/// Texture extension for images that core glTF does not allow as a texture's source.
constexpr const char* kKtx2Extension = "HALFLIGHT_texture_ktx2";
/// Members of the root extension that hold the bake's pictures, one per lightmap page.
constexpr std::string_view kPictureLists[] = {"lightmaps", "lightmapDirections", "shadowmasks"};

/// References {index} to the textures of the bake that a root extension records: its lists, and the pictures of
/// sky and reflection probes.
std::vector<Json> pictureReferences(const Json& root);

/// Index of the image that holds a texture's picture: that of an extension this program reads, else its source; -1 for
/// none.
int pictureImage(const Json& document, int texture);

} // namespace halflight
