#pragma once
// The final gather of many texels at once, on a device.

#include "transport/guiding/guides.h"
#include "transport/radiosity/radiance_cache.h"
#include "transport/random/stratified_pattern.h"

#include <algorithm>
#include <array>
#include <span>

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

/// Traces gather rays with their continuation paths, and rays to secondary sources, emitters and the sky's bright part,
/// as FinalGather does. Lists of components are empty where light is estimated as one.
class DeviceGather {
public:
    virtual ~DeviceGather() = default;

    struct Texel {
        uint32_t texel = 0;      ///< of the map
        uint32_t firstBlock = 0; ///< index into the list of blocks
        uint32_t blockCount = 0; ///< 0: the texel is not valid
        vec3 gathered{0.0f};     ///< sum of what it has gathered before: TexelEstimate::gathered
        uint32_t halfBlocks = 0; ///< terms of that sum
    };
    /// A block of 16 samples. The blocks of a texel follow one another.
    struct Block {
        uint32_t texel = 0; ///< index into a list of texels
        uint32_t number = 0;
    };
    /// Sums over a block, in the halves of BlockSums.
    struct Half {
        vec3 irradiance{0.0f};
        vec3 moment{0.0f};
    };
    using Halves = std::array<Half, 2>;
    struct Sums {
        Halves halves;
        float inverseSquares = 0.0f;
    };

    /// Most blocks of one call. Where there are components, their sums take 32 MiB at most.
    static constexpr std::size_t kMostBlocks = 65536;
    static constexpr std::size_t mostBlocks(std::size_t components)
    {
        constexpr std::size_t kMostBytes = std::size_t(32) << 20;
        return components == 0 ? kMostBlocks : std::min(kMostBlocks, kMostBytes / (components * sizeof(Halves)));
    }

    struct Batch {
        std::span<const Texel> texels;
        std::span<const Block> blocks;      ///< mostBlocks() of them, and of texels, at most
        std::span<const vec3> ofComponents; ///< by texel and component, as Texel::gathered
    };
    /// By block: `gathered` is what gather rays and samples of secondary sources bring, `emitted` those of emitters and
    /// the sky. It is empty where the scene has neither (SceneLight::samplesEmission()).
    struct Light {
        std::span<Sums> gathered;
        std::span<Halves> emitted;
        std::span<Halves> gatheredOf; ///< the same of components: by block, then by component
        std::span<Halves> emittedOf;
    };
    /// Any thread may call it.
    virtual Status gather(const TexelMap& map, const Batch& batch, const Light& out, uint64_t& rays) const = 0;
};

} // namespace halflight
