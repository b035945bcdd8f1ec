#pragma once
// Which lights' shadows have a colour.

#include "transport/random/stratified_pattern.h"
#include "transport/sample/path_tracer.h"

#include "halflight/bake/integrator.h"

#include <atomic>
#include <span>

namespace halflight {

/// Integrator::coloredShadows().
Status traceColoredShadows(const PathTracer& paths, const StratifiedPattern& pattern, const TexelMap& map,
                           uint32_t seed, std::span<float> shares, const Progress& progress,
                           std::atomic<uint64_t>& rays);

} // namespace halflight
