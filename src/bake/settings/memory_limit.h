#pragma once
// Programs of 32 bits (WebAssembly) hold 4 GiB: what a bake takes is foreseen before the long part of it.

#include "halflight/base/result.h"
#include "halflight/scene/scene.h"

#include <cstdint>

namespace halflight {

/// What a bake works on.
struct BakeSize {
    uint64_t texels = 0; ///< covered ones, of all pages
    uint64_t triangles = 0;
    double texelsPerMeter = 0.0; ///< 0: not known yet
};

/// Triangles of all objects, those of a mesh once for each object.
uint64_t trianglesOf(const Scene& scene);

/// Bytes that a bake takes at its most, by measured bakes of the project's scenes.
uint64_t expectedMemory(const BakeSize& size);

/// Error with the cures where that is more than `mostBytes`; by default more than this program can address.
Status checkMemory(const BakeSize& size, uint64_t mostBytes = sizeof(void*) == 4 ? uint64_t(1) << 32 : UINT64_MAX);

} // namespace halflight
