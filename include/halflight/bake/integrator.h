#pragma once
// The interface between the stages of a bake and the code that traces its rays. src/bake_cpu implements it with Embree.
// All positions are in world space, in metres, relative to Scene::originMeters.

#include "halflight/bake/bake_geometry.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

class PartFolder;
struct DenoiserTexels;
struct Signals;

/// The intersection of a triangle and one texel's square.
struct TexelFragment {
    uint32_t triangle = 0;
    vec2 barycentric{0.0f}; ///< weights of vertices 1 and 2 at the fragment's centroid
    float area = 0.0f;      ///< over that of the texel's square, 0…1
};

/// Sample points of a texel: bit i is point i of texelPoints(), batch 0.
using PointMask = uint16_t;
constexpr PointMask kAllPoints = 0xffff;

/// A texel that at least one triangle overlaps.
struct Texel {
    uint16_t x = 0; ///< column and row on the page
    uint16_t y = 0;
    PointMask validPoints = kAllPoints; ///< points outside geometry (Integrator::findValidPoints()); 0 = texel invalid
    uint32_t page = 0;
    uint32_t chart = 0;         ///< number of the connected piece of surface
    uint32_t firstFragment = 0; ///< index into TexelMap::fragments, of the largest one
    uint32_t fragmentCount = 0;
};

/// All covered texels of all pages. Coverage is conservative: any overlap counts. Texels are sorted by page, then by
/// Morton code, so that neighbours on the page are close in memory.
struct TexelMap {
    int pageSize = 0; ///< width and height in texels
    int pageCount = 0;
    uint32_t chartCount = 0;
    std::vector<Texel> texels;
    std::vector<TexelFragment> fragments;
};

/// A point on a surface from which rays start.
struct SurfacePoint {
    vec3 position{0.0f};        ///< world space
    vec3 normal{0.0f};          ///< interpolated shading normal, unit
    vec3 geometricNormal{0.0f}; ///< unit
    uint32_t triangle = 0;
    vec2 barycentric{0.0f};
};

/// The point of a triangle at barycentric weights (of vertices 1 and 2).
SurfacePoint surfacePoint(const BakeGeometry& geometry, uint32_t triangle, vec2 barycentric);

/// Sum of a texel's fragment areas over the area of its square: 0…1, more where triangles overlap.
float coveredArea(const TexelMap& map, const Texel& texel);

constexpr int kMaxTexelPoints = 16;
static_assert(kMaxTexelPoints <= 8 * sizeof(PointMask));

/// Writes 1 to kMaxTexelPoints sample points, stratified over the covered part of the texel, and returns their number.
/// Texels with a coverage of 1/8 and more get nearly kMaxTexelPoints. Batches have different points; the union of
/// batches is stratified too.
int texelPoints(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel,
                std::span<SurfacePoint, kMaxTexelPoints> out, int batch = 0);

/// Estimator of lightmaps. Path: path tracing, unbiased, the reference. Cache: final gathering from a radiance cache,
/// many times faster; the bias of the mean is below 1 % where surfaces are diffuse. Of glossy ones it has the first
/// moment of what they reflect (docs/quality_truth.md).
enum class IntegratorKind { Cache, Path };

/// Limit on indirect bounces that holds all light: surfaces that reflect 98 % lose 0.98^256 = 0.6 % to it, others less.
/// Paths end earlier by Russian roulette, the radiosity solution when it has converged.
constexpr int kAllBounces = 256;

/// What the cache integrator alone has.
struct CacheSettings {
    /// Largest standard error of a texel's luminance, relative to the mean of the texels around it on its chart (to
    /// 1/50 of the map's mean in darker places). IntegrationSettings::samples is then the most a texel gets. 0 = no
    /// target.
    float noiseTarget = 0.0f;
    /// Whether denoising follows. Without a noise target, samples are then allocated to the noise that the denoiser
    /// leaves: to texels where light varies from texel to texel.
    bool denoised = true;
};

/// Instructions of the processor that trace rays; other ones give light that differs within its noise, in other bytes.
/// Automatic: Avx2 where the processor has it, else Sse2, the first set of each processor. Other processors than x86
/// have one set, which is named Sse2 here.
enum class InstructionSet { Automatic, Sse2, Avx2, Avx512 };
/// As --isa has it.
const char* nameOf(InstructionSet set);

/// Sources of light by component: the rest, which is component 0, and light groups from 1 on (spec S33). Estimates of
/// components add up to those of the sum.
struct LightComponents {
    int count = 0;               ///< 0: light is estimated as one
    std::vector<int> ofLight;    ///< by Scene::lights
    std::vector<int> ofMaterial; ///< by Scene::materials: of emission
    std::array<int, 3> ofSky{};  ///< zenith, horizon and ground of a gradient; all the same for a picture
};

struct IntegrationSettings {
    IntegratorKind integrator = IntegratorKind::Cache;
    InstructionSet isa = InstructionSet::Automatic;
    /// Mean number of paths per traced texel, at least 1. The cache integrator works in blocks of 16 samples. It gives
    /// a texel between 1/2 and 32 times the mean, in proportion to the standard deviation of its noise (see
    /// CacheSettings::denoised). The least share is 1/2 among 24 neighbours of a chart, and larger among fewer: 1/2 x
    /// 25 / texels.
    int samples = 64;
    /// Rays per texel and light, for masks and for baked direct light, at least 1. Texels on a shadow edge get up to
    /// twice the number for masks and eight times for baked light, their neighbours half, texels far from an edge 1/8.
    int shadowSamples = 16;
    int probeSamples = 256;    ///< paths per probe, at least 1
    int bounces = kAllBounces; ///< most indirect bounces, 0 or more; 0 = direct light only
    /// Whether surfaces reflect light to other surfaces by glTF's BRDF, specular lobe included. False: as diffuse
    /// surfaces of shading::transportAlbedo().
    bool glossyBounces = true;
    uint32_t seed = 1;
    bool fewRays = false; ///< what takes long to build, but pays off only with many rays, is left out
    CacheSettings cache;
    LightComponents components;
};

/// Lightmap value of one texel, with the statistics for the denoiser.
struct IrradianceEstimate {
    vec3 irradiance{0.0f};         ///< lux
    vec3 moment{0.0f};             ///< lux: integral of luminance of radiance × cosine × direction (first moment)
    float varianceOfMean = 0.0f;   ///< of the luminance of `irradiance`, lux²
    vec3 direct{0.0f};             ///< lux: the part of `irradiance` that fully baked lights contribute directly
    float varianceOfDirect = 0.0f; ///< of its luminance, lux²; included in varianceOfMean
    uint32_t samples = 0;          ///< number of rays or paths
    bool valid = true;             ///< false: the texel has no valid points
};

struct ProbeEstimate {
    SphericalHarmonicsL2 radiance{};
    MaskValues occlusion;  ///< attenuation by mask channel, 0…1
    float variance = 0.0f; ///< of the luminance of a coefficient, mean over the nine
    bool valid = true;     ///< false: inside geometry
};

/// What a surface point reflects by its specular lobe, and its material (shading/brdf.h).
struct SpecularEstimate {
    vec3 baseColor{0.0f};
    float metallic = 0.0f;
    float roughness = 1.0f;
    float specular = 1.0f;
    std::vector<vec3> radiance; ///< nits, by view
};

/// Texels to work on, and the effort.
struct TexelRequest {
    std::span<const uint32_t> texels; ///< indices into TexelMap::texels
    int samples = 0;                  ///< paths per texel; 0 = IntegrationSettings::samples
    int shadowSamples = 0;            ///< rays per texel and light; 0 = IntegrationSettings::shadowSamples
    /// For a first look before findValidPoints(): path traced, all points taken as valid, one shadow ray for each baked
    /// light.
    bool rough = false;
};

/// A line between two points.
struct Segment {
    vec3 from{0.0f}; ///< world space, metres
    vec3 to{0.0f};
};

/// One side of a surface at a point: that of the point's normals.
struct SideEstimate {
    vec3 irradiance{0.0f}; ///< lux: the light of the lightmap, path traced
    vec3 direct{0.0f};     ///< lux: direct light that the lightmap does not contain
    /// Share of random walks through the space in front that leave the scene, meet a surface that emits, or come in
    /// sight of an eye.
    float open = 0.0f;
};

/// Irradiance of the texels of one map. Holds what they have in common, such as the radiance cache, as long as it
/// lives, and keeps it in the folder of parts, if there is one.
class PreparedLightmap {
public:
    virtual ~PreparedLightmap() = default;

    /// The light of the lightmap (spec S6), one estimate per texel of the request: emitters, the sky, direct light of
    /// lights that are baked for static receivers, bounced light of mixed and baked lights. The direct light of
    /// subtractive's main light is not included; bakeMainLight() derives it from the mask.
    virtual Status irradiance(const TexelRequest& request, std::span<IrradianceEstimate> out,
                              const Progress& progress) = 0;
    /// The same with the estimates of each component: that of component c at the request's texel i is
    /// components[i * LightComponents::count + c]. Unsupported by integrators without components.
    virtual Status irradianceByComponent(const TexelRequest& request, std::span<IrradianceEstimate> out,
                                         std::span<IrradianceEstimate> components, const Progress& progress);
    /// Computes now what irradiance() else computes when it first needs it.
    virtual Status prepareAll(const Progress& progress) = 0;
    /// The parts of prepareAll() that farm workers share, without what each would do by itself with them.
    virtual Status prepareParts(const Progress& progress) = 0;
    /// In place of IntegrationSettings::samples, from now on. Results are those of an integrator made with that number.
    /// False: what texels have in common does not serve it, and is computed anew.
    virtual bool setSamples(int samples) = 0;
};

/// Estimates light by tracing rays. Results depend on the scene, the settings and the texel or probe alone: not on
/// threads, nor on what else is requested. Errors of all functions: Cancelled, and DeviceFailed where the device is
/// lost. From then on all calls fail. `out` is undefined after an error, and the folder of parts keeps nothing of it.
class Integrator {
public:
    virtual ~Integrator() = default;

    /// One line for reports: device, library, threads.
    [[nodiscard]] virtual std::string description() const = 0;

    /// Validity, the first stage: sets Texel::validPoints of all texels. The functions below use valid points alone,
    /// but for rough requests of irradiance. `parts`, which may be null, keeps the result.
    virtual Status findValidPoints(TexelMap& map, PartFolder* parts, const Progress& progress) = 0;
    /// The same for single points: where `out` is 1, it becomes 0 for a point inside geometry. Others are not tested.
    virtual Status findValidPoints(std::span<const SurfacePoint> points, std::span<uint8_t> out) const = 0;

    /// For irradiance of a map's texels. `parts` may be null. It, the map and the integrator outlive the result.
    virtual std::unique_ptr<PreparedLightmap> prepare(const TexelMap& map, PartFolder* parts) = 0;

    /// By light of the scene: share of the texels in its reach where its shadow's colour channels differ by more than
    /// 2/255. Looks at a part of the texels, with few rays, and takes all their points as valid. 0 for lights without a
    /// mask channel, and in scenes without coloured glass.
    virtual Status coloredShadows(const TexelMap& map, std::span<float> shares, const Progress& progress) = 0;

    /// Attenuation by static casters for each light with a channel of that mask layer, 0…1; 1 in channels without a
    /// light in reach. Lights with coloured masks have a value in each of their three channels. For subtractive's main
    /// light: shadowed over unshadowed irradiance, 0 where both are 0.
    virtual Status shadowmask(const TexelMap& map, const TexelRequest& request, int layer, std::span<vec4> out,
                              const Progress& progress) = 0;

    /// Light and occlusion at positions[i] for each i of `which`, with `samples` paths each (0 =
    /// IntegrationSettings::probeSamples).
    virtual Status probes(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                          std::span<ProbeEstimate> out, const Progress& progress) = 0;

    /// The same with the radiance of each component: that of component c at position i is
    /// components[i * LightComponents::count + c]. Unsupported by integrators without components.
    virtual Status probesByComponent(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                                     std::span<ProbeEstimate> out, std::span<SphericalHarmonicsL2> components,
                                     const Progress& progress);

    /// Radiance that arrives at a point from all sides: emission, the sky, and what static surfaces reflect of the
    /// lightmap and of mixed lights; with IntegrationSettings::glossyBounces by their specular lobes too. `lightmap`:
    /// irradiance by page, lux; surfaces without a page are path traced. Texel (x, y) of the square map is the mean of
    /// `rays` rays over its square of octahedronFromDirection() in shading/reflection.h.
    virtual Status radianceAround(vec3 position, std::span<const ImageRgb32f> lightmap, int rays, ImageRgb32f& map,
                                  const Progress& progress) = 0;

    /// The same of each component: maps[c], all of one size, with the pages of `lightmaps`[c]. Unsupported by
    /// integrators without components.
    virtual Status radianceAroundByComponent(vec3 position, std::span<const std::span<const ImageRgb32f>> lightmaps,
                                             int rays, std::span<ImageRgb32f> maps, const Progress& progress);

    /// Estimates for sides of surfaces before there are texels, with `paths` paths for irradiance (0 = none) and
    /// `walks` random walks. `eyes`: places that one looks from, such as cameras and lights.
    virtual Status sides(std::span<const SurfacePoint> points, std::span<const vec3> eyes, int paths, int walks,
                         std::span<SideEstimate> out, const Progress& progress) = 0;

    /// Light that points reflect towards views by their specular lobes, path traced: all that the renderer makes of
    /// baked light, so without direct light of lights that it draws itself. `views`: unit vectors on the normals'
    /// sides, equally many for each point.
    virtual Status specularLight(std::span<const SurfacePoint> points, std::span<const vec3> views,
                                 std::span<SpecularEstimate> out, const Progress& progress) = 0;

    /// For each segment, the distances in metres from its start to the first and to the last surface on the way;
    /// nothing if it is unoccluded.
    virtual Status surfacesAlong(std::span<const Segment> segments, std::span<std::optional<vec2>> out) const = 0;

    [[nodiscard]] virtual uint64_t raysTraced() const = 0;
};

/// Denoises light of components (spec S33) on a device, in its place. A bake without groups has one. After an error all
/// of it is as it was. Unsupported: the map is not for the device. DeviceFailed: the device is lost.
using DeviceDenoiser = std::function<Status(const DenoiserTexels& texels, std::span<Signals> components)>;

/// A kind of integrator.
struct IntegratorFactory {
    /// Makes an integrator for a scene whose lights have their baking output assigned. `geometry` and `scene` outlive
    /// it.
    std::function<Result<std::unique_ptr<Integrator>>(const Scene& scene, const BakeGeometry& geometry,
                                                      const IntegrationSettings& settings)>
        make;
    /// The identity of what such an integrator computes here with an instruction set. Programs and machines with the
    /// same identity give the same bytes. It is a file's name of letters, digits, '.' and '-'. Unsupported where the
    /// processor lacks the set.
    std::function<Result<std::string>(InstructionSet set)> identity;
    /// Bakes anew where such an integrator fails with DeviceFailed: null = the bake fails too.
    std::shared_ptr<const IntegratorFactory> instead;
    DeviceDenoiser denoise; ///< empty: the processor denoises
    /// The most of the device's memory that was taken at one time, bytes. Empty: there is no device.
    std::function<uint64_t()> peakDeviceBytes;
};

struct BakeSettings;
/// The integrators for a bake. An error ends it.
using ChooseIntegrators = std::function<Result<IntegratorFactory>(const Scene& scene, const BakeSettings& settings)>;

} // namespace halflight
