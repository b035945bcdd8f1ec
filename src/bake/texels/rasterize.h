#pragma once
// Texels that the charts of a scene cover.

#include "halflight/bake/integrator.h"

namespace halflight {

/// Conservative rasterization of all lightmapped triangles.
TexelMap rasterizeTexels(const BakeGeometry& geometry, int pageSize, int pageCount);

} // namespace halflight
