#pragma once
// Compressed parts of a document made plain, before anything else looks at accessors: the rest of the reader, the
// writer and the fingerprints see a document that was never compressed.

#include "scene/document/document.h"

namespace halflight {

/// Decodes compressed buffer views and primitives into a new buffer, points buffer views and accessors there, removes
/// the extensions and the buffers that nothing refers to any more. `json` has passed checkPacked(). Decoded data
/// may take 256 MiB and 256 times the buffers' size, and 4 GiB at most; beyond that the file is refused.
Status decompress(Json& json, std::vector<std::vector<std::byte>>& buffers);

} // namespace halflight
