#pragma once
// The extensions of compressed data, by name, and which of them this build reads.

#include "halflight/scene/compression.h"

#include <string>
#include <string_view>

namespace halflight {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Draco's extension or one of meshoptimizer's (kMeshoptExtensions).
bool isCompressedGeometry(std::string_view extension);

/// Whether this build reads the extension's compressed data: geometry (KHR_draco_mesh_compression,
/// EXT_meshopt_compression, KHR_meshopt_compression) or images (EXT_texture_webp).
bool readsCompression(std::string_view extension);

/// The end of a sentence about an extension that is not read: "; `npx …` makes a file without it". Empty where no
/// command is known.
std::string conversionHint(std::string_view extension);

} // namespace halflight
