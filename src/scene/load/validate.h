#pragma once
// The checks that make a document safe to walk: types, ranges, references, the node hierarchy.

#include "scene/document/document.h"

namespace halflight {

/// On the bare JSON, before any buffer is read: version, types, required extensions, the ranges of buffer views.
Status checkPacked(const Json& json, bool isBinary);

/// On the document with its buffers unpacked: every index that any part of the scene module follows, every byte range,
/// the node hierarchy.
Status checkUnpacked(const SourceDocument& document);

} // namespace halflight
