#pragma once
// The stages of the bake, in the order bake.cpp calls them. Each is a function of its inputs.

#include "halflight/bake/bake.h"
#include "halflight/bake/integrator.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

struct Gather;

/// Which objects become geometry.
enum class GeometryFilter { Static, All };
BakeGeometry flattenGeometry(const Scene& scene, int pageSize, GeometryFilter filter);

/// Fills BakeGeometry::solid: closed pieces of one object, or of several together, whose faces look outward. Such a
/// piece has an inside that nobody sees, even when its material is double-sided (as many exporters write for
/// everything). Double-sided ones that look inward though there is nothing inside, not even light, are turned around:
/// they are seen from outside, and have their light there.
void findSolids(const Scene& scene, BakeGeometry& geometry);

/// Where local lights, cameras and moving objects are: what makes the inside of something a place to be seen.
std::vector<vec3> lightsAndLookers(const Scene& scene);

/// Turns triangles around: their front is where their back was, with the light that is there.
void turnAround(BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// The given triangles in patches that face one way, about: across edges of two of them that look to the same side and
/// do not turn sharply there.
std::vector<std::vector<uint32_t>> facingPatches(const BakeGeometry& geometry, std::span<const uint32_t> triangles);

/// Surfaces that look to both sides have light for one of them, their front. Where that is in a narrow hollow, closed
/// but for a little (of a chair's rail, say, some of whose faces look inward, as modellers without a care for sides
/// leave them), it would be all but black, and is seen from the back alone. Turns those around. Which they are an
/// integrator tells; returns the one for the geometry as it is then.
Result<std::unique_ptr<Integrator>> turnHollows(const IntegratorFactory& factory, const Scene& scene,
                                                BakeGeometry& geometry, const IntegrationSettings& settings);

/// Conservative rasterization of all lightmapped triangles.
TexelMap rasterizeTexels(const BakeGeometry& geometry, int pageSize, int pageCount);

/// A texel that is covered less than this is at the rim of its surface.
constexpr float kMostlyCovered = 0.6f;

/// 0, 1, … count - 1: all texels or probes.
std::vector<uint32_t> allIndices(std::size_t count);

/// Decides what each light's bake is and which mask channel it gets (spec S5, S9, S10); writes Light::baking.
void assignShadowmaskChannels(Scene& scene, MixedLightingMode mode);

/// A grid of probes over the bounds of the static objects; spacing 0 = by the scene's size.
ProbeSet probeGrid(const Scene& scene, float spacingMeters, std::vector<std::string>& warnings);

/// The probes (spec S14): at the positions the scene asks for, those inside geometry marked; or, where it asks for
/// none, a grid refined where neighbours disagree, without any inside geometry. Nothing when cancelled.
std::optional<ProbeSet> bakeProbes(const Scene& scene, float spacingMeters, bool denoise, const Gather& gather,
                                   std::vector<std::string>& warnings, const Progress& progress);

/// Edge-stopping à-trous filter within charts, guided by position, normal and the estimates' variance. `directions`:
/// their first moments too, which directional lightmaps alone have a use for.
void denoise(const BakeGeometry& geometry, const TexelMap& map, std::vector<IrradianceEstimate>& estimates,
             bool directions = true);

/// Replaces what the estimates have of `gathered` light (IrradianceEstimate::irradiance less direct, in lux, by number
/// of texel, before any denoising) by what Open Image Denoise's filter for lightmaps makes of it, each chart apart on
/// an image of its own; first moments keep their mean directions. Charts a few texels wide stay as they are. Fails
/// where the build has no such library, or where that fails.
Status imageDenoise(const TexelMap& map, const std::vector<vec3>& gathered, std::vector<IrradianceEstimate>& estimates,
                    const Progress& progress);

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

/// Turns the channels whose shadows have narrow edges into distance fields (shading/mask.h); the others stay
/// attenuation. Returns how each is to be read.
std::array<MaskChannel, 4> maskToDistances(const TexelMap& map, std::vector<vec4>& mask);

/// What the lightmap is made of, by texel.
struct TexelValues {
    std::vector<vec3> irradiance;
    std::vector<uint8_t> valid;
};
TexelValues splitEstimates(const std::vector<IrradianceEstimate>& estimates);

/// Rings of texels that dilation adds around charts: what bilinear filtering can touch, and one more for bicubic. Never
/// more than the padding: a ring past it would meet another chart.
constexpr int kDilationRings = 2;
/// Values of the covered texels laid out on their pages and grown into the padding: each empty texel takes the mean of
/// its nearest covered neighbours, all of one chart; with `extrapolate` what goes on in a straight line through two of
/// them (distances do, light need not).
template<typename T>
std::vector<Image<T>> dilate(const TexelMap& map, const std::vector<T>& values, int rings, bool extrapolate = false);

/// A place on an edge where two charts (or two objects) meet on one smooth surface, in texels on each side's page.
struct SeamSample {
    int objectA = 0; ///< index into Scene::objects
    int pageA = 0;
    int pageB = 0;
    vec2 texelA{0.0f};
    vec2 texelB{0.0f};
    float texels = 1.0f; ///< length of the stretch it stands for, on the side where it is longer
};
std::vector<SeamSample> findSeams(const BakeGeometry& geometry, int pageSize);

/// How much the sides of each seam are to agree, 0…1: wholly where they do nearly, not at all where one has several
/// times the other's light. Works on dilated pages: filtering at an edge reads padding.
template<typename T>
std::vector<float> seamWeights(const std::vector<SeamSample>& seams, const std::vector<Image<T>>& pages);
/// Makes bilinear values on both sides of each seam agree, by their weights. Works on dilated pages; padding gives way
/// rather than what `map` says is covered. `bounded`: padding stays between the least and the most of the covered
/// texels next to it, but where padding was extrapolated.
template<typename T> void stitchSeams(const TexelMap& map, const std::vector<SeamSample>& seams,
                                      std::span<const float> weights, std::vector<Image<T>>& pages,
                                      bool bounded = true);

/// The largest value RGB9E5 holds.
constexpr float kMaxRgb9e5 = 65408.0f;
/// Lux per unit of the encoded lightmap: the smallest power of two, 1 or more, with which no finite texel is cut. Being
/// a power of two it changes exponents and no mantissa.
float lightmapUnitFor(const std::vector<ImageRgb32f>& pages);
/// Pages in lux as RGB9E5 in units of `unitLux`; what is brighter than the format holds is cut there.
std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages, float unitLux);
/// Mean directions (shading/directional.h) from pages of irradiance and of its first moment.
std::vector<ImageRgba8> encodeDirections(const std::vector<ImageRgb32f>& irradiance,
                                         const std::vector<ImageRgb32f>& moments);
std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages);

/// Irradiance in lux of an encoded page.
ImageRgb32f decodeLightmap(const Image<uint32_t>& page, float unitLux);

/// What all points of a triangle share.
class TriangleFrame {
public:
    TriangleFrame(const BakeGeometry& geometry, uint32_t triangle)
        : triangle_(triangle), geometricNormal_(geometry.geometricNormal(triangle))
    {
        const uvec3 t = geometry.triangles[triangle];
        for (int i = 0; i < 3; ++i) {
            positions_[i] = geometry.positions[t[i]];
            normals_[i] = geometry.normals[t[i]];
        }
        flat_ = normals_[0] == normals_[1] && normals_[0] == normals_[2];
        if (flat_) normals_[0] = shadingNormal(normals_[0]);
    }
    /// Writes the point at barycentric weights (of vertices 1 and 2) where it is to be: copies of what was just written
    /// in parts make the processor wait.
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
    /// Smooth normals that lean behind the triangle (or files whose normals contradict the winding) would put the whole
    /// hemisphere inside the surface; the triangle's own normal is the safe choice there.
    [[nodiscard]] vec3 shadingNormal(vec3 sum) const
    {
        const float length = glm::length(sum);
        const vec3 normal = length > 0.0f ? sum * (1.0f / length) : geometricNormal_;
        return glm::dot(normal, geometricNormal_) > 0.0f ? normal : geometricNormal_;
    }

    uint32_t triangle_;
    vec3 geometricNormal_;
    vec3 positions_[3];
    vec3 normals_[3];
    bool flat_; ///< one normal for all points: normals_[0]
};

} // namespace halflight
