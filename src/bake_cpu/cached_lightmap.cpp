#include "bake_cpu/cached_lightmap.h"

#include <cmath>

namespace halflight {
namespace {

/// Blocks that all texels get, and around how many texels of theirs the noise is estimated: 5 x 5.
constexpr int kFirstBlocks = 2;
constexpr int kNoiseRadius = 2;

} // namespace

struct CachedLightmap::First {
    TexelSum sum;
    PointMask mask = 0;
    bool active = false;
};

bool CachedLightmap::prepare(const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (state_ != nullptr && map_ == &map && mapTexels_ == map.texels.size()) return true;
    auto state =
        std::make_unique<MapState>(MapState{TexelGrid(map), {}, std::vector<PointMask>(map.texels.size(), kAllPoints)});
    if (settings_.bounces > 0 &&
        !state->cache.build(paths_, map, pattern_, settings_, state->outside, progress, rays)) {
        return false;
    }
    // What counts as dark, for the noise target: a fiftieth of the mean, here of a few texels spread over the map.
    double sum = 0.0;
    std::size_t count = 0;
    constexpr std::size_t kProbedGroups = 128;
    FinalGather gather(paths_, pattern_, settings_.bounces > 0 ? &state->cache : nullptr, settings_);
    const std::size_t step = std::max<std::size_t>(1, map.texels.size() / kProbedGroups);
    for (std::size_t i = 0; settings_.noiseTarget > 0.0f && i < map.texels.size(); i += step) {
        const auto texel = uint32_t(i);
        std::array<TexelSum, TexelGroup::kLanes> sums;
        const TexelGroup group(paths_, map, std::span(&texel, 1), std::span(&state->outside[i], 1));
        uint64_t traced = 0;
        gather.add(group, 0, 1, sums, traced);
        rays += traced;
        if (!group.active(0)) continue;
        sum += double(luminance(sums[0].mean()));
        ++count;
    }
    mapMean_ = count > 0 ? float(sum / double(count)) : 0.0f;
    state_ = std::move(state);
    map_ = &map;
    mapTexels_ = map.texels.size();
    return true;
}

bool CachedLightmap::irradiance(const TexelMap& map, std::span<const uint32_t> texels, int samples,
                                std::span<IrradianceEstimate> out, const Progress& progress,
                                std::atomic<uint64_t>& rays)
{
    if (!prepare(map, progress, rays)) return false;
    const int most = std::clamp((samples + GatherPattern::kBlock - 1) / GatherPattern::kBlock, 1, 65535);
    const bool adaptive = settings_.noiseTarget > 0.0f && most > kFirstBlocks;
    const int firstBlocks = adaptive ? kFirstBlocks : most;

    // An estimate depends on its texel's neighbours when noise is estimated from them, asked for or not.
    const TexelSet set(state_->grid, map, texels, adaptive ? kNoiseRadius : 0);
    std::vector<First> first(set.size());
    if (!forTexelGroups(
            paths_, map, set.size(), [&](std::size_t i) { return set[i]; },
            [&](std::size_t i) { return state_->outside[set[i]]; }, progress, "lightmap", rays,
            [&] {
                return [&, gather = FinalGather(paths_, pattern_, cache(), settings_)](
                           const TexelGroup& group, std::size_t i, uint64_t& traced) mutable {
                    gatherChecked(map, group, gather, firstBlocks, &first[i], traced);
                };
            })) {
        return false;
    }

    if (adaptive) {
        struct Open {
            uint32_t place;
            int blocks;
        };
        std::vector<Open> open;
        std::vector<int> needed(texels.size());
        parallelFor(texels.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                needed[i] = blocksNeeded(set, first, texels[i], 0.02f * mapMean_, most);
            }
        });
        for (std::size_t i = 0; i < texels.size(); ++i) {
            if (needed[i] > kFirstBlocks) open.push_back({uint32_t(set.find(texels[i])), needed[i]});
        }
        // Some more for all that are not done yet, again and again, so that the texels of a group go on together.
        for (int done = kFirstBlocks; !open.empty();) {
            const int next = std::min(done + std::max(1, done / 2), most);
            if (!forTexelGroups(
                    paths_, map, open.size(), [&](std::size_t i) { return set[open[i].place]; },
                    [&](std::size_t i) { return first[open[i].place].mask; }, progress, "lightmap", rays,
                    [&] {
                        return [&, gather = FinalGather(paths_, pattern_, cache(), settings_)](
                                   const TexelGroup& group, std::size_t i, uint64_t& traced) mutable {
                            std::array<TexelSum, TexelGroup::kLanes> sums;
                            for (int lane = 0; lane < group.lanes(); ++lane)
                                sums[std::size_t(lane)] = first[open[i + std::size_t(lane)].place].sum;
                            gather.add(group, done, next - done, sums, traced);
                            for (int lane = 0; lane < group.lanes(); ++lane)
                                first[open[i + std::size_t(lane)].place].sum = sums[std::size_t(lane)];
                        };
                    })) {
                return false;
            }
            done = next;
            open.erase(std::remove_if(open.begin(), open.end(), [&](const Open& o) { return o.blocks <= done; }),
                       open.end());
        }
    }

    for (std::size_t i = 0; i < texels.size(); ++i) {
        const First& f = first[set.find(texels[i])];
        out[i] = {};
        out[i].valid = f.active;
        out[i].outsidePoints = f.mask;
        if (!f.active) continue;
        out[i].irradiance = f.sum.mean();
        out[i].moment = f.sum.moment / float(f.sum.blocks);
        out[i].varianceOfMean = f.sum.varianceOfMean();
        out[i].samples = uint32_t(f.sum.blocks) * GatherPattern::kBlock;
    }
    return true;
}

/// The first samples of a group. Where rays met the inside of surfaces, the texel's points are looked at one by one.
void CachedLightmap::gatherChecked(const TexelMap& map, const TexelGroup& group, FinalGather& gather, int blocks,
                                   First* first, uint64_t& rays) const
{
    std::array<TexelSum, TexelGroup::kLanes> sums;
    gather.add(group, 0, blocks, sums, rays);
    for (int lane = 0; lane < group.lanes(); ++lane) {
        const TexelSum& sum = sums[std::size_t(lane)];
        if (group.active(lane) && group.mask(lane) == kAllPoints &&
            sum.backFaces * 16 > sum.blocks * GatherPattern::kBlock) {
            const PointMask mask = validity_.outside(group.points(lane), group.pointCount(lane), group.id(lane), rays);
            if (mask != PointMask((1u << group.pointCount(lane)) - 1u)) {
                const uint32_t texel = group.texel(lane);
                gatherChecked(map, TexelGroup(paths_, map, std::span(&texel, 1), std::span(&mask, 1)), gather, blocks,
                              first + lane, rays);
                continue;
            }
        }
        first[lane] = {sum, group.mask(lane), group.active(lane)};
    }
}

/// Blocks after which the standard error of a texel's luminance is within the target, as far as the first samples of
/// the texels around it tell. Blocks are taken for independent, though all together are spread better than that.
int CachedLightmap::blocksNeeded(const TexelSet& set, const std::vector<First>& first, uint32_t texel, float dark,
                                 int most) const
{
    if (!first[set.find(texel)].active) return 0;
    float squares = 0.0f;
    float freedom = 0.0f;
    float mean = 0.0f;
    float count = 0.0f;
    state_->grid.around(texel, kNoiseRadius, [&](uint32_t other) {
        const First& f = first[set.find(other)];
        if (!f.active) return;
        squares += std::max(f.sum.squares, 0.0f);
        freedom += float(f.sum.blocks - 1);
        mean += luminance(f.sum.mean());
        count += 1.0f;
    });
    const float allowed = settings_.noiseTarget * std::max(mean / count, dark);
    if (!(squares > 0.0f)) return kFirstBlocks;
    if (!(allowed > 0.0f)) return most;
    const float blocks = squares / freedom / (allowed * allowed);
    return blocks >= float(most) ? most : std::max(int(std::ceil(blocks)), kFirstBlocks);
}

} // namespace halflight
