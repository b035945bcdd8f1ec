#pragma once
// The rays of the radiosity passes on a device.

#include "transport/radiosity/lobe_moments.h"
#include "transport/radiosity/patch_pass.h"

#include <functional>
#include <span>
#include <vector>

namespace halflight {

/// Traces and uses the rays of OccluderSearch and FormFactorSampler, with their random numbers. Light is estimated as
/// one: there are no components. One thread calls it.
class DeviceRadiosity {
public:
    virtual ~DeviceRadiosity() = default;

    static constexpr uint32_t kNearBit = 1u << 31;       ///< a ray is short: both of its ends are hit from near
    static constexpr uint32_t kLeaves = kMaxPatches + 1; ///< it hits nothing
    static constexpr uint32_t kOpen = kMaxPatches + 2;   ///< it hits no patch: its light is that of a path

    /// A ray of a form factor.
    struct FactorRay {
        PatchId source = kNoPatch; ///< where it starts; kNoPatch: there is no ray
        uint32_t target = kOpen;   ///< a patch, and perhaps kNearBit; kLeaves; or kOpen
        vec3 gathered{0.0f};       ///< radiance of the sky, or of the emitter that it hits, times the ray's tint
    };

    /// A sample of the lights at a point of a patch.
    struct DirectSample {
        PatchId source = kNoPatch; ///< kNoPatch: there is no sample
        float minDistance = 0.0f;  ///< as PatchRadiance::minDistance
        vec3 irradiance{0.0f};     ///< lux
        vec3 albedo{0.0f};         ///< of the diffuse part
        LobeMoments lobes;         ///< of the specular part; zero where bounces are diffuse
    };

    /// Items of one call: whole ranges of kRangeItems, but for the last one.
    static constexpr std::size_t kMostItems = 256 * kRangeItems;

    /// Takes the pass of the calls that follow: its patches as they are now. It outlives them.
    virtual Status begin(const PatchPass& pass) = 0;
    /// Appends the patches and elements of the items that an occluder crosses to `found`, in ascending order.
    virtual Status findOccluded(std::span<const uint32_t> items, std::vector<PatchId>& found, uint64_t& rays) = 0;
    /// What a call has traced. Ray n (of effortOf(pass)) of item i is at [i * rays + n], in the order of blocks and of
    /// shading::factorStratum(); light sample n is at [i * direct + n].
    struct Traced {
        std::span<const FactorRay> rays;
        std::span<const vec3> tints; ///< RayHit::tint of the rays; empty where no glass has a colour
        std::span<const DirectSample> direct;
    };
    using Use = std::function<void(const Traced& traced)>;
    /// Traces all rays of items and calls use(), unless there is an error.
    virtual Status gather(std::span<const uint32_t> items, const Use& use, uint64_t& rays) = 0;
};

} // namespace halflight
