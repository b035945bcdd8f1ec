#include "bake/time_limit.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

namespace halflight {
namespace {

/// Samples of the two measurements. Their difference is the cost of a sample; the rest does not depend on samples.
constexpr int kFewSamples = 16;
constexpr int kMoreSamples = 48;
constexpr int kMostSamples = 65'536;
/// Texels that are measured, in runs of neighbours that are spread evenly: a 32nd of all, and more of small maps.
constexpr std::size_t kTexelsOfRun = 256;
constexpr std::size_t kShare = 32;
constexpr std::size_t kFewTexels = 4096; // or a quarter of all
constexpr std::size_t kManyTexels = 16'384;
/// Texels within this distance of a run are computed too: the plan of samples reads them. They take all of the few
/// samples, and half of those beyond.
constexpr double kAround = 2.0;
/// Stages after the lightmap (denoising, filling, seams, encoding, writing) take about so many seconds of one core for
/// a texel: 4 to 6 in the project's scenes. Half of the cores are busy meanwhile.
constexpr double kSecondsAfterwards = 5.0e-6;
constexpr double kBusyAfterwards = 0.5;
/// Reflection probes take about so many rays, which are as fast as those of light probes: 1 to 6 million.
constexpr double kReflectionRays = 3.0e6;

/// Texels of all runs, one run after the other.
std::vector<uint32_t> someTexels(std::size_t count)
{
    const std::size_t wanted = std::clamp(count / kShare, std::min(kFewTexels, count / 4), kManyTexels);
    const std::size_t ofRun = std::min(kTexelsOfRun, count);
    const std::size_t runs = std::max<std::size_t>(wanted / ofRun, 1);
    std::vector<uint32_t> some;
    for (std::size_t run = 0; run < runs; ++run) {
        const std::size_t first = run * (count - ofRun) / runs;
        for (std::size_t i = 0; i < ofRun; ++i) some.push_back(uint32_t(first + i));
    }
    return some;
}

/// What the lightmap of all texels takes.
struct LightmapCost {
    double fixed = 0.0;  ///< seconds
    double sample = 0.0; ///< seconds for a sample of each texel

    [[nodiscard]] double of(int samples) const { return fixed + sample * double(samples); }
};

/// Seconds of some runs, which threads share as they share the parts of a map.
Result<double> secondsOf(const BakeRun& run, std::span<const uint32_t> texels, int samples, PreparedLightmap& lightmap)
{
    const std::size_t runs = (texels.size() + kTexelsOfRun - 1) / kTexelsOfRun;
    std::vector<Status> ends(runs);
    const Progress quiet{{}, run.progress.cancel};
    const double start = secondsNow(run.settings);
    parallelFor(runs, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            inIsolation([&, r] {
                const auto some = texels.subspan(r * kTexelsOfRun);
                const auto ofRun = some.first(std::min(kTexelsOfRun, some.size()));
                std::vector<IrradianceEstimate> estimates(ofRun.size());
                ends[r] = lightmap.irradiance({ofRun, samples}, estimates, quiet);
            });
        }
    });
    for (const Status& end : ends)
        if (!end) return end.error();
    return secondsNow(run.settings) - start;
}

Result<LightmapCost> measure(const BakeRun& run, std::size_t texels, PreparedLightmap& lightmap)
{
    const std::vector<uint32_t> some = someTexels(texels);
    const std::span<const uint32_t> all(some);
    const Result<double> first = secondsOf(run, all.first(1), kFewSamples, lightmap); // makes what all have in common
    if (!first) return first.error();
    const Result<double> few = secondsOf(run, all, kFewSamples, lightmap);
    if (!few) return few.error();
    const Result<double> more = secondsOf(run, all, kMoreSamples, lightmap);
    if (!more) return more.error();
    const double times = double(texels) / double(some.size());
    const double width = std::sqrt(double(std::min(kTexelsOfRun, some.size()))); // of a run
    const double around = std::pow(1.0 + 2.0 * kAround / width, 2.0) - 1.0;
    const double sampled = 1.0 + 0.5 * around;
    LightmapCost cost;
    cost.sample = times * std::max(*more - *few, 0.0) / (double(kMoreSamples - kFewSamples) * sampled);
    cost.fixed = std::max(times * *few / (1.0 + around) - cost.sample * double(kFewSamples), 0.0);
    return cost;
}

double secondsAfterwards(const BakeRun& run, std::size_t texels)
{
    const double busy = std::max(kBusyAfterwards * double(threadCount()), 1.0);
    double seconds = double(texels) * kSecondsAfterwards / busy;
    const auto& stages = run.report().stages;
    const auto probes = std::ranges::find(stages, "probes", &StageReport::name);
    if (run.settings.reflectionProbes && probes != stages.end() && probes->rays > 0)
        seconds += kReflectionRays * probes->seconds / double(probes->rays);
    return seconds;
}

} // namespace

double secondsNow(const BakeSettings& settings)
{
    if (settings.clock) return settings.clock();
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Status chooseSamples(const BakeRun& run, double began, const CachedIntegrator& cached, PreparedLightmap& lightmap)
{
    const std::size_t texels = cached.map.texels.size();
    if (texels == 0) return {};
    BakeReport& report = run.report();
    BakeSettings preview;
    preview.quality = Quality::Preview;
    const int least = resolveQuality(preview).samples;
    double needed = 0.0; // seconds of a bake with the least samples
    run.progress("measure", 0.0);
    StageTimer timer(report, "measure");
    const uint64_t before = cached.integrator.raysTraced();
    // Many samples may need a better radiance cache. That takes time too, and is measured with the second round.
    for (int round = 0; round < 2; ++round) {
        const Result<LightmapCost> cost = measure(run, texels, lightmap);
        if (!cost) return cost.error();
        const double others = secondsNow(run.settings) - began + secondsAfterwards(run, texels);
        const double left = run.settings.seconds - others - cost->fixed;
        const double samples = cost->sample > 0.0 ? left / cost->sample : double(kMostSamples);
        report.quality.samples = int(std::clamp(std::floor(samples), double(least), double(kMostSamples)));
        needed = others + cost->of(least);
        if (lightmap.setSamples(report.quality.samples)) break;
    }
    timer.finish(cached.integrator.raysTraced() - before);
    if (needed <= run.settings.seconds) return {};
    report.warnings.push_back(std::to_string(std::lround(run.settings.seconds)) +
                              " s are too few for this bake, which takes about " + std::to_string(std::lround(needed)) +
                              " s with the " + std::to_string(least) +
                              " samples per texel of a preview; it has these: a smaller --lightmap-size or "
                              "--texels-per-meter takes less time");
    return {};
}

} // namespace halflight
