#pragma once
// Texels of a call and what they lie on, where a device reads them (TexelData in shaders/bake/texels.glsl).

#include "bake_gpu/shadows/texel_layout.h"
#include "gpu/resources.h"

#include "halflight/bake/integrator.h"
#include "halflight/base/parallel.h"

#include <span>
#include <vector>

namespace halflight {

class TexelLists {
public:
    /// For up to `mostTexels`; `geometry` outlives it. `hitIndexOfTriangle`: as PatchLayout has it; empty: no shader
    /// asks for hit indices. Throws gpu::Failure.
    TexelLists(gpu::Device& device, const BakeGeometry& geometry, std::size_t mostTexels,
               std::span<const uint32_t> hitIndexOfTriangle = {});

    /// Writes texels and their fragments, on all threads: `texelAt(i)` is a number among the map's. Throws
    /// gpu::Failure.
    template<typename TexelAt> void set(const TexelMap& map, std::size_t count, const TexelAt& texelAt)
    {
        const std::vector<uint32_t> firsts = firstFragments(map, count, texelAt);
        growTo(firsts.back());
        auto* const texels = reinterpret_cast<shading::GpuMapTexel*>(texels_.mapped());
        auto* const fragments = reinterpret_cast<shading::GpuFragment*>(fragments_.mapped());
        forEachIndex(count, [&](std::size_t i) { texels[i] = put(map, map.texels[texelAt(i)], firsts[i], fragments); });
    }

    /// The same in two steps, for many threads that take turns with the device: only the copy has to wait.
    struct Copy {
        std::vector<shading::GpuMapTexel> texels;
        std::vector<shading::GpuFragment> fragments;
    };
    template<typename TexelAt> Copy copyOf(const TexelMap& map, std::size_t count, const TexelAt& texelAt) const
    {
        const std::vector<uint32_t> firsts = firstFragments(map, count, texelAt);
        Copy copy;
        copy.texels.resize(count);
        copy.fragments.resize(firsts.back());
        forEachIndex(count, [&](std::size_t i) {
            copy.texels[i] = put(map, map.texels[texelAt(i)], firsts[i], copy.fragments.data());
        });
        return copy;
    }
    void set(const Copy& copy);

    [[nodiscard]] VkDeviceAddress texels() const { return texels_.address(); }
    [[nodiscard]] VkDeviceAddress fragments() const { return fragments_.address(); }

private:
    template<typename TexelAt>
    static std::vector<uint32_t> firstFragments(const TexelMap& map, std::size_t count, const TexelAt& texelAt)
    {
        std::vector<uint32_t> firsts(count + 1);
        for (std::size_t i = 0; i < count; ++i) firsts[i + 1] = firsts[i] + map.texels[texelAt(i)].fragmentCount;
        return firsts;
    }
    void growTo(std::size_t fragments);
    /// Writes a texel's fragments, of which `first` is the first one's number.
    shading::GpuMapTexel put(const TexelMap& map, const Texel& texel, uint32_t first, shading::GpuFragment* to) const;
    [[nodiscard]] shading::GpuFragment fragmentOf(const TexelFragment& fragment) const;

    gpu::Device& device_;
    const BakeGeometry& geometry_;
    std::span<const uint32_t> hitIndexOfTriangle_;
    gpu::Buffer texels_;
    gpu::Buffer fragments_;
};

} // namespace halflight
