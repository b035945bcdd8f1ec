#pragma once
#include "scene/document/patcher.h"

namespace halflight {

/// Node extension of lights.
constexpr const char* kLightExtension = "HALFLIGHT_light";

/// Writes the scene's lights, what settings changed of them and what the bake made of them, into the document. Lights
/// without a node get one.
Status writeLights(DocumentPatcher& patcher, const SourceDocument& source, const Scene& scene);

} // namespace halflight
