#pragma once
// Which extensions this program reads, and which need no support.

#include "scene/document/document.h"

namespace halflight {

/// Whether this program reads the extension.
bool isSupportedExtension(std::string_view name);

/// Whether a file reads right without the extension, also one that requires it: surfaces keep their diffuse light, and
/// nothing moves or vanishes at rest.
bool isHarmlessExtension(std::string_view name);

/// The first extension of the document that may refer to parts of the file in ways this program does not know; empty if
/// there is none.
std::string unknownExtension(const Json& document);

/// Why something stays as it is: `what` is a clause, as "geometry stays as it is".
std::string staysForExtension(const std::string& what, const std::string& extension);

/// One warning that names the harmless extensions of the document, one that names those this program knows nothing of.
std::vector<std::string> extensionWarnings(const Json& document);

} // namespace halflight
