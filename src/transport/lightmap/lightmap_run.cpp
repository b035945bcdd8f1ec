#include "transport/lightmap/lightmap_run.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <utility>

namespace halflight {
namespace {

constexpr std::size_t kGrain = 64; ///< texels that a thread takes at a time

} // namespace

LightmapRun::LightmapRun(const LightmapInput& input, std::span<const uint32_t> texels, int samples, float scale,
                         const Progress& progress, std::atomic<uint64_t>& rays)
    : input_(input), scale_(scale), progress_(progress), rays_(rays),
      plan_(input.settings, input.paths.surfaces().geometry(), input.map, input.state.grid, input.state.mean, samples,
            scale),
      texels_{TexelSet(input.map, texels), {}, {}}
{
    TexelSet& set = texels_.texels;
    wanted_.emplace(set);
    set.extend([&](uint32_t texel, const auto& add) { input.state.grid.around(texel, SamplePlan::kRadius, add); });
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
    estimate.samples = e.blocks() * uint32_t(StratifiedPattern::kBlock);
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
    for (uint32_t place = 0; place < size(); ++place) {
        if (!takeFirstPass(place)) places.push_back(place);
    }
    const int blocks = plan_.firstBlocks();
    const auto first = [blocks](FinalGather& gather, const GatherGroup& group, const FinalGather::Estimates& estimates,
                                uint64_t& rays) { gather.add(group, 0, blocks, estimates, rays); };
    const std::vector<int> same(input_.state.device != nullptr ? places.size() : 0, blocks);
    if (Status s = input_.state.device != nullptr ? extendOnDevice(places, same, 0) : extend(places, first); !s)
        return s;
    for (const uint32_t place : places) stateAt(place).valid = input_.map.texels[texelAt(place)].validPoints != 0;
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
            if (stateAt(i).valid && wanted_->contains(texelAt(i))) needed[i] = plan_.blocksOf(texelAt(i), texels_);
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

/// Adds blocks of texels from `firstBlock` on. `blocks`: their numbers by place.
Status LightmapRun::extendOnDevice(std::span<const uint32_t> places, std::span<const int> blocks, int firstBlock)
{
    std::vector<BatchGather::Request> requests(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
        requests[i] = {texelAt(places[i]), blocks[i], &stateAt(places[i]).estimate, componentsAt(places[i])};
    const BatchGather gather(*input_.state.device, input_.map, input_.paths.light());
    const RayTracer& surfaces = input_.paths.surfaces();
    if (Status s = gather.add(requests, firstBlock, progress_, rays_); !s) {
        if (s.error().code != ErrorCode::Cancelled) surfaces.keep(s.error());
        return s;
    }
    return surfaces.outcome(true);
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
