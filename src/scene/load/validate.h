#pragma once
// The checks that make a document safe to walk. tinygltf itself checks little: neither ranges nor references nor
// cycles.

#include "scene/document/document.h"

namespace halflight {

/// On the bare JSON, before tinygltf sees it: version, required extensions, and whatever tinygltf would trust blindly.
Status checkBeforeParsing(const Json& json, bool isBinary);

/// On the parsed document: every index that any part of the scene module follows, every byte range, the node hierarchy.
Status checkAfterParsing(const SourceDocument& document);

} // namespace halflight
