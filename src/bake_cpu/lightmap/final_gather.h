#pragma once
// The lightmap's own rays: one per sample, ending in the radiance cache.

#include "bake_cpu/radiosity/radiance_cache.h"
#include "bake_cpu/texels/ray_bundle.h"
#include "bake_cpu/trace/lanes.h"

namespace halflight {

/// Running mean of one texel's samples, in halves of blocks: so that two tell of noise after one block.
struct TexelSum {
    vec3 sum{0.0f};       ///< of the halves' irradiance
    vec3 moment{0.0f};    ///< of their first moments
    float squares = 0.0f; ///< of the halves' differences from their mean, in luminance (Welford 1962)
    uint32_t halves = 0;

    void add(vec3 irradiance, vec3 firstMoment)
    {
        const float before = halves > 0 ? luminance(sum) / float(halves) : 0.0f;
        const float value = luminance(irradiance);
        sum += irradiance;
        moment += firstMoment;
        ++halves;
        squares += (value - before) * (value - luminance(sum) / float(halves));
    }
    [[nodiscard]] uint32_t blocks() const { return halves / 2; }
    [[nodiscard]] vec3 mean() const { return halves > 0 ? sum / float(halves) : vec3(0.0f); }
    [[nodiscard]] vec3 meanMoment() const { return halves > 0 ? moment / float(halves) : vec3(0.0f); }
    /// One that has the given means.
    static TexelSum of(vec3 mean, vec3 meanMoment, float varianceOfMean, uint32_t halves)
    {
        const auto n = float(halves);
        return {mean * n, meanMoment * n, varianceOfMean * n * (n - 1.0f), halves};
    }
    [[nodiscard]] float varianceOfMean() const
    {
        return halves > 1 ? std::max(squares, 0.0f) / (float(halves) * float(halves - 1)) : 0.0f;
    }
};

/// Running estimate of one texel.
struct TexelLight {
    TexelSum gathered;           ///< along rays spread over the hemisphere
    TexelSum emitted;            ///< from points sampled on emitters
    float inverseSquares = 0.0f; ///< of the distances of the rays' hits, summed: 1 / m^2
    BackFaceHits backFaces;

    [[nodiscard]] vec3 irradiance() const { return gathered.mean() + emitted.mean(); }
    /// On average.
    [[nodiscard]] float inverseSquaresOfRay() const
    {
        return inverseSquares / float(gathered.blocks() * uint32_t(StratifiedPattern::kBlock));
    }
};

class FinalGather {
public:
    /// `cache` null: no bounces, rays see emitters and sky alone.
    FinalGather(const PathTracer& paths, const StratifiedPattern& pattern, const RadianceCache* cache,
                const IntegrationSettings& settings)
        : paths_(paths), pattern_(pattern), cache_(cache), settings_(settings)
    {}

    /// Adds the given blocks of samples, 16 each, to the texels of the group. `lights` by lane.
    void add(const GatherGroup& group, int firstBlock, int blockCount, std::span<TexelLight> lights, uint64_t& rays);
    /// Samples emitters for texels that know already what they gather: as many blocks as that took.
    void addEmitters(const GatherGroup& group, std::span<TexelLight> lights, uint64_t& rays);

private:
    void beginBlock();
    void endBlock(int lane, TexelLight& light, TexelSum& sum);
    void cutEmitters(const GatherGroup& group);
    /// Decides how many of a block's samples look at bright cells.
    void prepareBright(const GatherGroup& group);
    [[nodiscard]] bool looksAtBright(std::size_t lane, int block, int cell) const
    {
        // A quarter or half of a block is one or two in each row and each column of the pattern.
        constexpr int kQuarter = StratifiedPattern::kBlock / 4;
        const int diagonal = ((cell >> 2) ^ cell ^ block) & 3;
        return brightSamples_[lane] == 4 * kQuarter || (brightSamples_[lane] == 2 * kQuarter && (diagonal & 1) == 0) ||
               (brightSamples_[lane] == kQuarter && diagonal == 0);
    }
    [[nodiscard]] float brightShare(std::size_t lane) const
    {
        return float(brightSamples_[lane]) / float(StratifiedPattern::kBlock);
    }
    /// What a ray that met a bright cell counts beside samples of it.
    [[nodiscard]] float brightWeight(int cell, int lane, uint32_t square) const;
    void sampleBright(const GatherGroup& group, int block, uint64_t& rays);
    /// Counts light from points that choose(cell, lanes) tells for the given cells, where nothing stands between.
    template<typename Choose> void countLights(std::span<const uint8_t> cells, const Choose& choose, uint64_t& rays);
    void countLights(std::size_t cell, const EmitterLanes& lanes, uint64_t& rays);
    void gatherBlock(const GatherGroup& group, int block, uint64_t& rays);
    /// From where the bundle's rays of the same block start.
    void sampleEmitters(const GatherGroup& group, int block, std::span<TexelLight> lights, uint64_t& rays);
    /// Place on a side of a triangle.
    struct SidePlace {
        uint32_t record = 0; ///< as RadianceCache::recordOf()
        vec2 barycentric{0.0f};
    };
    /// As RadianceCache::known() for many samples, in sweeps. knowing_ has the cells of their places; after it, what
    /// knows light from there over distanceOf(sample): them, parts of them, or RadianceCache::kNoCells.
    /// placeOf(sample): asked for parts.
    template<typename DistanceOf, typename PlaceOf>
    void findKnowing(std::span<const uint8_t> samples, const DistanceOf& distanceOf, const PlaceOf& placeOf);
    /// Who asks for the light that a ray brings.
    [[nodiscard]] Receiver receiverOf(const GatherGroup& group, int lane, int block, int cell) const
    {
        const GatherGroup::Origin& s = group.origin(lane, group.pointOf(lane, block, cell));
        return {s.position, s.normal, &cut_, std::size_t(lane)};
    }
    /// What the end of a ray emits, as it counts beside samples of emitters.
    [[nodiscard]] vec3 emission(const GatherGroup& group, int lane, int block, int cell) const;
    /// Counts a cell's ray that met a hidden back.
    void countBack(int lane, int cell, uint32_t triangle)
    {
        const uint8_t solid = paths_.surfaces().geometry().solid[triangle];
        backFaces_[std::size_t(lane)].add({1, solid, bundle_.rays[std::size_t(cell)].ray.tfar[lane]});
    }
    /// What a ray brings whose end has no cell, or is too close by for it.
    vec3 slowRadiance(const GatherGroup& group, int lane, int block, int cell, uint64_t& rays);
    /// Counts light that arrives along the rays of a packet.
    void count(std::size_t cell, const Vec3Lanes<TexelGroup::kLanes>& irradiance, const RTCRay8& rays)
    {
        Half& half = halves_[halfOf(cell)];
        for (std::size_t lane = 0; lane < TexelGroup::kLanes; ++lane) {
            half.irradiance.x[lane] += irradiance.x[lane];
            half.irradiance.y[lane] += irradiance.y[lane];
            half.irradiance.z[lane] += irradiance.z[lane];
            const float l = luminance(irradiance[lane]);
            half.moment.x[lane] += l * rays.dir_x[lane];
            half.moment.y[lane] += l * rays.dir_y[lane];
            half.moment.z[lane] += l * rays.dir_z[lane];
        }
    }
    /// Each half has two cells of each row and each column of the pattern, and half of those that look at bright cells.
    static std::size_t halfOf(std::size_t cell) { return ((cell >> 2) ^ (cell >> 1)) & 1u; }

    /// Samples of a block are numbered by cell, then lane.
    static constexpr std::size_t kSamples = std::size_t(StratifiedPattern::kBlock) * TexelGroup::kLanes;
    class SampleList {
    public:
        void add(std::size_t sample) { list_[count_++] = uint8_t(sample); }
        void addIf(bool wanted, std::size_t sample) ///< without a branch that nobody could foretell
        {
            list_[count_] = uint8_t(sample);
            count_ += wanted ? 1 : 0;
        }
        [[nodiscard]] std::span<const uint8_t> samples() const { return {list_.data(), count_}; }

    private:
        std::array<uint8_t, kSamples + 1> list_;
        std::size_t count_ = 0;
    };
    static std::size_t sampleOf(int cell, int lane) { return std::size_t(cell * TexelGroup::kLanes + lane); }
    static std::size_t cellOf(std::size_t sample) { return sample / TexelGroup::kLanes; }
    static int laneOf(std::size_t sample) { return int(sample % TexelGroup::kLanes); }
    [[nodiscard]] const RTCRayHit8& packetOf(std::size_t sample) const { return bundle_.rays[cellOf(sample)]; }

    const PathTracer& paths_;
    const StratifiedPattern& pattern_;
    const RadianceCache* cache_;
    const IntegrationSettings& settings_;
    RayBundle bundle_;
    /// Of a block, summed over its samples.
    struct Half {
        Vec3Lanes<TexelGroup::kLanes> irradiance;
        Vec3Lanes<TexelGroup::kLanes> moment;
    };
    std::array<Half, 2> halves_;
    std::array<float, TexelGroup::kLanes> inverseSquares_;
    std::array<BackFaceHits, TexelGroup::kLanes> backFaces_;
    LightTree::Cut cut_;                                        ///< of the group's texels
    std::array<BrightCells::Guide, TexelGroup::kLanes> guides_; ///< to bright cells
    std::array<int, TexelGroup::kLanes> brightSamples_{};       ///< of a block, for each texel
    std::array<uint32_t, kSamples> knowing_;                    ///< of a block's samples
    std::array<BrightCells::Choice, kSamples> choices_;         ///< of a block's samples: for cells in use
    std::array<BrightCells::Place, kSamples> places_;
};

} // namespace halflight
