#pragma once
// What light groups take in a file.

#include "halflight/scene/scene.h"

#include <cstdint>
#include <vector>

namespace halflight {

/// Bytes of each light group's pictures and probes in the document that a bake was read from, in its order; none for a
/// scene without a document, or without groups.
std::vector<uint64_t> bytesOfGroups(const Scene& scene);

} // namespace halflight
