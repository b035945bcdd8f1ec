#pragma once

#include "scene/document/document.h"

#include <filesystem>
#include <vector>

namespace halflight {

/// The files that a document names: buffers, images, the sky's picture.
std::vector<std::filesystem::path> externalFiles(const SourceDocument& document);

} // namespace halflight
