#pragma once

#include "measure.h"

namespace halflight::bench {

/// Time to a given error against a converged path traced reference, by both integrators; the cache's light as it is and
/// denoised, the time for that included.
void partError(const Options& options);

} // namespace halflight::bench
