// Measures the bake's light transport and prints plain tables. Every ratio is of two measurements of the same run;
// times are CPU seconds of the process, summed over threads, so that a busy machine disturbs them little.
//   bench_bake PART [--scene FILE]... [--size N] [--points N] [--reference N]
//              [--samples N] [--seeds N] [--references DIR] [--settings FILE]
//   PART: gather | error | shadows | seams | masks | scaling | lights | lamps | triangles | groups
// Scenes: the built-in "cornell" (a box with an emissive quad), or glTF files; FILE@sun leaves them the sun and the
// sky.

#include "bake/denoise/denoise.h"
#include "bake/geometry/indices.h"
#include "bake/pages/dilate.h"
#include "bake/pages/encode.h"
#include "bake/seams/seams.h"
#include "bake/texels/rasterize.h"
#include "equal_error.h"
#include "group_cost.h"
#include "measure.h"
#include "whole_bakes.h"

#include "bake_cpu/trace/embree_kernels.h"
#include "transport/guiding/build_guides.h"
#include "transport/lightmap/lightmap_run.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/image_filter.h"
#include "halflight/base/parallel.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

using namespace halflight;
using namespace halflight::bench;

namespace {

/// Of all texels together: not as many as were asked for.
double samplesOf(const Run& run)
{
    double sum = 0.0;
    for (const IrradianceEstimate& e : run.estimates) sum += double(e.samples);
    return sum;
}

/// Rays per second of the gather, shading and sampling included, on one thread and on two.
void partGather(const Options& options)
{
    std::printf("gather: points, sampling, tracing, looking up light\n");
    std::printf("%-34s %8s %8s %12s\n", "scene", "threads", "Mrays", "gather Mr/s");
    for (const std::string& name : options.scenes) {
        Prepared p = prepare(name, options.size, true);
        const PathTracer paths(p.scene, p.geometry, LightUse::Bake, Bounces::Diffuse, embreeKernels());
        const StratifiedPattern pattern(1);
        const IntegrationSettings settings = options.integration();
        std::atomic<uint64_t> ignored{0};
        const auto radiosity = buildRadiosity({paths, p.map, pattern, settings}, {}, ignored);
        const Guides guides = buildGuides(*radiosity, p.map, paths.surfaces());
        std::vector<uint32_t> chosen;
        subsetOf(p.map, 8192, chosen);
        constexpr std::size_t kRun = 64;
        const std::size_t runs = chosen.size() / kRun;
        const auto gatherAll = [&] {
            std::atomic<uint64_t> total{0};
            parallelFor(runs, 4, [&](std::size_t begin, std::size_t end) {
                FinalGather gather(paths, pattern, &radiosity->solution.cache, &guides, settings);
                uint64_t rays = 0;
                for (std::size_t g = begin * kRun; g < end * kRun; g += kLanes) {
                    const GatherGroup group(paths, p.map, std::span(&chosen[g], kLanes));
                    std::array<TexelEstimate, kLanes> estimates;
                    gather.add(group, 0, 4, {estimates, {}}, rays);
                }
                total += rays;
            });
            return total.load();
        };
        double single = 0.0;
        for (const int threads : {1, 2}) {
            const ThreadLimit limit(threads);
            // The best of nine turns, each long enough that its end, where one thread waits for the other, is little.
            constexpr double kTurnSeconds = 0.25;
            double start = cpuSeconds();
            const uint64_t rays = gatherAll();
            const int times = std::max(1, int(kTurnSeconds / (cpuSeconds() - start)));
            double cpu = 1.0e30;
            double wall = 1.0e30;
            for (int repeat = 0; repeat < 9; ++repeat) {
                const double wallStart = wallSeconds();
                start = cpuSeconds();
                for (int i = 0; i < times; ++i) gatherAll();
                cpu = std::min(cpu, (cpuSeconds() - start) / times);
                wall = std::min(wall, (wallSeconds() - wallStart) / times);
            }
            const double mrays = double(rays) * 1.0e-6;
            std::printf("%-34s %8d %8.1f %12.2f", name.c_str(), threads, mrays, mrays / cpu * threads);
            if (threads == 1) {
                single = wall;
                std::printf("\n");
            } else {
                std::printf("   wall: %.2f x one thread\n", single / wall);
            }
            std::fflush(stdout);
        }
    }
}

/// Direct light that is baked: at 64 shadow rays for each texel, against 4096; left out are the texels that compare()
/// leaves out too.
void partShadows(const Options& options)
{
    std::printf("%-34s %8s %10s %10s %12s %12s\n", "scene", "texels", "CPU s", "Mrays", "RMSE", "overlooked");
    for (const std::string& name : options.scenes) {
        Prepared p = prepare(name, options.size, true);
        std::vector<uint32_t> chosen;
        const TexelMap subset = subsetOf(p.map, 4 * options.points, chosen);
        IntegrationSettings settings;
        settings.integrator = IntegratorKind::Path; // one sample of all else: little time
        settings.samples = 1;
        settings.bounces = 1;
        settings.shadowSamples = 64;
        Run run = integrate(p, subset, settings);
        settings.shadowSamples = 4096;
        settings.seed = 77;
        Run reference = integrate(p, subset, settings);
        std::size_t overlooked = 0; // lit a little, and taken for dark
        for (std::size_t i = 0; i < subset.texels.size(); ++i) {
            IrradianceEstimate& a = run.estimates[i];
            IrradianceEstimate& b = reference.estimates[i];
            a.irradiance = a.direct;
            b.irradiance = b.direct;
            overlooked += luminance(b.direct) > 0.0f && luminance(a.direct) == 0.0f ? 1 : 0;
        }
        const LightError e = compare(run.estimates, nullptr, reference.estimates);
        std::printf("%-34s %8zu %10.2f %10.1f %11.2f%% %11.2f%%\n", name.c_str(), subset.texels.size(), run.cpu,
                    double(run.rays) * 1.0e-6, 100.0 * e.rmse,
                    100.0 * double(overlooked) / double(subset.texels.size()));
    }
}

/// Light along the seams, on both their sides, before and after stitching: its step over the local light, the length
/// where that is above a tenth, and the distance from a map of four times as many texels in each direction.
void seamsOf(const Options& options, const std::string& name, bool bakeLights)
{
    constexpr int kFiner = 4;
    const Prepared p = prepare(name, options.size, bakeLights);
    const auto pagesOf = [&](const Prepared& scene) {
        IntegrationSettings settings = options.integration();
        settings.samples = options.samples > 0 ? options.samples : 16;
        settings.shadowSamples = 32;
        std::vector<IrradianceEstimate> estimates = integrate(scene, scene.map, settings).estimates;
        denoise(scene.geometry, scene.map, {}, estimates, false);
        TexelValues values = splitEstimates(estimates);
        const std::vector<uint8_t> valid = validTexels(scene.map);
        fillInvalid(scene.geometry, scene.map, valid, values.irradiance);
        fillInvalid(scene.geometry, scene.map, valid, values.direct);
        return std::array{dilate(scene.map, values.irradiance, kDilationRings),
                          dilate(scene.map, values.direct, kDilationRings)};
    };
    const std::vector<SeamSample> seams = findSeams(p.geometry, p.map.pageSize);
    const auto [light, direct] = pagesOf(p);
    std::vector<ImageRgb32f> stitched = light;
    stitchSeams(p.map, seams, lightSeamWeights(seams, light, direct), stitched);
    Prepared finer = p;
    finer.geometry.scaleTexels(float(kFiner));
    finer.map = rasterizeTexels(finer.geometry, p.map.pageSize * kFiner, p.map.pageCount);
    const std::vector<ImageRgb32f> truth = pagesOf(finer)[0];
    const auto lightAt = [](const std::vector<ImageRgb32f>& from, const SeamSample& seam, float scale) {
        return glm::dvec2(luminance(bilinear(from[std::size_t(seam.pageA)], scale * seam.texelA)),
                          luminance(bilinear(from[std::size_t(seam.pageB)], scale * seam.texelB)));
    };
    double mean = 0.0;
    double length = 0.0;
    for (const SeamSample& seam : seams) {
        const glm::dvec2 sides = lightAt(truth, seam, kFiner);
        mean += 0.5 * double(seam.texels) * (sides.x + sides.y);
        length += double(seam.texels);
    }
    mean /= length;
    std::printf("%-34s %8zu", (name + (bakeLights ? "" : ", bounced")).c_str(), seams.size());
    for (const auto* pages : {&light, static_cast<const std::vector<ImageRgb32f>*>(&stitched)}) {
        double steps = 0.0;
        double above = 0.0;
        double squares = 0.0;
        for (const SeamSample& seam : seams) {
            const glm::dvec2 sides = lightAt(*pages, seam, 1.0f);
            const glm::dvec2 error = sides - lightAt(truth, seam, kFiner);
            const double step = std::abs(sides.x - sides.y);
            steps += double(seam.texels) * step;
            if (step > 0.1 * (std::max(sides.x, sides.y) + 1.0e-3 * mean)) above += double(seam.texels);
            squares += 0.5 * double(seam.texels) * glm::dot(error, error);
        }
        std::printf(" %8.2f%% %6.1f%% %8.2f%%", 100.0 * steps / (length * mean), 100.0 * above / length,
                    100.0 * std::sqrt(squares / length) / mean);
    }
    std::puts("");
}

void partSeams(const Options& options)
{
    std::printf("scene, places; step, above a tenth, error; the same stitched\n");
    for (const std::string& name : options.scenes)
        for (const bool bakeLights : {true, false}) seamsOf(options, name, bakeLights);
}

/// Shadowmasks: CPU seconds for each light, and the difference from masks with every ray traced.
void partMasks(const Options& options)
{
    std::printf("%-34s %8s %8s %10s %12s\n", "scene", "texels", "lights", "CPU s", "s per light");
    for (const std::string& name : options.scenes) {
        Prepared p = prepare(name, options.size, false);
        IntegrationSettings settings;
        settings.shadowSamples = 64;
        settings.samples = 16;
        auto made = makeEmbreeIntegrator(p.scene, p.geometry, settings);
        if (!made) std::exit(1);
        if (!(*made)->findValidPoints(p.map, nullptr, {})) std::exit(1);
        std::vector<vec4> mask(p.map.texels.size());
        const double start = cpuSeconds();
        if (!(*made)->shadowmask(p.map, {allIndices(p.map.texels.size())}, 0, mask, {})) std::exit(1);
        const double cpu = cpuSeconds() - start;
        int lights = 0;
        for (const Light& light : p.scene.lights) lights += light.baking.occlusionMaskChannel >= 0 ? 1 : 0;
        std::printf("%-34s %8zu %8d %10.2f %12.2f\n", name.c_str(), p.map.texels.size(), lights, cpu,
                    lights > 0 ? cpu / lights : 0.0);
    }
}

/// A hall with 1, 10, 100, 1000 emissive quads of the same total power: time and error at equal samples.
void partLights(const Options& options)
{
    std::printf("%8s %10s %10s %10s %9s %9s\n", "quads", "texels", "CPU s", "us/sample", "RMSE", "bias");
    for (const int quads : {1, 10, 100, 1000}) {
        Prepared p = prepareScene(hallOfQuads(quads), options.size, false);
        std::vector<uint32_t> chosen;
        const TexelMap subset = subsetOf(p.map, options.points / 2, chosen);
        IntegrationSettings settings;
        settings.bounces = 2;
        settings.integrator = IntegratorKind::Path;
        settings.samples = options.reference / 2;
        settings.seed = 77;
        const Run reference = integrate(p, subset, settings);
        settings.integrator = IntegratorKind::Cache;
        settings.seed = 1;
        settings.samples = 64;
        const Run run = integrate(p, p.map, settings);
        const LightError e = compare(run.estimates, &chosen, reference.estimates);
        std::printf("%8d %10zu %10.2f %10.3f %8.2f%% %8.2f%%\n", quads, p.map.texels.size(), run.cpu,
                    1.0e6 * run.cpu / samplesOf(run), 100.0 * e.rmse, 100.0 * e.bias);
        std::fflush(stdout);
    }
}

/// One shape of 1,000 to 1,000,000 triangles in a room: time at equal texels and samples.
void partTriangles(const Options& options)
{
    std::printf("%10s %10s %10s %10s %10s\n", "triangles", "texels", "build s", "CPU s", "us/sample");
    for (const int triangles : {1000, 10000, 100000, 1000000}) {
        Prepared p = prepareScene(roomWithBall(triangles), options.size, false);
        IntegrationSettings settings = options.integration();
        settings.samples = 64;
        const double start = cpuSeconds();
        if (!makeEmbreeIntegrator(p.scene, p.geometry, settings)) std::exit(1);
        const double build = cpuSeconds() - start;
        const Run run = integrate(p, p.map, settings);
        std::printf("%10zu %10zu %10.2f %10.2f %10.3f\n", trianglesOf(p), p.map.texels.size(), build, run.cpu,
                    1.0e6 * run.cpu / samplesOf(run));
        std::fflush(stdout);
    }
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    for (int i = 1; i < argc; ++i) {
        const auto option = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
        if (option("--scene")) {
            options.scenes.emplace_back(argv[++i]);
        } else if (option("--size")) {
            options.size = std::atoi(argv[++i]);
        } else if (option("--points")) {
            options.points = std::atoi(argv[++i]);
        } else if (option("--reference")) {
            options.reference = std::atoi(argv[++i]);
        } else if (option("--bounces")) {
            options.bounces = std::atoi(argv[++i]);
        } else if (option("--samples")) {
            options.samples = std::atoi(argv[++i]);
        } else if (option("--seeds")) {
            options.seeds = std::max(1, std::atoi(argv[++i]));
        } else if (option("--references")) {
            options.folder = argv[++i];
        } else if (option("--target")) {
            options.target = std::atof(argv[++i]) / 100.0;
        } else if (option("--settings")) {
            options.settings = argv[++i];
        } else if (std::strcmp(argv[i], "--diffuse") == 0) {
            options.diffuse = true;
        } else {
            options.part = argv[i];
        }
    }
    if (options.scenes.empty()) options.scenes = {"cornell"};
    if (options.part == "gather") {
        partGather(options);
    } else if (options.part == "error") {
        partError(options);
    } else if (options.part == "shadows") {
        partShadows(options);
    } else if (options.part == "seams") {
        partSeams(options);
    } else if (options.part == "masks") {
        partMasks(options);
    } else if (options.part == "scaling") {
        partScaling(options);
    } else if (options.part == "lights") {
        partLights(options);
    } else if (options.part == "lamps") {
        partLamps(options);
    } else if (options.part == "triangles") {
        partTriangles(options);
    } else if (options.part == "groups") {
        partGroups(options);
    } else {
        std::fprintf(stderr, "usage: bench_bake gather|error|shadows|seams|masks|scaling|lights|lamps|triangles|groups "
                             "[--scene FILE|cornell]... "
                             "[--size N] [--points N] [--reference N] [--bounces N] [--target PERCENT] [--samples N] "
                             "[--references DIR] [--settings FILE] [--diffuse]\n");
        return 2;
    }
    return 0;
}
