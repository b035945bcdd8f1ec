#pragma once

#include "measure.h"

namespace halflight::bench {

/// Light groups of Options::settings: rays and CPU seconds of the lightmap with them over those without, and the error
/// of each group over that of a bake of its light alone.
void partGroups(const Options& options);

} // namespace halflight::bench
