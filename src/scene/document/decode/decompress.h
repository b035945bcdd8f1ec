#pragma once
// Compressed parts of a document made plain, before anything else looks at accessors: the rest of the reader, the
// writer and the fingerprints see a document that was never compressed.

#include "scene/document/document.h"

#include <string_view>

namespace halflight {

/// Whether this build reads the extension's compressed data: geometry (KHR_draco_mesh_compression,
/// EXT_meshopt_compression, KHR_meshopt_compression) or images (EXT_texture_webp).
bool readsCompression(std::string_view extension);

/// The end of a sentence about an extension that is not read: "; `npx …` makes a file without it". Empty where no
/// command is known.
std::string conversionHint(std::string_view extension);

/// Decodes compressed buffer views and primitives into a new buffer, points buffer views and accessors there, removes
/// the extensions and the buffers that nothing refers to any more. `json` has passed checkBeforeParsing(). Decoded data
/// may take 256 MiB and 256 times the buffers' size, and 4 GiB at most; beyond that the file is refused.
Status decompress(Json& json, std::vector<tinygltf::Buffer>& buffers);

} // namespace halflight
