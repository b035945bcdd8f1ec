#include "transport/guiding/patch_components.h"

#include "halflight/base/parallel.h"

#include <algorithm>

namespace halflight {
namespace {

/// Luminance of a patch by component; of an occluded one the mean of its elements.
void componentsOf(const RadianceCache& cache, PatchId patch, std::span<float> out)
{
    const PatchLayout& layout = cache.layout();
    const auto add = [&](PatchId from, float share) {
        const std::span<const ComponentRadiance> light = cache.componentsOf(cache.patches()[from]);
        for (std::size_t c = 0; c < out.size(); ++c) out[c] += share * luminance(light[c].radiance);
    };
    if (layout.elements[patch].split == 0 || cache.patches()[patch].minDistance < kInfinity) return add(patch, 1.0f);
    const PatchId first = layout.elements[patch].first;
    const auto isUsed = [&](PatchId e) { return cache.patches()[e].minDistance < kInfinity; };
    float count = 0.0f;
    for (PatchId e = first; e < first + layout.elementCount(patch); ++e) count += isUsed(e) ? 1.0f : 0.0f;
    for (PatchId e = first; e < first + layout.elementCount(patch); ++e)
        if (isUsed(e)) add(e, 1.0f / count);
}

} // namespace

PatchComponents findComponents(const Radiosity& radiosity, const PatchObservations& observations,
                               std::vector<PatchLight>& lights)
{
    const RadianceCache& cache = radiosity.solution.cache;
    PatchComponents found{cache.componentCount(), {}, radiosity.solution.ofComponents};
    if (found.count == 0) return found;
    found.radiance.resize(lights.size() * found.count);
    const auto radianceOf = [&](std::size_t i) {
        return std::span(found.radiance).subspan(i * found.count, found.count);
    };
    forEachIndex(lights.size(), [&](std::size_t i) { componentsOf(cache, PatchId(i), radianceOf(i)); });
    std::vector<double> means(found.count);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        for (std::size_t c = 0; c < found.count; ++c) means[c] += double(radianceOf(i)[c]) / double(lights.size());
    }
    forEachIndex(observations.frontPatches(), [&](std::size_t patch) {
        const float share = kPi / std::max(lights[patch].rays, 1.0f);
        observations.forSamples(PatchId(patch), [&](const PatchSamples&, std::span<const PatchId> links) {
            for (const PatchId target : links) {
                if (target == kNoPatch) continue;
                const auto light = cache.componentsOf(cache.patches()[observations.patchOf(target)]);
                for (std::size_t c = 0; c < found.count; ++c)
                    found.illuminance[patch * found.count + c] += share * luminance(light[c].radiance);
            }
        });
    });
    forEachIndex(lights.size(), [&](std::size_t i) {
        lights[i].radiance = 0.0f;
        for (std::size_t c = 0; c < found.count; ++c)
            if (means[c] > 0.0) lights[i].radiance += radianceOf(i)[c] / float(means[c]);
    });
    return found;
}

} // namespace halflight
