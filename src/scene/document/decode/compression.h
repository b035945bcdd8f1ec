#pragma once
// The extensions of compressed data, by name, and which of them this build reads.

#include "halflight/scene/compression.h"
#include "scene/document/document.h"

#include <string>
#include <string_view>

namespace halflight {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Draco's extension or one of meshoptimizer's (kMeshoptExtensions).
bool isCompressedGeometry(std::string_view extension);

/// Whether this build reads the extension's compressed data: geometry (KHR_draco_mesh_compression,
/// EXT_meshopt_compression, KHR_meshopt_compression) or images (EXT_texture_webp).
bool readsCompression(std::string_view extension);

/// The image that a texture shows in this build: EXT_texture_webp names one to prefer over the texture's own, which is
/// for programs without WebP. -1 where there is none.
int imageOf(const Json& texture);

/// The end of a sentence about an extension that is not read: "; `npx …` makes a file without it". Empty where no
/// command is known.
std::string conversionHint(std::string_view extension);

} // namespace halflight
