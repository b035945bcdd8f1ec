#pragma once
#include "halflight/scene/scene.h"
#include "scene/document/document.h"

namespace halflight {

/// Gives a scene that an engine filled a glTF document of its own (scene.source), as if it had been read from a file:
/// all source indices are set, and the parts' vertices become the document's.
Status giveSourceDocument(Scene& scene);

} // namespace halflight
