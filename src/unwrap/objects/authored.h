#pragma once
// A mesh's own TEXCOORD_1: may it serve as its lightmap layout?

#include "halflight/base/progress.h"
#include "unwrap/surface/overlap.h"
#include "unwrap/surface/surface.h"

#include <string>

namespace halflight::charts {

/// TEXCOORD_1 as a layout.
struct AuthoredLayout {
    std::string fault;                     ///< why it cannot be used; empty when it can
    std::vector<FlatTriangle> triangles;   ///< of all parts, in uv units
    std::vector<uint32_t> chartOfTriangle; ///< triangles connected in uv; kNone for degenerate ones
    uint32_t chartCount = 0;
    double uvArea = 0.0;
    double worldArea = 0.0;
    double stretch = 1.0; ///< area-weighted L2 stretch at the mean scale
    dvec2 least{0.0}, most{0.0};
};

/// Whether any part of the mesh has TEXCOORD_1.
bool hasAuthoredLayout(const Mesh& mesh);

/// `surface` is the mesh's. Valid means: every part with area has it, it is finite and in [0,1], no triangle that has
/// area is without area in uv, and no two triangles overlap.
AuthoredLayout readAuthoredLayout(const Mesh& mesh, const Surface& surface);

/// Whether two charts lie closer than `padding` texels when a uv unit is `texelsPerUnit` texels and the layout's origin
/// is the corner of a texel. `layouts` share one uv square.
bool chartsTooClose(std::span<const AuthoredLayout* const> layouts, double texelsPerUnit, int padding);

/// Whether two layouts touch one texel when all are laid on one page of `pageSize` texels as they stand.
bool layoutsShareTexel(std::span<const AuthoredLayout* const> layouts, int pageSize);

} // namespace halflight::charts
