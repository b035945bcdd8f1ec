// Light probes (spec S14): a coarse grid, halved around rooms and along shadow edges, refined where neighbouring probes
// disagree, with a layer on floors, denoised.
#include "bake/probes/probes.h"
#include "bake/cache/cached_integrator.h"
#include "bake/denoise/denoise.h"
#include "bake/geometry/hash_grid.h"
#include "bake/geometry/indices.h"
#include "bake/probes/probe_rooms.h"

#include "halflight/shading/color.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace halflight {
namespace {

constexpr int kRefinements = 2;                    ///< times that a link can be halved
constexpr std::size_t kGrowth = 4;                 ///< most probes after refinement, over those of the grid
constexpr std::size_t kShadowGrowth = kGrowth / 2; ///< most probes added along shadow edges, over those of the grid
constexpr std::size_t kNewPointsOfCell = 19;       ///< of its 27, all but the corners
/// Standard error of a probe's light, over it, above which it is traced again: denoising divides it by two or three.
constexpr float kNoisy = 0.15f;

using ProbeComponents = std::vector<SphericalHarmonicsL2>;

/// Probes baked so far, and the links between neighbours.
class ProbeBake {
public:
    /// `step` of the lattice that probes are placed on, metres.
    ProbeBake(const CachedIntegrator& cached, float step, const Progress& progress)
        : cached_(cached), step_(step), progress_(progress)
    {}

    std::vector<Probe> probes;
    std::vector<float> variances; ///< by probe: of the luminance of a coefficient, mean over the nine
    std::vector<vec3> sides;      ///< by probe: of the cell that it was placed by, metres
    std::vector<ProbeLink> links;
    std::vector<Place> checked; ///< a place beside a surface in each cell that has one

    [[nodiscard]] std::size_t validCount() const
    {
        return std::size_t(std::count_if(probes.begin(), probes.end(), [](const Probe& p) { return p.valid; }));
    }
    std::vector<ProbeComponents> components; ///< by component: of each probe
    /// Traces probes. `ofComponents`, if given, receives what they have by position and component.
    Status trace(const std::vector<vec3>& positions, std::vector<ProbeEstimate>& estimates,
                 ProbeComponents* ofComponents = nullptr)
    {
        estimates.resize(positions.size());
        if (positions.empty()) return {};
        if (components.empty() || ofComponents == nullptr)
            return cached_.probes(positions, estimates, batches_++, progress_);
        ofComponents->resize(positions.size() * components.size());
        return cached_.probesByComponent(positions, estimates, *ofComponents, batches_++, progress_);
    }
    Status add(const AddedProbes& added)
    {
        std::vector<vec3> positions;
        for (const vec3 position : added.positions) positions.push_back(onProbeLattice(position, step_));
        std::vector<ProbeEstimate> estimates;
        ProbeComponents ofComponents;
        if (Status s = trace(positions, estimates, &ofComponents); !s) return s;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            for (std::size_t c = 0; c < components.size(); ++c)
                components[c].push_back(ofComponents[i * components.size() + c]);
            probes.push_back({positions[i], estimates[i].radiance, estimates[i].occlusion, estimates[i].valid});
            variances.push_back(estimates[i].variance);
        }
        sides.insert(sides.end(), added.sides.begin(), added.sides.end());
        links.insert(links.end(), added.links.begin(), added.links.end());
        return {};
    }
    Status add(const std::vector<vec3>& positions, vec3 cellSides)
    {
        return add(AddedProbes{positions, std::vector<vec3>(positions.size(), cellSides), {}});
    }

    /// Halves cells of the grid until their corners say what light is beside surfaces, or there are `most` probes, the
    /// largest cells first. Where no corner of the last cells sees a place, a probe is put there. Returns the cells.
    Status findRooms(ProbeTree& tree, RoomSearch& search, std::size_t most, std::vector<ProbeTree::Cell>& leaves)
    {
        AddedProbes lonely;
        const auto close = [&](const RoomCell& room, std::optional<uint32_t> unseen) {
            leaves.push_back(room.cell);
            if (!room.places.empty()) checked.push_back(search.at(room.places.front()));
            if (unseen) lonely.add(search.at(*unseen).position, room.cell.sides);
        };
        std::vector<RoomCell> rooms = search.gridCells();
        while (!rooms.empty()) {
            const auto verdicts = search.judge(rooms, probes, progress_);
            if (!verdicts) return verdicts.error();
            std::vector<RoomCell> parts;
            std::vector<ProbeTree::Cell> halved;
            AddedProbes added;
            std::vector<uint32_t> order = allIndices(rooms.size());
            std::stable_sort(order.begin(), order.end(),
                             [&](uint32_t a, uint32_t b) { return (*verdicts)[a].error > (*verdicts)[b].error; });
            for (const uint32_t i : order) {
                const auto& verdict = (*verdicts)[i];
                if (!verdict.halve || validCount() + added.positions.size() + kNewPointsOfCell > most) {
                    close(rooms[i], verdict.unseen);
                    continue;
                }
                std::vector<RoomCell> halves = search.halvesOf(rooms[i]);
                ProbeTree::Cell cell = rooms[i].cell;
                cell.sides = halves.front().cell.sides;
                tree.addProbes(cell, probes.size(), added);
                halved.push_back(cell);
                std::move(halves.begin(), halves.end(), std::back_inserter(parts));
            }
            added.links.clear(); // those of the last cells follow
            if (Status s = add(added); !s) return s;
            for (const ProbeTree::Cell& cell : halved) tree.takeSamples(cell, probes);
            rooms = std::move(parts);
        }
        links = tree.linksOf(leaves);
        lonely.positions.resize(std::min(lonely.positions.size(), most - std::min(most, validCount())));
        lonely.sides.resize(lonely.positions.size());
        return add(lonely);
    }

    /// Up to `most` valid probes in all.
    Status refine(std::size_t most)
    {
        most += probes.size() - validCount();
        std::vector<ProbeLink> level = links;
        for (int i = 0; i < kRefinements && !level.empty(); ++i) {
            Result<AddedProbes> added = probesBetween(probes, sides, level, most, cached_.integrator);
            if (!added) return added.error();
            if (Status s = add(*added); !s) return s;
            level = std::move(added->links);
        }
        return {};
    }

    /// Adds up to `most` probes where shadow edges cross cells. `unresolved`: cells that would need more.
    Status refineShadows(ProbeTree& tree, std::vector<ProbeTree::Cell> cells, std::size_t most,
                         std::vector<ProbeTree::Cell>& unresolved)
    {
        if (cells.size() > kMostProbes)
            std::erase_if(cells, [&](const ProbeTree::Cell& cell) { return !cornersDisagree(tree, cell); });
        std::size_t addedCount = 0;
        while (!cells.empty()) {
            if (Status s = sample(tree, cells); !s) return s;
            tree.keepWrong(cells);
            AddedProbes added;
            std::vector<ProbeTree::Cell> parts;
            for (const ProbeTree::Cell& cell : cells) {
                if (addedCount + added.positions.size() + kNewPointsOfCell > most) {
                    unresolved.push_back(cell);
                    continue;
                }
                tree.addProbes(cell, probes.size(), added);
                for (const ProbeTree::Cell& part : tree.halves(cell))
                    if (tree.canHalve(part, tree.finestMeters())) parts.push_back(part);
            }
            addedCount += added.positions.size();
            cells = std::move(parts);
            if (Status s = add(added); !s) return s;
        }
        return {};
    }

    Status addFloors(std::size_t most)
    {
        const Result<AddedProbes> added = probesOnFloors(probes, sides, most, cached_.integrator);
        return added ? add(*added) : Status(added.error());
    }

    /// Traces noisy probes again, with more paths: beside a doorway, where few of them find light.
    Status calm()
    {
        std::vector<std::size_t> noisy;
        for (std::size_t i = probes.size(); i-- > 0;) {
            const float light = luminance(probes[i].radiance[0]);
            if (probes[i].valid && variances[i] > kNoisy * kNoisy * light * light) noisy.push_back(i);
        }
        const std::size_t runs = 3;
        std::vector<vec3> positions;
        for (std::size_t run = 0; run < runs; ++run)
            for (const std::size_t i : noisy) positions.push_back(probes[i].position);
        std::vector<ProbeEstimate> estimates;
        ProbeComponents ofComponents;
        if (Status s = trace(positions, estimates, &ofComponents); !s) return s;
        const float share = 1.0f / float(1 + runs);
        for (std::size_t n = 0; n < noisy.size(); ++n) {
            Probe& probe = probes[noisy[n]];
            float& variance = variances[noisy[n]];
            for (std::size_t run = 0; run < runs; ++run) {
                const ProbeEstimate& more = estimates[run * noisy.size() + n];
                for (std::size_t k = 0; k < 9; ++k) probe.radiance[k] += more.radiance[k];
                variance += more.variance;
            }
            for (vec3& coefficient : probe.radiance) coefficient *= share;
            variance *= share * share;
            for (std::size_t c = 0; c < components.size(); ++c) {
                for (std::size_t k = 0; k < 9; ++k) {
                    vec3& coefficient = components[c][noisy[n]][k];
                    for (std::size_t run = 0; run < runs; ++run)
                        coefficient += ofComponents[(run * noisy.size() + n) * components.size() + c][k];
                    coefficient *= share;
                }
            }
        }
        return {};
    }

    /// Denoises the light of the probes, and of each component by itself.
    Status denoise(const std::vector<ProbeLink>& along)
    {
        for (ProbeComponents& light : components) {
            // A component's variance is about the sum's, by the square of its share.
            std::vector<Probe> own = withLight(light);
            std::vector<float> ownVariances = variances;
            for (std::size_t i = 0; i < own.size(); ++i) {
                const float all = luminance(probes[i].radiance[0]);
                const float ratio = all > 0.0f ? luminance(own[i].radiance[0]) / all : 0.0f;
                ownVariances[i] *= ratio * ratio;
            }
            if (Status s = denoiseProbes(own, ownVariances, along, cached_.integrator); !s) return s;
            for (std::size_t i = 0; i < own.size(); ++i) light[i] = own[i].radiance;
        }
        return denoiseProbes(probes, variances, along, cached_.integrator);
    }
    [[nodiscard]] std::vector<Probe> withLight(const ProbeComponents& light) const
    {
        std::vector<Probe> own = probes;
        for (std::size_t i = 0; i < own.size(); ++i) own[i].radiance = light[i];
        return own;
    }

    /// Moves the probes into a grid's set, the invalid ones with the light of those around them.
    void finishGrid(ProbeSet& set)
    {
        for (ProbeComponents& light : components) {
            set.probes = withLight(light);
            fillInvalidProbes(set);
            for (std::size_t i = 0; i < light.size(); ++i) light[i] = set.probes[i].radiance;
        }
        set.probes = std::move(probes);
        fillInvalidProbes(set);
    }

    /// Removes probes inside geometry, and all but the first of probes at one place.
    void removeSuperfluous(float cellMeters)
    {
        DistinctPoints places(cellMeters);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < probes.size(); ++i) {
            if (!probes[i].valid || !places.insert(probes[i].position)) continue;
            probes[kept] = probes[i];
            for (ProbeComponents& light : components) light[kept] = light[i];
            ++kept;
        }
        probes.resize(kept);
        for (ProbeComponents& light : components) light.resize(kept);
    }

private:
    /// Occlusion at the points of the cells that have none, of few paths each.
    Status sample(ProbeTree& tree, std::span<const ProbeTree::Cell> cells) const
    {
        const std::vector<ivec3> points = tree.unsampledPoints(cells);
        std::vector<vec3> positions;
        positions.reserve(points.size());
        for (const ivec3 point : points) positions.push_back(tree.positionOf(point));
        std::vector<ProbeEstimate> tests(points.size());
        const Progress quiet{{}, progress_.cancel};
        const std::vector<uint32_t> all = allIndices(points.size());
        if (Status s = cached_.integrator.probes(positions, all, kTestPaths, tests, quiet); !s) return s;
        for (std::size_t i = 0; i < points.size(); ++i)
            tree.at(points[i]) = {tests[i].occlusion, tests[i].valid, std::nullopt};
        return {};
    }
    bool cornersDisagree(ProbeTree& tree, const ProbeTree::Cell& cell) const
    {
        MaskValues least(1.0f);
        MaskValues most(0.0f);
        for (const uint32_t corner : tree.validCorners(cell)) {
            least = min(least, probes[corner].occlusion);
            most = max(most, probes[corner].occlusion);
        }
        return largestExcess(most, least) > kDisagrees;
    }

    const CachedIntegrator& cached_;
    float step_;
    const Progress& progress_;
    int batches_ = 0;
};

/// Checks in places that do not count.
void leaveOutUnlit(const std::vector<Place>& checked, BakedProbes& probes)
{
    const float dark = darkIrradiance(probes.set.probes).value_or(0.0f);
    for (std::size_t i = 0; i < checked.size(); ++i)
        if (isUnlit(checked[i], probes.checks[i].radiance, dark)) probes.checks[i].valid = false;
}

std::string shadowEdgeWarning(const ProbeTree& tree, std::span<const ProbeTree::Cell> unresolved)
{
    float longest = 0.0f;
    for (const ProbeTree::Cell& cell : unresolved) {
        const vec3 sides = tree.sidesOf(cell);
        longest = std::max({longest, sides.x, sides.y, sides.z});
    }
    return "probes: shadow edges cross " + std::to_string(unresolved.size()) +
           " more places than there are probes for; moving objects there have shadows blurred over up to " +
           std::to_string(longest) + " m; --probe-spacing makes all probes denser";
}

} // namespace

Result<BakedProbes> bakeProbes(const Scene& scene, float spacingMeters, ProbeLayout layout, bool denoise,
                               const CachedIntegrator& cached, std::vector<std::string>& warnings,
                               const Progress& progress)
{
    Bounds box = scene.bounds(true);
    for (const vec3 position : scene.probePositions) box.extend(position);
    ProbeBake bake(cached, box.empty() ? 0.0f : probeStep(box.size()), progress);
    bake.components.resize(std::size_t(cached.settings.components.count));
    BakedProbes result;
    ProbeSet& set = result.set;
    set = probeGrid(scene, scene.probePositions.empty() ? spacingMeters : 0.0f, warnings);
    const float reach = set.probes.empty() ? 0.0f : std::min(kFinestMeters, shortestSide(set.spacingMeters));
    std::vector<Place> places;
    if (!set.probes.empty()) {
        Result<std::vector<Place>> found = placesBesideSurfaces(scene.bounds(true), reach, cached.integrator);
        if (!found) return found.error();
        places = std::move(*found);
    }
    const auto finish = [&](std::vector<Probe> probes, const std::vector<Place>& between) -> Result<BakedProbes> {
        set.probes = std::move(probes);
        result.components = std::move(bake.components);
        const std::vector<Place> checked = checkPlaces(between, set.probes.size());
        for (const Place& place : checked) result.checkedAt.push_back(place.position);
        if (Status s = bake.trace(result.checkedAt, result.checks); !s) return s.error();
        leaveOutUnlit(checked, result);
        return std::move(result);
    };
    if (!scene.probePositions.empty()) {
        // Positions of the author: all are kept, in their order.
        if (Status s = bake.add(scene.probePositions, vec3(0.0f)); !s) return s.error();
        set = {};
        return finish(std::move(bake.probes), places);
    }
    if (set.probes.empty()) return result;
    std::vector<vec3> positions;
    for (const Probe& probe : set.probes) positions.push_back(probe.position);
    if (Status s = bake.add(positions, set.spacingMeters); !s) return s.error();
    ProbeTree tree(set, bake.probes);

    if (layout == ProbeLayout::Grid) {
        if (denoise) {
            const std::vector<ProbeLink> links = tree.linksOf(tree.gridCells());
            if (Status s = bake.denoise(links); !s) return s.error();
        }
        bake.finishGrid(set);
        return finish(std::move(set.probes), places);
    }
    // Each step leaves some of the probes to those after it.
    const std::size_t gridCount = positions.size();
    const bool bounded = spacingMeters <= 0.0f; // else there are as many as the spacing asks for
    const std::size_t limit = bounded ? kMostProbes : 2 * (kGrowth + kShadowGrowth) * (gridCount + kMostProbes);
    std::vector<ProbeTree::Cell> cells;
    RoomSearch search(tree, std::move(places), reach, cached.integrator);
    const std::size_t most = std::max(std::min(limit, gridCount + kMostProbes) / 16 * 10, gridCount);
    if (Status s = bake.findRooms(tree, search, most, cells); !s) return s.error();
    const std::size_t rooms = bake.probes.size();
    const std::size_t refined = std::min(rooms + (kGrowth - 1) * std::max(gridCount, rooms / 2), limit / 16 * 13);
    if (Status s = bake.refine(refined); !s) return s.error();
    std::vector<ProbeTree::Cell> unresolved;
    const bool masked = std::any_of(scene.lights.begin(), scene.lights.end(),
                                    [](const Light& light) { return light.baking.occlusionMaskChannel >= 0; });
    const std::size_t left = limit / 16 * 15 - std::min(limit / 16 * 15, bake.validCount());
    if (masked) {
        const std::size_t added = std::min(std::max(kShadowGrowth * gridCount, rooms), left);
        if (Status s = bake.refineShadows(tree, cells, added, unresolved); !s) return s.error();
    }
    if (!unresolved.empty()) warnings.push_back(shadowEdgeWarning(tree, unresolved));
    const std::size_t withFloors = bake.probes.size() + limit - std::min(limit, bake.validCount());
    if (Status s = bake.addFloors(withFloors); !s) return s.error();
    if (Status s = bake.calm(); !s) return s.error();
    if (denoise)
        if (Status s = bake.denoise(bake.links); !s) return s.error();
    float shortest = kInfinity;
    for (const vec3 sides : bake.sides) shortest = std::min(shortest, shortestSide(sides));
    bake.removeSuperfluous(kSamePlaceShare * shortest);
    // The set stays a grid if nothing was added and nothing removed.
    const bool isGrid = bake.probes.size() == gridCount && bake.variances.size() == gridCount;
    if (!isGrid) set = {vec3(0.0f), vec3(1.0f), ivec3(0), {}};
    return finish(std::move(bake.probes), bake.checked);
}

} // namespace halflight
