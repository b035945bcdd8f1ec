#include "bake_gpu/texel_lists.h"

#include "gpu/compute.h"
#include "transport/texels/texel_points.h"

#include <cstring>

namespace halflight {

using shading::GpuFragment;
using shading::GpuMapTexel;

static_assert(uint32_t(TexelSide::FrontOfBoth) == shading::kFrontOfBoth);
static_assert(uint32_t(TexelSide::Mean) == shading::kMeanTexel);

/// There are fragments for two of each texel. More take a larger buffer.
TexelLists::TexelLists(gpu::Device& device, const BakeGeometry& geometry, std::size_t mostTexels,
                       std::span<const uint32_t> hitIndexOfTriangle)
    : device_(device), geometry_(geometry), hitIndexOfTriangle_(hitIndexOfTriangle),
      texels_(device, mostTexels * sizeof(GpuMapTexel), gpu::kAddressed, gpu::MemoryUse::Upload),
      fragments_(device, 2 * mostTexels * sizeof(GpuFragment), gpu::kAddressed, gpu::MemoryUse::Upload)
{}

void TexelLists::growTo(std::size_t fragments)
{
    const std::size_t bytes = fragments * sizeof(GpuFragment);
    if (bytes > fragments_.size()) fragments_ = {device_, bytes, gpu::kAddressed, gpu::MemoryUse::Upload};
}

void TexelLists::set(const Copy& copy)
{
    growTo(copy.fragments.size());
    std::memcpy(texels_.mapped(), copy.texels.data(), copy.texels.size() * sizeof(GpuMapTexel));
    std::memcpy(fragments_.mapped(), copy.fragments.data(), copy.fragments.size() * sizeof(GpuFragment));
}

GpuMapTexel TexelLists::put(const TexelMap& map, const Texel& texel, uint32_t first, GpuFragment* to) const
{
    for (uint32_t f = 0; f < texel.fragmentCount; ++f)
        to[first + f] = fragmentOf(map.fragments[texel.firstFragment + f]);
    return {texelId(map, texel), uint32_t(texel.x) | uint32_t(texel.y) << 16, first, texel.fragmentCount,
            texel.validPoints};
}

GpuFragment TexelLists::fragmentOf(const TexelFragment& fragment) const
{
    const BakeGeometry::Part& part = geometry_.partOf(fragment.triangle);
    return {part.firstStored + (fragment.triangle - part.firstTriangle),
            part.instance == BakeGeometry::kOwn ? shading::kNone : part.instance,
            uint32_t(geometry_.texelSideOf(fragment.triangle)) | (part.receiveShadows ? shading::kReceivesShadows : 0u),
            hitIndexOfTriangle_.empty() ? shading::kNone : hitIndexOfTriangle_[fragment.triangle],
            fragment.barycentric,
            fragment.area};
}

} // namespace halflight
