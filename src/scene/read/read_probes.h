#pragma once
#include "scene/document/document.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// `probes` of the root extension, which may be null. `shift` takes positions relative to the file's origin to the
/// scene's: zero but for files that were moved.
Status readProbes(const SourceDocument& document, const Json& json, const glm::dvec3& shift, ProbeSet& set);

} // namespace halflight
