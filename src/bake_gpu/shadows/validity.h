#pragma once
// Validity of sample points on a device: all rays of a texel in one invocation.

#include "bake_gpu/device_scene.h"
#include "transport/texels/device_validity.h"

namespace halflight {

class GpuValidity final : public DeviceValidity {
public:
    /// Throws gpu::Failure. `device` and `scene` outlive it.
    GpuValidity(BakeDevice& device, const DeviceScene& scene, bool anySolid);

    Status validPoints(std::span<const Texel> texels, std::span<PointMask> masks, uint64_t& rays) const override;

private:
    void testSome(std::span<const Texel> texels, std::span<PointMask> masks, uint64_t& rays) const;

    /// Texels of one launch: two million rays, and 18 MiB of points.
    static constexpr std::size_t kMostTexels = 32768;

    BakeDevice& device_;
    const DeviceScene& scene_;
    bool anySolid_; ///< of the scene's triangles
    gpu::Buffer texels_;
    gpu::Buffer masks_;
    gpu::Buffer counts_;
    gpu::Buffer lists_;
};

} // namespace halflight
