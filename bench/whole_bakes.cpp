#include "whole_bakes.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace halflight::bench {
namespace {

uint64_t peakBytes()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return uint64_t(usage.ru_maxrss) * 1024u;
}

struct BakeCost {
    double texels = 0.0;
    double cpu = 0.0;
    uint64_t peak = 0;
};

/// The whole bake in a process of its own, so that the peak of memory is its own too.
BakeCost costOfBake(const std::function<Scene()>& make, int size)
{
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) std::exit(1);
    const pid_t child = fork();
    if (child == 0) {
        Scene scene = make();
        BakeSettings settings;
        settings.lightmapSize = size;
        settings.samples = 32;
        settings.shadowSamples = 16;
        settings.uvMode = UvMode::Unwrap;
        const double start = cpuSeconds();
        const auto result = halflight::bake(std::move(scene), settings, embreeIntegrators());
        BakeCost cost;
        if (result) cost = {double(result->report.coveredTexels), cpuSeconds() - start, peakBytes()};
        const bool written = write(ends[1], &cost, sizeof(cost)) == ssize_t(sizeof(cost));
        _exit(written && result ? 0 : 1);
    }
    close(ends[1]);
    BakeCost cost;
    const bool read = child > 0 && ::read(ends[0], &cost, sizeof(cost)) == ssize_t(sizeof(cost));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (!read || status != 0) std::exit(1);
    return cost;
}

} // namespace

void partScaling(const Options& options)
{
    std::printf("%-34s %8s %10s %10s %12s %10s %14s\n", "scene", "size", "texels", "CPU s", "us/texel", "peak MB",
                "bytes/texel");
    constexpr int kSmallest = 256;
    for (const std::string& name : options.scenes) {
        BakeCost own;
        for (int size = kSmallest; size <= options.size; size *= 2) {
            const BakeCost c = costOfBake([&] { return load(name, false); }, size);
            if (size == kSmallest) own = c;
            std::printf("%-34s %8d %10.0f %10.2f %12.2f %10.1f", name.c_str(), size, c.texels, c.cpu,
                        1.0e6 * c.cpu / c.texels, double(c.peak) * 1.0e-6);
            if (size > kSmallest) {
                std::printf(" %14.1f", (double(c.peak) - double(own.peak)) / (c.texels - own.texels));
            }
            std::printf("\n");
            std::fflush(stdout);
        }
    }
}

void partLamps(const Options& options)
{
    std::printf("%8s %8s %10s %10s %10s\n", "lamps", "mode", "texels", "CPU s", "us/texel");
    for (const LightMode mode : {LightMode::Baked, LightMode::Mixed}) {
        for (const int side : {10, 32, 55, 100}) {
            const BakeCost c = costOfBake([&] { return fieldOfLamps(side, mode); }, options.size);
            std::printf("%8d %8s %10.0f %10.2f %10.2f\n", side * side, mode == LightMode::Baked ? "baked" : "mixed",
                        c.texels, c.cpu, 1.0e6 * c.cpu / c.texels);
            std::fflush(stdout);
        }
    }
}

} // namespace halflight::bench
