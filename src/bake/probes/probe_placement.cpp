#include "bake/probes/probe_placement.h"

#include "bake/geometry/hash_grid.h"
#include "bake/geometry/surfaces_along.h"
#include "bake/probes/probe_tree.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/color.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace halflight {
namespace {

/// Irradiance below this share of the median probe's counts as dark, so that its differences count little.
constexpr float kDarkShare = 0.01f;
/// Distance of a probe from a wall, over the spacing. Probes on both sides of a wall are two layers at twice this
/// distance from each other. No Delaunay tetrahedron reaches through both: the smallest sphere around a triangle of one
/// layer, half a diagonal of the grid in radius, ends before the other.
constexpr float kWallShare = 0.36f;
constexpr float kShortestShare = 0.3f; ///< a link is halved if both halves are longer than this share of the spacing
constexpr float kFloorShare = 0.02f;   ///< height of the probes on floors, over the spacing

struct Disagreement {
    ProbeLink link;
    float size = 0.0f;
    std::optional<vec2> surfaces; ///< distances of the first and the last surface from probe a, metres
};

/// The links whose ends disagree, largest disagreement first.
Result<std::vector<Disagreement>> disagreements(std::span<const Probe> probes, std::span<const ProbeLink> links,
                                                float dark, const Integrator& integrator)
{
    std::vector<Disagreement> all(links.size());
    parallelFor(links.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Probe& a = probes[links[i].a];
            const Probe& b = probes[links[i].b];
            all[i].link = links[i];
            if (!a.valid && !b.valid) continue;
            // Light often changes beside geometry, and a probe inside it has no light to compare.
            all[i].size = a.valid && b.valid ? disagreement(std::array{&a, &b}, dark) : 1.0f;
        }
    });
    std::erase_if(all, [](const Disagreement& d) { return d.size < 1.0f; });
    std::vector<Segment> segments;
    segments.reserve(all.size());
    for (const Disagreement& d : all) segments.push_back({probes[d.link.a].position, probes[d.link.b].position});
    const Result<SurfacesAlong> surfaces = surfacesAlong(integrator, segments);
    if (!surfaces) return surfaces.error();
    for (std::size_t i = 0; i < all.size(); ++i) all[i].surfaces = (*surfaces)[i];
    std::stable_sort(all.begin(), all.end(),
                     [](const Disagreement& x, const Disagreement& y) { return x.size > y.size; });
    return all;
}

/// Adds probes that are linked with one that is there already.
class Adder {
public:
    explicit Adder(std::size_t probeCount) : probeCount_(probeCount) {}
    uint32_t add(uint32_t neighbour, vec3 position, float spacing, vec3 sides)
    {
        const auto index = uint32_t(total());
        added.add(position, sides);
        added.links.push_back({neighbour, index, spacing});
        return index;
    }
    [[nodiscard]] std::size_t total() const { return probeCount_ + added.positions.size(); }

    AddedProbes added;

private:
    std::size_t probeCount_;
};

/// Adds a probe on each side of the surfaces on a link, unless that side's probe is close to them already. The distance
/// between the two layers stays 2 × `wall`: where one probe is closer, the other side's keeps the difference.
void addBesideWall(const Disagreement& d, const Probe& a, const Probe& b, vec3 sides, Adder& adder)
{
    const float wall = kWallShare * d.link.spacing;
    const float length = glm::distance(a.position, b.position);
    const vec3 direction = (b.position - a.position) / length;
    const float fromA = d.surfaces->x;
    const float fromB = length - d.surfaces->y;
    const auto isNear = [&](const Probe& probe, float distance) { return probe.valid && distance <= 1.5f * wall; };
    const bool nearA = isNear(a, fromA);
    const bool nearB = isNear(b, fromB);
    const float offA = nearB ? std::max(wall, 2.0f * wall - fromB) : wall;
    const float offB = nearA ? std::max(wall, 2.0f * wall - fromA) : wall;
    if (a.valid && !nearA && fromA > offA)
        adder.add(d.link.a, a.position + direction * (fromA - offA), d.link.spacing, sides);
    if (b.valid && !nearB && fromB > offB)
        adder.add(d.link.b, b.position - direction * (fromB - offB), d.link.spacing, sides);
}

/// Weight of a linked probe's coefficients, exp(-2 d / noise) with d the difference in excess of the expected noise.
float bilateralWeight(const Probe& a, const Probe& b, float noise)
{
    if (!a.valid || !b.valid || noise <= 0.0f) return 0.0f;
    float difference = 0.0f;
    for (std::size_t k = 0; k < 9; ++k) {
        const float d = luminance(a.radiance[k] - b.radiance[k]);
        difference += d * d;
    }
    const float excess = std::max(difference - noise, 0.0f);
    return excess > noise ? 0.0f : math::exp(-2.0f * excess / noise);
}

} // namespace

float probeStep(vec3 boxSize)
{
    const float largest = std::max({boxSize.x, boxSize.y, boxSize.z});
    return largest > 0.0f ? math::exp2(std::ceil(math::log2(largest)) - 20.0f) : 0.0f;
}

vec3 onProbeLattice(vec3 position, float step)
{
    return step > 0.0f ? glm::round(position / step) * step : position;
}

std::optional<float> darkIrradiance(std::span<const Probe> probes)
{
    std::vector<float> means;
    for (const Probe& probe : probes)
        if (probe.valid) means.push_back(luminance(probe.radiance[0]));
    if (means.empty()) return std::nullopt;
    std::nth_element(means.begin(), means.begin() + std::ptrdiff_t(means.size() / 2), means.end());
    return kDarkShare * means[means.size() / 2] * shading::shIrradianceWeight(0, vec3(0, 1, 0));
}

std::array<float, 6> irradianceAround(const SphericalHarmonicsL2& radiance)
{
    std::array<float, 6> sides{};
    for (int side = 0; side < 6; ++side) {
        vec3 n(0.0f);
        n[side / 2] = side % 2 == 0 ? 1.0f : -1.0f;
        for (int i = 0; i < 9; ++i)
            sides[std::size_t(side)] += luminance(radiance[std::size_t(i)]) * shading::shIrradianceWeight(i, n);
        sides[std::size_t(side)] = std::max(sides[std::size_t(side)], 0.0f);
    }
    return sides;
}

float disagreement(std::span<const Probe* const> probes, float dark)
{
    std::array<float, 6> least;
    std::array<float, 6> largest;
    least.fill(kInfinity);
    largest.fill(0.0f);
    MaskValues mostHidden(1.0f);
    MaskValues leastHidden(0.0f);
    for (const Probe* probe : probes) {
        const std::array<float, 6> sides = irradianceAround(probe->radiance);
        for (std::size_t i = 0; i < 6; ++i) {
            least[i] = std::min(least[i], sides[i]);
            largest[i] = std::max(largest[i], sides[i]);
        }
        mostHidden = min(mostHidden, probe->occlusion);
        leastHidden = max(leastHidden, probe->occlusion);
    }
    float most = 0.0f;
    for (std::size_t i = 0; i < 6; ++i) {
        const float larger = std::max(largest[i], dark);
        if (larger > 0.0f) most = std::max(most, (largest[i] - least[i]) / larger / kDisagrees);
    }
    return std::max(most, largestExcess(leastHidden, mostHidden) / kDisagrees);
}

Result<AddedProbes> probesBetween(std::span<const Probe> probes, std::span<const vec3> sides,
                                  std::span<const ProbeLink> links, std::size_t most, const Integrator& integrator)
{
    const std::optional<float> dark = darkIrradiance(probes);
    if (!dark) return AddedProbes();
    const Result<std::vector<Disagreement>> found = disagreements(probes, links, *dark, integrator);
    if (!found) return found.error();
    Adder adder(probes.size());
    for (const Disagreement& d : *found) {
        if (adder.total() + 2 > most) break;
        const Probe& a = probes[d.link.a];
        const Probe& b = probes[d.link.b];
        if (d.surfaces) {
            addBesideWall(d, a, b, sides[d.link.a], adder);
        } else if (a.valid && b.valid &&
                   glm::distance(a.position, b.position) >= 2.0f * kShortestShare * d.link.spacing) {
            const vec3 position = 0.5f * (a.position + b.position);
            const uint32_t middle = adder.add(d.link.a, position, d.link.spacing, sides[d.link.a]);
            adder.added.links.push_back({middle, d.link.b, d.link.spacing});
        }
    }
    return std::move(adder.added);
}

Result<AddedProbes> probesOnFloors(std::span<const Probe> probes, std::span<const vec3> sides, std::size_t most,
                                   const Integrator& integrator)
{
    std::vector<uint32_t> above;
    std::vector<Segment> segments;
    float finest = kInfinity;
    for (uint32_t i = 0; i < probes.size(); ++i) {
        if (!probes[i].valid) continue;
        above.push_back(i);
        segments.push_back({probes[i].position, probes[i].position - vec3(0.0f, sides[i].y, 0.0f)});
        finest = std::min(finest, shortestSide(sides[i]));
    }
    const Result<SurfacesAlong> surfaces = surfacesAlong(integrator, segments);
    if (!surfaces) return surfaces.error();
    DistinctPoints floorPoints(kSamePlaceShare * finest); // probes of one column share theirs
    Adder adder(probes.size());
    for (std::size_t k = 0; k < above.size() && adder.total() < most; ++k) {
        const vec3 cell = sides[above[k]];
        const float height = kFloorShare * shortestSide(cell);
        const float low = shortestSide(cell) > kFinestMeters ? 0.25f * kFinestMeters : 2.0f * height;
        const std::optional<vec2>& floor = (*surfaces)[k];
        if (!floor || floor->x <= low) continue;
        const vec3 foot = segments[k].from - vec3(0.0f, floor->x - height, 0.0f);
        if (floorPoints.insert(foot)) adder.add(above[k], foot, shortestSide(cell), cell);
    }
    return std::move(adder.added);
}

namespace {

/// One pass; variances become those of the results, as if probes were independent.
void smoothOnce(std::span<Probe> probes, std::span<float> variances, std::span<const ProbeLink> links,
                std::span<const uint8_t> isOpen)
{
    std::vector<float> linkWeights(links.size(), 0.0f);
    parallelFor(links.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float noise = 3.0f * 3.0f * (variances[links[i].a] + variances[links[i].b]); // 3 standard deviations
            if (isOpen[i] != 0) linkWeights[i] = bilateralWeight(probes[links[i].a], probes[links[i].b], noise);
        }
    });
    std::vector<SphericalHarmonicsL2> sums(probes.size());
    std::vector<float> weights(probes.size(), 1.0f);
    std::vector<float> squares(variances.begin(), variances.end()); // sums of squared weights times variances
    for (std::size_t i = 0; i < probes.size(); ++i) sums[i] = probes[i].radiance;
    for (std::size_t i = 0; i < links.size(); ++i) {
        const auto [a, b, spacing] = links[i];
        const float weight = linkWeights[i];
        if (weight == 0.0f) continue;
        for (std::size_t k = 0; k < 9; ++k) {
            sums[a][k] += weight * probes[b].radiance[k];
            sums[b][k] += weight * probes[a].radiance[k];
        }
        weights[a] += weight;
        weights[b] += weight;
        squares[a] += weight * weight * variances[b];
        squares[b] += weight * weight * variances[a];
    }
    for (std::size_t i = 0; i < probes.size(); ++i) {
        for (std::size_t k = 0; k < 9; ++k) probes[i].radiance[k] = sums[i][k] / weights[i];
        variances[i] = squares[i] / (weights[i] * weights[i]);
    }
}

} // namespace

Status denoiseProbes(std::span<Probe> probes, std::vector<float> variances, std::span<const ProbeLink> links,
                     const Integrator& integrator)
{
    std::vector<Segment> segments;
    segments.reserve(links.size());
    for (const ProbeLink& link : links) segments.push_back({probes[link.a].position, probes[link.b].position});
    const Result<SurfacesAlong> surfaces = surfacesAlong(integrator, segments);
    if (!surfaces) return surfaces.error();
    std::vector<uint8_t> isOpen;
    for (const auto& surface : *surfaces) isOpen.push_back(surface ? 0 : 1);
    for (int pass = 0; pass < 2; ++pass) smoothOnce(probes, variances, links, isOpen); // more would blur light
    return {};
}

} // namespace halflight
