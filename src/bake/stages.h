#pragma once
// The stages of the bake, in the order in which bake.cpp calls them. Each is a function of its inputs.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

struct Gather;

/// Which objects become geometry.
enum class GeometryFilter { Static, All };
/// The triangles of the scene, with solids marked (findSolids()). Objects that share a large mesh share its stored
/// triangles (shareMeshes()). `pageSize`: of the lightmap, in texels.
BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter);

/// Fills BakeGeometry::solid and BakeGeometry::flipped. A solid is a closed, outward-facing surface of one object or of
/// several together. Its inside is never seen, even if its material is double-sided (many exporters write that for all
/// materials). Double-sided, inward-facing surfaces around empty space are flipped: they are seen from outside.
void findSolids(const Scene& scene, BakeGeometry& geometry);

/// Positions of local lights, cameras and dynamic objects: space that contains one is not empty.
std::vector<vec3> lightAndViewPoints(const Scene& scene);

/// Numbers of parts that have each stored triangle once: all but the second and later instances of a mesh.
std::vector<uint32_t> partsOnce(const BakeGeometry& geometry);

/// Gives the objects of triangles stored triangles of their own (BakeGeometry::storeInWorldSpace()).
void storeInWorldSpace(BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// Reverses the winding of triangles, and vertex normals that would point to their back. Their objects no longer share
/// stored triangles.
void flipTriangles(BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// Splits triangles into patches, connected across edges where the winding is consistent and the angle between the
/// normals below 50 degrees.
std::vector<std::vector<uint32_t>> facetPatches(const BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// Flips double-sided patches whose front faces a narrow, closed, empty cavity (the inside of a rail, say) and whose
/// back faces open space. Returns an integrator for the repaired geometry. `tree`: one for the same surfaces, if there
/// is one already; else the geometry gets one for the test.
Result<std::unique_ptr<Integrator>> repairOrientation(const IntegratorFactory& factory, const Scene& scene,
                                                      BakeGeometry& geometry, const IntegrationSettings& settings,
                                                      const Integrator* tree = nullptr);

/// Conservative rasterization of all lightmapped triangles.
TexelMap rasterizeTexels(const BakeGeometry& geometry, int pageSize, int pageCount);

/// A texel with a smaller coverage is at the rim of its surface.
constexpr float kMostlyCovered = 0.6f;

/// Smallest cosine between normals on one side of a surface; below it there is a corner between them: 60 degrees.
constexpr float kSameSideCosine = 0.5f;
/// Smallest cosine between normals on a smooth surface, where light does not differ: 18 degrees.
constexpr float kSmoothCosine = 0.95f;

/// Texels between an edge and places that lie within it, despite rounding.
constexpr float kInsetTexels = 4.0e-3f;

/// Irradiance is even over a texel if that of its points varies by no more than this share of the largest. Other texels
/// take further batches of points, because lightmaps and masks hold the mean.
constexpr float kEvenIrradiance = 0.05f;
/// Most batches of such texels: 1,024 points, whose mean is within 1/255 of a step's.
constexpr int kMostBatches = 64;

/// 0, 1, … count - 1: all texels or probes.
std::vector<uint32_t> allIndices(std::size_t count);

/// Decides how each light is baked and assigns mask channels (spec S5, S9, S10); writes Light::baking.
void assignShadowmaskChannels(Scene& scene, MixedLightingMode mode);

/// Of a bake without bounces no light is reflected.
void limitBounces(Scene& scene, const IntegrationSettings& settings);

/// A grid of probes over the bounds of the static objects. `spacingMeters`: 0 = by the scene's size.
ProbeSet probeGrid(const Scene& scene, float spacingMeters, std::vector<std::string>& warnings);

/// Gives the invalid probes of a grid the mean light and occlusion of their nearest valid neighbours along its axes, so
/// that trilinear interpolation darkens nothing beside walls. They stay marked as invalid.
void fillInvalidProbes(ProbeSet& grid);

/// How far probes see (ProbeSight), so that interpolation leaves out those behind a wall. Nothing when cancelled.
std::optional<ProbeSight> findProbeSight(const ProbeSet& set, const Integrator& integrator, const Progress& progress);

/// Probes, and check probes: estimates between them, which are not kept.
struct BakedProbes {
    ProbeSet set;
    std::vector<vec3> checkedAt;       ///< places beside surfaces, metres
    std::vector<ProbeEstimate> checks; ///< by place; some are inside geometry
};
/// The probes (spec S14): those at the scene's own positions, with invalid ones marked; or, without positions, a grid
/// as `layout` says. Nothing when cancelled.
std::optional<BakedProbes> bakeProbes(const Scene& scene, float spacingMeters, ProbeLayout layout, bool denoise,
                                      const Gather& gather, std::vector<std::string>& warnings,
                                      const Progress& progress);
/// How far the light of the finished probes is off between them. `baked` has the probes, with what they see. Adds a
/// warning that names places where it is off by more than ProbeCheck::kOff.
ProbeCheck checkProbes(const BakedScene& baked, const BakedProbes& probes, std::vector<std::string>& warnings);

/// Reflection probes at the scene's own boxes, or where they bring what lightmapped surfaces reflect nearest to the
/// truth; none in a scene without light probes. `lightmap`: irradiance by page, lux. Writes how far texels trust the
/// probes into lightmapDirections. `size`: of a tile, if probes are few. False when cancelled.
bool bakeReflections(BakedScene& baked, const Gather& gather, std::span<const ImageRgb32f> lightmap, int size,
                     std::vector<std::string>& warnings, const Progress& progress);

struct SeamSample;
/// Edge-avoiding à-trous filter on the surface: within charts, and across their `seams` (denoise.cpp). Position, normal
/// and variance guide it. `directions`: also filters first moments, for directional lightmaps.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::span<const SeamSample> seams,
             std::vector<IrradianceEstimate>& estimates, bool directions = true);

/// Replaces the gathered light of the estimates by the result of Open Image Denoise's lightmap filter for `gathered`
/// (IrradianceEstimate::irradiance less direct, lux, by texel, before any denoising). Each chart is filtered on an
/// image of its own. Mean directions stay. Charts a few texels wide stay as they are. Fails in builds without the
/// library, and with the library's error.
Status imageDenoise(const TexelMap& map, const std::vector<vec3>& gathered, std::vector<IrradianceEstimate>& estimates,
                    const Progress& progress);

/// Fills texels inside geometry (valid 0), from the first of these that exists: adjacent valid texels of the same
/// chart; valid texels of any chart within a few texels in the world, with a similar normal (for charts that are inside
/// but for a sliver); texels farther away on the same chart. Other texels keep their values. `values`: one entry per
/// texel.
template<typename T> void fillInvalid(const BakeGeometry& geometry, const TexelMap& map,
                                      const std::vector<uint8_t>& valid, std::vector<T>& values);

/// A texel in the world.
struct TexelPlace {
    vec3 position{0.0f};      ///< centroid of the largest fragment, metres
    vec3 normal{0.0f};        ///< shading normal, unit
    float texelMeters = 0.0f; ///< width of a texel
};
TexelPlace placeOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel);

/// Turns channels whose shadows have narrow penumbrae into distance fields (shading/mask.h); other channels stay
/// attenuation. Returns the encoding of each channel.
std::array<MaskChannel, 4> maskToDistances(const TexelMap& map, std::vector<vec4>& mask);

/// Values of the lightmap, by texel.
struct TexelValues {
    std::vector<vec3> irradiance; ///< lux
    std::vector<vec3> direct;     ///< lux: IrradianceEstimate::direct
    std::vector<uint8_t> valid;   ///< 0: inside geometry
};
TexelValues splitEstimates(const std::vector<IrradianceEstimate>& estimates);

/// Rings of texels that dilation adds around charts: one for bilinear filtering, one more for bicubic. At most the
/// padding: more rings would reach other charts.
constexpr int kDilationRings = 2;
/// Pages with the values of the covered texels, extended into the padding ring by ring. An empty texel gets the
/// weighted mean of its neighbours of one chart; with `extrapolate` the linear extrapolation of pairs of them, which
/// suits distances and not light.
template<typename T>
std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings, bool extrapolate = false);

/// A point on an edge where two charts or objects meet on one smooth surface.
struct SeamSample {
    int objectA = 0; ///< index into Scene::objects
    int pageA = 0;
    int pageB = 0;
    vec2 texelA{0.0f};   ///< position on page A, in texels
    vec2 texelB{0.0f};   ///< position on page B
    float texels = 1.0f; ///< length that the sample represents, on the longer side
    bool bent = false;   ///< the triangles of both sides face differently, though the shading normals agree
    vec2 outwardA{0.0f}; ///< unit, on page A: at a right angle to the edge in the world, away from side A
    /// Offsets on page B for offsets on page A, with side A unfolded into the plane of side B.
    mat2 acrossFromA{1.0f};
    Segment sight; ///< from a point above side A to one above side B, less than a texel apart
};
std::vector<SeamSample> findSeams(const BakeGeometry& geometry, int pageSize);

/// Weight of each seam sample, 0…1: 1 if both sides are similar, 0 if one side has several times the other's light.
/// Gathered light may differ more at bends; `direct` is the part of `light` that lights contribute directly. Needs
/// dilated pages, because filtering at an edge reads padding.
std::vector<float> lightSeamWeights(const std::vector<SeamSample>& seams, const std::vector<ImageRgb32f>& light,
                                    const std::vector<ImageRgb32f>& direct);
/// The same for masks: 1 if both sides differ by up to a half.
std::vector<float> maskSeamWeights(const std::vector<SeamSample>& seams, const std::vector<ImageRgba32f>& masks);
/// Minimizes the difference of the bilinear values on both sides of the seams. Needs dilated pages; padding changes
/// more readily than covered texels. `bounded`: padding stays within the range of the adjacent covered texels; off for
/// extrapolated padding.
template<typename T> void stitchSeams(const TexelMap& map, const std::vector<SeamSample>& seams,
                                      std::span<const float> weights, std::vector<Image<T>>& pages,
                                      bool bounded = true);

/// Lux per unit of the encoded lightmap: the smallest power of two, 1 or more, for which no finite texel is clamped. A
/// power of two changes no mantissa.
float lightmapUnitFor(const std::vector<ImageRgb32f>& pages);
/// Encodes pages in lux as RGB9E5 in units of `unitLux`, clamped to the format's range.
std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages, float unitLux);
/// Encodes mean directions (shading/directional.h) from pages of irradiance and of its first moment, both in lux.
std::vector<ImageRgba8> encodeDirections(const std::vector<ImageRgb32f>& irradiance,
                                         const std::vector<ImageRgb32f>& moments);
/// Attenuation or distance, 0…1, in 8 bits.
std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages);

/// Makes surface points of one triangle.
class TriangleFrame {
public:
    TriangleFrame(const BakeGeometry& geometry, uint32_t triangle)
        : triangle_(triangle), geometricNormal_(geometry.geometricNormal(triangle)),
          positions_(geometry.cornersOf(triangle)), normals_(geometry.normalsOf(triangle))
    {
        flat_ = normals_[0] == normals_[1] && normals_[0] == normals_[2];
        if (flat_) normals_[0] = shadingNormal(normals_[0]);
    }
    /// Writes the point at barycentric weights (of vertices 1 and 2) to `p`. An output parameter avoids
    /// store-forwarding stalls of copies.
    void put(vec2 barycentric, SurfacePoint& p) const
    {
        const float w = 1.0f - barycentric.x - barycentric.y;
        p.triangle = triangle_;
        p.barycentric = barycentric;
        p.position = w * positions_[0] + barycentric.x * positions_[1] + barycentric.y * positions_[2];
        p.geometricNormal = geometricNormal_;
        p.normal = flat_ ? normals_[0]
                         : shadingNormal(w * normals_[0] + barycentric.x * normals_[1] + barycentric.y * normals_[2]);
    }

private:
    /// The normalized sum; the geometric normal where the sum points to the back. (Smooth normals on coarse meshes, and
    /// files whose normals contradict the winding, would put the hemisphere inside the surface.)
    [[nodiscard]] vec3 shadingNormal(vec3 sum) const
    {
        const float length = glm::length(sum);
        const vec3 normal = length > 0.0f ? sum * (1.0f / length) : geometricNormal_;
        return glm::dot(normal, geometricNormal_) > 0.0f ? normal : geometricNormal_;
    }

    uint32_t triangle_;
    vec3 geometricNormal_;
    std::array<vec3, 3> positions_;
    std::array<vec3, 3> normals_;
    bool flat_; ///< all points have the normal normals_[0]
};

} // namespace halflight
