// Options, bakes and errors of bench_bake.
#include "measure.h"
#include "bake/geometry/indices.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/system.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

namespace halflight::bench {

double cpuSeconds()
{
    return processCpuSeconds();
}

double wallSeconds()
{
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return double(t.tv_sec) + 1.0e-9 * double(t.tv_nsec);
}

TexelMap subsetOf(const TexelMap& map, int texels, std::vector<uint32_t>& chosen)
{
    TexelMap subset = map;
    subset.texels.clear();
    constexpr std::size_t kRun = 64;
    const std::size_t runs = std::max<std::size_t>(1, std::size_t(texels) / kRun);
    const std::size_t all = (map.texels.size() + kRun - 1) / kRun;
    for (std::size_t r = 0; r < std::min(runs, all); ++r) {
        const std::size_t begin = (runs >= all ? r : r * all / runs) * kRun;
        for (std::size_t i = begin; i < std::min(begin + kRun, map.texels.size()); ++i) {
            chosen.push_back(uint32_t(i));
            subset.texels.push_back(map.texels[i]);
        }
    }
    return subset;
}

Run integrate(const Prepared& p, const TexelMap& map, const IntegrationSettings& settings)
{
    Run run;
    auto made = makeEmbreeIntegrator(p.scene, p.geometry, settings);
    if (!made) std::exit(1);
    run.estimates.resize(map.texels.size());
    run.components.resize(map.texels.size() * std::size_t(settings.components.count));
    TexelMap valid = map;
    const double start = cpuSeconds();
    const bool done = (*made)->findValidPoints(valid, nullptr, {}) &&
                      (*made)
                          ->prepare(valid, nullptr)
                          ->irradianceByComponent({allIndices(map.texels.size())}, run.estimates, run.components, {});
    if (!done) std::exit(1);
    run.cpu = cpuSeconds() - start;
    run.rays = (*made)->raysTraced();
    return run;
}

LightError compare(const std::vector<IrradianceEstimate>& run, const std::vector<uint32_t>* pick,
                   const std::vector<IrradianceEstimate>& reference)
{
    double mean = 0.0;
    for (const IrradianceEstimate& e : reference) mean += double(luminance(e.irradiance)) / double(reference.size());
    double squares = 0.0;
    double difference = 0.0;
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        const IrradianceEstimate& e = run[pick != nullptr ? (*pick)[i] : i];
        if (!e.valid || !reference[i].valid) continue;
        const double a = double(luminance(e.irradiance));
        const double b = double(luminance(reference[i].irradiance));
        if (b > 20.0 * mean) continue;
        squares += (a - b) * (a - b);
        difference += a - b;
        sum += b;
        ++count;
    }
    if (count == 0 || sum <= 0.0) return {};
    return {std::sqrt(squares / double(count)) / (sum / double(count)), difference / sum};
}

std::vector<IrradianceEstimate> referenceOf(const Options& options, const std::string& name, const Prepared& p,
                                            const TexelMap& subset)
{
    std::vector<vec4> kept(subset.texels.size()); // irradiance, and its variance where valid
    std::filesystem::path file;
    if (!options.folder.empty()) {
        const std::string key = std::filesystem::path(name).filename().string();
        file = std::filesystem::path(options.folder) /
               (key + "-" + std::to_string(options.size) + "-" + std::to_string(subset.texels.size()) + "-" +
                std::to_string(options.reference) + "-" + std::to_string(options.bounces) +
                (options.diffuse ? "-diffuse" : ""));
    }
    std::vector<IrradianceEstimate> reference(kept.size());
    const auto bytes = std::streamsize(kept.size() * sizeof(vec4));
    if (std::ifstream in(file, std::ios::binary); in.read(reinterpret_cast<char*>(kept.data()), bytes)) {
        for (std::size_t i = 0; i < kept.size(); ++i) {
            reference[i].irradiance = vec3(kept[i]);
            reference[i].valid = kept[i].w > 0.0f;
            reference[i].varianceOfMean = kept[i].w;
        }
        return reference;
    }
    IntegrationSettings settings = options.integration();
    settings.integrator = IntegratorKind::Path;
    settings.samples = options.reference;
    settings.shadowSamples = 256;
    settings.seed = 77;
    reference = integrate(p, subset, settings).estimates;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const float variance = std::max(reference[i].varianceOfMean, 1.0e-30f);
        kept[i] = vec4(reference[i].irradiance, reference[i].valid ? variance : 0.0f);
    }
    if (!file.empty()) std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(kept.data()), bytes);
    return reference;
}

} // namespace halflight::bench
