#pragma once
#include "scene/document/patcher.h"

namespace halflight {

/// Puts triangles and vertices of the document into an order that compresses well, and attributes into small types:
/// positions and morph targets as floats of few bits, normals and tangents for the octahedral filter, texture
/// coordinates in 0…1 as 16-bit fractions, colours as bytes. Probes of the bake become floats of few bits. To be
/// followed by compressDocument().
Status optimizeMeshes(DocumentPatcher& patcher, const SourceDocument& source);

} // namespace halflight
