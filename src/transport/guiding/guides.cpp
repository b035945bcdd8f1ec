#include "transport/guiding/guides.h"

#include <algorithm>

namespace halflight {
namespace {

/// Index of the last element of a range with isBefore(i), or of the first element. The range is partitioned. The search
/// has no branch that depends on data.
template<typename IsBefore> std::size_t lastBefore(std::size_t first, std::size_t count, const IsBefore& isBefore)
{
    while (count > 1) {
        const std::size_t half = count / 2;
        first += isBefore(first + half) ? half : 0;
        count -= half;
    }
    return first;
}

} // namespace

Guide Guides::guideAt(const PatchLayout& layout, const SurfacePoint& point) const
{
    FaceId face;
    if (empty() || !layout.faceOf(point.triangle, false, face) || !layout.hasPatches(face)) return {};
    const PatchId patch = layout.patchAt(face, point.barycentric);
    const uint32_t number = patch < guideOfPatch_.size() ? guideOfPatch_[patch] : ~0u;
    return number != ~0u ? guides_[number] : Guide{};
}

float Guides::probability(const GuideList& list, uint32_t cluster) const
{
    if (list.count == 0) return 0.0f;
    const Entry& entry =
        entries_[lastBefore(list.first, list.count, [&](std::size_t i) { return entries_[i].cluster <= cluster; })];
    return entry.cluster == cluster ? entry.probability : 0.0f;
}

float Guides::probability(const Guide& guide, uint32_t cluster) const
{
    const float local = probability(guide.local, cluster);
    if (guide.shared.count == 0) return local;
    return (1.0f - guide.sharedFraction()) * local + guide.sharedFraction() * probability(guide.shared, cluster);
}

SourcePoint Guides::choosePoint(const Guide& guide, vec2 u) const
{
    const GuideList* list = &guide.local;
    if (guide.shared.count > 0) {
        // The first random number selects the list and is rescaled.
        if (shading::selectsOwn(guide.sharedFraction(), u.x)) list = &guide.shared;
    }
    if (list->count == 0) return {};
    const std::size_t number =
        lastBefore(list->first, list->count, [&](std::size_t i) { return cumulative_[i - 1] <= u.x; });
    const float begin = number == list->first ? 0.0f : cumulative_[number - 1];
    u.x = std::clamp((u.x - begin) / std::max(cumulative_[number] - begin, 1.0e-12f), 0.0f, shading::kBelowOne);
    const Entry& entry = entries_[number];
    const float probability = guide.shared.count > 0 ? this->probability(guide, entry.cluster) : entry.probability;
    return clusters_.choosePoint(entry.cluster, probability, u);
}

} // namespace halflight
