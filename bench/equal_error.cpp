// Part "error" of bench_bake: seconds to equal error.

#include "equal_error.h"

#include "bake/denoise/denoise.h"
#include "transport/lightmap/lightmap_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace halflight::bench {
namespace {

/// Of several seeds together: the root mean square of their errors, their mean time and number of rays.
class MeanError {
public:
    void add(double cpu, double rays, LightError error)
    {
        cpu_ += cpu;
        rays_ += rays;
        squares_ += error.rmse * error.rmse;
        bias_ += error.bias;
        ++count_;
    }
    [[nodiscard]] double cpu() const { return cpu_ / count_; }
    [[nodiscard]] double rays() const { return rays_ / count_; }
    [[nodiscard]] LightError error() const { return {std::sqrt(squares_ / count_), bias_ / count_}; }

private:
    double cpu_ = 0.0;
    double rays_ = 0.0;
    double squares_ = 0.0;
    double bias_ = 0.0;
    double count_ = 0.0;
};

/// CPU seconds after which an error reaches a target, of points measured with ever more samples.
class TimeToTarget {
public:
    explicit TimeToTarget(double target) : target_(target) {}

    void add(double cpu, double error)
    {
        if (found_ > 0.0) return;
        if (error <= target_) {
            // Between the last two points, straight in logarithms.
            const double t = lastTime_ > 0.0 ? std::log(target_ / lastError_) / std::log(error / lastError_) : 1.0;
            found_ = lastTime_ > 0.0 ? lastTime_ * std::pow(cpu / lastTime_, t) : cpu;
        }
        lastTime_ = cpu;
        lastError_ = error;
    }
    [[nodiscard]] bool reached() const { return found_ > 0.0; }
    /// As if the error fell with the root of the time from the last point on, where it is not reached.
    [[nodiscard]] double time() const
    {
        return reached() ? found_ : lastTime_ * (lastError_ / target_) * (lastError_ / target_);
    }
    void print(const std::string& label, double pathTime) const
    {
        if (!reached()) return;
        std::printf("  CPU s to %.1f %%: path %.1f, %s %.2f, ratio %.1f\n", 100.0 * target_, pathTime, label.c_str(),
                    found_, pathTime / found_);
    }

private:
    double target_;
    double found_ = 0.0;
    double lastTime_ = 0.0;
    double lastError_ = 0.0;
};

} // namespace

void partError(const Options& options)
{
    constexpr int kPathSamples = 64;
    // As medium quality has them, and more where so many samples are taken that shadows would be rougher than the rest.
    const auto shadowSamplesFor = [](int samples) { return std::max(32, samples / 2); };
    std::printf("relative RMSE: of luminance over all valid texels, divided by their mean\n");
    std::printf("time to %.1f %%: from the measured points, error falling with the root of the samples\n\n",
                100.0 * options.target);
    for (const std::string& name : options.scenes) {
        Prepared p = prepare(name, options.size, true);
        std::vector<uint32_t> chosen;
        const TexelMap subset = subsetOf(p.map, options.points, chosen);
        const std::vector<IrradianceEstimate> reference = referenceOf(options, name, p, subset);
        IntegrationSettings settings = options.integration();
        const double scale = double(p.map.texels.size()) / double(subset.texels.size());
        const auto tracePaths = [&](int samples, int seed, MeanError& mean) {
            IntegrationSettings paths = settings;
            paths.integrator = IntegratorKind::Path;
            paths.seed = uint32_t(seed);
            paths.samples = samples;
            paths.shadowSamples = shadowSamplesFor(samples);
            const Run run = integrate(p, subset, paths);
            mean.add(run.cpu * scale, double(run.rays) * scale, compare(run.estimates, nullptr, reference));
        };
        const auto tracedPaths = [&](int samples) {
            MeanError mean;
            for (int seed = 1; seed <= options.seeds; ++seed) tracePaths(samples, seed, mean);
            return mean;
        };
        MeanError pathMean = tracedPaths(kPathSamples);
        // The reference has noise of its own.
        const double noise = pathMean.error().rmse * std::sqrt(kPathSamples / double(options.reference + kPathSamples));
        const auto errorOf = [&](const MeanError& mean) {
            LightError e = mean.error();
            e.rmse = std::sqrt(std::max(e.rmse * e.rmse - noise * noise, 1.0e-12));
            return e;
        };
        const LightError pathError = errorOf(pathMean);
        // In times of what few samples take, which is measured again and again.
        TimeToTarget pathTarget(options.target);
        pathTarget.add(pathMean.cpu(), pathError.rmse);
        for (int samples = 2 * kPathSamples; !pathTarget.reached() && samples <= options.reference / 4; samples *= 2) {
            const MeanError mean = tracedPaths(samples);
            pathTarget.add(mean.cpu(), errorOf(mean).rmse);
        }
        const double pathTimes = pathTarget.time() / pathMean.cpu();
        const auto pathTime = [&] { return pathMean.cpu() * pathTimes; };
        std::printf("%s: %zu texels, %zu triangles, reference %d paths on %zu texels\n", name.c_str(),
                    p.map.texels.size(), trianglesOf(p), options.reference, subset.texels.size());
        std::printf("  %-8s %8s %10s %10s %9s %9s %10s %9s %9s\n", "", "samples", "CPU s", "Mrays", "RMSE", "bias",
                    "denoised s", "RMSE", "bias");
        std::printf("  %-8s %8d %10.2f %10.1f %8.2f%% %8.2f%%   (scaled from %zu texels)\n", "path", kPathSamples,
                    pathMean.cpu(), pathMean.rays() * 1.0e-6, 100.0 * pathError.rmse, 100.0 * pathError.bias,
                    subset.texels.size());
        settings.integrator = IntegratorKind::Cache;
        // With the step between traced texels that is the default for the map, and with the other one.
        for (const int step : {0, texelStepOf(IntegrationSettings(), p.map) == 1 ? 2 : 1}) {
            if (step > 0 && options.samples > 0) break;
            settings.cache.texelStep = step;
            const std::string label = step == 0 ? "cache" : "step " + std::to_string(step);
            TimeToTarget raw(options.target);
            TimeToTarget denoised(options.target);
            const int first = options.samples > 0 ? options.samples : 2;
            const int last = options.samples > 0 ? options.samples : 512;
            for (int samples = first; samples <= last && !(raw.reached() && denoised.reached());
                 samples += (samples & (samples - 1)) == 0 ? samples / 2 : samples / 3) {
                settings.samples = samples;
                settings.shadowSamples = shadowSamplesFor(samples);
                MeanError rawMean;
                MeanError denoisedMean;
                for (int seed = 1; seed <= options.seeds; ++seed) {
                    settings.seed = uint32_t(seed);
                    Run run = integrate(p, p.map, settings);
                    rawMean.add(run.cpu, double(run.rays), compare(run.estimates, &chosen, reference));
                    const double start = cpuSeconds();
                    denoise(p.geometry, p.map, {}, run.estimates, false);
                    const double cpu = run.cpu + cpuSeconds() - start;
                    denoisedMean.add(cpu, double(run.rays), compare(run.estimates, &chosen, reference));
                    // Beside it, for the speed of the machine now.
                    tracePaths(kPathSamples, seed, pathMean);
                }
                const LightError before = errorOf(rawMean);
                const LightError after = errorOf(denoisedMean);
                std::printf("  %-8s %8d %10.2f %10.1f %8.2f%% %8.2f%% %10.2f %8.2f%% %8.2f%%\n", label.c_str(), samples,
                            rawMean.cpu(), rawMean.rays() * 1.0e-6, 100.0 * before.rmse, 100.0 * before.bias,
                            denoisedMean.cpu(), 100.0 * after.rmse, 100.0 * after.bias);
                std::fflush(stdout);
                raw.add(rawMean.cpu(), before.rmse);
                denoised.add(denoisedMean.cpu(), after.rmse);
            }
            raw.print(label, pathTime());
            denoised.print(label + " denoised", pathTime());
        }
        std::printf("\n");
    }
}

} // namespace halflight::bench
