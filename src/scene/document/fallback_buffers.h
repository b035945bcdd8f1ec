#pragma once
// Buffers without data, which stand for what compressed buffer views decode to (EXT_meshopt_compression).

#include "scene/document/document.h"

#include <array>

namespace halflight {

/// Extensions of buffer views whose data meshoptimizer decodes.
inline constexpr std::array<const char*, 2> kMeshoptExtensions = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

/// Whether the buffer of the JSON holds no data of its own, but stands for what buffer views decode to.
bool isFallbackBuffer(const Json& buffer);

/// Marks buffers that are such by their use, so that isFallbackBuffer() finds them: without a uri, and with compressed
/// views alone. A GLB's binary chunk (`hasBinary`) is buffer 0's data. `json` need not have passed any check.
void markFallbackBuffers(Json& json, bool hasBinary);

} // namespace halflight
