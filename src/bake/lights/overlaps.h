#pragma once
// Which lights reach a common point, and which of them come first.

#include "halflight/scene/scene.h"

#include <vector>

namespace halflight {

/// Order of precedence that does not depend on the order of the lights in the file.
bool moreImportant(const Light& a, const Light& b);

/// Of each light, those that it overlaps, ascending.
using Graph = std::vector<std::vector<int>>;

/// Which lights overlap: compared are those whose reaches overlap along X.
Graph overlapsOf(const std::vector<const Light*>& lights);

} // namespace halflight
