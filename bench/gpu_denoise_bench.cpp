// Measures the denoiser on a GPU and on the processor, in one run.
//   bench_gpu_denoise [--scene FILE]... [--size N] [--components N] [--device NAME]
// Estimates are made up: even light with the noise of 64 samples, few fireflies, and light of a baked lamp on one side
// of the scene. Each of N components has all of it. "grid" is what both begin with, "first" the device's first run,
// which compiles its shaders, "off" the texels whose gathered light differs by more than 1e-4 of the mean.

#include "bench_scenes.h"
#include "measure.h"

#include "bake/denoise/component_signals.h"
#include "bake/seams/seams.h"
#include "bake/texels/texel_places.h"
#include "bake_gpu/denoise.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

using namespace halflight;
using namespace halflight::bench;

namespace {

constexpr int kRuns = 3;

std::vector<IrradianceEstimate> estimatesOf(const Prepared& p)
{
    constexpr float kNoise = 0.1f;
    std::vector<IrradianceEstimate> estimates(p.map.texels.size());
    forEachIndex(estimates.size(), [&](std::size_t i) {
        const auto number = [&](uint32_t k) { return unitFloat(hashCombine(uint32_t(i), k)); };
        const auto noise = [&](uint32_t k) {
            return kNoise * (number(k) + number(k + 1) + number(k + 2) - 1.5f) * 2.0f;
        };
        const vec3 at = placeOf(p.geometry, p.map, p.map.texels[i]).position;
        const float light = 2.0f + 0.5f * std::sin(1.5f * at.x) + 0.3f * std::cos(2.0f * at.z + at.y);
        const bool lamp = at.x > 0.0f;
        IrradianceEstimate& e = estimates[i];
        e.direct = vec3(lamp ? 1.0f : 0.0f);
        e.varianceOfDirect = lamp ? 0.001f : 0.0f;
        e.irradiance = vec3(light + noise(1), light + noise(4), light) * (number(7) < 0.002f ? 8.0f : 1.0f) + e.direct;
        e.moment = vec3(noise(8), 0.5f * light, noise(11));
        e.varianceOfMean = kNoise * kNoise + e.varianceOfDirect;
        e.samples = 64;
        e.valid = p.map.texels[i].validPoints != 0;
    });
    return estimates;
}

/// The light of an estimate as `count` components; each has the direct light and directions that are asked for.
std::vector<Signals> componentsOf(const std::vector<IrradianceEstimate>& estimates, int count, bool directions)
{
    const std::vector<ComponentSignals::Content> contents(std::size_t(count), {true, directions});
    ComponentSignals components(estimates.size(), contents);
    forEachIndex(estimates.size(), [&](std::size_t i) {
        for (std::size_t c = 0; c < components.count(); ++c) components.set(i, c, estimates[i]);
    });
    return {components.components().begin(), components.components().end()};
}

/// One row: so many components, with first moments or without.
void measure(BakeDevice& device, const DenoiserTexels& texels, const std::vector<IrradianceEstimate>& estimates,
             int count, bool directions)
{
    const std::vector<Signals> stated = componentsOf(estimates, count, directions);
    std::vector<Signals> cpu;
    std::vector<Signals> gpu;
    double processor = 1.0e9;
    double first = 0.0;
    double best = 1.0e9;
    DenoiseSeconds parts; ///< of the best run
    for (int i = 0; i < kRuns; ++i) {
        cpu = stated;
        const double begin = wallSeconds();
        denoiseComponents(texels, cpu);
        processor = std::min(processor, wallSeconds() - begin);
    }
    for (int i = 0; i <= kRuns; ++i) {
        gpu = stated;
        const double begin = wallSeconds();
        DenoiseSeconds own;
        const Status status = denoiseOnDevice(device, texels, gpu, &own);
        const double seconds = wallSeconds() - begin;
        if (!status) {
            std::fprintf(stderr, "%s\n", status.error().message.c_str());
            return;
        }
        if (i == 0) first = seconds;
        if (seconds >= best) continue;
        best = seconds;
        parts = own;
    }
    std::size_t off = 0;
    for (std::size_t c = 0; c < cpu.size(); ++c)
        for (std::size_t i = 0; i < estimates.size(); ++i)
            off += estimates[i].valid &&
                   glm::distance(cpu[c].gathered[i].irradiance, gpu[c].gathered[i].irradiance) > 2.0e-4f;
    std::printf("%-12s %10d %10.3f %8.3f %8.3f %8.3f %8.3f %8.3f %8.3f %8zu\n", directions ? "directional" : "plain",
                count, processor, first, best, parts.memory, parts.upload, parts.filter, parts.download, off);
}

void measureScene(BakeDevice& device, const std::string& name, int size, int components)
{
    const Prepared p = prepare(name, size, false);
    const std::vector<SeamSample> seams = findSeams(p.geometry, p.map.pageSize);
    const std::vector<IrradianceEstimate> estimates = estimatesOf(p);
    std::vector<uint8_t> valid;
    std::vector<uint8_t> samples;
    for (const IrradianceEstimate& e : estimates) {
        valid.push_back(e.valid ? 1 : 0);
        samples.push_back(DenoiserTexels::samplesOf(e));
    }
    const double begin = wallSeconds();
    const SurfaceGrid grid(p.map, seams);
    const double gridSeconds = wallSeconds() - begin;
    std::printf("%s: %zu texels on %d pages of %d, %zu seam samples, grid %.3f s\n", name.c_str(), estimates.size(),
                p.map.pageCount, p.map.pageSize, seams.size(), gridSeconds);
    std::printf("%-12s %10s %10s %8s %8s %8s %8s %8s %8s %8s\n", "seconds", "components", "processor", "first",
                "device", "memory", "upload", "filter", "download", "off");
    for (const int count : {1, components})
        for (const bool directions : {false, true})
            if (count == 1 || components > 1)
                measure(device, {p.geometry, p.map, grid, valid, samples}, estimates, count, directions);
}

} // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> scenes;
    std::string name;
    int size = 512;
    int components = 5; // of four light groups
    for (int i = 1; i + 1 < argc; i += 2) {
        if (std::strcmp(argv[i], "--scene") == 0)
            scenes.emplace_back(argv[i + 1]);
        else if (std::strcmp(argv[i], "--device") == 0)
            name = argv[i + 1];
        else if (std::strcmp(argv[i], "--size") == 0)
            size = std::atoi(argv[i + 1]);
        else if (std::strcmp(argv[i], "--components") == 0)
            components = std::atoi(argv[i + 1]);
    }
    const auto device = openBakeDevice({.name = name});
    if (!device) {
        std::fprintf(stderr, "%s\n", device.error().message.c_str());
        return 1;
    }
    std::printf("%s; %d threads\n", describe(**device).c_str(), threadCount());
    for (const std::string& scene : scenes) measureScene(**device, scene, size, components);
    return 0;
}
