#pragma once
// The bake: scene in, lightmaps, shadowmasks and probes out. bake() runs all stages; each stage is a function of its
// own in src/bake/.

#include "halflight/bake/integrator.h"
#include "halflight/base/hash.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"
#include "halflight/scene/written_bytes.h"
#include "halflight/unwrap/unwrap.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

enum class Quality { Preview, Medium, High, Ultra };

/// What shadowmask texels hold. Distance: distance to the shadow's edge for channels whose shadows have narrow
/// penumbrae (about two texels), so that hard edges stay crisp with a quarter of the texels; attenuation for the
/// others.
enum class MaskEncoding { Attenuation, Distance };

/// BuiltIn: an edge-stopping filter within charts, guided by position, normal and the estimates' variance. OpenImage:
/// what rays gather by Open Image Denoise's network for lightmaps, chart by chart, all else as BuiltIn; for builds that
/// have it (hasOpenImageDenoise()).
enum class Denoiser { Off, BuiltIn, OpenImage };
bool hasOpenImageDenoise();

struct BakeSettings {
    MixedLightingMode mode = MixedLightingMode::Shadowmask;
    Quality quality = Quality::Medium;
    int samples = 0;       ///< paths per texel; 0 = by quality
    int shadowSamples = 0; ///< rays per texel and masked light; 0 = by quality
    int bounces = -1;      ///< indirect bounces, 0 = direct light only; -1 = by quality
    IntegratorKind integrator = IntegratorKind::Cache;
    /// Relative standard error at which a texel has enough samples (IntegrationSettings::noiseTarget); `samples` is
    /// then the most a texel gets, 4096 when it is 0. 0 = no target.
    float noiseTarget = 0.0f;
    int texelStep = 0; ///< IntegrationSettings::texelStep
    UvMode uvMode = UvMode::Auto;
    float texelsPerMeter = 0.0f; ///< 0 = what fits one page; without a lightmapSize at most sceneDensity()
    int lightmapSize = 0;        ///< 0 = at most what the quality says, cut to what is used
    int paddingTexels = 2;       ///< UnwrapSettings::paddingTexels
    Denoiser denoiser = Denoiser::BuiltIn;
    bool directional = false; ///< also keep the mean direction of lightmap light, for normal maps (spec S32)
    MaskEncoding maskEncoding = MaskEncoding::Attenuation; ///< shadowmask bakes
    /// Subtractive bakes: also store the main light's own mask, so that dynamic shadows take away only light that
    /// arrives (subtractiveIrradiance() in shading/law.h).
    bool subtractiveMask = true;
    float probeSpacingMeters = 0.0f; ///< 0 = by the scene's size
    int threads = 0;                 ///< 0 = all cores; changes no byte of the result
    uint32_t seed = 1;
    /// Every stage's result is written here (lightmap_N.exr, shadowmask_N.png, probes.json, and more); empty = nowhere.
    std::filesystem::path imagesDirectory;
    /// Finished tiles are kept here and taken from here: an interrupted bake goes on, a changed scene is baked anew
    /// only where the change shows (within noise). May be deleted at any time; empty = none.
    std::filesystem::path cacheDirectory;
};

/// What a quality stands for, with the explicit settings applied.
struct BakeQuality {
    int samples;
    int shadowSamples;
    int bounces;
    int lightmapSize;
    int probeSamples;
    float noiseTarget; ///< 0 = none
};
BakeQuality resolveQuality(const BakeSettings& settings);

struct LightReport {
    std::string name;
    LightType type = LightType::Point;
    LightMode authoredMode = LightMode::Mixed;
    LightMode bakedAs = LightMode::Mixed;
    int channel = -1;
    std::string reason;        ///< empty when the light is what its author asked for
    float reachMeters = 0.0f;  ///< BakingOutput::reachMeters
    bool distanceMask = false; ///< its channel holds distances (MaskEncoding::Distance), not attenuation
};

/// Subtractive's main light and what its dynamic shadows are limited by.
struct MainLightReport {
    std::string name;
    bool mask = false;        ///< the file holds its own mask
    vec3 shadowColor{0.0f};   ///< lower limit of its dynamic shadows, lux
    bool colorByBake = false; ///< the author named none, so the bake chose
};

struct StageReport {
    std::string name;
    double seconds = 0.0;
    uint64_t rays = 0;
};

/// Where the tiles of a bake with a cache came from; the rest was baked.
struct TileCounts {
    std::size_t tiles = 0;
    std::size_t same = 0;      ///< of this very bake, interrupted or finished earlier
    std::size_t unchanged = 0; ///< of the bake before, whose change does not reach them
};

struct BakeReport {
    std::vector<LightReport> lights;
    std::optional<MainLightReport> mainLight; ///< of subtractive bakes that have one
    std::vector<StageReport> stages;
    std::vector<MeshUnwrapReport> meshes;
    std::vector<std::string> warnings;
    BakeQuality quality{};
    TileCounts cache;       ///< all zero without a cache
    std::string integrator; ///< e.g. "cpu (radiance cache, Embree 3.13.5, 2 threads)"
    int pageCount = 0;
    int pageSize = 0;
    int chartCount = 0;
    uint64_t coveredTexels = 0;
    double samplesPerTexel = 0.0; ///< mean
    float noiseReached =
        0.0f; ///< standard error of a texel's luminance before denoising over the mean, root mean square
    uint64_t texelsBetween = 0; ///< texels that take the mean of those around them (IntegrationSettings::texelStep)
    uint64_t texelsAtCap = 0;   ///< texels that a noise target would have given more samples than allowed
    uint64_t invalidTexels = 0; ///< texels inside geometry, filled from neighbours
    float texelsPerMeter = 0.0f;
    DensityFrom densityFrom = DensityFrom::Page;
    float atlasCoverage = 0.0f; ///< 0…1
    WrittenBytes written;       ///< of the output file; zero until it is written
    int probeCount = 0;
    int validProbeCount = 0;
    uint64_t triangleCount = 0; ///< static, drawn
    uint64_t peakMemoryBytes = 0;
    double seconds = 0.0;
};

struct BakeResult {
    BakedScene baked;
    BakeReport report;
    Status images; ///< the first of BakeSettings::imagesDirectory's files that could not be written, by name
};

/// What a report says when tiles could not be kept in the folder: the next bake computes them again.
std::string cacheWarning(const std::filesystem::path& folder, const Error& error);

/// Runs the whole bake with the given integrator.
Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress = {});

/// Of all that decides a bake's output file: equal hashes, equal bytes.
Hash128 bakeHash(const Scene& scene, const BakeSettings& settings);

/// Why the density is what it is: "asked", "page", "scene".
const char* nameOf(DensityFrom from);

/// The report as the JSON that `halflight bake --report` writes.
std::string reportJson(const BakeReport& report);

} // namespace halflight
