#pragma once
// Proxy volumes on the device: all of a scene's in one 3D texture (layout: GpuProbeVolume in gpu_layout.h).

#include "gpu/resources.h"
#include "halflight/render/probes.h"
#include "render/scene/gpu_layout.h"

#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// Places for boxes of texels beside one another in a 3D texture.
struct VolumePacking {
    ivec3 size{1};              ///< of the texture
    std::vector<ivec3> offsets; ///< -1 where a box does not fit within the limits
};
/// Rows along x, of rows layers along y, of layers the whole along z; none longer than `limits`.
VolumePacking packVolumes(std::span<const ivec3> boxes, ivec3 limits);

class ProbeVolumes {
public:
    ProbeVolumes() = default;
    /// Makes room. Volumes for which the device has none are taken out of the plan: their objects get one sample.
    ProbeVolumes(const gpu::Device& device, ProxyVolumePlan plan, int maskLayers);

    /// Fills all volumes. Uploads may still be pending afterwards, so this must stay where it is until they finish.
    void upload(gpu::Uploader& uploader, const Scene& scene, std::span<const Bounds> meshBounds,
                const ProbeInterpolator& probes);
    /// Fills the volumes of these objects anew.
    void update(gpu::Uploader& uploader, const Scene& scene, std::span<const Bounds> meshBounds,
                const ProbeInterpolator& probes, std::span<const uint32_t> changedObjects);

    [[nodiscard]] const ProxyVolumePlan& plan() const { return plan_; }
    [[nodiscard]] const gpu::Image& texture() const { return texture_; }
    [[nodiscard]] const gpu::Buffer& buffer() const { return buffer_; }

private:
    struct Filled {
        shading::GpuProbeVolume volume;
        std::vector<uint64_t> texels; ///< half floats, slab after slab
    };
    [[nodiscard]] Filled fill(std::size_t volume, const Scene& scene, std::span<const Bounds> meshBounds,
                              const ProbeInterpolator& probes) const;
    void copy(gpu::Uploader& uploader, std::span<const std::size_t> volumes, const gpu::ImageState& before,
              const Scene& scene, std::span<const Bounds> meshBounds, const ProbeInterpolator& probes);

    ProxyVolumePlan plan_;
    ivec3 slabSize_{1};
    int slabs_ = shading::kProbeSlabs;
    std::vector<ivec3> offsets_;
    gpu::Image texture_;
    gpu::Buffer buffer_;
};

} // namespace halflight
