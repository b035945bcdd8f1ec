// What each refinement of the bake gains: time and error with all of them, and without one at a time, in one run.

#include "measure.h"

#include "bake/refinements.h"
#include "bake/stages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

namespace halflight::bench {

#ifndef HALFLIGHT_ABLATION

int partAblate(const Options& /*options*/)
{
    std::fprintf(stderr, "bench_bake ablate: this build has no switches; configure one with -DHALFLIGHT_ABLATION=ON "
                         "(cmake --preset ablation)\n");
    return 2;
}

#else

namespace {

struct Named {
    std::string_view name;
    bool Refinements::*on;
};
constexpr std::array kRefinements = {
    Named{"lightTreeCut", &Refinements::lightTreeCut},
    Named{"lightTreeQuads", &Refinements::lightTreeQuads},
    Named{"stratumShuffle", &Refinements::stratumShuffle},
    Named{"emitterRoulette", &Refinements::emitterRoulette},
    Named{"directionTables", &Refinements::directionTables},
    Named{"prefetch", &Refinements::prefetch},
    Named{"sourceShares", &Refinements::sourceShares},
    Named{"planDetail", &Refinements::planDetail},
    Named{"planRims", &Refinements::planRims},
    Named{"planTrimmed", &Refinements::planTrimmed},
    Named{"planMapMean", &Refinements::planMapMean},
    Named{"guides", &Refinements::guides},
    Named{"sharedGuides", &Refinements::sharedGuides},
    Named{"widerGuides", &Refinements::widerGuides},
    Named{"unseenSources", &Refinements::unseenSources},
    Named{"thinnedGather", &Refinements::thinnedGather},
    Named{"splitNear", &Refinements::splitNear},
    Named{"splitOccluded", &Refinements::splitOccluded},
    Named{"halfTexels", &Refinements::halfTexels},
    Named{"firstBatches", &Refinements::firstBatches},
    Named{"foldBatches", &Refinements::foldBatches},
    Named{"besideEdges", &Refinements::besideEdges},
    Named{"validityScouts", &Refinements::validityScouts},
    Named{"validityEarlyOut", &Refinements::validityEarlyOut},
    Named{"varianceScales", &Refinements::varianceScales},
    Named{"outliers", &Refinements::outliers},
    Named{"darkSpecks", &Refinements::darkSpecks},
    Named{"varianceQuantiles", &Refinements::varianceQuantiles},
    Named{"fittedTrend", &Refinements::fittedTrend},
    Named{"slopes", &Refinements::slopes},
    Named{"pairedTaps", &Refinements::pairedTaps},
    Named{"filteredDirect", &Refinements::filteredDirect},
    Named{"sparseOutliers", &Refinements::sparseOutliers},
};

/// CPU seconds and mean square error of one bake, before and after denoising.
struct Cost {
    double gather = 0.0;
    double denoise = 0.0;
    double rays = 0.0;
    double raw = 0.0;
    double denoised = 0.0;
};

/// Mean and its standard error, over the seeds.
class Mean {
public:
    void add(double x)
    {
        sum_ += x;
        squares_ += x * x;
        ++count_;
    }
    [[nodiscard]] double mean() const { return sum_ / count_; }
    [[nodiscard]] double error() const
    {
        return count_ > 1.0 ? std::sqrt(std::max(0.0, squares_ / count_ - mean() * mean()) / (count_ - 1.0)) : 0.0;
    }

private:
    double sum_ = 0.0;
    double squares_ = 0.0;
    double count_ = 0.0;
};

/// Median; it ignores bakes that other programs slowed down.
double medianOf(std::vector<double> values)
{
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Logarithms of ratios, without the refinement over with it.
struct Gain {
    std::vector<double> gather; ///< CPU time
    std::vector<double> all;    ///< CPU time, denoising included
    Mean rays;
    Mean raw; ///< mean square errors
    Mean denoised;
};

class Ablation {
public:
    Ablation(const Options& options, const std::string& name)
        : p_(prepare(name, options.size, true)), subset_(subsetOf(p_.map, options.points, chosen_)),
          reference_(referenceOf(options, name, p_, subset_))
    {
        settings_ = options.integration();
        settings_.samples = options.samples > 0 ? options.samples : 16;
        settings_.shadowSamples = std::max(32, settings_.samples / 2);
        double variance = 0.0;
        double mean = 0.0;
        for (const IrradianceEstimate& e : reference_) {
            variance += double(e.varianceOfMean);
            mean += double(luminance(e.irradiance));
        }
        noise_ = variance * double(reference_.size()) / (mean * mean);
    }

    Cost bake(const Refinements& with, int seed)
    {
        refinements = with;
        settings_.seed = uint32_t(seed);
        Run run = integrate(p_, p_.map, settings_);
        Cost cost{run.cpu};
        cost.rays = double(run.rays);
        cost.raw = squared(run);
        const double start = cpuSeconds();
        denoise(p_.geometry, p_.map, {}, run.estimates, false);
        cost.denoise = cpuSeconds() - start;
        cost.denoised = squared(run);
        refinements = {};
        return cost;
    }

private:
    /// Without the noise of the reference.
    [[nodiscard]] double squared(const Run& run) const
    {
        const double rmse = compare(run.estimates, &chosen_, reference_).rmse;
        return std::max(rmse * rmse - noise_, 1.0e-12);
    }

    Prepared p_;
    std::vector<uint32_t> chosen_;
    TexelMap subset_;
    std::vector<IrradianceEstimate> reference_;
    double noise_ = 0.0; ///< of the reference: its mean square error over the square of the mean
    IntegrationSettings settings_;
};

double percent(double logarithm)
{
    return 100.0 * (std::exp(logarithm) - 1.0);
}

} // namespace

int partAblate(const Options& options)
{
    std::vector<Named> chosen;
    for (const Named& n : kRefinements) {
        const auto& names = options.without;
        if (names.empty() || std::find(names.begin(), names.end(), n.name) != names.end()) chosen.push_back(n);
    }
    for (const std::string& name : options.without) {
        if (std::any_of(chosen.begin(), chosen.end(), [&](const Named& n) { return n.name == name; })) continue;
        std::fprintf(stderr, "bench_bake ablate: there is no refinement \"%s\"; these exist:", name.c_str());
        for (const Named& n : kRefinements) std::fprintf(stderr, " %s", n.name.data());
        std::fprintf(stderr, "\n");
        return 1;
    }
    std::printf(
        "Without a refinement, how much more is: CPU time (median of %d seeds), rays, squared error before and "
        "after denoising\n(with standard errors over the seeds), and the time to the same error before and after "
        "denoising (the product)\n\n",
        options.seeds);
    constexpr std::size_t kRunsPerBase = 4; // bakes between two with all refinements, for the speed of the machine now
    for (const std::string& name : options.scenes) {
        Ablation ablation(options, name);
        std::vector<Gain> gains(chosen.size());
        Mean seconds;
        Mean raw;
        Mean denoised;
        for (int seed = 1; seed <= options.seeds; ++seed) {
            for (std::size_t first = 0; first < chosen.size(); first += kRunsPerBase) {
                const Cost all = ablation.bake({}, seed);
                const std::size_t end = std::min(first + kRunsPerBase, chosen.size());
                std::vector<Cost> costs;
                for (std::size_t i = first; i < end; ++i) {
                    Refinements with;
                    with.*chosen[i].on = false;
                    costs.push_back(ablation.bake(with, seed));
                }
                const Cost again = ablation.bake({}, seed);
                const double gather = 0.5 * (all.gather + again.gather);
                const double denoise = 0.5 * (all.denoise + again.denoise);
                seconds.add(gather + denoise);
                raw.add(all.raw);
                denoised.add(all.denoised);
                for (std::size_t i = first; i < end; ++i) {
                    const Cost& c = costs[i - first];
                    Gain& g = gains[i];
                    g.gather.push_back(std::log(c.gather / gather));
                    g.all.push_back(std::log((c.gather + c.denoise) / (gather + denoise)));
                    g.rays.add(std::log(c.rays / all.rays));
                    g.raw.add(std::log(c.raw / all.raw));
                    g.denoised.add(std::log(c.denoised / all.denoised));
                }
            }
        }
        std::printf("%s at %d: %.2f CPU s, RMSE %.2f %%, denoised %.2f %%\n", name.c_str(), options.size,
                    seconds.mean(), 100.0 * std::sqrt(raw.mean()), 100.0 * std::sqrt(denoised.mean()));
        std::printf("  %-20s %9s %9s %9s %6s %9s %6s %10s %10s\n", "without", "CPU", "rays", "raw", "+-", "denoised",
                    "+-", "wait raw", "denoised");
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            const Gain& g = gains[i];
            const double gather = medianOf(g.gather);
            std::printf("  %-20s %+8.1f%% %+8.1f%% %+8.1f%% %5.1f%% %+8.1f%% %5.1f%% %+9.1f%% %+9.1f%%\n",
                        chosen[i].name.data(), percent(gather), percent(g.rays.mean()), percent(g.raw.mean()),
                        100.0 * g.raw.error(), percent(g.denoised.mean()), 100.0 * g.denoised.error(),
                        percent(gather + g.raw.mean()), percent(medianOf(g.all) + g.denoised.mean()));
        }
        std::printf("\n");
        std::fflush(stdout);
    }
    return 0;
}

#endif

} // namespace halflight::bench
