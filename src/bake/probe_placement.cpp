#include "bake/probe_placement.h"

#include "bake/hash_grid.h"
#include "bake/occlusion_cells.h"

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
constexpr float kDarkShare = 0.05f;
/// Distance of a probe from a wall, over the spacing. Probes on both sides of a wall are two layers at twice this
/// distance from each other. No Delaunay tetrahedron reaches through both: the smallest sphere around a triangle of one
/// layer, half a diagonal of the grid in radius, ends before the other.
constexpr float kWallShare = 0.36f;
constexpr float kShortestShare = 0.3f; ///< a link is halved if both halves are longer than this share of the spacing
constexpr float kFloorShare = 0.02f;   ///< height of the probes on floors, over the spacing

/// Irradiance (luminance, lux) on the six faces of a small cube.
std::array<float, 6> irradianceAround(const Probe& probe)
{
    std::array<float, 6> sides{};
    for (int side = 0; side < 6; ++side) {
        vec3 n(0.0f);
        n[side / 2] = side % 2 == 0 ? 1.0f : -1.0f;
        for (int i = 0; i < 9; ++i)
            sides[std::size_t(side)] += luminance(probe.radiance[std::size_t(i)]) * shading::shIrradianceWeight(i, n);
        sides[std::size_t(side)] = std::max(sides[std::size_t(side)], 0.0f);
    }
    return sides;
}

/// 1 or more where two probes need one in between. `dark`: irradiance in lux below which differences count little.
float disagreement(const Probe& a, const Probe& b, float dark)
{
    float most = 0.0f;
    const auto sidesA = irradianceAround(a);
    const auto sidesB = irradianceAround(b);
    for (std::size_t i = 0; i < 6; ++i) {
        const float larger = std::max({sidesA[i], sidesB[i], dark});
        if (larger > 0.0f) most = std::max(most, std::abs(sidesA[i] - sidesB[i]) / larger / kDisagrees);
    }
    for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(a.occlusion[c] - b.occlusion[c]) / kDisagrees);
    return most;
}

/// Lux; nothing where no probe is valid.
std::optional<float> darkIrradiance(std::span<const Probe> probes)
{
    std::vector<float> means;
    for (const Probe& probe : probes)
        if (probe.valid) means.push_back(luminance(probe.radiance[0]));
    if (means.empty()) return std::nullopt;
    std::nth_element(means.begin(), means.begin() + std::ptrdiff_t(means.size() / 2), means.end());
    return kDarkShare * means[means.size() / 2] * shading::shIrradianceWeight(0, vec3(0, 1, 0));
}

struct Disagreement {
    ProbeLink link;
    float size = 0.0f;
    std::optional<vec2> surfaces; ///< distances of the first and the last surface from probe a, metres
};

/// The links whose ends disagree, largest disagreement first.
std::vector<Disagreement> disagreements(std::span<const Probe> probes, std::span<const ProbeLink> links, float dark,
                                        const Integrator& integrator)
{
    std::vector<Disagreement> all(links.size());
    parallelFor(links.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Probe& a = probes[links[i].a];
            const Probe& b = probes[links[i].b];
            all[i].link = links[i];
            if (!a.valid && !b.valid) continue;
            // Light often changes beside geometry, and a probe inside it has no light to compare.
            all[i].size = a.valid && b.valid ? disagreement(a, b, dark) : 1.0f;
        }
    });
    std::erase_if(all, [](const Disagreement& d) { return d.size < 1.0f; });
    std::vector<Segment> segments;
    segments.reserve(all.size());
    for (const Disagreement& d : all) segments.push_back({probes[d.link.a].position, probes[d.link.b].position});
    std::vector<std::optional<vec2>> surfaces(segments.size());
    integrator.surfacesAlong(segments, surfaces);
    for (std::size_t i = 0; i < all.size(); ++i) all[i].surfaces = surfaces[i];
    std::stable_sort(all.begin(), all.end(),
                     [](const Disagreement& x, const Disagreement& y) { return x.size > y.size; });
    return all;
}

/// Adds probes that are linked with one that is there already.
class Adder {
public:
    explicit Adder(std::size_t probeCount) : probeCount_(probeCount) {}
    uint32_t add(uint32_t neighbour, vec3 position)
    {
        const auto index = uint32_t(total());
        added.positions.push_back(position);
        added.links.push_back({neighbour, index});
        return index;
    }
    [[nodiscard]] std::size_t total() const { return probeCount_ + added.positions.size(); }

    AddedProbes added;

private:
    std::size_t probeCount_;
};

/// Adds a probe on each side of the surfaces on a link, unless that side's probe is close to them already. The distance
/// between the two layers stays 2 × `wall`: where one probe is closer, the other side's keeps the difference.
void addBesideWall(const Disagreement& d, const Probe& a, const Probe& b, float wall, Adder& adder)
{
    const float length = glm::distance(a.position, b.position);
    const vec3 direction = (b.position - a.position) / length;
    const float fromA = d.surfaces->x;
    const float fromB = length - d.surfaces->y;
    const auto isNear = [&](const Probe& probe, float distance) { return probe.valid && distance <= 1.5f * wall; };
    const bool nearA = isNear(a, fromA);
    const bool nearB = isNear(b, fromB);
    const float offA = nearB ? std::max(wall, 2.0f * wall - fromB) : wall;
    const float offB = nearA ? std::max(wall, 2.0f * wall - fromA) : wall;
    if (a.valid && !nearA && fromA > offA) adder.add(d.link.a, a.position + direction * (fromA - offA));
    if (b.valid && !nearB && fromB > offB) adder.add(d.link.b, b.position - direction * (fromB - offB));
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
    return excess > noise ? 0.0f : std::exp(-2.0f * excess / noise);
}

} // namespace

std::vector<ProbeLink> linksOfGrid(ivec3 size)
{
    std::vector<ProbeLink> links;
    const auto index = [&](int x, int y, int z) { return uint32_t((z * size.y + y) * size.x + x); };
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                if (x + 1 < size.x) links.push_back({index(x, y, z), index(x + 1, y, z)});
                if (y + 1 < size.y) links.push_back({index(x, y, z), index(x, y + 1, z)});
                if (z + 1 < size.z) links.push_back({index(x, y, z), index(x, y, z + 1)});
            }
        }
    }
    return links;
}

AddedProbes probesBetween(std::span<const Probe> probes, std::span<const ProbeLink> links, float spacing,
                          std::size_t most, const Integrator& integrator)
{
    const std::optional<float> dark = darkIrradiance(probes);
    if (!dark) return {};
    Adder adder(probes.size());
    for (const Disagreement& d : disagreements(probes, links, *dark, integrator)) {
        if (adder.total() + 2 > most) break;
        const Probe& a = probes[d.link.a];
        const Probe& b = probes[d.link.b];
        if (d.surfaces) {
            addBesideWall(d, a, b, kWallShare * spacing, adder);
        } else if (a.valid && b.valid && glm::distance(a.position, b.position) >= 2.0f * kShortestShare * spacing) {
            const uint32_t middle = adder.add(d.link.a, 0.5f * (a.position + b.position));
            adder.added.links.push_back({middle, d.link.b});
        }
    }
    return std::move(adder.added);
}

AddedProbes probesOnFloors(std::span<const Probe> probes, float spacing, float reachMeters,
                           const Integrator& integrator)
{
    const float height = kFloorShare * spacing;
    std::vector<uint32_t> above;
    std::vector<Segment> segments;
    for (uint32_t i = 0; i < probes.size(); ++i) {
        if (!probes[i].valid) continue;
        above.push_back(i);
        segments.push_back({probes[i].position, probes[i].position - vec3(0.0f, reachMeters, 0.0f)});
    }
    std::vector<std::optional<vec2>> surfaces(segments.size());
    integrator.surfacesAlong(segments, surfaces);
    DistinctPoints floorPoints(kSamePlaceShare * spacing); // probes of one column share theirs
    Adder adder(probes.size());
    for (std::size_t k = 0; k < above.size(); ++k) {
        if (!surfaces[k] || surfaces[k]->x <= 2.0f * height) continue;
        const vec3 foot = segments[k].from - vec3(0.0f, surfaces[k]->x - height, 0.0f);
        if (floorPoints.insert(foot)) adder.add(above[k], foot);
    }
    return std::move(adder.added);
}

void denoiseProbes(std::span<Probe> probes, std::span<const float> variances, std::span<const ProbeLink> links,
                   const Integrator& integrator)
{
    std::vector<float> linkWeights(links.size(), 0.0f);
    parallelFor(links.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float noise = 3.0f * 3.0f * (variances[links[i].a] + variances[links[i].b]); // 3 standard deviations
            linkWeights[i] = bilateralWeight(probes[links[i].a], probes[links[i].b], noise);
        }
    });
    std::vector<uint32_t> weighted;
    std::vector<Segment> segments;
    for (uint32_t i = 0; i < links.size(); ++i) {
        if (linkWeights[i] == 0.0f) continue;
        weighted.push_back(i);
        segments.push_back({probes[links[i].a].position, probes[links[i].b].position});
    }
    std::vector<std::optional<vec2>> surfaces(segments.size());
    integrator.surfacesAlong(segments, surfaces);

    std::vector<SphericalHarmonicsL2> sums(probes.size());
    std::vector<float> weights(probes.size(), 1.0f);
    for (std::size_t i = 0; i < probes.size(); ++i) sums[i] = probes[i].radiance;
    for (std::size_t w = 0; w < weighted.size(); ++w) {
        if (surfaces[w]) continue;
        const ProbeLink link = links[weighted[w]];
        const float weight = linkWeights[weighted[w]];
        for (std::size_t k = 0; k < 9; ++k) {
            sums[link.a][k] += weight * probes[link.b].radiance[k];
            sums[link.b][k] += weight * probes[link.a].radiance[k];
        }
        weights[link.a] += weight;
        weights[link.b] += weight;
    }
    for (std::size_t i = 0; i < probes.size(); ++i) {
        for (std::size_t k = 0; k < 9; ++k) probes[i].radiance[k] = sums[i][k] / weights[i];
    }
}

} // namespace halflight
