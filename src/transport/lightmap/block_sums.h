#pragma once
// Sums over the samples of one block of eight texels, and the estimates of texels that they are added to.

#include "transport/lightmap/device_gather.h"
#include "transport/sample/path_light.h"
#include "transport/texels/ray_bundle.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <span>
#include <vector>

namespace halflight {

/// Estimate of one texel. Its samples are half-blocks, so that one block has a variance.
struct TexelEstimate {
    RunningMoments gathered;     ///< along gather rays and from secondary sources
    RunningMoments emitted;      ///< from emitters
    float inverseSquares = 0.0f; ///< sum over the gather rays of 1 / length^2, in 1 / m^2

    [[nodiscard]] uint32_t blocks() const { return gathered.count / 2; }
    [[nodiscard]] vec3 irradiance() const { return gathered.mean() + emitted.mean(); }
    [[nodiscard]] float meanInverseSquare() const
    {
        return inverseSquares / float(blocks() * uint32_t(StratifiedPattern::kBlock));
    }
};

/// Samples of a block, numbered by stratum, then lane.
constexpr std::size_t kBlockSamples = std::size_t(StratifiedPattern::kBlock) * kLanes;
inline std::size_t sampleOf(int stratum, int lane)
{
    return std::size_t(stratum * kLanes + lane);
}
inline std::size_t stratumOf(std::size_t sample)
{
    return sample / kLanes;
}
inline int laneOf(std::size_t sample)
{
    return int(sample % kLanes);
}

class SampleList {
public:
    void add(std::size_t sample) { list_[count_++] = uint8_t(sample); }
    [[nodiscard]] std::span<const uint8_t> samples() const { return {list_.data(), count_}; }

private:
    std::array<uint8_t, kBlockSamples> list_;
    std::size_t count_ = 0;
};

/// Sums of a block in two halves. Each half has two strata of each row and column of the pattern.
class BlockSums {
public:
    void begin()
    {
        halves_ = {};
        inverseSquares_.fill(0.0f);
    }
    /// Adds light that arrives along the rays of a stratum.
    void add(std::size_t stratum, const Vec3Lanes& irradiance, std::span<const Ray, kLanes> rays)
    {
        Half& half = halves_[halfOf(stratum)];
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            half.irradiance.x[lane] += irradiance.x[lane];
            half.irradiance.y[lane] += irradiance.y[lane];
            half.irradiance.z[lane] += irradiance.z[lane];
            const float l = luminance(irradiance[lane]);
            half.moment.x[lane] += l * rays[lane].direction.x;
            half.moment.y[lane] += l * rays[lane].direction.y;
            half.moment.z[lane] += l * rays[lane].direction.z;
        }
    }
    /// Infinite for rays without a hit.
    void addDistance(std::size_t lane, float distance) { inverseSquares_[lane] += 1.0f / (distance * distance); }
    /// Adds a lane's sums to its texel; `moments` is one of the estimate's.
    void end(int lane, TexelEstimate& estimate, RunningMoments& moments) const
    {
        const auto l = std::size_t(lane);
        const auto half = [&](std::size_t h) {
            return DeviceGather::Half{halves_[h].irradiance[l], halves_[h].moment[l]};
        };
        end({{half(0), half(1)}, inverseSquares_[l]}, estimate, moments);
    }
    static void end(const DeviceGather::Sums& sums, TexelEstimate& estimate, RunningMoments& moments)
    {
        constexpr float kShare = 2.0f / float(StratifiedPattern::kBlock);
        for (const DeviceGather::Half& half : sums.halves) {
            // Lights of extreme size or intensity may overflow.
            const vec3 irradiance = half.irradiance * kShare;
            const vec3 moment = half.moment * kShare;
            const bool finite = isFinite(irradiance) && isFinite(moment);
            moments.add(finite ? irradiance : vec3(0.0f), finite ? moment : vec3(0.0f));
        }
        estimate.inverseSquares += sums.inverseSquares;
    }

    static std::size_t halfOf(std::size_t stratum) { return shading::patternHalf(uint32_t(stratum)); }

private:
    struct Half {
        Vec3Lanes irradiance;
        Vec3Lanes moment;
    };

    std::array<Half, 2> halves_;
    std::array<float, kLanes> inverseSquares_;
};

/// The sums of components, in the halves of BlockSums. Estimates of a lane's components follow one another.
class ComponentSums {
public:
    explicit ComponentSums(int components)
        : count_(std::size_t(components)), sums_(std::size_t(kLanes) * std::size_t(components))
    {}
    [[nodiscard]] int count() const { return int(count_); }
    void begin() { std::fill(sums_.begin(), sums_.end(), DeviceGather::Halves{}); }
    void add(std::size_t stratum, std::size_t lane, int component, vec3 irradiance, vec3 direction)
    {
        if (irradiance == vec3(0.0f)) return;
        DeviceGather::Half& sum = sums_[lane * count_ + std::size_t(component)][BlockSums::halfOf(stratum)];
        sum.irradiance += irradiance;
        sum.moment += luminance(irradiance) * direction;
    }
    /// Adds a lane's sums to its texel: to the term `moments` of its components. Those of a half-block that is not
    /// finite are left out together.
    void end(std::size_t lane, std::span<ComponentEstimate> estimates, RunningMoments ComponentEstimate::*moments) const
    {
        end(std::span(sums_).subspan(lane * count_, count_), estimates.subspan(lane * count_, count_), moments);
    }
    /// The same of a texel's components.
    static void end(std::span<const DeviceGather::Halves> sums, std::span<ComponentEstimate> estimates,
                    RunningMoments ComponentEstimate::*moments)
    {
        constexpr float kShare = 2.0f / float(StratifiedPattern::kBlock);
        for (std::size_t half = 0; half < 2; ++half) {
            const bool finite = std::all_of(sums.begin(), sums.end(), [half](const DeviceGather::Halves& sum) {
                return isFinite(sum[half].irradiance * kShare) && isFinite(sum[half].moment * kShare);
            });
            for (std::size_t c = 0; c < sums.size(); ++c)
                (estimates[c].*moments)
                    .add(finite ? sums[c][half].irradiance * kShare : vec3(0.0f),
                         finite ? sums[c][half].moment * kShare : vec3(0.0f));
        }
    }

private:
    std::size_t count_;
    std::vector<DeviceGather::Halves> sums_; ///< by lane and component
};

} // namespace halflight
