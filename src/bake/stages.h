#pragma once
// The stages of the bake, in the order bake.cpp calls them. Each is a function of its inputs.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"

#include <vector>

namespace halflight {

/// Which objects become geometry.
enum class GeometryFilter { Static, All };
BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter);

/// For each triangle, 1 when it belongs to a closed piece of one object, or of several together, whose faces look
/// outward. Such a piece has an inside that nobody sees, even when its material is double-sided (as many exporters
/// write for everything).
std::vector<uint8_t> markSolids(const BakeGeometry& geometry);

/// Conservative rasterization of all lightmapped triangles.
TexelMap rasterizeTexels(const BakeGeometry& geometry, int pageSize, int pageCount);

/// 0, 1, … one less than the number of texels.
std::vector<uint32_t> allTexels(const TexelMap& map);

/// Decides what each light's bake is and which mask channel it gets (spec S5, S9, S10); writes Light::baking.
void assignShadowmaskChannels(Scene& scene, MixedLightingMode mode);

/// Where probes go (spec S14): a grid over the bounds of the static objects, or the positions the scene asks for.
ProbeSet placeProbes(const Scene& scene, float spacingMeters);

/// Edge-stopping à-trous filter within charts, guided by position, normal and the estimates' variance.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::vector<IrradianceEstimate>& estimates);

/// Gives texels that lie inside geometry (valid 0) other texels' values: those of valid texels of their own chart next
/// to them; else the mean of valid texels of any chart that lie within a few texels in the world and face the same way
/// (a moulding pressed into a wall, of which a sliver shows); else what grows in from farther away on their own chart.
/// Texels that find nothing keep theirs. `values` has one entry per texel of the map.
template<typename T> void fillInvalid(const BakeGeometry& geometry, const TexelMap& map,
                                      const std::vector<uint8_t>& valid, std::vector<T>& values);

/// The point of a texel's largest piece, and the world size of a texel there.
struct TexelPlace {
    vec3 position{0.0f};
    vec3 normal{0.0f};
    float texelMeters = 0.0f;
};
TexelPlace placeOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel);

/// Values of the covered texels laid out on their pages and grown into the padding: each empty texel takes the mean of
/// its nearest covered neighbours, all of one chart.
template<typename T> std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings);

/// A place on an edge where two charts (or two objects) meet on one smooth surface, in texels on each side's page.
struct SeamSample {
    int pageA = 0;
    int pageB = 0;
    vec2 texelA{0.0f};
    vec2 texelB{0.0f};
};
std::vector<SeamSample> findSeams(const BakeGeometry& geometry, int pageSize);

/// Makes bilinear values on both sides of each seam agree. Works on dilated pages: filtering at an edge reads padding.
template<typename T> void stitchSeams(const std::vector<SeamSample>& seams, std::vector<Image<T>>& pages);

/// The largest value RGB9E5 holds; brighter texels are cut there.
constexpr float kMaxRgb9e5 = 65408.0f;
std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages);
/// Mean directions (shading/directional.h) from pages of irradiance and of its first moment.
std::vector<ImageRgba8> encodeDirections(const std::vector<ImageRgb32f>& irradiance,
                                         const std::vector<ImageRgb32f>& moments);
std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages);

/// Irradiance image of an encoded page.
ImageRgb32f decodeLightmap(const Image<uint32_t>& page);

} // namespace halflight
