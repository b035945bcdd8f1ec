// Memory of geometry whose meshes are shared, and the rate of rays in it. `bench_instances [INSTANCES]`
#include "bake/geometry/flatten.h"
#include "measure.h"

#include "bake_cpu/trace/embree_kernels.h"
#include "halflight/shading/random.h"
#include "transport/trace/ray_tracer.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

namespace halflight::bench {
namespace {

/// A ball with bumps of 2 * columns * (rows - 1) triangles.
MeshPart ball(int rows, int columns)
{
    MeshPart part;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            const float theta = kPi * float(j) / float(rows);
            const float phi = 2.0f * kPi * float(i % columns) / float(columns);
            const float ring = j == 0 || j == rows ? 0.0f : std::sin(theta);
            const vec3 n(ring * std::cos(phi), std::cos(theta), -ring * std::sin(phi));
            part.positions.push_back((0.4f + 0.05f * ring * ring * std::sin(5.0f * phi)) * n);
            part.normals.push_back(n);
            part.uv[0].emplace_back(float(i) / float(columns), float(j) / float(rows));
            part.lightmapUv.push_back(part.uv[0].back());
        }
    }
    for (uint32_t j = 0; j < uint32_t(rows); ++j) {
        for (uint32_t i = 0; i < uint32_t(columns); ++i) {
            const uint32_t a = j * (uint32_t(columns) + 1) + i;
            const uint32_t b = a + uint32_t(columns) + 1;
            if (j + 1 < uint32_t(rows)) part.indices.insert(part.indices.end(), {a, b, b + 1});
            if (j > 0) part.indices.insert(part.indices.end(), {a, b + 1, a + 1});
        }
    }
    return part;
}

/// Balls in a square on a floor, 1.5 m apart, turned and of different sizes. `shared`: of one mesh, else each has its
/// own.
Scene balls(int count, const MeshPart& part, bool shared)
{
    Scene scene;
    scene.materials.resize(1);
    const int side = int(std::ceil(std::sqrt(double(count))));
    const float half = 0.75f * float(side);
    MeshPart floor;
    floor.positions = {{-half, 0, -half}, {-half, 0, half}, {half, 0, half}, {half, 0, -half}};
    floor.normals.assign(4, vec3(0, 1, 0));
    floor.indices = {0, 1, 2, 0, 2, 3};
    scene.meshes.resize(2);
    scene.meshes[0].parts.push_back(floor);
    scene.meshes[1].parts.push_back(part);
    scene.objects.resize(1);
    scene.objects[0].mesh = 0;
    for (int i = 0; i < count; ++i) {
        Object object;
        object.mesh = 1;
        if (!shared && i > 0) {
            object.mesh = int(scene.meshes.size());
            scene.meshes.push_back(scene.meshes[1]);
        }
        object.worldFromObject = glm::translate(
            mat4(1.0f), vec3(1.5f * float(i % side) - half + 0.75f, 0.5f, 1.5f * float(i / side) - half + 0.75f));
        object.worldFromObject = glm::rotate(object.worldFromObject, 0.37f * float(i), vec3(0, 1, 0));
        object.worldFromObject = glm::scale(object.worldFromObject, vec3(0.7f + 0.003f * float(i * 7919 % 100)));
        scene.objects.push_back(object);
    }
    return scene;
}

struct Built {
    Scene scene;
    BakeGeometry geometry;
    std::unique_ptr<RayTracer> tracer;

    explicit Built(Scene s) : scene(std::move(s)), geometry(flattenGeometry(scene, 512, GeometryFilter::Static))
    {
        tracer = std::make_unique<RayTracer>(scene, geometry, embreeKernels());
        if (!tracer->ok()) std::exit(1);
    }
    [[nodiscard]] double bytes() const { return double(geometry.byteCount() + tracer->peakBytes()); }
};

/// Seconds of a core for rays from random points above the floor in random directions.
double secondsOfRays(const Built& built, float half, uint32_t count, uint64_t& found)
{
    const double start = cpuSeconds();
    found = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const auto number = [&](uint32_t k) { return unitFloat(hashCombine(i, k)); };
        const vec3 origin =
            vec3(-half, 0.1f, -half) + vec3(2 * half, 1.5f, 2 * half) * vec3(number(1), number(2), number(3));
        const float z = 2.0f * number(4) - 1.0f;
        const float phi = 2.0f * kPi * number(5);
        const float ring = std::sqrt(std::max(0.0f, 1.0f - z * z));
        const RayHit hit =
            built.tracer->nearest(origin, vec3(ring * std::cos(phi), z, ring * std::sin(phi)), 0.0f, kInfinity);
        found += hit.found() ? 1 : 0;
    }
    return cpuSeconds() - start;
}

int run(int count)
{
    const MeshPart small = ball(32, 65);
    const double few = Built(balls(count / 2, small, true)).bytes();
    const Built shared(balls(count, small, true));
    const double perInstance = (shared.bytes() - few) / double(count - count / 2);
    std::printf("%d instances of %zu triangles: %.2f MB in geometry and trees, %.0f bytes per instance\n", count,
                small.indices.size() / 3, shared.bytes() * 1.0e-6, perInstance);
    const MeshPart large = ball(300, 500);
    const MeshPart larger = ball(600, 500);
    const double bytes = Built(balls(2, large, true)).bytes();
    const double more = Built(balls(2, larger, true)).bytes();
    std::printf("meshes of %zu and %zu triangles: %.1f bytes per distinct triangle\n", large.indices.size() / 3,
                larger.indices.size() / 3, (more - bytes) / double((larger.indices.size() - large.indices.size()) / 3));
    const int flatCount = std::min(count, 475); // what fits small machines
    const Built some(balls(flatCount, small, true));
    const Built flat(balls(flatCount, small, false));
    std::printf("%d balls with a mesh each: %.2f MB, %.0f bytes per triangle; as instances %.2f MB\n", flatCount,
                flat.bytes() * 1.0e-6, flat.bytes() / double(flat.geometry.triangleCount()), some.bytes() * 1.0e-6);
    const float half = 0.75f * std::ceil(std::sqrt(float(flatCount)));
    std::vector<double> ratios;
    for (int repeat = 0; repeat < 5; ++repeat) {
        uint64_t a = 0;
        uint64_t b = 0;
        const double inInstances = secondsOfRays(some, half, 1000000, a);
        const double inWorld = secondsOfRays(flat, half, 1000000, b);
        ratios.push_back(inWorld / inInstances);
        std::printf("1 M rays: %.2f s in instances (%llu hit), %.2f s in world space (%llu hit)\n", inInstances,
                    static_cast<unsigned long long>(a), inWorld, static_cast<unsigned long long>(b));
    }
    std::sort(ratios.begin(), ratios.end());
    std::printf("rate of rays in instances over that in world space: %.2f (median of 5)\n", ratios[2]);
    return 0;
}

} // namespace
} // namespace halflight::bench

int main(int argc, char** argv)
{
    const int count = argc > 1 ? std::atoi(argv[1]) : 1900;
    if (count < 40) {
        std::fprintf(stderr, "usage: bench_instances [INSTANCES], 40 or more\n");
        return 2;
    }
    return halflight::bench::run(count);
}
