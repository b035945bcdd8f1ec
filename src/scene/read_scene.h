#pragma once
#include "halflight/scene/gltf.h"
#include "scene/document.h"

namespace halflight {

/// readScene() on a document that is loaded already.
Result<Scene> sceneFromDocument(std::shared_ptr<const SourceDocument> document, const ReadOptions& options);

/// The local origin that a baked file's positions are relative to (`origin` of its root extension); zero where it has
/// none.
Result<glm::dvec3> recordedOrigin(const SourceDocument& document);

} // namespace halflight
