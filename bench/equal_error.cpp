// Part "error" of bench_bake: seconds to equal error.

#include "equal_error.h"

#include "bake/denoise/denoise.h"
#include "transport/lightmap/lightmap_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
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

constexpr int kPathSamples = 64;

/// As medium quality has them, and more where so many samples are taken that shadows would be rougher than the rest.
int shadowSamplesFor(int samples)
{
    return std::max(32, samples / 2);
}

/// One scene: its reference, the path tracer's time to the target and that of the cache.
class EqualError {
public:
    EqualError(const Options& options, std::string name)
        : options_(options), name_(std::move(name)), prepared_(prepare(name_, options.size, true)),
          subset_(subsetOf(prepared_.map, options.points, chosen_)),
          reference_(referenceOf(options, name_, prepared_, subset_))
    {}

    void measurePaths()
    {
        pathMean_ = tracedPaths(kPathSamples);
        referenceNoise_ = pathMean_.error().rmse * std::sqrt(kPathSamples / double(options_.reference + kPathSamples));
        const LightError error = errorOf(pathMean_);
        TimeToTarget target(options_.target);
        target.add(pathMean_.cpu(), error.rmse);
        for (int samples = 2 * kPathSamples; !target.reached() && samples <= options_.reference / 4; samples *= 2) {
            const MeanError mean = tracedPaths(samples);
            target.add(mean.cpu(), errorOf(mean).rmse);
        }
        pathTimes_ = target.time() / pathMean_.cpu();
        const std::size_t texels = prepared_.map.texels.size();
        std::printf("%s: %zu texels, %zu triangles, reference %d paths on %zu texels\n", name_.c_str(), texels,
                    trianglesOf(prepared_), options_.reference, subset_.texels.size());
        std::printf("  %-8s %8s %10s %10s %9s %9s %10s %9s %9s\n", "", "samples", "CPU s", "Mrays", "RMSE", "bias",
                    "denoised s", "RMSE", "bias");
        std::printf("  %-8s %8d %10.2f %10.1f %8.2f%% %8.2f%%   (scaled from %zu texels)\n", "path", kPathSamples,
                    pathMean_.cpu(), pathMean_.rays() * 1.0e-6, 100.0 * error.rmse, 100.0 * error.bias,
                    subset_.texels.size());
    }

    void measureCache()
    {
        TimeToTarget raw(options_.target);
        TimeToTarget denoised(options_.target);
        const int first = options_.samples > 0 ? options_.samples : 2;
        const int last = options_.samples > 0 ? options_.samples : 512;
        for (int samples = first; samples <= last && !(raw.reached() && denoised.reached());
             samples += (samples & (samples - 1)) == 0 ? samples / 2 : samples / 3) {
            MeanError rawMean;
            MeanError denoisedMean;
            bakeWithCache(samples, rawMean, denoisedMean);
            const LightError before = errorOf(rawMean);
            const LightError after = errorOf(denoisedMean);
            std::printf("  %-8s %8d %10.2f %10.1f %8.2f%% %8.2f%% %10.2f %8.2f%% %8.2f%%\n", "cache", samples,
                        rawMean.cpu(), rawMean.rays() * 1.0e-6, 100.0 * before.rmse, 100.0 * before.bias,
                        denoisedMean.cpu(), 100.0 * after.rmse, 100.0 * after.bias);
            std::fflush(stdout);
            raw.add(rawMean.cpu(), before.rmse);
            denoised.add(denoisedMean.cpu(), after.rmse);
        }
        raw.print("cache", pathMean_.cpu() * pathTimes_);
        denoised.print("cache denoised", pathMean_.cpu() * pathTimes_);
    }

private:
    void tracePaths(int samples, int seed, MeanError& mean) const
    {
        IntegrationSettings paths = options_.integration();
        paths.integrator = IntegratorKind::Path;
        paths.seed = uint32_t(seed);
        paths.samples = samples;
        paths.shadowSamples = shadowSamplesFor(samples);
        const Run run = integrate(prepared_, subset_, paths);
        const double scale = double(prepared_.map.texels.size()) / double(subset_.texels.size());
        mean.add(run.cpu * scale, double(run.rays) * scale, compare(run.estimates, nullptr, reference_));
    }

    [[nodiscard]] MeanError tracedPaths(int samples) const
    {
        MeanError mean;
        for (int seed = 1; seed <= options_.seeds; ++seed) tracePaths(samples, seed, mean);
        return mean;
    }

    /// Without the noise of the reference.
    [[nodiscard]] LightError errorOf(const MeanError& mean) const
    {
        LightError e = mean.error();
        e.rmse = std::sqrt(std::max(e.rmse * e.rmse - referenceNoise_ * referenceNoise_, 1.0e-12));
        return e;
    }

    /// Each seed once. Paths are traced beside it, for the speed of the machine now.
    void bakeWithCache(int samples, MeanError& raw, MeanError& denoised)
    {
        IntegrationSettings settings = options_.integration();
        settings.integrator = IntegratorKind::Cache;
        settings.samples = samples;
        settings.shadowSamples = shadowSamplesFor(samples);
        for (int seed = 1; seed <= options_.seeds; ++seed) {
            settings.seed = uint32_t(seed);
            Run run = integrate(prepared_, prepared_.map, settings);
            raw.add(run.cpu, double(run.rays), compare(run.estimates, &chosen_, reference_));
            const double start = cpuSeconds();
            denoise(prepared_.geometry, prepared_.map, {}, run.estimates, false);
            const double cpu = run.cpu + cpuSeconds() - start;
            denoised.add(cpu, double(run.rays), compare(run.estimates, &chosen_, reference_));
            tracePaths(kPathSamples, seed, pathMean_);
        }
    }

    const Options& options_;
    std::string name_;
    Prepared prepared_;
    std::vector<uint32_t> chosen_; ///< texels of the map that the subset has
    TexelMap subset_;
    std::vector<IrradianceEstimate> reference_;
    MeanError pathMean_;          ///< of kPathSamples
    double referenceNoise_ = 0.0; ///< relative RMSE
    double pathTimes_ = 0.0;      ///< time to the target in times of pathMean_'s, which is measured again and again
};

} // namespace

void partError(const Options& options)
{
    std::printf("relative RMSE: of luminance over all valid texels, divided by their mean\n");
    std::printf("time to %.1f %%: from the measured points, error falling with the root of the samples\n\n",
                100.0 * options.target);
    for (const std::string& name : options.scenes) {
        EqualError scene(options, name);
        scene.measurePaths();
        scene.measureCache();
        std::printf("\n");
    }
}

} // namespace halflight::bench
