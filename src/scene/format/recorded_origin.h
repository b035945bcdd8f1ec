#pragma once
#include "scene/document/document.h"

namespace halflight {

/// The local origin that a baked file's positions are relative to (`origin` of its root extension); zero where it has
/// none.
Result<glm::dvec3> recordedOrigin(const SourceDocument& document);

} // namespace halflight
