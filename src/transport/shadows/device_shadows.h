#pragma once
// Shadow rays of many texels at once, on a device.

#include "transport/shadows/shadow_rays.h"

#include "halflight/base/result.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace halflight {

/// What shadow rays read; all of it outlives them.
struct ShadowTables {
    const RayTracer& surfaces;
    std::span<const PunctualLight> lights; ///< of the scene; sources point to them
    const StratifiedPattern& pattern;
};

/// Traces half-batches as ShadowRays does, with the terminator's second rays, and adds them up.
class DeviceShadows {
public:
    virtual ~DeviceShadows() = default;

    /// A half-batch of rays from a texel to the lights of a source.
    struct Item {
        uint32_t texel = 0;   ///< index into a list of texels
        uint32_t half = 0;    ///< number of the half-batch
        PointMask points = 0; ///< those that rays start from; kAllPoints takes another batch for each two half-batches
        uint16_t source = 0;  ///< index into a list of sources
    };
    static_assert(sizeof(Item) == 12);

    /// Items that a device traces in one submission: a million rays.
    static constexpr std::size_t kItemsAtOnce = std::size_t(1) << 17;
    /// Items in the order of `texels`, which are indices into TexelMap::texels.
    struct Batch {
        std::span<const ShadowSource> sources;
        std::span<const uint32_t> texels;
        std::span<const Item> items;
    };
    /// Sums of any number of items. Any thread may call it. `colors`: ShadowRays::Sums::colors by item, or empty; they
    /// are asked for only where glass has a colour. `rays` are counted.
    virtual Status trace(const TexelMap& map, const Batch& batch, std::span<LitSum> sums, std::span<vec3> colors,
                         uint64_t& rays) const = 0;
};

} // namespace halflight
