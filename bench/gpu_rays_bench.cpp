// Measures rays a second on a GPU and on the processor, in one run.
//   bench_gpu_rays [--scene FILE]... [--size N] [--device NAME]
// Rays are those of a lightmap's gather, incoherent; "shadow" are rays of the same texels to a random point of the
// scene's bounds. "launch" is the device's part alone, "verb" with copies of rays and hits to it and back.

#include "bench_scenes.h"
#include "measure.h"

#include "bake_cpu/trace/embree_kernels.h"
#include "bake_gpu/kernels.h"
#include "transport/sample/gather_direction.h"
#include "transport/trace/ray_tracer.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

using namespace halflight;
using namespace halflight::bench;

namespace {

constexpr std::size_t kRays = std::size_t(1) << 22;
constexpr int kRuns = 20;

template<typename Body> double bestSeconds(const Body& body)
{
    double best = 1.0e9;
    for (int i = 0; i < kRuns; ++i) {
        const double begin = wallSeconds();
        body();
        best = std::min(best, wallSeconds() - begin);
    }
    return best;
}

std::vector<Ray> gatherRays(const Prepared& p, const RayTracer& tracer, bool shadow, bool coherent = false)
{
    Bounds bounds;
    for (const vec3 position : p.geometry.positions) bounds.extend(position);
    std::vector<Ray> rays(kRays);
    parallelFor(kRays, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto number = [&](uint32_t k) { return unitFloat(hashCombine(uint32_t(i), k)); };
            const std::size_t place = coherent ? i % (kRays / 16) * 16 + i / (kRays / 16) : i;
            const std::size_t stratum = i / (kRays / 16);
            const TexelFragment& f = p.map.fragments[place * p.map.fragments.size() / kRays];
            const SurfacePoint point = surfacePoint(p.geometry, f.triangle, f.barycentric);
            const vec3 origin = tracer.rayOrigin(point);
            if (!shadow) {
                vec2 u(number(1), number(2));
                if (coherent) u = (u + vec2(float(stratum % 4), float(stratum / 4))) / 4.0f;
                rays[i] = {origin, 0.0f, gatherDirection(point, u), kInfinity};
                continue;
            }
            const vec3 to = bounds.min + bounds.size() * vec3(number(3), number(4), number(5));
            rays[i] = {origin, 0.0f, glm::normalize(to - origin), glm::distance(origin, to)};
        }
    });
    return rays;
}

/// Seconds of one launch, without the copies.
template<typename Verb>
double launchSeconds(BakeDevice& bake, const DeviceScene& scene, const Verb& verb, const std::vector<Ray>& rays)
{
    gpu::Device& device = bake.device();
    const gpu::Buffer input = bufferOf(device, rays);
    const gpu::Buffer results(device, rays.size() * sizeof(RayHit), gpu::kAddressed, gpu::MemoryUse::Device);
    const TracePush push{scene.address(), input.address(), results.address(), 0};
    return bestSeconds([&] {
        device.execute([&](VkCommandBuffer commands) { (bake.*verb)(commands, push, uint32_t(rays.size())); });
    });
}

void measure(const std::shared_ptr<BakeDevice>& device, const std::string& name, int size)
{
    const Prepared p = prepare(name, size, true);
    double begin = wallSeconds();
    const RayTracer cpu(p.scene, p.geometry, embreeKernels());
    const double cpuBuild = wallSeconds() - begin;
    begin = wallSeconds();
    const DeviceScene scene(device->device(), cpu);
    const double gpuBuild = wallSeconds() - begin;
    const RayTracer gpu(p.scene, p.geometry, [&](const RayScene& of) {
        return std::make_unique<GpuKernels>(device, of, embreeKernels()(of));
    });
    std::printf("%s: %u triangles, trees %.2f s on the processor, %.2f s and %.0f MiB on the device\n", name.c_str(),
                cpu.hitTriangleCount(), cpuBuild, gpuBuild, double(scene.bytes()) / (1 << 20));
    std::printf("%-10s %12s %12s %12s\n", "Mrays/s", "processor", "launch", "verb");
    const auto print = [](const char* what, double cpuTime, double launch, double verb) {
        const double millions = double(kRays) * 1.0e-6;
        std::printf("%-10s %12.1f %12.1f %12.1f\n", what, millions / cpuTime, millions / launch, millions / verb);
    };
    const std::vector<Ray> rays = gatherRays(p, cpu, false);
    std::vector<RayHit> hits(kRays);
    const double nearest = bestSeconds([&] {
        parallelFor(kRays, 1024, [&](std::size_t first, std::size_t end) {
            cpu.nearest(std::span(rays).subspan(first, end - first), std::span(hits).subspan(first, end - first));
        });
    });
    print("nearest", nearest, launchSeconds(*device, scene, &BakeDevice::nearest, rays),
          bestSeconds([&] { gpu.nearest(rays, hits); }));
    const std::vector<Ray> shadow = gatherRays(p, cpu, true);
    std::vector<vec3> passed(kRays);
    const double through = bestSeconds([&] {
        parallelFor(kRays, 1024, [&](std::size_t first, std::size_t end) {
            cpu.transmittance(std::span(shadow).subspan(first, end - first),
                              std::span(passed).subspan(first, end - first));
        });
    });
    print("shadow", through, launchSeconds(*device, scene, &BakeDevice::transmittance, shadow),
          bestSeconds([&] { gpu.transmittance(shadow, passed); }));
}

} // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> scenes;
    std::string name;
    int size = 512;
    for (int i = 1; i + 1 < argc; i += 2) {
        if (std::strcmp(argv[i], "--scene") == 0)
            scenes.emplace_back(argv[i + 1]);
        else if (std::strcmp(argv[i], "--device") == 0)
            name = argv[i + 1];
        else if (std::strcmp(argv[i], "--size") == 0)
            size = std::atoi(argv[i + 1]);
    }
    const auto device = openBakeDevice({.name = name});
    if (!device) {
        std::fprintf(stderr, "%s\n", device.error().message.c_str());
        return 1;
    }
    std::printf("%s; %d threads\n", describe(**device).c_str(), threadCount());
    for (const std::string& scene : scenes) measure(*device, scene, size);
    return 0;
}
