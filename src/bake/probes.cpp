// Light probes (spec S14): a coarse grid, refined where neighbouring probes disagree and along shadow edges, with a
// layer on floors, denoised.
#include "bake/gather.h"
#include "bake/hash_grid.h"
#include "bake/occlusion_cells.h"
#include "bake/probe_placement.h"
#include "bake/stages.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace halflight {
namespace {

constexpr int kRefinements = 2;              ///< times that a link can be halved
constexpr std::size_t kGrowth = 4;           ///< most probes after refinement, over those of the grid
constexpr std::size_t kShadowGrowth = 2;     ///< most probes added along shadow edges, over those of the grid
constexpr int kTestPaths = 8;                ///< paths of a test point: enough to find those inside geometry
constexpr std::size_t kNewPointsOfCell = 19; ///< of its 27, all but the corners

/// Probes baked so far, and the links between neighbours.
class ProbeBake {
public:
    ProbeBake(const Gather& gather, const Progress& progress) : gather_(gather), progress_(progress) {}

    std::vector<Probe> probes;
    std::vector<float> variances; ///< by probe: of the luminance of a coefficient, mean over the nine
    std::vector<ProbeLink> links;

    /// Traces the probes. False when cancelled, as the functions below.
    bool add(const std::vector<vec3>& positions)
    {
        if (positions.empty()) return true;
        std::vector<ProbeEstimate> estimates(positions.size());
        if (!gather_.probes(positions, estimates, batches_++, progress_)) return false;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            probes.push_back({positions[i], estimates[i].radiance, estimates[i].occlusion, estimates[i].valid});
            variances.push_back(estimates[i].variance);
        }
        return true;
    }
    bool add(const AddedProbes& added)
    {
        links.insert(links.end(), added.links.begin(), added.links.end());
        return add(added.positions);
    }

    bool refine(float spacing, std::size_t most)
    {
        std::vector<ProbeLink> level = links;
        for (int i = 0; i < kRefinements && !level.empty(); ++i) {
            AddedProbes added = probesBetween(probes, level, spacing, most, gather_.integrator);
            if (!add(added)) return false;
            level = std::move(added.links);
        }
        return true;
    }

    /// Adds up to `most` probes where shadow edges cross cells of the grid. `unresolved`: cells that would need more.
    bool refineShadows(const ProbeSet& grid, std::size_t most, std::size_t& unresolved)
    {
        unresolved = 0;
        OcclusionCells cells(grid, probes);
        std::size_t addedCount = 0;
        for (int level = 0; level < OcclusionCells::kLevels && !cells.cells().empty(); ++level) {
            if (!sample(cells)) return false;
            cells.estimateErrors();
            AddedProbes added;
            std::size_t taken = 0;
            for (; taken < cells.cells().size() && addedCount + added.positions.size() + kNewPointsOfCell <= most;
                 ++taken)
                addCell(cells, cells.cells()[taken], added);
            unresolved += cells.cells().size() - taken;
            addedCount += added.positions.size();
            cells.subdivide(taken);
            if (!add(added)) return false;
        }
        return true;
    }

    bool addFloors(float spacing, float reachMeters)
    {
        return add(probesOnFloors(probes, spacing, reachMeters, gather_.integrator));
    }

private:
    /// Occlusion at the points of the cells that have none, of few paths each.
    bool sample(OcclusionCells& cells) const
    {
        const std::vector<ivec3> points = cells.unsampledPoints();
        std::vector<vec3> positions;
        positions.reserve(points.size());
        for (const ivec3 point : points) positions.push_back(cells.positionOf(point));
        std::vector<ProbeEstimate> tests(points.size());
        const Progress quiet{{}, progress_.cancel};
        if (!gather_.integrator.probes(positions, allIndices(points.size()), kTestPaths, tests, quiet)) return false;
        for (std::size_t i = 0; i < points.size(); ++i)
            cells.at(points[i]) = {tests[i].occlusion, tests[i].valid, std::nullopt};
        return true;
    }
    /// Probes at the valid points of a cell, linked along the axes.
    void addCell(OcclusionCells& cells, const OcclusionCells::Cell& cell, AddedProbes& added) const
    {
        OcclusionCells::forPoints(cell, [&](ivec3 point, ivec3 offset) {
            OcclusionCells::Sample& sample = cells.at(point);
            if (sample.valid && !sample.probe) {
                sample.probe = uint32_t(probes.size() + added.positions.size());
                added.positions.push_back(cells.positionOf(point));
            }
            for (int axis = 0; axis < 3; ++axis) {
                ivec3 before = point;
                before[axis] -= cell.size / 2;
                if (!sample.probe || offset[axis] == 0 || !cells.at(before).probe) continue;
                added.links.push_back({*cells.at(before).probe, *sample.probe});
            }
        });
    }

    const Gather& gather_;
    const Progress& progress_;
    int batches_ = 0;
};

/// Removes probes inside geometry, and all but the first of probes at one place.
void removeSuperfluous(std::vector<Probe>& probes, float cellMeters)
{
    DistinctPoints places(cellMeters);
    std::erase_if(probes, [&](const Probe& probe) { return !probe.valid || !places.insert(probe.position); });
}

std::string shadowEdgeWarning(std::size_t unresolved, vec3 spacing)
{
    return "probes: shadow edges cross " + std::to_string(unresolved) +
           " more places than there are probes for; moving objects there have shadows blurred over up to " +
           std::to_string(std::max({spacing.x, spacing.y, spacing.z})) + " m; --probe-spacing makes all probes denser";
}

} // namespace

std::optional<ProbeSet> bakeProbes(const Scene& scene, float spacingMeters, ProbeLayout layout, bool denoise,
                                   const Gather& gather, std::vector<std::string>& warnings, const Progress& progress)
{
    ProbeBake bake(gather, progress);
    ProbeSet set;
    if (!scene.probePositions.empty()) {
        // Positions of the author: all are kept, in their order.
        if (!bake.add(scene.probePositions)) return std::nullopt;
        set.probes = std::move(bake.probes);
        return set;
    }
    set = probeGrid(scene, spacingMeters, warnings);
    if (set.probes.empty()) return set;
    std::vector<vec3> positions;
    for (const Probe& probe : set.probes) positions.push_back(probe.position);
    if (!bake.add(positions)) return std::nullopt;
    bake.links = linksOfGrid(set.size);

    if (layout == ProbeLayout::Grid) {
        if (denoise) denoiseProbes(bake.probes, bake.variances, bake.links, gather.integrator);
        set.probes = std::move(bake.probes);
        fillInvalidProbes(set);
        return set;
    }
    const vec3 s = set.spacingMeters;
    const float spacing = std::min({s.x, s.y, s.z});
    if (!bake.refine(spacing, kGrowth * positions.size())) return std::nullopt;
    std::size_t unresolved = 0;
    const bool masked = std::any_of(scene.lights.begin(), scene.lights.end(),
                                    [](const Light& light) { return light.baking.occlusionMaskChannel >= 0; });
    if (masked && !bake.refineShadows(set, kShadowGrowth * positions.size(), unresolved)) return std::nullopt;
    if (unresolved > 0) warnings.push_back(shadowEdgeWarning(unresolved, s));
    if (!bake.addFloors(spacing, s.y)) return std::nullopt;
    if (denoise) denoiseProbes(bake.probes, bake.variances, bake.links, gather.integrator);
    removeSuperfluous(bake.probes, kSamePlaceShare * spacing);
    // The set stays a grid if nothing was added and nothing removed.
    const std::size_t gridCount = set.probes.size();
    const bool isGrid = bake.probes.size() == gridCount && bake.variances.size() == gridCount;
    set.probes = std::move(bake.probes);
    if (!isGrid) set = {vec3(0.0f), vec3(1.0f), ivec3(0), std::move(set.probes)};
    return set;
}

} // namespace halflight
