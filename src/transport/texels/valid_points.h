#pragma once
// Validity, the first stage: which sample points of a map's texels are outside geometry.

#include "bake/cache/store.h"
#include "transport/sample/path_tracer.h"

#include "halflight/base/progress.h"

#include <atomic>

namespace halflight {

/// As Integrator::findValidPoints(). Texels are tested in blocks (TexelValidity::testBlock()). `store`:
/// keeps the result, and the parts of it that processes share.
Status findValidPoints(const PathTracer& paths, TexelMap& map, const Store& store, const Progress& progress,
                       std::atomic<uint64_t>& rays);
Status findValidPoints(const PathTracer& paths, std::span<const SurfacePoint> points, std::span<uint8_t> out);

} // namespace halflight
