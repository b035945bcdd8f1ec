#pragma once
// Validity, the first stage: which sample points of a map's texels are outside geometry.

#include "bake_cpu/sample/path_tracer.h"

#include "halflight/base/progress.h"

#include <atomic>

namespace halflight {

/// As Integrator::findValidPoints(). Few rays find the texels that may have invalid points. These and the texels next
/// to them have all points tested (TexelValidity). `parts`: may be null; keeps the result, and the parts of it that
/// processes share. False when cancelled, and when a shared folder cannot be written.
bool findValidPoints(const PathTracer& paths, TexelMap& map, PartFolder* parts, const Progress& progress,
                     std::atomic<uint64_t>& rays);

} // namespace halflight
