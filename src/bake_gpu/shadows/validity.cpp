#include "bake_gpu/shadows/validity.h"

#include "bake_gpu/shadows/validity_layout.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace halflight {
namespace {

static_assert(sizeof(DeviceValidity::Texel) == sizeof(shading::GpuValidityTexel));
static_assert(sizeof(DeviceValidity::Point) == sizeof(shading::GpuValidityPoint));

/// Lists in shaders/bake/validity.rgen.
struct ValidityLists {
    VkDeviceAddress texels, masks, counts;
    uint32_t anySolid;
};

} // namespace

GpuValidity::GpuValidity(BakeDevice& device, const DeviceScene& scene, bool anySolid)
    : device_(device), scene_(scene), anySolid_(anySolid),
      texels_(device.device(), kMostTexels * sizeof(Texel), gpu::kAddressed, gpu::MemoryUse::Upload),
      masks_(device.device(), kMostTexels * sizeof(uint32_t), gpu::kAddressed, gpu::MemoryUse::Readback),
      counts_(device.device(), sizeof(uint32_t), gpu::kAddressed, gpu::MemoryUse::Readback),
      lists_(device.device(), sizeof(ValidityLists), gpu::kAddressed, gpu::MemoryUse::Upload)
{}

Status GpuValidity::validPoints(std::span<const Texel> texels, std::span<PointMask> masks, uint64_t& rays) const
{
    try {
        for (std::size_t first = 0; first < texels.size(); first += kMostTexels) {
            const std::size_t count = std::min(texels.size() - first, kMostTexels);
            testSome(texels.subspan(first, count), masks.subspan(first, count), rays);
        }
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    return {};
}

void GpuValidity::testSome(std::span<const Texel> texels, std::span<PointMask> masks, uint64_t& rays) const
{
    std::memcpy(texels_.mapped(), texels.data(), texels.size_bytes());
    std::memset(counts_.mapped(), 0, counts_.size());
    const ValidityLists lists{texels_.address(), masks_.address(), counts_.address(), anySolid_ ? 1u : 0u};
    std::memcpy(lists_.mapped(), &lists, sizeof(lists));
    device_.device().execute([&](VkCommandBuffer commands) {
        device_.validity(commands, {scene_.address(), 0, lists_.address()}, uint32_t(texels.size()));
        gpu::fullBarrier(device_.device(), commands);
    });
    const auto* const found = reinterpret_cast<const uint32_t*>(masks_.mapped());
    for (std::size_t i = 0; i < masks.size(); ++i) masks[i] = PointMask(found[i]);
    uint32_t traced = 0;
    std::memcpy(&traced, counts_.mapped(), sizeof(traced));
    rays += traced;
}

} // namespace halflight
