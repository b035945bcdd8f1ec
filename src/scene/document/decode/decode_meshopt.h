#pragma once
// Buffer views that were compressed with meshoptimizer, made plain.

#include "scene/document/decode/decoded_buffer.h"

namespace halflight {

/// Decodes a view that has the extension `name`, which `path` leads to. A build without meshoptimizer takes the view's
/// fallback data where it has some.
Status decodeMeshoptView(DecodedBuffer& buffer, Json& view, const char* name, const std::string& path);

} // namespace halflight
