#pragma once
// What the parts of bench_bake have in common: options, CPU time, bakes, and their error against a reference.

#include "bench_scenes.h"

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <string>
#include <vector>

namespace halflight::bench {

struct Options {
    std::string part;
    std::vector<std::string> scenes;
    int size = 512;
    int points = 8192;    ///< texels with a reference
    int reference = 4096; ///< paths for each of them
    int samples = 0;      ///< the only number that errors are measured of; 0: those that the target takes
    int seeds = 3;        ///< of which times and errors are the mean: single texels weigh much in one alone
    std::string folder;   ///< where references are kept, so that versions of the bake compare with the same
    int bounces = 4;
    bool diffuse = false; ///< light goes from surface to surface without specular lobes
    double target = 0.03;
    std::string settings; ///< settings file of the scenes, for light groups

    [[nodiscard]] IntegrationSettings integration() const { return {.bounces = bounces, .glossyBounces = !diffuse}; }
};

/// CPU seconds of the process, and seconds of the clock.
double cpuSeconds();
double wallSeconds();

/// Every n-th run of 64 texels: neighbours stay together, so that their rays are what a whole map's would be.
TexelMap subsetOf(const TexelMap& map, int texels, std::vector<uint32_t>& chosen);

struct Run {
    std::vector<IrradianceEstimate> estimates;
    std::vector<IrradianceEstimate> components; ///< by texel and component, where the settings have some
    double cpu = 0.0;
    uint64_t rays = 0;
};
Run integrate(const Prepared& p, const TexelMap& map, const IntegrationSettings& settings);

struct LightError {
    double rmse = 0.0; ///< of luminance, over the mean of the reference
    double bias = 0.0;
};
/// `pick` maps the reference's texels to the run's. Left out are texels that either calls invalid, and those more than
/// twenty times as bright as the mean: a few inside of lamps would outweigh all others.
LightError compare(const std::vector<IrradianceEstimate>& run, const std::vector<uint32_t>* pick,
                   const std::vector<IrradianceEstimate>& reference);

/// Path tracing of many samples, or what a folder has kept of it.
std::vector<IrradianceEstimate> referenceOf(const Options& options, const std::string& name, const Prepared& p,
                                            const TexelMap& subset);

} // namespace halflight::bench
