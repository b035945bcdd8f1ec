// What the baked probes say at a point.
#include "halflight/shading/sh.h"
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace halflight {
namespace {

void accumulate(ProbeSample& sum, const Probe& probe, float weight)
{
    for (std::size_t i = 0; i < sum.radiance.size(); ++i) sum.radiance[i] += weight * probe.radiance[i];
    sum.occlusion += weight * probe.occlusion;
}

ProbeSample emptySum()
{
    ProbeSample sum;
    sum.occlusion = vec4(0.0f);
    return sum;
}

/// The nearest valid probes, nearest first (the earlier one of two at the same distance). Returns how many there are.
template<std::size_t N> std::size_t nearestValid(const std::vector<Probe>& probes, vec3 position,
                                                 std::array<std::pair<float, const Probe*>, N>& nearest)
{
    std::size_t count = 0;
    for (const Probe& probe : probes) {
        if (!probe.valid) continue;
        const vec3 d = probe.position - position;
        const float distanceSquared = glm::dot(d, d);
        if (count == N && !(distanceSquared < nearest[N - 1].first)) continue;
        std::size_t at = count < N ? count++ : N - 1;
        for (; at > 0 && distanceSquared < nearest[at - 1].first; --at) nearest[at] = nearest[at - 1];
        nearest[at] = {distanceSquared, &probe};
    }
    return count;
}

/// Trilinear over the cell, invalid corners left out. Total weight 0 means that no valid corner has a share.
float sampleCell(const ProbeSet& set, vec3 position, ProbeSample& sum)
{
    // A point outside the grid moves to the grid's nearest.
    const vec3 last = vec3(set.size - 1);
    const vec3 at = glm::clamp((position - set.origin) / set.spacingMeters, vec3(0.0f), last);
    const ivec3 low = glm::min(ivec3(at), glm::max(set.size - 2, ivec3(0)));
    const vec3 part = at - vec3(low);
    float total = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const ivec3 side(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        float weight = 1.0f;
        for (int axis = 0; axis < 3; ++axis) weight *= side[axis] != 0 ? part[axis] : 1.0f - part[axis];
        if (weight <= 0.0f) continue;
        const ivec3 p = low + side;
        const Probe& probe =
            set.probes[(std::size_t(p.z) * std::size_t(set.size.y) + std::size_t(p.y)) * std::size_t(set.size.x) +
                       std::size_t(p.x)];
        if (!probe.valid) continue;
        accumulate(sum, probe, weight);
        total += weight;
    }
    return total;
}

} // namespace

// The gradient sky is constant plus two clamped cosines: horizon + (zenith - horizon) max(y, 0) + (ground - horizon)
// max(-y, 0). The projection of a clamped cosine about an axis on basis function i is shIrradianceWeight(i, axis)
// (Ramamoorthi and Hanrahan 2001), so this is exact.
ProbeSample skyProbe(const Sky& sky)
{
    ProbeSample sample;
    sample.radiance[0] = sky.horizon * (4.0f * kPi * shading::shBasis(0, vec3(0, 1, 0)));
    for (int i = 0; i < 9; ++i) {
        sample.radiance[std::size_t(i)] += (sky.zenith - sky.horizon) * shading::shIrradianceWeight(i, vec3(0, 1, 0)) +
                                           (sky.ground - sky.horizon) * shading::shIrradianceWeight(i, vec3(0, -1, 0));
    }
    return sample;
}

ProbeSample sampleProbes(const BakedScene& baked, vec3 position)
{
    const ProbeSet& set = baked.probes;
    const bool isGrid = set.size.x > 0 && set.size.y > 0 && set.size.z > 0;
    assert(!isGrid || set.probes.size() == std::size_t(set.size.x) * std::size_t(set.size.y) * std::size_t(set.size.z));

    ProbeSample sum = emptySum();
    float total = isGrid ? sampleCell(set, position, sum) : 0.0f;
    if (!(total > 1.0e-4f)) {
        // No grid, or a cell whose valid corners have no part in this point: nearest valid probes. One in a grid; in a
        // free list the nearest four by inverse squared distance (Shepard 1968, "A Two-Dimensional Interpolation
        // Function for Irregularly-Spaced Data").
        std::array<std::pair<float, const Probe*>, 4> nearest{};
        const std::size_t found = nearestValid(set.probes, position, nearest);
        if (found == 0) return skyProbe(baked.scene.sky);
        sum = emptySum();
        total = 0.0f;
        const bool single = isGrid || nearest[0].first < 1.0e-8f;
        for (std::size_t i = 0; i < (single ? 1 : found); ++i) {
            const float weight = single ? 1.0f : nearest[0].first / nearest[i].first;
            accumulate(sum, *nearest[i].second, weight);
            total += weight;
        }
    }
    for (vec3& coefficient : sum.radiance) coefficient /= total;
    sum.occlusion /= total;
    return sum;
}

} // namespace halflight
