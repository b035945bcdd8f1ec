#pragma once
// Parts of bench_bake that bake whole scenes.

#include "measure.h"

namespace halflight::bench {

/// The whole bake over lightmap sizes. Nearly all memory that the smallest takes is the scene's: triangles, textures,
/// the tree over them. Bytes are of the texels that a larger one has in addition.
void partScaling(const Options& options);
/// The whole bake of a floor under many lamps that reach 5 m: of 10,000, about 20 reach a texel.
void partLamps(const Options& options);

} // namespace halflight::bench
