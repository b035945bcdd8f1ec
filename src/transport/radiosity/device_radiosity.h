#pragma once
// The rays of the radiosity passes on a device.

#include "transport/radiosity/lobe_moments.h"
#include "transport/radiosity/patch_pass.h"

#include <span>
#include <vector>

namespace halflight {

/// Traces and uses the rays of OccluderSearch and FormFactorSampler, with their random numbers. One thread calls it.
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
        vec3 gathered{0.0f}; ///< radiance of the emitter that it hits, or of the sky, before its tint; where parts of
                             ///< the sky are of different components, the shares of its zenith, horizon and ground
    };

    /// A sample of the lights at a point of a patch.
    struct DirectSample {
        PatchId source = kNoPatch; ///< kNoPatch: there is no sample
        float minDistance = 0.0f;  ///< as PatchRadiance::minDistance
        vec3 irradiance{0.0f};     ///< lux
        vec3 albedo{0.0f};         ///< of the diffuse part
        LobeMoments lobes;         ///< of the specular part; zero where bounces are diffuse
    };

    /// What one light of a sample brings, where there are components.
    struct LightPart {
        uint32_t component = 0;
        vec3 irradiance{0.0f}; ///< lux
        // Of LobeMoments:
        vec3 exitance{0.0f};
        float sampledExitance = 0.0f;
        vec3 sampledMoment{0.0f};
    };
    /// Parts of a sample: of a light of each component that has some, of an emitter and of the sky.
    static std::size_t partsOf(const SceneLight& light) { return light.components() > 0 ? light.choosers() + 2 : 0; }

    /// Items of one call: whole ranges of kRangeItems, but for the last one.
    static constexpr std::size_t kMostItems = 256 * kRangeItems;
    /// Items of a call of gather() for the pass of begin(): fewer where parts take memory.
    [[nodiscard]] virtual std::size_t mostItems() const = 0;

    /// Takes the pass of the calls that follow: its patches as they are now. It outlives them.
    virtual Status begin(const PatchPass& pass) = 0;
    /// Appends the patches and elements of the items that an occluder crosses to `found`, in ascending order.
    virtual Status findOccluded(std::span<const uint32_t> items, std::vector<PatchId>& found, uint64_t& rays) = 0;
    /// What a call has traced. Ray n (of effortOf(pass)) of item i is at [i * rays + n], in the order of blocks and of
    /// shading::factorStratum(); light sample n is at [i * direct + n].
    struct Traced {
        std::span<const FactorRay> rays;
        std::span<const DirectSample> direct;
        std::span<const vec3> tints; ///< RayHit::tint of the rays; empty where no glass has a colour
        // Where there are components; else empty.
        std::span<const uint32_t> emitters; ///< by ray: component of the emitter that it hits
        std::span<const LightPart> parts;   ///< by light sample, then partsOf() of them
    };
    /// Traces all rays of items. `traced` lasts until the call after the next one, so that it is used while that
    /// traces.
    virtual Status gather(std::span<const uint32_t> items, Traced& traced, uint64_t& rays) = 0;
};

} // namespace halflight
