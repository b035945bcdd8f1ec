#pragma once
// The bake: from a scene to lightmaps, shadowmasks and probes. bake() runs all stages; each stage is a function in
// src/bake/.

#include "halflight/bake/integrator.h"
#include "halflight/base/hash.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"
#include "halflight/scene/light_groups.h"
#include "halflight/scene/written_bytes.h"
#include "halflight/unwrap/unwrap.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

enum class Quality { Preview, Medium, High, Ultra };
/// As --quality has it.
const char* nameOf(Quality quality);

/// Content of shadowmask texels. Distance: signed distance to the shadow's edge in channels with narrow penumbrae (up
/// to about two texels), which keeps hard edges sharp with a quarter of the texels; attenuation in the other channels.
enum class MaskEncoding { Attenuation, Distance };

/// Refined: a grid, halved around rooms, with probes added where neighbours disagree and on floors, and without those
/// inside geometry. At most 20,000, unless a spacing is asked for. Grid:
/// the grid alone, for engines that read nothing else; probes inside geometry have the light of those around them.
enum class ProbeLayout { Refined, Grid };

/// BuiltIn: an edge-avoiding filter on charts and across their seams, guided by position, normal and the estimates'
/// variance.
enum class Denoiser { Off, BuiltIn };

/// In place of an identity (IntegratorFactory::identity), where results of machines of all identities are mixed.
inline constexpr const char* kMixedIdentities = "mixed";

struct BakeSettings {
    MixedLightingMode mode = MixedLightingMode::Shadowmask;
    Quality quality = Quality::Medium;
    int samples = 0;           ///< paths per texel; 0 = by quality
    int shadowSamples = 0;     ///< rays per texel and light, for masks and baked light; 0 = by quality
    int bounces = kAllBounces; ///< most indirect bounces; 0 = direct light only
    bool glossyBounces = true; ///< IntegrationSettings::glossyBounces
    IntegratorKind integrator = IntegratorKind::Cache;
    /// Relative standard error up to which a texel is sampled (CacheSettings::noiseTarget). `samples` is then the
    /// most that a texel gets, 4096 if it is 0. 0 = no target.
    float noiseTarget = 0.0f;
    /// Seconds that the bake, with the writing of its file, may take: it measures, and chooses `samples`, which must be
    /// 0. Not with a noise target or a cache. 0 = no limit.
    double seconds = 0.0;
    std::function<double()> clock; ///< seconds, for that limit; empty = of the machine
    InstructionSet isa = InstructionSet::Automatic;
    UvMode uvMode = UvMode::Auto;
    float texelsPerMeter = 0.0f; ///< 0 = as many as fit one page; without a lightmapSize at most sceneDensity()
    int lightmapSize = 0;        ///< texels; 0 = at most the quality's, cut to the used part
    int paddingTexels = 2;       ///< UnwrapSettings::paddingTexels
    TwoSided twoSided = TwoSided::Automatic; ///< of objects that do not say it themselves
    Denoiser denoiser = Denoiser::BuiltIn;
    /// Also bakes mean directions, for normal maps, gloss and metal (S32). Not given: not at previews with little
    /// metal.
    std::optional<bool> directional;
    MaskEncoding maskEncoding = MaskEncoding::Attenuation; ///< shadowmask bakes
    /// Shadowmask bakes have at most so many mask layers of four channels (spec S36), 1 to kMostMaskLayers.
    int mostMaskLayers = kMostMaskLayers;
    /// Subtractive bakes: also stores the main light's own mask, so that dynamic shadows subtract only unoccluded light
    /// (subtractiveIrradiance() in shading/law.h).
    bool subtractiveMask = true;
    float probeSpacingMeters = 0.0f; ///< 0 = by the scene's size
    ProbeLayout probeLayout = ProbeLayout::Refined;
    bool reflectionProbes = true;
    GroupChoice groups = GroupChoice::Authored; ///< light groups (spec S33)
    int threads = 0;                            ///< 0 = all cores; changes no byte of the result
    uint32_t seed = 1;
    /// Directory for every stage's result (lightmap_N.exr, shadowmask_N.png, probes.json, …); empty = none.
    std::filesystem::path imagesDirectory;
    /// Directory of the tile cache; empty = none. With it an interrupted bake continues, and a bake of a changed scene
    /// computes only the tiles that the change affects (beyond 0.5 %). It may be deleted at any time.
    std::filesystem::path cacheDirectory;
    /// The cache's results are shared by machines of all identities (IntegratorFactory::identity), as in a farm of
    /// unlike machines: each tile has the light of the machine that computed it. False: each identity has its own.
    bool mixedIdentities = false;
    /// Names of the objects to bake; empty = all. All other objects keep the texels of the last bake in the cache,
    /// which must have the same layout and settings. An entry names objects, or a node above them (see objectsNamed()),
    /// or several of these between commas.
    std::vector<std::string> only;
};

/// The numbers of a quality, with explicit settings applied.
struct BakeQuality {
    int samples;
    int shadowSamples;
    int lightmapSize;
    int probeSamples;
    int reflectionSize;        ///< texels, ReflectionSet::size
    int bounces = kAllBounces; ///< the most
    float noiseTarget = 0.0f;  ///< 0 = none
    bool directional = false;
};
BakeQuality resolveQuality(const BakeSettings& settings);
/// About how many samples a lightmap will take, before anything of it is known: the lightmapped area at its density,
/// times the quality's samples. Where a page limits the density, four fifths of the page are texels.
double expectedSamples(const Scene& scene, const BakeSettings& settings);

struct LightReport {
    std::string name;
    LightType type = LightType::Point;
    LightMode authoredMode = LightMode::Mixed;
    LightMode bakedAs = LightMode::Mixed;
    int channel = -1;
    std::string reason;        ///< why it is not baked as authored; empty if it is
    float reachMeters = 0.0f;  ///< BakingOutput::reachMeters
    bool coloredMask = false;  ///< BakingOutput::coloredMask
    bool distanceMask = false; ///< its channel holds distances (MaskEncoding::Distance), not attenuation
};

/// Subtractive's main light, and the lower limit of its dynamic shadows.
struct MainLightReport {
    std::string name;
    bool mask = false;        ///< the file holds its own mask
    vec3 shadowColor{0.0f};   ///< lower limit of its dynamic shadows, lux
    bool colorByBake = false; ///< the scene has no colour, so the bake chose it
};

/// Stages of pages run beside those that trace rays.
struct StageReport {
    std::string name;
    double start = 0.0; ///< seconds since the bake began
    double seconds = 0.0;
    double cpuSeconds = 0.0; ///< of all threads meanwhile; over `seconds`: how many cores are busy
    uint64_t rays = 0;
};

/// Number of tiles of a bake with a cache, by source; the rest was computed.
struct TileCounts {
    std::size_t tiles = 0;
    std::size_t same = 0;      ///< written by an earlier run of the same bake
    std::size_t unchanged = 0; ///< of the last bake, not affected by the change
    std::size_t kept = 0;      ///< of the last bake, whole tiles that BakeSettings::only leaves as they were
};

/// An object with sheets whose sides have texels of their own.
struct TwoSidedReport {
    std::string object;
    uint64_t triangles = 0; ///< of one side
    uint64_t texels = 0;    ///< of the second side
};

/// Light interpolated between probes, against check probes at places beside surfaces that are baked and not kept. An
/// error is the difference of irradiance, mean over six sides and beyond the check probe's noise, over the mean
/// irradiance. In the dark it is over 1 % of that of the median probe.
struct ProbeCheck {
    static constexpr float kOff = 0.25f; ///< error above which a place is named in a warning

    int places = 0;         ///< check probes outside geometry
    int off = 0;            ///< places with a larger error than kOff
    float meanError = 0.0f; ///< 0…
    float mostError = 0.0f;
};

struct BakeReport {
    std::vector<LightReport> lights;
    std::optional<MainLightReport> mainLight; ///< of subtractive bakes that have one
    std::vector<StageReport> stages;          ///< by start
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
    std::vector<MeshUnwrapReport> meshes;
    std::vector<TwoSidedReport> twoSided;
    std::vector<std::string> warnings;
    BakeQuality quality{};
    TileCounts cache;       ///< all zero without a cache
    std::string integrator; ///< e.g. "cpu (radiance cache, Embree 3.13.5, 2 threads)"
    std::string identity;   ///< IntegratorFactory::identity
    int pageCount = 0;
    int pageSize = 0;
    int chartCount = 0;
    int cuts = 0; ///< UnwrappedScene::cuts
    uint64_t coveredTexels = 0;
    double samplesPerTexel = 0.0; ///< mean
    /// Root mean square over the texels of the standard error of luminance before denoising, over the mean luminance.
    float noiseReached = 0.0f;
    uint64_t texelsAtCap = 0;   ///< texels that reached `samples` before the noise target
    uint64_t invalidTexels = 0; ///< texels inside geometry, filled from neighbours
    float texelsPerMeter = 0.0f;
    DensityFrom densityFrom = DensityFrom::Page;
    float atlasCoverage = 0.0f; ///< 0…1
    WrittenBytes written;       ///< of the output file; zero until it is written
    int probeCount = 0;
    int validProbeCount = 0;
    ProbeCheck probeCheck;
    int reflectionProbeCount = 0;
    uint64_t triangleCount = 0; ///< static, drawn
    uint64_t peakMemoryBytes = 0;
    uint64_t peakDeviceBytes = 0; ///< of the memory of the GPU that baked; 0 = none did
    double seconds = 0.0;
};

struct BakeResult {
    BakedScene baked;
    std::vector<ImageRgb32f> irradiance;                   ///< the lightmaps before they became RGB9E5, lux
    std::vector<std::vector<ImageRgb32f>> groupIrradiance; ///< the same of BakedScene::groups
    BakeReport report;
    Status images; ///< the first error of a file in BakeSettings::imagesDirectory
};

/// The warning for tiles that could not be written to the cache.
std::string cacheWarning(const std::filesystem::path& folder, const Error& error);

/// Runs the whole bake. `integratorFactory` makes its integrator (embreeIntegrators() of bake_cpu, say). Errors:
/// those of unwrap() and of the integrator, Cancelled, and Unsupported for a denoiser that the build lacks.
Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress = {});

/// Hash of all inputs that affect the output file: equal hashes and identities mean equal bytes. Not for bakes of some
/// objects, whose bytes follow from the last bake too.
Hash128 bakeHash(const Scene& scene, const BakeSettings& settings);

/// "asked", "page" or "scene".
const char* nameOf(DensityFrom from);

/// The report as the JSON that `halflight bake --report` writes.
std::string reportJson(const BakeReport& report);

} // namespace halflight
