#include "halflight/bake/bake.h"

#include "bake/gather.h"
#include "bake/main_light.h"
#include "bake/stages.h"

#include "halflight/base/file.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/text.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sys/resource.h>

namespace halflight {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kFewestSamples = 16; ///< per texel, of the cache integrator: one block

Error cancelledError()
{
    return {ErrorCode::Cancelled, "interrupted"};
}

uint64_t peakMemory()
{
    rusage usage{};
    return getrusage(RUSAGE_SELF, &usage) == 0 ? uint64_t(usage.ru_maxrss) * 1024u : 0u;
}

/// Adds a stage to the report when it ends.
class StageTimer {
public:
    StageTimer(BakeReport& report, std::string name) : report_(report), name_(std::move(name)), start_(Clock::now()) {}
    void finish(uint64_t rays = 0)
    {
        report_.stages.push_back({name_, std::chrono::duration<double>(Clock::now() - start_).count(), rays});
    }

private:
    BakeReport& report_;
    std::string name_;
    Clock::time_point start_;
};

void reportLights(const Scene& scene, BakeReport& report)
{
    std::vector<std::string> ended;
    for (const Light& light : scene.lights) {
        report.lights.push_back({light.name, light.type, light.mode, light.baking.bakeType,
                                 light.baking.occlusionMaskChannel, light.baking.reason, light.baking.reachMeters});
        if (!light.baking.reason.empty())
            report.warnings.push_back("light \"" + light.name + "\" " + light.baking.reason);
        if (light.type != LightType::Directional && light.rangeMeters <= 0.0f && light.baking.reachMeters > 0.0f)
            ended.push_back(light.name);
    }
    if (!ended.empty()) {
        report.warnings.push_back("lights " + listOf(ended) +
                                  " have no range, and there are not enough shadowmask channels for lights that reach "
                                  "everything: their baked shadows end where they add little light (reach in the "
                                  "report); give them a range to choose it yourself");
    }
}

/// Keeps the first error.
void note(Status& first, const Status& status)
{
    if (first && !status) first = status;
}

/// Writes pages as PREFIX_N.exr into the images directory, when there is one.
template<typename Page>
Status dumpPages(const BakeSettings& settings, const std::string& prefix, const std::vector<Page>& pages)
{
    if (settings.imagesDirectory.empty()) return {};
    for (std::size_t i = 0; i < pages.size(); ++i) {
        const auto path = settings.imagesDirectory / (prefix + "_" + std::to_string(i) + ".exr");
        if (Status status = writeExr(path, pages[i]); !status) {
            return Error{status.error().code, path.string() + " " + status.error().message};
        }
    }
    return {};
}

Status dumpResult(const BakeSettings& settings, const BakedScene& baked)
{
    if (settings.imagesDirectory.empty()) return {};
    for (const auto& [prefix, pages] :
         {std::pair{"shadowmask", &baked.shadowmasks}, std::pair{"lightmap_direction", &baked.lightmapDirections}}) {
        for (std::size_t i = 0; i < pages->size(); ++i) {
            const auto path = settings.imagesDirectory / (prefix + ("_" + std::to_string(i) + ".png"));
            if (Status status = writePng(path, (*pages)[i]); !status) {
                return Error{status.error().code, path.string() + " " + status.error().message};
            }
        }
    }
    nlohmann::json probes = nlohmann::json::array();
    for (const Probe& probe : baked.probes.probes) {
        nlohmann::json coefficients = nlohmann::json::array();
        for (const vec3 c : probe.radiance) coefficients.push_back({c.x, c.y, c.z});
        const dvec3 position = baked.scene.originMeters + dvec3(probe.position);
        probes.push_back({{"position", {position.x, position.y, position.z}},
                          {"valid", probe.valid},
                          {"occlusion", {probe.occlusion.x, probe.occlusion.y, probe.occlusion.z, probe.occlusion.w}},
                          {"radiance", std::move(coefficients)}});
    }
    const auto path = settings.imagesDirectory / "probes.json";
    if (Status status = writeFileAtomically(path, nlohmann::json{{"probes", std::move(probes)}}.dump(1)); !status) {
        return Error{status.error().code, path.string() + " " + status.error().message};
    }
    return {};
}

/// How far the estimates got. `main`: light that is in the lightmap beside them.
void reportNoise(const std::vector<IrradianceEstimate>& estimates, const std::optional<MainLight>& main,
                 BakeReport& report)
{
    double variance = 0.0;
    double sum = 0.0;
    double samples = 0.0;
    uint64_t valid = 0;
    const auto most = uint32_t(report.quality.samples);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const IrradianceEstimate& e = estimates[i];
        if (!e.valid) continue;
        ++valid;
        variance += double(e.varianceOfMean);
        sum += double(luminance(e.irradiance));
        if (main) sum += double(luminance(main->at(i)));
        samples += double(e.samples);
        if (e.samples == 0) ++report.texelsBetween;
        if (report.quality.noiseTarget > 0.0f && e.samples >= most) ++report.texelsAtCap;
    }
    report.invalidTexels = estimates.size() - valid;
    if (valid == 0) return;
    const uint64_t traced = valid - report.texelsBetween;
    report.samplesPerTexel = traced > 0 ? samples / double(traced) : 0.0;
    report.noiseReached = sum > 0.0 ? float(std::sqrt(variance * double(valid)) / sum) : 0.0f;
}

/// A mask's pages: filled inside geometry, dilated, stitched.
std::vector<ImageRgba8> maskPages(const BakeGeometry& geometry, const TexelMap& map, const std::vector<uint8_t>& valid,
                                  const std::vector<SeamSample>& seams, std::vector<vec4> mask, bool distances,
                                  std::array<MaskChannel, 4>& channels)
{
    fillInvalid(geometry, map, valid, mask);
    if (distances) channels = maskToDistances(map, mask);
    std::vector<ImageRgba32f> pages = dilate(map, mask, kDilationRings, distances);
    stitchSeams(map, seams, seamWeights(seams, pages), pages, !distances);
    return encodeShadowmask(pages);
}

/// What a subtractive bake knows of its main light, for the report and for whoever reads it.
void reportMainLight(const BakedScene& baked, const MainLight& main, const BakeSettings& settings, BakeReport& report)
{
    report.mainLight = {main.name, !baked.shadowmasks.empty(), subtractiveShadowColor(baked),
                        !baked.scene.subtractiveShadowColor.has_value()};
    if (settings.maskEncoding == MaskEncoding::Distance && report.mainLight->mask) {
        report.warnings.emplace_back("a subtractive bake's mask holds attenuation, as the lightmap does: distance "
                                     "fields are for shadowmask bakes");
    }
}

/// Objects that were baked from their other side.
void reportTurned(const Scene& scene, const BakeGeometry& geometry, BakeReport& report)
{
    std::vector<std::string> names;
    int last = -1; // parts of an object follow one another
    for (const BakeGeometry::Part& part : geometry.parts) {
        const auto begin = geometry.flipped.begin() + std::ptrdiff_t(part.firstTriangle);
        const auto end = begin + std::ptrdiff_t(part.triangleCount);
        if (part.object == last || std::find(begin, end, uint8_t(1)) == end) continue;
        names.push_back(scene.objects[std::size_t(part.object)].name);
        last = part.object;
    }
    if (names.empty()) return;
    report.warnings.push_back(listOf(names) +
                              ": double-sided faces look into closed, empty hollows; baked as seen from outside");
}

} // namespace

std::string cacheWarning(const std::filesystem::path& folder, const Error& error)
{
    return "the cache " + folder.string() + " is not complete, so the next bake computes more: " + error.message;
}

TexelValues splitEstimates(const std::vector<IrradianceEstimate>& estimates)
{
    TexelValues values;
    values.irradiance.reserve(estimates.size());
    values.valid.reserve(estimates.size());
    for (const IrradianceEstimate& e : estimates) {
        values.irradiance.push_back(e.irradiance);
        values.valid.push_back(e.valid ? 1 : 0);
    }
    return values;
}

BakeQuality resolveQuality(const BakeSettings& settings)
{
    BakeQuality q{};
    switch (settings.quality) {
    case Quality::Preview:
        q = {32, 16, 3, 1024, 128, 0.0f};
        break;
    case Quality::Medium:
        q = {96, 32, 4, 2048, 256, 0.0f};
        break;
    case Quality::High:
        q = {256, 64, 6, 4096, 512, 0.0f};
        break;
    case Quality::Ultra:
        q = {1024, 128, 8, 4096, 1024, 0.0f};
        break;
    }
    q.noiseTarget = settings.noiseTarget;
    if (q.noiseTarget > 0.0f) q.samples = 4096;
    if (settings.samples > 0) q.samples = settings.samples;
    if (settings.shadowSamples > 0) q.shadowSamples = settings.shadowSamples;
    if (settings.bounces >= 0) q.bounces = settings.bounces;
    if (settings.lightmapSize > 0) q.lightmapSize = settings.lightmapSize;
    return q;
}

Result<BakeResult> bake(Scene scene, const BakeSettings& settings, const IntegratorFactory& integratorFactory,
                        const Progress& progress)
{
    const Clock::time_point start = Clock::now();
    const ThreadLimit threads(settings.threads);
    BakeResult result;
    BakeReport& report = result.report;
    report.quality = resolveQuality(settings);
    report.warnings = scene.warnings;
    if (farFromOrigin(scene)) {
        report.warnings.emplace_back(
            "the scene lies far from its origin for its size, where positions are coarse: call "
            "recenter() before baking");
    }

    StageTimer unwrapTimer(report, "unwrap");
    UnwrapSettings unwrapSettings;
    unwrapSettings.uvMode = settings.uvMode;
    unwrapSettings.texelsPerMeter = settings.texelsPerMeter;
    unwrapSettings.pageSize = report.quality.lightmapSize;
    unwrapSettings.paddingTexels = settings.paddingTexels;
    unwrapSettings.cutPage = settings.lightmapSize == 0;
    if (settings.lightmapSize == 0 && settings.texelsPerMeter == 0.0f)
        unwrapSettings.mostTexelsPerMeter = sceneDensity(scene, unwrapSettings.pageSize);
    Result<UnwrappedScene> unwrapped = unwrap(std::move(scene), unwrapSettings, progress);
    if (!unwrapped) return unwrapped.error();
    BakedScene& baked = result.baked;
    baked.scene = std::move(unwrapped->scene);
    baked.mode = settings.mode;
    baked.isBaked = true;
    report.meshes = unwrapped->meshes;
    report.pageCount = unwrapped->pageCount;
    report.pageSize = unwrapped->pageSize;
    report.chartCount = unwrapped->chartCount;
    report.texelsPerMeter = unwrapped->texelsPerMeter;
    report.densityFrom = unwrapped->densityFrom;
    report.atlasCoverage = unwrapped->coverage;
    report.warnings.insert(report.warnings.end(), unwrapped->warnings.begin(), unwrapped->warnings.end());
    unwrapTimer.finish();

    assignShadowmaskChannels(baked.scene, settings.mode);
    reportLights(baked.scene, report);

    StageTimer buildTimer(report, "build");
    BakeGeometry geometry = flattenGeometry(baked.scene, unwrapped->pageSize, GeometryFilter::Static);
    report.triangleCount = geometry.triangles.size();
    IntegrationSettings integration;
    integration.integrator = settings.integrator;
    integration.noiseTarget = settings.noiseTarget;
    integration.texelStep = settings.texelStep;
    integration.denoised = settings.denoiser != Denoiser::Off;
    integration.samples = report.quality.samples;
    integration.shadowSamples = report.quality.shadowSamples;
    integration.bounces = report.quality.bounces;
    if (integration.bounces == 0) {
        for (Light& light : baked.scene.lights) light.baking.atBake.indirectMultiplier = 0.0f; // nothing bounced
    }
    integration.probeSamples = report.quality.probeSamples;
    integration.seed = settings.seed;
    if (settings.integrator == IntegratorKind::Cache && settings.samples > 0 && settings.samples < kFewestSamples) {
        report.warnings.push_back(std::to_string(settings.samples) + " samples per texel are asked for: the cache " +
                                  "integrator takes " + std::to_string(kFewestSamples) + " at least (one block)");
    }
    Result<std::unique_ptr<Integrator>> made = turnHollows(integratorFactory, baked.scene, geometry, integration);
    if (!made) return made.error();
    if (progress.cancelled()) return cancelledError();
    Integrator& integrator = **made;
    report.integrator = integrator.description();
    reportTurned(baked.scene, geometry, report);
    buildTimer.finish();

    StageTimer rasterTimer(report, "rasterize");
    const TexelMap map = rasterizeTexels(geometry, unwrapped->pageSize, unwrapped->pageCount);
    report.coveredTexels = map.texels.size();
    rasterTimer.finish();
    if (progress.cancelled()) return cancelledError();
    std::optional<BakeCache> cache;
    if (!settings.cacheDirectory.empty()) {
        const Hash128 layout = layoutHash(map, integration, settings.mode);
        Result<BakeCache> opened =
            BakeCache::open(settings.cacheDirectory, lightHash(layout, baked.scene, geometry), layout);
        if (opened) {
            cache.emplace(std::move(*opened));
        } else {
            report.warnings.push_back(cacheWarning(settings.cacheDirectory, opened.error()));
        }
    }
    const Gather gather{integrator, geometry, map, integration, cache ? &*cache : nullptr};

    StageTimer lightmapTimer(report, "lightmap");
    std::vector<IrradianceEstimate> estimates(map.texels.size());
    if (!gather.irradiance(estimates, progress)) return cancelledError();
    integrator.releaseIrradiance();
    lightmapTimer.finish(integrator.raysTraced());
    std::optional<MainLight> main = findMainLight(baked.scene);
    if (main) {
        StageTimer mainTimer(report, "main light");
        const uint64_t before = integrator.raysTraced();
        if (!bakeMainLight(gather, estimates, *main, progress)) return cancelledError();
        mainTimer.finish(integrator.raysTraced() - before);
    }
    reportNoise(estimates, main, report);
    if (!settings.imagesDirectory.empty()) {
        std::vector<vec3> raw = splitEstimates(estimates).irradiance;
        if (main) main->addTo(raw);
        note(result.images, dumpPages(settings, "lightmap_raw", dilate(map, raw, 0)));
    }

    if (integration.denoised) {
        StageTimer denoiseTimer(report, "denoise");
        progress("denoise", 0.0);
        std::vector<vec3> gathered; // as it is
        if (settings.denoiser == Denoiser::OpenImage) {
            gathered.reserve(estimates.size());
            for (const IrradianceEstimate& e : estimates) gathered.push_back(e.irradiance - e.direct);
        }
        denoise(geometry, map, estimates, settings.directional);
        if (settings.denoiser == Denoiser::OpenImage) {
            if (Status status = imageDenoise(map, gathered, estimates, progress); !status) return status.error();
        }
        denoiseTimer.finish();
        if (progress.cancelled()) return cancelledError();
    }
    // What a large lightmap no longer needs goes as soon as can be.
    TexelValues values = splitEstimates(estimates);
    if (main) {
        baked.defaultShadowColor = chooseShadowColor(*main, values.irradiance, values.valid, settings.subtractiveMask);
        main->addTo(values.irradiance);
    }
    fillInvalid(geometry, map, values.valid, values.irradiance);
    StageTimer seamTimer(report, "seams");
    const std::vector<SeamSample> seams = findSeams(geometry, unwrapped->pageSize);
    std::vector<ImageRgb32f> pages = dilate(map, values.irradiance, kDilationRings);
    release(values.irradiance);
    const std::vector<float> seamWeight = seamWeights(seams, pages);
    stitchSeams(map, seams, seamWeight, pages);
    seamTimer.finish();
    if (progress.cancelled()) return cancelledError();
    note(result.images, dumpPages(settings, "lightmap", pages));
    baked.lightmapUnitLux = lightmapUnitFor(pages);
    baked.lightmaps = encodeLightmap(pages, baked.lightmapUnitLux);
    if (settings.directional) {
        std::vector<vec3> moments;
        moments.reserve(estimates.size());
        for (const IrradianceEstimate& e : estimates) moments.push_back(e.moment);
        if (main) main->addMomentTo(moments);
        fillInvalid(geometry, map, values.valid, moments);
        std::vector<ImageRgb32f> momentPages = dilate(map, moments, kDilationRings);
        stitchSeams(map, seams, seamWeight, momentPages);
        baked.lightmapDirections = encodeDirections(pages, momentPages);
    }
    release(pages);

    const auto hasChannel = [](const Light& light) { return light.baking.occlusionMaskChannel >= 0; };
    if (settings.mode == MixedLightingMode::Shadowmask &&
        std::any_of(baked.scene.lights.begin(), baked.scene.lights.end(), hasChannel)) {
        StageTimer maskTimer(report, "shadowmask");
        const uint64_t before = integrator.raysTraced();
        std::vector<vec4> mask(map.texels.size());
        if (!gather.shadowmask(estimates, mask, progress)) return cancelledError();
        release(estimates);
        baked.shadowmasks = maskPages(geometry, map, values.valid, seams, std::move(mask),
                                      settings.maskEncoding == MaskEncoding::Distance, baked.maskChannels);
        for (LightReport& light : report.lights) {
            light.distanceMask =
                light.channel >= 0 && baked.maskChannels[std::size_t(light.channel)].rangeTexels > 0.0f;
        }
        maskTimer.finish(integrator.raysTraced() - before);
        if (progress.cancelled()) return cancelledError();
    }
    if (main && settings.subtractiveMask)
        baked.shadowmasks = maskPages(geometry, map, values.valid, seams, main->mask(), false, baked.maskChannels);
    if (main) reportMainLight(baked, *main, settings, report);

    StageTimer probeTimer(report, "probes");
    const uint64_t before = integrator.raysTraced();
    std::optional<ProbeSet> probes =
        bakeProbes(baked.scene, settings.probeSpacingMeters, integration.denoised, gather, report.warnings, progress);
    if (!probes) return cancelledError();
    baked.probes = std::move(*probes);
    report.probeCount = int(baked.probes.probes.size());
    report.validProbeCount = int(
        std::count_if(baked.probes.probes.begin(), baked.probes.probes.end(), [](const Probe& p) { return p.valid; }));
    probeTimer.finish(integrator.raysTraced() - before);

    if (cache) {
        cache->finish();
        if (!cache->status()) report.warnings.push_back(cacheWarning(settings.cacheDirectory, cache->status().error()));
        report.cache = cache->counts();
    }
    note(result.images, dumpResult(settings, baked));
    report.peakMemoryBytes = peakMemory();
    report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return result;
}

} // namespace halflight
