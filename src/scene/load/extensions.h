#pragma once
// Which extensions this program reads, and which need no support.

#include "scene/document/document.h"

namespace halflight {

/// Whether this program reads the extension.
bool isSupportedExtension(std::string_view name);

/// Whether a file reads right without the extension, also one that requires it: surfaces keep their diffuse light, and
/// nothing moves or vanishes at rest.
bool isHarmlessExtension(std::string_view name);

/// One warning that names the harmless extensions of the document, one that names those this program knows nothing of.
std::vector<std::string> extensionWarnings(const Json& document);

} // namespace halflight
