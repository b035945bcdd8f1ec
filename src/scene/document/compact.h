#pragma once
#include "scene/document/document.h"

namespace halflight {

/// Takes meshes, materials, textures, images and samplers that nothing refers to out of a document and renumbers the
/// rest. `onlyLast`: only those at the end of their arrays, so that no index shifts, for documents with extensions that
/// may refer to them unseen.
void compactDocument(Json& document, bool onlyLast);

} // namespace halflight
