#pragma once
// The final gather of many texels at once, on a device.

#include "transport/guiding/guides.h"
#include "transport/radiosity/radiance_cache.h"
#include "transport/random/stratified_pattern.h"

#include <array>
#include <span>
#include <vector>

namespace halflight {

/// What the gather reads; all of it outlives the gather.
struct GatherTables {
    const PathTracer& paths;
    const StratifiedPattern& pattern;
    const RadianceCache& cache;
    const Guides& guides;
    uint32_t seed = 1;
    int bounces = kAllBounces;
};

/// Traces gather rays with their continuation paths, and rays to secondary sources, as FinalGather does. It leaves
/// emitters to the processor: samples of them, and what they send along rays that hit them.
class DeviceGather {
public:
    virtual ~DeviceGather() = default;

    struct Point {
        vec3 position{0.0f}; ///< origin of rays
        vec3 normal{0.0f};
        vec3 geometricNormal{0.0f};
    };
    struct Texel {
        uint32_t id = 0;         ///< texelId()
        uint32_t firstPoint = 0; ///< index into a list of points
        uint32_t pointCount = 0; ///< 1 … 16
        uint32_t guide = ~0u;    ///< index into Guides::guides(); ~0 = none
        uint32_t sources = 0;    ///< samples of secondary sources of a block
    };
    /// A block of 16 samples.
    struct Block {
        uint32_t texel = 0; ///< index into a list of texels
        uint32_t number = 0;
    };
    /// Sums over a block, in the halves of BlockSums.
    struct Half {
        vec3 irradiance{0.0f};
        vec3 moment{0.0f};
    };
    struct Sums {
        std::array<Half, 2> halves;
        float inverseSquares = 0.0f;
    };
    /// A ray that hits an emitter. What the surface reflects is in the sums, what it emits is not.
    struct EmitterHit {
        uint32_t block = 0; ///< index into the list of blocks
        uint32_t stratum = 0;
        FaceId face;
        vec2 barycentric{0.0f};
        float distance = 0.0f;
        vec3 direction{0.0f};
    };
    static_assert(sizeof(EmitterHit) == 36);

    /// Most blocks of one call.
    static constexpr std::size_t kMostBlocks = 65536;
    /// `emissive` gets the rays that hit emitters in the order of blocks and strata. Any thread may call it.
    virtual Status gather(std::span<const Texel> texels, std::span<const Point> points, std::span<const Block> blocks,
                          std::span<Sums> sums, std::vector<EmitterHit>& emissive, uint64_t& rays) const = 0;
};

} // namespace halflight
