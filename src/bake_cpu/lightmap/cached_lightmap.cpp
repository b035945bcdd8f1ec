#include "bake_cpu/lightmap/cached_lightmap.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace halflight {
namespace {

/// Blocks that all traced texels get where there is a noise target, and around how many texels of theirs the noise is
/// estimated: 5 x 5.
constexpr int kFirstBlocks = 2;
constexpr int kNoiseRadius = 2;

/// Without a noise target, texels want as many times the samples, within these bounds, as the standard deviation of
/// half a block is of this share of the light, and get what they want times a factor that makes all of a map's samples
/// as many as asked for: samples in proportion to it leave the least noise altogether (Neyman 1934, "On the Two
/// Different Aspects of the Representative Method"). The light is the geometric mean of that around the texel, counted
/// once, and that of the map, counted three times: noise in dark places shows less than its share of their light, but
/// more than its share of all.
constexpr float kFewestTimes = 0.5f;
constexpr float kMostTimes = 32.0f;
constexpr float kNoise = 0.15f;

/// What the denoiser leaves of the noise is a share of about (w / d)^(2/3) where texels are w wide and their rays end d
/// away: from a twentieth at w / d = 0.02 to nearly all from 2 on, in the scenes of `bench_bake error`. Samples are in
/// proportion to the root of that, too: so many times as many where w is d, and at most.
constexpr float kDetail = 1.4f;
constexpr float kMostForDetail = 2.0f;

/// A texel with fewer others than this around it on its chart, in 5 x 5, has nobody to share its noise with: it gets at
/// least twice the samples, or four times where there are fewer than half of these.
constexpr int kFewAround = 12;

/// From so many texels on, in the open, one in four has rays enough for all.
constexpr std::size_t kManyTexels = 400'000;

/// That factor follows from the wishes of all texels, or, in maps of more than this, of so many runs of so many texels
/// that lie side by side, spread evenly over the map. It is rounded to a 16th of a power of two: so small changes
/// somewhere are none elsewhere.
constexpr std::size_t kMostLookedAt = 65'536;
constexpr std::size_t kRuns = 512;
constexpr std::size_t kTexelsOfRun = 64;
constexpr float kShareSteps = 16.0f;

/// A texel may lie between others whose distance, squared, times the mean of the inverse squared distances of what
/// their rays hit is at most this: how much the light could bend between them.
constexpr float kMostBend = 0.03f;

} // namespace

int texelStepOf(const IntegrationSettings& settings, const TexelMap& map)
{
    if (settings.texelStep > 0) return settings.texelStep;
    return map.texels.size() > kManyTexels ? 2 : 1;
}

class CachedLightmap::Run {
public:
    /// `share`: what texels' wishes are multiplied with; 0: all get the same.
    Run(const CachedLightmap& lightmap, const TexelMap& map, std::span<const uint32_t> texels, int samples, float share,
        const Progress& progress, std::atomic<uint64_t>& rays)
        : lightmap_(lightmap), map_(map), blocks_(float(samples) / float(StratifiedPattern::kBlock)), share_(share),
          progress_(progress), rays_(rays), adaptive_(lightmap.settings_.noiseTarget > 0.0f),
          lattice_(lightmap.paths_.surfaces().geometry(), map, lightmap.state_->grid,
                   texelStepOf(lightmap.settings_, map)),
          set_(map, texels)
    {
        // What a texel may lie between, and what these may lie between.
        const auto neighbours = [&](uint32_t texel, const auto& add) { lattice_.forNeighbours(texel, add); };
        const auto addNeighbours = [&] {
            for (int step = lattice_.step(); step > 1; step /= 2) set_.extend(neighbours);
        };
        addNeighbours();
        wanted_.emplace(set_);
        set_.extend([&](uint32_t texel, const auto& add) { lightmap.state_->grid.around(texel, kNoiseRadius, add); });
        addNeighbours();
        known_.resize(set_.size());
    }

    bool work() { return gatherFirst() && gatherMore() && finishBetween(); }
    bool lookFirst() { return gatherFirst(); }
    [[nodiscard]] FirstLook takeFirstLook() { return {std::move(set_), std::move(known_)}; }

    /// After the first look: the factor with which texels come to the samples asked for, on average over those that
    /// are traced.
    [[nodiscard]] float findShare() const
    {
        std::vector<float> wishes(set_.size(), 0.0f);
        parallelFor(set_.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (isTraced(i) && wanted_->contains(set_[i])) wishes[i] = timesWanted(set_[i]);
            }
        });
        std::erase(wishes, 0.0f);
        if (wishes.empty()) return 1.0f;
        const auto mean = [&](float share) {
            double sum = 0.0;
            for (const float wish : wishes) sum += double(blocksOf(share * wish)) / double(wishes.size());
            return sum;
        };
        // Between a first look for all and the most for all, there is one.
        float low = -kMostSteps;
        float high = kMostSteps;
        while (high - low > 1.0f) {
            const float middle = std::floor(0.5f * (low + high));
            (mean(std::exp2(middle / kShareSteps)) < double(blocks_) ? low : high) = middle;
        }
        const auto off = [&](float steps) { return std::abs(mean(std::exp2(steps / kShareSteps)) - double(blocks_)); };
        return std::exp2((off(low) <= off(high) ? low : high) / kShareSteps);
    }

    [[nodiscard]] IrradianceEstimate estimateOf(uint32_t texel) const
    {
        const Known& k = known_[set_.find(texel)];
        IrradianceEstimate estimate;
        estimate.valid = k.active;
        estimate.outsidePoints = k.mask;
        if (!k.active) return estimate;
        estimate.irradiance = k.light.irradiance();
        estimate.moment = k.light.gathered.meanMoment() + k.light.emitted.meanMoment();
        estimate.varianceOfMean = k.light.gathered.varianceOfMean() + k.light.emitted.varianceOfMean();
        estimate.samples = k.between ? 0 : k.light.gathered.blocks() * uint32_t(StratifiedPattern::kBlock);
        return estimate;
    }

private:
    static constexpr float kMostSteps = 10.0f * kShareSteps; ///< a factor of 1024 either way

    [[nodiscard]] bool isTraced(std::size_t place) const { return known_[place].active && !known_[place].between; }
    [[nodiscard]] PointMask outside(uint32_t texel) const { return lightmap_.state_->outside.masks[texel]; }
    [[nodiscard]] FinalGather makeGather() const
    {
        return {lightmap_.paths_, lightmap_.pattern_, lightmap_.cache(), lightmap_.settings_};
    }

    /// First samples, level by level: where those of the levels before tell that light hardly changes, a texel goes
    /// between.
    bool gatherFirst()
    {
        std::vector<uint32_t> places;
        for (int spacing = lattice_.step(); spacing >= 1; spacing /= 2) {
            places.clear();
            for (std::size_t i = 0; i < set_.size(); ++i) {
                if (lattice_.spacingOf(set_[i]) == spacing) places.push_back(uint32_t(i));
            }
            parallelFor(places.size(), 256, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) goBetween(places[i]);
            });
            std::erase_if(places, [&](uint32_t place) { return known_[place].between || isLookedAt(place); });
            const bool done = forTexelGroups<GatherGroup>(
                lightmap_.paths_, map_, places.size(), [&](std::size_t i) { return set_[places[i]]; },
                [&](std::size_t i) { return outside(set_[places[i]]); }, progress_, "lightmap", rays_,
                [&] {
                    return
                        [&, gather = makeGather()](const GatherGroup& group, std::size_t i, uint64_t& traced) mutable {
                            std::array<Known*, TexelGroup::kLanes> known{};
                            for (int lane = 0; lane < group.lanes(); ++lane)
                                known[std::size_t(lane)] = &known_[places[i + std::size_t(lane)]];
                            gatherChecked(group, gather, known.data(), traced);
                        };
                });
            if (!done) return false;
        }
        return true;
    }

    /// Takes a texel's first samples from findShare()'s look, where that had it.
    bool isLookedAt(uint32_t place)
    {
        const std::optional<FirstLook>& looked = lightmap_.state_->looked;
        if (!looked || share_ <= 0.0f || !looked->texels.contains(set_[place])) return false;
        known_[place] = looked->known[looked->texels.find(set_[place])];
        return true;
    }

    /// The first samples of a group. Where rays met the inside of surfaces, the texel's points are looked at one by
    /// one.
    void gatherChecked(const GatherGroup& group, FinalGather& gather, Known* const* known, uint64_t& rays) const
    {
        std::array<TexelLight, TexelGroup::kLanes> lights;
        gather.add(group, 0, firstBlocks(), lights, rays);
        for (int lane = 0; lane < group.lanes(); ++lane) {
            const TexelLight& light = lights[std::size_t(lane)];
            if (group.active(lane) && lightmap_.state_->outside.known[group.texel(lane)] == 0 &&
                group.mask(lane) == kAllPoints && light.backFaces.hidden > 0) {
                // As many rays have left all of its points.
                const TexelValidity::Met met{int(light.gathered.blocks()) * StratifiedPattern::kBlock, light.backFaces,
                                             0, lightmap_.state_->outside.together[group.texel(lane)] != 0};
                const PointMask mask =
                    lightmap_.validity_.outside(group.points(lane), group.pointCount(lane), met, group.id(lane), rays);
                if (mask != kAllPoints) {
                    const uint32_t texel = group.texel(lane);
                    gatherChecked(GatherGroup(lightmap_.paths_, map_, std::span(&texel, 1), std::span(&mask, 1)),
                                  gather, known + lane, rays);
                    continue;
                }
            }
            *known[lane] = {light, group.mask(lane), group.active(lane), false};
        }
    }

    /// More samples for texels whose noise is above the target; without one, the more the more noise they have, and for
    /// those with few texels around them.
    bool gatherMore()
    {
        std::vector<int> needed(set_.size());
        parallelFor(set_.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (isTraced(i) && wanted_->contains(set_[i]))
                    needed[i] = adaptive_ ? blocksNeeded(set_[i]) : blocksGiven(set_[i]);
            }
        });
        // Texels with about as many samples to come go on together, in the same steps whichever texels there are.
        std::vector<uint32_t> places;
        const int first = firstBlocks();
        const int most = *std::max_element(needed.begin(), needed.end());
        for (int done = first; done < most;) {
            const int next = nextStep(done);
            places.clear();
            for (std::size_t i = 0; i < set_.size(); ++i) {
                if (needed[i] > done && needed[i] <= next) places.push_back(uint32_t(i));
            }
            done = next;
            const auto more = [&](FinalGather& gather, const GatherGroup& group, std::span<TexelLight> lights,
                                  uint64_t& rays) { gather.add(group, first, next - first, lights, rays); };
            if (!addTo(places, more)) return false;
        }
        return true;
    }

    [[nodiscard]] int firstBlocks() const
    {
        const int fewest = std::max(1, int(std::lround(kFewestTimes * blocks_)));
        return adaptive_ ? std::min(fewest, kFirstBlocks) : fewest;
    }
    [[nodiscard]] int mostBlocks() const { return int(std::ceil(adaptive_ ? blocks_ : kMostTimes * blocks_)); }
    [[nodiscard]] int nextStep(int blocks) const { return std::min(blocks + std::max(1, blocks / 2), mostBlocks()); }
    /// Blocks that so many times the samples asked for come to, the first look's at least.
    [[nodiscard]] float blocksOf(float times) const
    {
        return std::clamp(times * blocks_, float(firstBlocks()), float(std::max(mostBlocks(), firstBlocks())));
    }
    /// Blocks for a texel where there is no noise target: of the two steps around what it is to have, one or the other,
    /// so that texels have that on average.
    [[nodiscard]] int blocksGiven(uint32_t texel) const
    {
        const float blocks = blocksOf(share_ > 0.0f ? share_ * timesWanted(texel) : 1.0f);
        int below = firstBlocks();
        while (below < mostBlocks() && float(nextStep(below)) <= blocks) below = nextStep(below);
        const int above = nextStep(below);
        if (above <= below) return below;
        const Texel& t = map_.texels[texel];
        const float chance = (blocks - float(below)) / float(above - below);
        return unitFloat(hashCombine(hashCombine(t.page, t.x), t.y)) < chance ? above : below;
    }
    /// How many times the samples asked for a texel wants.
    [[nodiscard]] float timesWanted(uint32_t texel) const
    {
        const Noise noise = noiseAround(texel);
        const float fewest = noise.texels >= kFewAround ? kFewestTimes : 2 * noise.texels >= kFewAround ? 2.0f : 4.0f;
        const float light = std::sqrt(std::sqrt(noise.mean * lightmap_.mapMean_) * lightmap_.mapMean_);
        const float detail = lightmap_.settings_.denoised ? detailAt(texel, noise) : 1.0f;
        const float times = light > 0.0f ? detail * std::sqrt(noise.ofMost) / (kNoise * light) : 0.0f;
        return std::clamp(times, fewest, kMostTimes);
    }

    /// What the first samples of the texels around one tell, of luminance. Halves of blocks are taken for independent,
    /// though all together are spread better than that.
    struct Noise {
        float variance = 0.0f; ///< of half a block
        /// The same without the fifth of the texels that have most: where a few rays in a thousand meet something very
        /// bright, more samples would make blotches of the dots that the denoiser takes out.
        float ofMost = 0.0f;
        float mean = 0.0f;
        int texels = 0;              ///< around and including it, of whatever is known of them
        float inverseSquares = 0.0f; ///< of the rays' lengths, on average: 1 / m^2
    };
    [[nodiscard]] Noise noiseAround(uint32_t texel) const
    {
        float squares = 0.0f;
        float freedom = 0.0f;
        float mean = 0.0f;
        float inverseSquares = 0.0f;
        std::array<float, (2 * kNoiseRadius + 1) * (2 * kNoiseRadius + 1)> own;
        std::size_t count = 0;
        int texels = 0;
        lightmap_.state_->grid.around(texel, kNoiseRadius, [&](uint32_t other) {
            ++texels;
            const Known& k = known_[set_.find(other)];
            if (!k.active || k.between) return;
            own[count] = std::max(k.light.gathered.squares, 0.0f) + std::max(k.light.emitted.squares, 0.0f);
            squares += own[count++];
            freedom += float(k.light.gathered.halves - 1);
            mean += luminance(k.light.irradiance());
            inverseSquares += k.light.inverseSquaresOfRay();
        });
        if (count == 0) return {.texels = texels};
        const std::size_t most = count - count / 5;
        std::nth_element(own.begin(), own.begin() + most, own.begin() + count);
        const float ofMost = std::accumulate(own.begin(), own.begin() + most, 0.0f) / float(most);
        return {squares / freedom, ofMost * float(count) / freedom, mean / float(count), texels,
                inverseSquares / float(count)};
    }

    /// How much of a texel's noise is its own to get rid of, as a factor of its samples.
    [[nodiscard]] float detailAt(uint32_t texel, const Noise& noise) const
    {
        const uint32_t triangle = map_.fragments[map_.texels[texel].firstFragment].triangle;
        const float width = lightmap_.paths_.surfaces().geometry().texelMeters(triangle);
        return std::min(kDetail * std::cbrt(width * std::sqrt(noise.inverseSquares)), kMostForDetail);
    }

    /// Blocks after which the standard error of a texel's luminance is within the target.
    [[nodiscard]] int blocksNeeded(uint32_t texel) const
    {
        const Noise noise = noiseAround(texel);
        const float dark = 0.02f * lightmap_.mapMean_;
        const float allowed = lightmap_.settings_.noiseTarget * std::max(noise.mean, dark);
        if (!(noise.variance > 0.0f)) return 0;
        if (!(allowed > 0.0f)) return mostBlocks();
        return int(std::ceil(std::min(noise.variance / (2.0f * allowed * allowed), blocks_)));
    }

    /// Decides whether a texel can lie between others, all of which are known.
    void goBetween(uint32_t place)
    {
        SparseGrid::Around around;
        if (outside(set_[place]) != kAllPoints || !lattice_.around(set_[place], around)) return;
        float inverseSquares = 0.0f; // mean over the rays
        for (int i = 0; i < around.count; ++i) {
            const Known& k = known_[set_.find(around.texels[std::size_t(i)])];
            if (!k.active || k.mask != kAllPoints || k.light.backFaces.hidden > 0) return;
            inverseSquares += k.light.inverseSquaresOfRay() / float(around.count);
        }
        if (!(inverseSquares * around.meters * around.meters <= kMostBend)) return;
        Known& k = known_[place];
        k.between = k.active = true;
        k.mask = kAllPoints;
        mix(around, k);
    }

    /// What the texels around gather, on average, as if it had been gathered.
    void mix(const SparseGrid::Around& around, Known& k) const
    {
        const float share = 1.0f / float(around.count);
        vec3 irradiance(0.0f);
        vec3 moment(0.0f);
        float variance = 0.0f;
        float inverseSquares = 0.0f; // mean over the rays
        uint32_t halves = ~0u;
        for (int i = 0; i < around.count; ++i) {
            const TexelLight& light = known_[set_.find(around.texels[std::size_t(i)])].light;
            irradiance += share * light.gathered.mean();
            moment += share * light.gathered.meanMoment();
            variance += share * share * light.gathered.varianceOfMean();
            inverseSquares += share * light.inverseSquares / float(light.gathered.halves);
            halves = std::min(halves, light.gathered.halves);
        }
        k.light.gathered = TexelSum::of(irradiance, moment, variance, halves);
        k.light.inverseSquares = inverseSquares * float(halves);
    }

    /// Texels between others get what these gather in the end. Emitters they look at themselves: shadows of small ones
    /// have edges.
    bool finishBetween()
    {
        std::vector<uint32_t> places;
        for (std::size_t i = 0; i < set_.size(); ++i) {
            if (known_[i].between) places.push_back(uint32_t(i));
        }
        for (int spacing = lattice_.step() / 2; adaptive_ && spacing >= 1; spacing /= 2) {
            parallelFor(places.size(), 1024, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    SparseGrid::Around around;
                    if (lattice_.spacingOf(set_[places[i]]) != spacing) continue;
                    lattice_.around(set_[places[i]], around);
                    mix(around, known_[places[i]]);
                }
            });
        }
        if (lightmap_.paths_.emitters().empty()) return true;
        return addTo(places, [](FinalGather& gather, const GatherGroup& group, std::span<TexelLight> lights,
                                uint64_t& rays) { gather.addEmitters(group, lights, rays); });
    }

    /// Calls add(gather, group, lights, rays) for groups of texels that something is known of already, named by their
    /// places in the set.
    template<typename Add> bool addTo(const std::vector<uint32_t>& places, const Add& add)
    {
        return forTexelGroups<GatherGroup>(
            lightmap_.paths_, map_, places.size(), [&](std::size_t i) { return set_[places[i]]; },
            [&](std::size_t i) { return known_[places[i]].mask; }, progress_, "lightmap", rays_,
            [&] {
                return [&, gather = makeGather()](const GatherGroup& group, std::size_t i, uint64_t& traced) mutable {
                    std::array<TexelLight, TexelGroup::kLanes> lights;
                    for (int lane = 0; lane < group.lanes(); ++lane)
                        lights[std::size_t(lane)] = known_[places[i + std::size_t(lane)]].light;
                    add(gather, group, std::span<TexelLight>(lights), traced);
                    for (int lane = 0; lane < group.lanes(); ++lane)
                        known_[places[i + std::size_t(lane)]].light = lights[std::size_t(lane)];
                };
            });
    }

    const CachedLightmap& lightmap_;
    const TexelMap& map_;
    float blocks_; ///< asked for, of a texel
    float share_;
    const Progress& progress_;
    std::atomic<uint64_t>& rays_;
    bool adaptive_;
    SparseGrid lattice_;
    TexelSet set_;
    std::optional<TexelSet> wanted_; ///< of the set, what may get more samples
    std::vector<Known> known_;       ///< of the set
};

bool CachedLightmap::prepare(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (state_ != nullptr && map_ == &map && mapTexels_ == map.texels.size()) return true;
    auto state = std::make_unique<MapState>(MapState{TexelGrid(map), {}, ValidPoints(map.texels.size()), {}, 0.0f});
    if (settings_.bounces > 0 &&
        !state->cache.build(paths_, map, pattern_, settings_, state->outside, progress, rays)) {
        return false;
    }
    // How bright the map is, of a few texels spread over it: roughly, so that small changes somewhere are none
    // elsewhere.
    double sum = 0.0;
    std::size_t count = 0;
    constexpr std::size_t kProbedGroups = 128;
    FinalGather gather(paths_, pattern_, settings_.bounces > 0 ? &state->cache : nullptr, settings_);
    const std::size_t step = std::max<std::size_t>(1, map.texels.size() / kProbedGroups);
    for (std::size_t i = 0; i < map.texels.size(); i += step) {
        const auto texel = uint32_t(i);
        std::array<TexelLight, TexelGroup::kLanes> lights;
        const GatherGroup group(paths_, map, std::span(&texel, 1), std::span(&state->outside.masks[i], 1));
        uint64_t traced = 0;
        gather.add(group, 0, 1, lights, traced);
        rays += traced;
        if (!group.active(0)) continue;
        sum += double(luminance(lights[0].irradiance()));
        ++count;
    }
    mapMean_ = sum > 0.0 ? float(std::exp2(std::round(std::log2(sum / double(count))))) : 0.0f;
    state_ = std::move(state);
    map_ = &map;
    mapTexels_ = map.texels.size();
    return true;
}

// A texel's samples are the same whichever others are asked for, so the factor is the whole map's.
bool CachedLightmap::findShare(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (state_->share > 0.0f) return true;
    std::vector<uint32_t> some(map.texels.size() <= kMostLookedAt ? map.texels.size() : kRuns * kTexelsOfRun);
    if (some.size() == map.texels.size()) {
        std::iota(some.begin(), some.end(), 0u);
    } else {
        for (std::size_t i = 0; i < some.size(); ++i) {
            const std::size_t first = i / kTexelsOfRun * (map.texels.size() - kTexelsOfRun) / (kRuns - 1);
            some[i] = uint32_t(first + i % kTexelsOfRun);
        }
    }
    Run run(*this, map, some, settings_.samples, 0.0f, progress, rays);
    if (!run.lookFirst()) return false;
    state_->share = run.findShare();
    state_->looked.emplace(run.takeFirstLook());
    return true;
}

bool CachedLightmap::irradiance(const TexelMap& map, std::span<const uint32_t> texels, int samples,
                                std::span<IrradianceEstimate> out, const Progress& progress,
                                std::atomic<uint64_t>& rays)
{
    if (texels.empty()) return true;
    if (!prepare(map, progress, rays)) return false;
    // Witnesses of a change have fewer samples than the map, all as many.
    const bool shares = settings_.noiseTarget <= 0.0f && samples == settings_.samples;
    if (shares && !findShare(map, partOf(progress, 0.0, 0.0), rays)) return false;
    // Some at a time: what is known of a texel while it is worked on takes more memory than its estimate.
    constexpr std::size_t kTexelsAtOnce = 65536;
    for (std::size_t first = 0; first < texels.size(); first += kTexelsAtOnce) {
        const auto some = texels.subspan(first, std::min(kTexelsAtOnce, texels.size() - first));
        const double share = 1.0 / double(texels.size());
        const Progress part = partOf(progress, double(first) * share, double(first + some.size()) * share);
        Run run(*this, map, some, samples, shares ? state_->share : 0.0f, part, rays);
        if (!run.work()) return false;
        for (std::size_t i = 0; i < some.size(); ++i) out[first + i] = run.estimateOf(some[i]);
    }
    return true;
}

} // namespace halflight
