#include "transport/guiding/build_guides.h"

#include "transport/guiding/patch_components.h"
#include "transport/guiding/receiver_grid.h"

#include "halflight/base/atomic_ref.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <tuple>

namespace halflight {
namespace {

/// Width of a receiver region.
constexpr float kGuideTexels = 8.0f;
/// A region with fewer hits on secondary sources takes the guide of a region three times as wide, up to this level. Its
/// sources may be occluded from some of the receivers. So they are used only from this relative variance on.
constexpr float kEnoughHits = 128.0f;
constexpr float kWider = 3.0f;
constexpr int kGuideLevels = 5;
constexpr float kMuchVariance = 0.5f;
/// Level of the regions whose hits make shared lists. A guide has one if the clusters that its local list lacks cause
/// much variance.
constexpr int kSharedLevel = 3;
constexpr std::size_t kMostEntries = 64; ///< of a list, which is searched per sample: 6 steps

/// Places of chart patches. Triangle patches (leaves, mostly) are no sources, because they are many.
std::vector<PatchLight> placePatches(const Radiosity& radiosity, const TexelMap& map, const BakeGeometry& geometry)
{
    const PatchLayout& layout = radiosity.solution.cache.layout();
    constexpr uint32_t kNoFragment = ~0u;
    std::vector<uint32_t> firstFragment(layout.chartPatches, kNoFragment); // of a patch's texels
    forEachIndex(map.texels.size(), [&](std::size_t i) {
        const Texel& texel = map.texels[i];
        for (uint32_t f = texel.firstFragment; f < texel.firstFragment + texel.fragmentCount; ++f) {
            const PatchId patch = radiosity.patches.charts.patchOf(texel, map.fragments[f].triangle);
            if (patch == kNoPatch) continue;
            const AtomicRef<uint32_t> first(firstFragment[patch]);
            uint32_t least = first.load(std::memory_order_relaxed);
            while (f < least && !first.compare_exchange_weak(least, f, std::memory_order_relaxed)) {
            }
        }
    });
    std::vector<PatchLight> lights(2 * std::size_t(layout.chartPatches));
    forEachIndex(layout.chartPatches, [&](std::size_t i) {
        const auto patch = PatchId(i);
        if (firstFragment[patch] == kNoFragment) return;
        const TexelFragment& fragment = map.fragments[firstFragment[patch]];
        const auto [a, b, c] = geometry.cornersOf(fragment.triangle);
        PatchLight& front = lights[patch];
        PatchLight& back = lights[layout.backOf(patch)];
        front.position = back.position = a + fragment.barycentric.x * (b - a) + fragment.barycentric.y * (c - a);
        front.axis = uint8_t(radiosity.patches.charts.axisOf(fragment.triangle));
        back.axis = front.axis ^ 1u;
        front.receives = true;
    });
    return lights;
}

/// Luminance of a patch; of an occluded one, the mean of its elements.
float luminanceOf(const RadianceCache& cache, PatchId patch)
{
    const PatchLayout& layout = cache.layout();
    if (layout.elements[patch].split == 0 || cache.patches()[patch].minDistance < kInfinity)
        return luminance(cache.patches()[patch].radiance);
    const PatchId first = layout.elements[patch].first;
    float sum = 0.0f;
    float count = 0.0f;
    for (PatchId e = first; e < first + layout.elementCount(patch); ++e) {
        if (!(cache.patches()[e].minDistance < kInfinity)) continue;
        sum += luminance(cache.patches()[e].radiance);
        ++count;
    }
    return count > 0.0f ? sum / count : 0.0f;
}

std::vector<PatchLight> findPatchLights(const Radiosity& radiosity, const PatchObservations& observations,
                                        const TexelMap& map, const BakeGeometry& geometry)
{
    const RadianceCache& cache = radiosity.solution.cache;
    std::vector<PatchLight> lights = placePatches(radiosity, map, geometry);
    forEachIndex(lights.size(), [&](std::size_t i) { lights[i].radiance = luminanceOf(cache, PatchId(i)); });
    forEachIndex(observations.frontPatches(), [&](std::size_t patch) {
        PatchLight& light = lights[patch];
        float gathered = 0.0f;
        observations.forSamples(PatchId(patch), [&](const PatchSamples& s, std::span<const PatchId> links) {
            light.rays += float(s.rayCount);
            for (const PatchId target : links) {
                if (target != kNoPatch) gathered += luminance(cache.patches()[observations.patchOf(target)].radiance);
            }
        });
        light.illuminance = radiosity.solution.illuminance[patch] + kPi * gathered / std::max(light.rays, 1.0f);
    });
    return lights;
}

} // namespace

class GuideBuilder {
public:
    GuideBuilder(std::span<const PatchLight> patches, const PatchComponents& components, float texelMeters)
        : patches_(patches), components_(components), width_(kGuideTexels * texelMeters)
    {}

    Guides build(const PatchObservations& observations, const PatchLayout& layout, const RayTracer& tracer)
    {
        makeRegions();
        addHits(observations, layout.texelMeters);
        addGuides();
        std::vector<float> use(guides_.clusters_.size());
        for (const Guides::Entry& e : guides_.entries_) use[e.cluster] += e.probability;
        guides_.clusters_.finish(layout, tracer, patches_, use);
        return std::move(guides_);
    }

private:
    struct Limits {
        float hits = 0.0f;
        float variance = 0.0f;
    };

    void makeRegions()
    {
        const HashGrid hashGrid(width_);
        std::vector<uint64_t> keys(patches_.size(), HashGrid::kNone);
        for (std::size_t i = 0; i < patches_.size(); ++i) {
            const PatchLight& p = patches_[i];
            if (p.receives && p.axis != PatchLight::kNoAxis) keys[i] = hashGrid.key(p.position, p.axis);
        }
        std::vector<uint32_t>& regionOfPatch = guides_.guideOfPatch_;
        for (const uint64_t key : HashGrid::numberKeys(keys, regionOfPatch)) grid_.regions.push_back({.key = key});
        for (std::size_t i = 0; i < patches_.size(); ++i) {
            if (regionOfPatch[i] == ~0u) continue;
            ReceiverGrid::Region& region = grid_.regions[regionOfPatch[i]];
            region.position = patches_[i].position;
            region.axis = patches_[i].axis;
            if (!(patches_[i].rays > 0.0f)) continue;
            region.rays += patches_[i].rays;
            region.illuminances += patches_[i].illuminance;
            ++region.receivers;
        }
        if (components_.count > 0) makeRegionsRelative();
    }

    /// Light by component is relative to its illuminance of the region, so that the region's own is 1.
    void makeRegionsRelative()
    {
        const std::size_t count = components_.count;
        illuminance_.resize(grid_.regions.size() * count);
        for (std::size_t i = 0; i < patches_.size(); ++i) {
            const uint32_t region = guides_.guideOfPatch_[i];
            if (region == ~0u || !(patches_[i].rays > 0.0f)) continue;
            for (std::size_t c = 0; c < count; ++c)
                illuminance_[region * count + c] +=
                    components_.illuminance[i * count + c] / grid_.regions[region].receivers;
        }
        for (ReceiverGrid::Region& region : grid_.regions) region.illuminances = region.receivers;
    }

    /// What a ray from a region receives of a patch, and its square: of all light; or, of components, the sum of the
    /// shares of their illuminance, and the square of the largest.
    [[nodiscard]] vec2 receivedFrom(PatchId patch, std::size_t region) const
    {
        const float all = patches_[patch].radiance;
        if (components_.count == 0) return {all, all * all};
        float sum = 0.0f;
        float most = 0.0f;
        const std::span<const float> radiance = components_.radianceOf(patch);
        for (std::size_t c = 0; c < radiance.size(); ++c) {
            const float illuminance = illuminance_[region * components_.count + c];
            if (!(illuminance > 0.0f) || !isSecondarySource(radiance[c], illuminance)) continue;
            sum += radiance[c] / illuminance;
            most = std::max(most, radiance[c] / illuminance);
        }
        return {sum, most * most};
    }

    /// Clusters the secondary sources that rays hit, and adds the hits to the regions.
    void addHits(const PatchObservations& observations, float texelMeters)
    {
        struct Hit {
            uint32_t region;
            PatchId patch;
        };
        std::vector<Hit> hits;
        std::mutex mutex;
        parallelFor(observations.frontPatches(), 4096, [&](std::size_t begin, std::size_t end) {
            std::vector<Hit> some;
            for (std::size_t receiver = begin; receiver < end; ++receiver) {
                const uint32_t region = guides_.guideOfPatch_[receiver];
                if (region == ~0u) continue;
                observations.forRays(PatchId(receiver), [&](PatchId patch) {
                    if (patches_[patch].axis == PatchLight::kNoAxis) return;
                    if (isSecondarySource(receivedFrom(patch, region).x, grid_.regions[region].illuminance()))
                        some.push_back({region, patch});
                });
            }
            const std::scoped_lock lock(mutex);
            hits.insert(hits.end(), some.begin(), some.end());
        });
        parallelSort(hits, [](const Hit& a, const Hit& b) {
            return a.region != b.region ? a.region < b.region : a.patch < b.patch;
        });
        std::vector<uint32_t> timesHit(patches_.size());
        for (const Hit& h : hits) ++timesHit[h.patch];
        guides_.clusters_ = SourceClusters(patches_, timesHit, texelMeters);
        std::size_t next = 0;
        for (std::size_t region = 0; region < grid_.regions.size(); ++region) {
            const std::size_t first = grid_.regions[region].firstHit = grid_.hits.size();
            for (; next < hits.size() && hits[next].region == region; ++next) {
                const vec2 received = receivedFrom(hits[next].patch, region);
                grid_.hits.push_back({guides_.clusters_.clusterOf(hits[next].patch), 1.0f, received.x, received.y});
            }
            HitStatistics::merge(grid_.hits, first);
        }
    }

    /// Guides of regions with enough hits, then of ever wider regions for the others.
    void addGuides()
    {
        guides_.guides_.resize(grid_.regions.size());
        std::vector<uint32_t> open(guides_.guides_.size());
        std::iota(open.begin(), open.end(), 0u);
        std::vector<uint32_t> regionOfGuide = open;
        ConnectedComponents components(grid_, guides_.clusters_.size());
        std::vector<float> illuminances;
        for (const ReceiverGrid::Region& region : grid_.regions) illuminances.push_back(region.illuminance());
        const std::vector<float> hits = addGuides(open, {}, [&](uint32_t g) -> Guide& { return guides_.guides_[g]; });
        std::erase_if(open, [&](uint32_t g) { return hits[g] >= kEnoughHits; });
        for (int level = 2; level <= kGuideLevels; ++level) {
            width_ *= kWider;
            const std::vector<uint32_t> parents = grid_.coarsen(width_);
            for (uint32_t& region : regionOfGuide) region = parents[region];
            addWiderGuides(open, regionOfGuide, {level < kGuideLevels ? kEnoughHits : 0.0f, kMuchVariance});
            if (level == kSharedLevel) addShared(regionOfGuide, illuminances, components);
        }
    }

    void addWiderGuides(std::vector<uint32_t>& open, std::span<const uint32_t> regionOfGuide, const Limits& limits)
    {
        // Regions in the order of their first guides.
        std::vector<uint32_t> regions;
        std::vector<uint32_t> numberOf(grid_.regions.size(), ~0u);
        for (const uint32_t g : open) {
            uint32_t& number = numberOf[regionOfGuide[g]];
            if (number != ~0u) continue;
            number = uint32_t(regions.size());
            regions.push_back(regionOfGuide[g]);
        }
        std::vector<Guide> guides(regions.size());
        const std::vector<float> hits =
            addGuides(regions, limits, [&](uint32_t region) -> Guide& { return guides[numberOf[region]]; });
        std::erase_if(open, [&](uint32_t g) {
            const uint32_t number = numberOf[regionOfGuide[g]];
            if (guides[number].local.count > 0) guides_.guides_[g] = guides[number];
            return hits[number] >= limits.hits;
        });
    }

    /// A guide whose list is not among the entries yet.
    struct Draft {
        float hitCount = 0.0f;
        bool made = false; ///< the hits and their variance reach the limits
        Guide guide;
        std::vector<HitStatistics> list;
    };

    /// Makes guides of regions whose hits and their variance reach the limits. Returns the numbers of hits.
    template<typename GuideOf>
    std::vector<float> addGuides(std::span<const uint32_t> regions, const Limits& limits, const GuideOf& guideOf)
    {
        constexpr std::size_t kAtOnce = 16384; // drafts, of up to 64 entries each
        std::vector<float> hits;
        std::vector<Draft> drafts;
        for (std::size_t first = 0; first < regions.size(); first += kAtOnce) {
            const auto some = regions.subspan(first, std::min(kAtOnce, regions.size() - first));
            drafts.resize(some.size());
            parallelFor(some.size(), 32, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) drafts[i] = draftOf(some[i], limits);
            });
            for (std::size_t i = 0; i < some.size(); ++i) {
                hits.push_back(drafts[i].hitCount);
                if (!drafts[i].made) continue;
                drafts[i].guide.local = addList(drafts[i].list, lightOf);
                guideOf(some[i]) = drafts[i].guide;
            }
        }
        return hits;
    }

    [[nodiscard]] Draft draftOf(uint32_t region, const Limits& limits) const
    {
        Observations observed(grid_, region, grid_.regions[region].illuminance());
        Draft draft{observed.hitCount, false, {}, {}};
        if (observed.hitCount < limits.hits) return draft;
        observed.keepHighest(kMostEntries, lightOf);
        double light = 0.0;
        double squares = 0.0;
        for (const HitStatistics& h : observed.hits) {
            light += double(h.light);
            squares += double(h.squares);
        }
        if (!(light > 0.0 && light < double(kInfinity) && observed.rays > 0.0f && observed.illuminance > 0.0f))
            return draft;
        const float variance = observed.relativeVariance(squares, observed.illuminance);
        if (variance < limits.variance) return draft;
        draft.made = true;
        draft.guide.relativeVariance = variance;
        draft.list = std::move(observed.hits);
        return draft;
    }
    static float lightOf(const HitStatistics& h) { return h.light; }

    /// A list of clusters with probabilities in proportion to weights.
    template<typename Weight> GuideList addList(std::span<const HitStatistics> hits, const Weight& weight)
    {
        const GuideList list{uint32_t(guides_.entries_.size()), uint32_t(hits.size())};
        double total = 0.0;
        for (const HitStatistics& h : hits) total += double(weight(h));
        double sum = 0.0;
        for (const HitStatistics& h : hits) {
            sum += double(weight(h));
            guides_.entries_.push_back({h.cluster, float(double(weight(h)) / total)});
            guides_.cumulative_.push_back(float(sum / total));
        }
        return list;
    }

    /// Gives guides the list of a wider region in the same component, if local rays missed much of its light.
    void addShared(std::span<const uint32_t> regionOfGuide, std::span<const float> illuminances,
                   ConnectedComponents& components)
    {
        struct Member {
            uint32_t region;
            uint32_t component;
            uint32_t guide;
            [[nodiscard]] bool together(const Member& m) const
            {
                return region == m.region && component == m.component;
            }
        };
        std::vector<Member> order;
        for (uint32_t g = 0; g < guides_.guides_.size(); ++g) {
            if (components.ofRegion(g) != ~0u) order.push_back({regionOfGuide[g], components.ofRegion(g), g});
        }
        std::sort(order.begin(), order.end(), [](const Member& a, const Member& b) {
            return std::tie(a.region, a.component, a.guide) < std::tie(b.region, b.component, b.guide);
        });
        for (std::size_t i = 0; i < order.size();) {
            const Member first = order[i];
            Observations observed(grid_, first.region, 0.0f);
            std::erase_if(observed.hits,
                          [&](const HitStatistics& h) { return components.ofCluster(h.cluster) != first.component; });
            // Root of the sum of squares: a cluster's contribution to the standard deviation.
            const auto deviation = [](const HitStatistics& h) { return std::sqrt(h.squares); };
            observed.keepHighest(kMostEntries, deviation);
            GuideList list;
            for (; i < order.size() && order[i].together(first); ++i) {
                Guide& guide = guides_.guides_[order[i].guide];
                double missed = 0.0;
                for (const HitStatistics& h : observed.hits) {
                    if (guides_.probability(guide.local, h.cluster) <= 0.0f) missed += double(h.squares);
                }
                const float variance = observed.relativeVariance(missed, illuminances[order[i].guide]);
                if (!(variance >= kMuchVariance && variance < kInfinity)) continue;
                if (list.count == 0) list = addList(observed.hits, deviation);
                guide.shared = list;
                guide.relativeVariance += variance;
            }
        }
    }

    std::span<const PatchLight> patches_;
    const PatchComponents& components_;
    std::vector<float> illuminance_; ///< by region of the first width and component
    float width_;                    ///< of the current regions
    ReceiverGrid grid_;
    Guides guides_;
};

Guides buildGuides(const Radiosity& radiosity, const TexelMap& map, const RayTracer& tracer)
{
    const PatchLayout& layout = radiosity.solution.cache.layout();
    if (!(layout.texelMeters > 0.0f)) return {};
    const PatchObservations observations(radiosity);
    std::vector<PatchLight> patches = findPatchLights(radiosity, observations, map, tracer.geometry());
    const PatchComponents components = findComponents(radiosity, observations, patches);
    return GuideBuilder(patches, components, layout.texelMeters).build(observations, layout, tracer);
}

} // namespace halflight
