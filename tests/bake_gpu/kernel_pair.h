#pragma once
// A scene with the processor's kernels and a device's, and rays for both.

#include "bake/geometry/balls.h"
#include "bake/geometry/flatten.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "bake_gpu/kernels.h"
#include "transport/trace/ray_tracer.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace halflight::test {

constexpr std::size_t kRays = 40000;
static_assert(kRays > GpuKernels::kLeastBatch);

/// A scene with kernels of both kinds.
struct Pair {
    Scene scene;
    BakeGeometry geometry;
    RayTracer cpu;
    RayTracer gpu;

    Pair(Scene s, const std::shared_ptr<BakeDevice>& device)
        : scene(std::move(s)), geometry(flattenGeometry(scene, balls::kPage, GeometryFilter::All)),
          cpu(scene, geometry, embreeKernels()), gpu(scene, geometry, [&](const RayScene& of) {
              return std::make_unique<GpuKernels>(device, of, embreeKernels()(of));
          })
    {}
};

/// About the balls; rays[7] meets nothing.
inline std::vector<Ray> randomRays(float length)
{
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < kRays; ++i) {
        rays.push_back(balls::randomRay(uint32_t(i)));
        rays.back().tMax = length;
    }
    rays[7].tMax = -1.0f;
    return rays;
}

/// Both count the same solids that rays leave, but for one ray of `oneOf`.
inline void expectSameCrossings(Scene scene, const std::shared_ptr<BakeDevice>& device, std::size_t oneOf)
{
    const Pair pair(std::move(scene), device);
    const std::vector<Ray> rays = randomRays(kInfinity);
    std::vector<int> a(kRays);
    std::vector<int> b(kRays);
    ASSERT_TRUE(pair.cpu.kernels().crossings(rays, a));
    ASSERT_TRUE(pair.gpu.kernels().crossings(rays, b));
    std::size_t inside = 0;
    std::size_t other = 0;
    for (std::size_t i = 0; i < kRays; ++i) {
        inside += a[i] > 0 ? 1 : 0;
        other += a[i] != b[i] ? 1 : 0;
    }
    EXPECT_GT(inside, kRays / 200);
    EXPECT_LT(other, kRays / oneOf);
}

} // namespace halflight::test
