#include "transport/lightmap/lightmap_run.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <utility>

namespace halflight {
namespace {

/// A texel is interpolated if its distance to the anchors, squared, times the mean of 1 / length^2 of their rays is at
/// most this: a bound of the second derivative of irradiance (Ward, Rubinstein and Clear 1988).
constexpr float kMostBend = 0.03f;
/// Maps with more texels have a sparse grid of step 2: its texels have rays enough for all in open places.
constexpr std::size_t kManyTexels = 400'000;
constexpr std::size_t kGrain = 64; ///< texels that a thread takes at a time

} // namespace

int texelStepOf(const IntegrationSettings& settings, const TexelMap& map)
{
    if (settings.cache.texelStep > 0) return settings.cache.texelStep;
    return map.texels.size() > kManyTexels ? 2 : 1;
}

LightmapRun::LightmapRun(const LightmapInput& input, std::span<const uint32_t> texels, int samples, float scale,
                         const Progress& progress, std::atomic<uint64_t>& rays)
    : input_(input), scale_(scale), progress_(progress), rays_(rays),
      plan_(input.settings, input.paths.surfaces().geometry(), input.map, input.state.grid, input.state.mean, samples,
            scale),
      grid_(input.paths.surfaces().geometry(), input.map, input.state.grid, texelStepOf(input.settings, input.map)),
      texels_{TexelSet(input.map, texels), {}, {}}
{
    TexelSet& set = texels_.texels;
    const auto neighbours = [&](uint32_t texel, const auto& add) { grid_.forNeighbours(texel, add); };
    // Anchors of the texels, and their anchors.
    const auto addAnchors = [&] {
        for (int step = grid_.step(); step > 1; step /= 2) set.extend(neighbours);
    };
    addAnchors();
    wanted_.emplace(set);
    set.extend([&](uint32_t texel, const auto& add) { input.state.grid.around(texel, SamplePlan::kRadius, add); });
    addAnchors();
    texels_.states.resize(set.size());
    texels_.components.resize(set.size() * componentCount());
}

IrradianceEstimate LightmapRun::estimateOf(uint32_t texel) const
{
    const TexelState& s = texels_.of(texel);
    IrradianceEstimate estimate;
    estimate.valid = s.valid;
    if (!s.valid) return estimate;
    const TexelEstimate& e = s.estimate;
    estimate.irradiance = e.irradiance();
    estimate.moment = e.gathered.meanMoment() + e.emitted.meanMoment();
    estimate.varianceOfMean = e.gathered.varianceOfMean() + e.emitted.varianceOfMean();
    estimate.samples = s.interpolated ? 0 : e.blocks() * uint32_t(StratifiedPattern::kBlock);
    return estimate;
}

void LightmapRun::componentsOf(uint32_t texel, IrradianceEstimate& all, std::span<IrradianceEstimate> out) const
{
    const std::size_t count = componentCount();
    const auto components = std::span(texels_.components).subspan(texels_.texels.find(texel) * count, count);
    if (all.valid) all.irradiance = all.moment = vec3(0.0f);
    for (std::size_t c = 0; c < count; ++c) {
        const ComponentEstimate& e = components[c];
        out[c] = {};
        out[c].valid = all.valid;
        if (!all.valid) continue;
        out[c].irradiance = e.gathered.mean() + e.emitted.mean();
        out[c].moment = e.gathered.meanMoment() + e.emitted.meanMoment();
        out[c].varianceOfMean = e.gathered.varianceOfMean() + e.emitted.varianceOfMean();
        out[c].samples = all.samples;
        all.irradiance += out[c].irradiance;
        all.moment += out[c].moment;
    }
}

Status LightmapRun::firstPass()
{
    std::vector<uint32_t> places;
    for (int spacing = grid_.step(); spacing >= 1; spacing /= 2) {
        places.clear();
        for (std::size_t i = 0; i < size(); ++i) {
            if (grid_.spacingOf(texelAt(i)) == spacing) places.push_back(uint32_t(i));
        }
        parallelFor(places.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) tryInterpolate(places[i]);
        });
        std::erase_if(places, [&](uint32_t place) { return stateAt(place).interpolated || takeFirstPass(place); });
        const int blocks = plan_.firstBlocks();
        const auto first = [blocks](FinalGather& gather, const GatherGroup& group,
                                    const FinalGather::Estimates& estimates,
                                    uint64_t& rays) { gather.add(group, 0, blocks, estimates, rays); };
        const std::vector<int> same(input_.state.device != nullptr ? places.size() : 0, blocks);
        if (Status s = input_.state.device != nullptr ? extendOnDevice(places, same, 0) : extend(places, first); !s)
            return s;
        for (const uint32_t place : places) stateAt(place).valid = input_.map.texels[texelAt(place)].validPoints != 0;
    }
    return {};
}

/// Copies a texel's first samples from the pass that computed the scale, if that has them.
bool LightmapRun::takeFirstPass(uint32_t place)
{
    const std::optional<TexelStates>& first = input_.state.firstPass;
    if (!first || scale_ <= 0.0f || !first->texels.contains(texelAt(place))) return false;
    stateAt(place) = first->of(texelAt(place));
    const std::size_t count = componentCount();
    const auto components = std::span(first->components).subspan(first->texels.find(texelAt(place)) * count, count);
    std::copy(components.begin(), components.end(), componentsAt(place).begin());
    return true;
}

Status LightmapRun::laterPasses()
{
    std::vector<int> needed(size());
    parallelFor(size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (stateAt(i).traced() && wanted_->contains(texelAt(i))) needed[i] = plan_.blocksOf(texelAt(i), texels_);
        }
    });
    const int first = plan_.firstBlocks();
    if (input_.state.device != nullptr) {
        std::vector<uint32_t> places;
        std::vector<int> blocks;
        for (std::size_t i = 0; i < size(); ++i) {
            if (needed[i] <= first) continue;
            places.push_back(uint32_t(i));
            blocks.push_back(plan_.blocksAtLeast(first, needed[i]) - first);
        }
        return extendOnDevice(places, blocks, first);
    }
    // Texels of one step form groups. The steps are the same whichever texels are asked for. All steps run at one time,
    // the longest first, because single steps have too few texels for many threads.
    const int most = *std::max_element(needed.begin(), needed.end());
    std::vector<std::vector<uint32_t>> placesOfStep;
    std::vector<int> blocksOfStep;
    for (int done = first; done < most;) {
        const int next = plan_.nextStep(done);
        std::vector<uint32_t>& places = placesOfStep.emplace_back();
        for (std::size_t i = 0; i < size(); ++i) {
            if (needed[i] > done && needed[i] <= next) places.push_back(uint32_t(i));
        }
        blocksOfStep.push_back(next - first);
        done = next;
    }
    struct Batch {
        std::span<const uint32_t> places;
        int blocks = 0;
    };
    std::vector<Batch> batches;
    for (std::size_t step = placesOfStep.size(); step-- > 0;) {
        const std::span<const uint32_t> places(placesOfStep[step]);
        for (std::size_t i = 0; i < places.size(); i += kGrain)
            batches.push_back({places.subspan(i, std::min(kGrain, places.size() - i)), blocksOfStep[step]});
    }
    const bool finished =
        parallelFor(batches.size(), 1, progress_, "lightmap", [&](std::size_t begin, std::size_t end) {
            FinalGather gather = input_.makeGather();
            for (std::size_t b = begin; b < end; ++b) {
                const int blocks = batches[b].blocks;
                extendSome(batches[b].places, gather,
                           [first, blocks](FinalGather& g, const GatherGroup& group,
                                           const FinalGather::Estimates& estimates,
                                           uint64_t& rays) { g.add(group, first, blocks, estimates, rays); });
            }
        });
    return input_.paths.surfaces().outcome(finished);
}

/// Interpolates a texel if its anchors are valid and no geometry is near them.
void LightmapRun::tryInterpolate(uint32_t place)
{
    SparseGrid::Anchors anchors;
    const uint32_t texel = texelAt(place);
    if (input_.map.texels[texel].validPoints != kAllPoints || !grid_.anchorsOf(texel, anchors)) return;
    float inverseSquare = 0.0f; // mean over the rays
    for (int i = 0; i < anchors.count; ++i) {
        const TexelState& s = texels_.of(anchors.texels[std::size_t(i)]);
        if (input_.map.texels[anchors.texels[std::size_t(i)]].validPoints != kAllPoints) return;
        inverseSquare += s.estimate.meanInverseSquare() / float(anchors.count);
    }
    if (!(inverseSquare * anchors.meters * anchors.meters <= kMostBend)) return;
    TexelState& s = stateAt(place);
    s.interpolated = s.valid = true;
    interpolate(anchors, place);
}

/// Sets the gathered light to the mean of the anchors'.
void LightmapRun::interpolate(const SparseGrid::Anchors& anchors, uint32_t place)
{
    const float share = 1.0f / float(anchors.count);
    float inverseSquares = 0.0f; // per half-block
    uint32_t count = ~0u;
    for (int i = 0; i < anchors.count; ++i) {
        const TexelEstimate& e = texels_.of(anchors.texels[std::size_t(i)]).estimate;
        inverseSquares += share * e.inverseSquares / float(e.gathered.count);
        count = std::min(count, e.gathered.count);
    }
    // `gatheredOf` gives a term of an anchor, whose texel has a place.
    const auto meanOf = [&](const auto& gatheredOf) {
        vec3 irradiance(0.0f);
        vec3 moment(0.0f);
        float variance = 0.0f;
        for (int i = 0; i < anchors.count; ++i) {
            const RunningMoments& gathered = gatheredOf(texels_.texels.find(anchors.texels[std::size_t(i)]));
            irradiance += share * gathered.mean();
            moment += share * gathered.meanMoment();
            variance += share * share * gathered.varianceOfMean();
        }
        return RunningMoments::of(irradiance, moment, variance, count);
    };
    TexelState& state = stateAt(place);
    state.estimate.gathered =
        meanOf([&](std::size_t anchor) -> const RunningMoments& { return texels_.states[anchor].estimate.gathered; });
    state.estimate.inverseSquares = inverseSquares * float(count);
    for (std::size_t c = 0; c < componentCount(); ++c)
        componentsAt(place)[c].gathered = meanOf([&](std::size_t anchor) -> const RunningMoments& {
            return texels_.components[anchor * componentCount() + c].gathered;
        });
}

/// Interpolates again from the final samples of the anchors, if these have grown. Emitters are sampled at every texel,
/// because shadows of small emitters have sharp edges.
Status LightmapRun::finishInterpolated()
{
    std::vector<uint32_t> places;
    for (std::size_t i = 0; i < size(); ++i) {
        if (stateAt(i).interpolated) places.push_back(uint32_t(i));
    }
    for (int spacing = grid_.step() / 2; plan_.hasTarget() && spacing >= 1; spacing /= 2) {
        parallelFor(places.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                SparseGrid::Anchors anchors;
                if (grid_.spacingOf(texelAt(places[i])) != spacing) continue;
                grid_.anchorsOf(texelAt(places[i]), anchors);
                interpolate(anchors, places[i]);
            }
        });
    }
    if (!input_.paths.light().samplesEmission()) return {};
    return extend(places, [](FinalGather& gather, const GatherGroup& group, const FinalGather::Estimates& estimates,
                             uint64_t& rays) { gather.addEmitters(group, 0, estimates, rays); });
}

/// Adds blocks of texels from `firstBlock` on. `blocks`: their numbers by place.
Status LightmapRun::extendOnDevice(std::span<const uint32_t> places, std::span<const int> blocks, int firstBlock)
{
    std::vector<BatchGather::Request> requests(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
        requests[i] = {texelAt(places[i]), blocks[i], &stateAt(places[i]).estimate};
    const BatchGather gather(*input_.state.device, input_.paths, input_.pattern, input_.state.cache,
                             input_.state.guides, input_.settings, input_.map);
    if (Status s = gather.add(requests, firstBlock, progress_, rays_); !s) return s;
    return input_.paths.surfaces().outcome(true);
}

/// Calls add(gather, group, estimates, rays) for groups of texels and their estimates.
template<typename Add> Status LightmapRun::extend(const std::vector<uint32_t>& places, const Add& add)
{
    const bool finished =
        parallelFor(places.size(), kGrain, progress_, "lightmap", [&](std::size_t begin, std::size_t end) {
            FinalGather gather = input_.makeGather();
            extendSome(std::span(places).subspan(begin, end - begin), gather, add);
        });
    return input_.paths.surfaces().outcome(finished);
}

template<typename Add>
void LightmapRun::extendSome(std::span<const uint32_t> places, FinalGather& gather, const Add& add)
{
    uint64_t traced = 0;
    std::array<uint32_t, kLanes> texels{};
    std::array<TexelEstimate, kLanes> estimates;
    const std::size_t count = componentCount();
    std::vector<ComponentEstimate> components(std::size_t(kLanes) * count); // by lane
    for (std::size_t i = 0; i < places.size() && !stopped(); i += kLanes) {
        const std::size_t lanes = std::min(places.size() - i, std::size_t(kLanes));
        for (std::size_t k = 0; k < lanes; ++k) {
            texels[k] = texelAt(places[i + k]);
            estimates[k] = stateAt(places[i + k]).estimate;
            std::ranges::copy(componentsAt(places[i + k]), components.begin() + std::ptrdiff_t(k * count));
        }
        const GatherGroup group(input_.paths, input_.map, std::span<const uint32_t>(texels.data(), lanes));
        add(gather, group, FinalGather::Estimates{estimates, components}, traced);
        for (std::size_t k = 0; k < lanes; ++k) {
            stateAt(places[i + k]).estimate = estimates[k];
            std::ranges::copy(std::span(components).subspan(k * count, count), componentsAt(places[i + k]).begin());
        }
    }
    rays_ += traced;
}

} // namespace halflight
