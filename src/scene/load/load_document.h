#pragma once
// From a file's bytes to a document that is parsed, checked and unpacked.

#include "scene/document/document.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace halflight {

/// Reads and checks a .glb or .gltf file.
Result<std::shared_ptr<const SourceDocument>> loadDocument(const std::filesystem::path& path);

/// The same from memory; `bytes` is a whole GLB or the JSON of a .gltf.
Result<std::shared_ptr<const SourceDocument>> parseDocument(std::span<const std::byte> bytes,
                                                            const std::filesystem::path& directory);

} // namespace halflight
