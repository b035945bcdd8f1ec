#include "render/scene/probe_volumes.h"

#include "halflight/base/mathematics.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace halflight {
namespace {

static_assert(shading::kProbeSlabs + kMostMaskLayers - 1 == ProxyVolume::kTextures);

/// Every device filters half floats.
constexpr VkFormat kFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
/// Layers are this wide and high at most.
constexpr int kLayerSize = 256;

/// The power of two that brings the largest coefficient just below half of what a half float holds. A power of two
/// changes no mantissa, and leaves light 28 binary orders below the brightest its full precision.
float radianceFactor(const ProxyVolume& volume)
{
    float largest = 0.0f;
    for (const int i : {0, 1, 2, 4, 5, 6, 7}) {
        for (const vec4& texel : volume.textures[std::size_t(i)]) {
            const vec4 size = glm::abs(texel);
            largest = std::max({largest, size.x, size.y, size.z, size.w});
        }
    }
    return largest > 0.0f ? math::exp2(std::ceil(math::log2(largest)) - 15.0f) : 1.0f;
}

} // namespace

VolumePacking packVolumes(std::span<const ivec3> boxes, ivec3 limits)
{
    VolumePacking packing;
    packing.offsets.assign(boxes.size(), ivec3(-1));
    std::vector<std::size_t> order(boxes.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return boxes[a].z != boxes[b].z ? boxes[a].z > boxes[b].z : boxes[a].y > boxes[b].y;
    });
    ivec3 at(0);        // where the next box goes
    ivec3 thickness(0); // of the current row (y) and layer (z)
    for (const std::size_t i : order) {
        const ivec3 box = boxes[i];
        if (box.x > limits.x || box.y > limits.y) continue;
        if (at.x + box.x > limits.x) {
            at = {0, at.y + thickness.y, at.z};
            thickness.y = 0;
        }
        if (at.y + box.y > limits.y) {
            at = {0, 0, at.z + thickness.z};
            thickness = ivec3(0);
        }
        if (at.z + box.z > limits.z) continue;
        packing.offsets[i] = at;
        packing.size = glm::max(packing.size, at + box);
        thickness = glm::max(thickness, box);
        at.x += box.x;
    }
    return packing;
}

ProbeVolumes::ProbeVolumes(const gpu::Device& device, ProxyVolumePlan plan, int maskLayers)
    : plan_(std::move(plan)), slabs_(shading::kProbeSlabs + maskLayers - 1)
{
    const int limit = int(device.properties().limits.maxImageDimension3D);
    std::vector<ivec3> boxes;
    for (const ProxyVolumePlan::Volume& volume : plan_.volumes) boxes.push_back(volume.resolution);
    const VolumePacking packing =
        packVolumes(boxes, {std::min(limit, kLayerSize), std::min(limit, kLayerSize), limit / slabs_});
    slabSize_ = packing.size;
    offsets_ = packing.offsets;
    for (std::size_t i = 0; i < offsets_.size(); ++i) {
        if (offsets_[i].x >= 0) continue;
        for (const uint32_t object : plan_.volumes[i].objects) plan_.volumeOf[object] = -1;
    }
    texture_ = gpu::Image(device, {.format = kFormat,
                                   .width = uint32_t(slabSize_.x),
                                   .height = uint32_t(slabSize_.y),
                                   .depth = uint32_t(slabSize_.z * slabs_),
                                   .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    buffer_ =
        gpu::Buffer(device, plan_.volumes.size() * sizeof(shading::GpuProbeVolume),
                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Device);
}

void ProbeVolumes::upload(gpu::Uploader& uploader, const Scene& scene, std::span<const Bounds> meshBounds,
                          const ProbeInterpolator& probes)
{
    // Texels of no volume are read with weight 0; they must not be NaN all the same.
    const std::size_t slice = std::size_t(slabSize_.x) * std::size_t(slabSize_.y);
    const uint32_t depth = texture_.info().depth;
    const std::vector<uint64_t> zeros(slice, 0);
    std::vector<gpu::Uploader::Box> boxes;
    for (uint32_t z = 0; z < depth; ++z)
        boxes.push_back({{0, 0, int32_t(z)}, {uint32_t(slabSize_.x), uint32_t(slabSize_.y), 1}, zeros.data()});
    uploader.boxes(texture_, gpu::state::kUndefined, boxes, sizeof(uint64_t));

    std::vector<std::size_t> all(plan_.volumes.size());
    std::iota(all.begin(), all.end(), std::size_t(0));
    copy(uploader, all, gpu::state::kFragmentRead, scene, meshBounds, probes);
}

void ProbeVolumes::update(gpu::Uploader& uploader, const Scene& scene, std::span<const Bounds> meshBounds,
                          const ProbeInterpolator& probes, std::span<const uint32_t> changedObjects)
{
    std::vector<std::size_t> changed;
    for (const uint32_t object : changedObjects)
        if (plan_.volumeOf[object] >= 0) changed.push_back(std::size_t(plan_.volumeOf[object]));
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    copy(uploader, changed, gpu::state::kFragmentRead, scene, meshBounds, probes);
}

void ProbeVolumes::copy(gpu::Uploader& uploader, std::span<const std::size_t> volumes, const gpu::ImageState& before,
                        const Scene& scene, std::span<const Bounds> meshBounds, const ProbeInterpolator& probes)
{
    for (const std::size_t i : volumes) {
        if (offsets_[i].x < 0) continue;
        const Filled filled = fill(i, scene, meshBounds, probes);
        const ivec3 size = plan_.volumes[i].resolution;
        const std::size_t slabTexels = filled.texels.size() / std::size_t(slabs_);
        std::vector<gpu::Uploader::Box> boxes;
        for (int slab = 0; slab < slabs_; ++slab)
            boxes.push_back({{offsets_[i].x, offsets_[i].y, offsets_[i].z + slab * slabSize_.z},
                             {uint32_t(size.x), uint32_t(size.y), uint32_t(size.z)},
                             filled.texels.data() + std::size_t(slab) * slabTexels});
        uploader.boxes(texture_, before, boxes, sizeof(uint64_t));
        uploader.buffer(buffer_, &filled.volume, sizeof(filled.volume), i * sizeof(filled.volume));
    }
}

ProbeVolumes::Filled ProbeVolumes::fill(std::size_t volume, const Scene& scene, std::span<const Bounds> meshBounds,
                                        const ProbeInterpolator& probes) const
{
    const ProxyVolume made = makeProxyVolume(probes, scene, meshBounds, plan_.volumes[volume]);
    const float factor = radianceFactor(made);
    Filled filled;
    for (std::size_t i = 0; i < std::size_t(slabs_); ++i) {
        const float scale = i == 3 || i >= shading::kProbeSlabs ? 1.0f : 1.0f / factor;
        for (const vec4& texel : made.textures[i]) filled.texels.push_back(glm::packHalf4x16(texel * scale));
    }

    // [0, 1]^3 of the volume to its box of slab 0, in coordinates of the texture.
    const glm::dvec3 textureSize(slabSize_.x, slabSize_.y, slabSize_.z * slabs_);
    const glm::dvec3 offset(offsets_[volume]);
    const glm::dvec3 resolution(made.resolution);
    const glm::dmat4 slabFromVolume = glm::scale(glm::dmat4(1.0), 1.0 / textureSize) *
                                      glm::translate(glm::dmat4(1.0), offset) * glm::scale(glm::dmat4(1.0), resolution);
    filled.volume.slabFromWorld = mat4(slabFromVolume * glm::dmat4(made.volumeFromWorld));
    filled.volume.low = vec4(vec3((offset + 0.5) / textureSize), factor);
    filled.volume.high = vec4(vec3((offset + resolution - 0.5) / textureSize), 0.0f);
    return filled;
}

} // namespace halflight
