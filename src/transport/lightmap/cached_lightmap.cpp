#include "transport/lightmap/cached_lightmap.h"

#include "transport/guiding/build_guides.h"
#include "transport/radiosity/form_factors.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/progress_of_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace halflight {
namespace {

/// The scale of the sample plan follows from all texels. In maps with more texels than so many runs have, it follows
/// from these runs of neighbouring texels, spread evenly.
constexpr std::size_t kRuns = 512;
constexpr std::size_t kTexelsOfRun = 64;
/// Names of kept results: of the map's state, and of the plan's scale.
constexpr const char* kRadianceStage = "radiance";
constexpr const char* kScaleStage = "scale";

} // namespace

Status CachedLightmap::prepare(const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (state_ != nullptr) return {};
    auto state = std::make_unique<LightmapState>(map_, paths_.light().components() > 0);
    const auto compute = [&] { return build(*state, progress, rays); };
    if (Status s = store_.computed(kRadianceStage, *state, compute); !s) return s;
    if (settings_.bounces > 0) {
        auto device = paths_.surfaces().kernels().prepareGather(
            {paths_, pattern_, state->cache, state->guides, settings_.seed, settings_.bounces});
        if (!device) return device.error();
        state->device = std::move(*device);
    }
    state_ = std::move(state);
    return {};
}

Status CachedLightmap::build(LightmapState& state, const Progress& progress, std::atomic<uint64_t>& rays) const
{
    if (settings_.bounces > 0) {
        if (Status s = buildCache(state, progress, rays); !s) return s;
        releaseFreeMemory();
    }
    state.mean = meanOf({paths_, pattern_, settings_, map_, state}, rays);
    return paths_.surfaces().outcome(true);
}

Status CachedLightmap::buildCache(LightmapState& state, const Progress& progress, std::atomic<uint64_t>& rays) const
{
    const RadiosityInput input{paths_, map_, pattern_, settings_, store_};
    Result<Radiosity> radiosity = buildRadiosity(input, progress, rays);
    if (!radiosity) return radiosity.error();
    state.guides = buildGuides(*radiosity, map_, paths_.surfaces());
    state.cache = std::move(radiosity->solution.cache);
    return {};
}

/// Mean luminance over as many texels as the plan has runs, spread over the map. It is rounded to a power of two, so
/// that small changes of the scene do not change it.
float CachedLightmap::meanOf(const LightmapInput& input, std::atomic<uint64_t>& rays) const
{
    double sum = 0.0;
    std::size_t count = 0;
    const TexelMap& map = input.map;
    FinalGather gather = input.makeGather();
    const std::size_t step = std::max<std::size_t>(1, map.texels.size() / kRuns);
    for (std::size_t i = 0; i < map.texels.size(); i += step) {
        const auto texel = uint32_t(i);
        std::array<TexelEstimate, kLanes> estimates;
        std::vector<ComponentEstimate> components(std::size_t(kLanes) * std::size_t(paths_.light().components()));
        const GatherGroup group(paths_, map, std::span(&texel, 1));
        uint64_t traced = 0;
        gather.add(group, 0, 1, {estimates, components}, traced);
        rays += traced;
        if (!group.active(0)) continue;
        sum += double(luminance(estimates[0].irradiance()));
        ++count;
    }
    return sum > 0.0 ? float(math::exp2(std::round(math::log2(sum / double(count))))) : 0.0f;
}

// The scale is of the whole map, so that a texel's samples do not depend on the request.
Status CachedLightmap::findScale(const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (state_->scale > 0.0f) return {};
    const LightmapInput input = this->input();
    const std::size_t count = map_.texels.size();
    std::vector<uint32_t> some(std::min(count, kRuns * kTexelsOfRun));
    if (some.size() == count) {
        std::iota(some.begin(), some.end(), 0u);
    } else {
        for (std::size_t i = 0; i < some.size(); ++i) {
            const std::size_t first = i / kTexelsOfRun * (count - kTexelsOfRun) / (kRuns - 1);
            some[i] = uint32_t(first + i % kTexelsOfRun);
        }
    }
    return store_.computed(kScaleStage, state_->scale, [&]() -> Status {
        if (store_.isShared()) return findScaleTogether(input, some, progress, rays);
        LightmapRun run(input, some, settings_.samples, 0.0f, progress, rays);
        if (Status s = run.firstPass(); !s) return s;
        state_->scale = run.scaleOf(run.demands());
        state_->firstPass.emplace(run.takeStates());
        return {};
    });
}

/// The parts are runs of the texels. They have some demands in common: those of anchors.
Status CachedLightmap::findScaleTogether(const LightmapInput& input, std::span<const uint32_t> texels,
                                         const Progress& progress, std::atomic<uint64_t>& rays)
{
    constexpr std::size_t kPartTexels = 8 * kTexelsOfRun;
    std::vector<std::vector<TexelDemand>> parts((texels.size() + kPartTexels - 1) / kPartTexels);
    const auto compute = [&](std::size_t first, std::size_t end) -> Status {
        for (std::size_t part = first; part < end; ++part) {
            const auto some = texels.subspan(part * kPartTexels);
            LightmapRun run(input, some.first(std::min(kPartTexels, some.size())), settings_.samples, 0.0f, progress,
                            rays);
            if (Status s = run.firstPass(); !s) return s;
            parts[part] = run.demands();
        }
        return {};
    };
    if (Status s = store_.computedParts("demands", std::span(parts), 1, compute); !s) return s;
    std::map<uint32_t, float> byTexel;
    for (const std::vector<TexelDemand>& demands : parts) {
        for (const TexelDemand& d : demands) byTexel.emplace(d.texel, d.times);
    }
    std::vector<TexelDemand> all;
    for (const auto& [texel, times] : byTexel) all.push_back({texel, times});
    state_->scale = LightmapRun(input, texels.first(std::min<std::size_t>(1, texels.size())), settings_.samples, 0.0f,
                                progress, rays)
                        .scaleOf(all);
    return {};
}

Status CachedLightmap::prepareParts(const Progress& progress, std::atomic<uint64_t>& rays) const
{
    const bool needed = store_.isShared() && !store_.contains(kRadianceStage);
    if (!needed || map_.texels.empty() || settings_.bounces == 0) return {};
    return buildRadiosityParts({paths_, map_, pattern_, settings_, store_}, progress, rays);
}

Status CachedLightmap::prepareAll(const Progress& progress, std::atomic<uint64_t>& rays)
{
    if (map_.texels.empty()) return {};
    if (Status s = prepare(progress, rays); !s) return s;
    return settings_.cache.noiseTarget > 0.0f ? Status() : findScale(progress, rays);
}

bool CachedLightmap::samplesChanged(int before)
{
    if (state_ == nullptr) return true;
    state_->scale = 0.0f;
    state_->firstPass.reset();
    if (takesManySamples(before) == takesManySamples(settings_.samples)) return true;
    state_.reset();
    return false;
}

Status CachedLightmap::irradiance(std::span<const uint32_t> texels, int samples, std::span<IrradianceEstimate> out,
                                  std::span<IrradianceEstimate> components, const Progress& progress,
                                  std::atomic<uint64_t>& rays)
{
    const auto count = std::size_t(paths_.light().components());
    if (texels.empty()) return {};
    if (Status s = prepare(progress, rays); !s) return s;
    const LightmapInput input = this->input();
    // Requests for other numbers of samples than the settings' (check samples of the tile cache) have no plan.
    const bool planned = settings_.cache.noiseTarget <= 0.0f && samples == settings_.samples;
    if (planned)
        if (Status s = findScale(partOf(progress, 0.0, 0.0), rays); !s) return s;
    // In parts, because states take more memory than estimates: each thread has those of one part at a time. Threads
    // that would wait for the end of a pass of one part go on with other parts.
    constexpr std::size_t kPartTexels = 65536; // few texels beside a part are computed for its sake
    const std::size_t parts = (texels.size() + kPartTexels - 1) / kPartTexels;
    ProgressOfParts progressOfParts(progress, parts);
    parallelFor(parts, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end && !progress.cancelled(); ++p) {
            inIsolation([&, p] {
                const std::size_t first = p * kPartTexels;
                const auto some = texels.subspan(first, std::min(kPartTexels, texels.size() - first));
                const Progress part = progressOfParts.part(p);
                LightmapRun run(input, some, samples, planned ? state_->scale : 0.0f, part, rays);
                if (!run.run()) return; // outcome() says why
                for (std::size_t i = 0; i < some.size(); ++i) {
                    IrradianceEstimate& all = out[first + i] = run.estimateOf(some[i]);
                    if (!components.empty())
                        run.componentsOf(some[i], all, components.subspan((first + i) * count, count));
                }
            });
        }
    });
    return paths_.surfaces().outcome(!progress.cancelled());
}

} // namespace halflight
