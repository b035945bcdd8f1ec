#pragma once
// Judges an unwrapped scene by brute force, sharing no code with the unwrapper.

#include "halflight/unwrap/unwrap.h"

#include <cstdint>
#include <string>
#include <vector>

namespace halflight {

struct AtlasCheck {
    std::string fault; ///< the first thing found wrong; empty when all is well
    int charts = 0;    ///< pieces connected in uv, over all objects
    uint64_t coveredTexels = 0;
    double worldArea = 0.0; ///< of lightmapped triangles
    double texelArea = 0.0; ///< and what they take on the pages
};

/// Every lightmapped triangle is rasterized conservatively (all texels it touches, borders included) on its page, and:
/// all coordinates are finite and on the page; no texel is within `paddingTexels` of two charts; no two triangles of a
/// chart overlap; a triangle with an area on the surface has one on the page.
AtlasCheck checkAtlas(const UnwrappedScene& unwrapped, int paddingTexels);

/// Brute force: the first texel that triangles of two objects touch, or triangles of two charts of a layout that is not
/// the file's own; empty when there is none. Also a fault: a mesh that is reported as kept and as unwrapped.
std::string findSharedTexel(const UnwrappedScene& unwrapped);

/// What every mesh must keep: vertex arrays of one length, valid indices, sourceVertex pointing at equal vertices of
/// the source part. Compares with the scene before unwrapping. Returns the first fault.
std::string checkMeshes(const Scene& before, const UnwrappedScene& after);

} // namespace halflight
