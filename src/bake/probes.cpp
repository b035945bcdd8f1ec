// Where light probes go and what they say (spec S14). A coarse grid first; then, where neighbouring probes disagree,
// probes in between: halfway where the light changes gradually, on both sides of what stands between them where it
// does not.
#include "bake/cells.h"
#include "bake/gather.h"
#include "bake/stages.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/color.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <unordered_set>

namespace halflight {
namespace {

constexpr double kDefaultProbes = 600.0;  ///< of the first grid, unless the caller asks for a spacing
constexpr double kMaxProbes = 500000.0;   ///< of the first grid, whatever the caller asks for
constexpr std::size_t kGrowth = 4;        ///< refinement stops at this many times the first grid
constexpr int kLevels = 2;                ///< times that a distance may be halved
constexpr float kLightDisagrees = 0.35f;  ///< difference of irradiance, of the larger
constexpr float kShadowDisagrees = 0.35f; ///< difference of occlusion
/// Probes beside a wall stand off it by this share of the distance between probes. Two layers of probes on both sides
/// of a wall, twice as far from each other, keep Delaunay tetrahedra from reaching through both: the smallest sphere
/// around a triangle of one layer, half a diagonal of the grid in radius, ends before the other. So light of the other
/// side ends at the layer.
constexpr float kWallShare = 0.36f;
constexpr float kShortestShare = 0.3f; ///< of the grid's distance: links shorter than that are not halved
constexpr float kSamePlaceShare = 0.05f;
constexpr float kFloorShare = 0.02f; ///< height of the probes on floors, of the grid's distance

/// Shadow edges: cells of the first grid are halved this often along each axis, until this many times the first grid's
/// probes are added.
constexpr int kShadowLevels = 2;
constexpr std::size_t kShadowGrowth = 2;
constexpr int kTestPaths = 8; ///< of places that are looked at: they tell what lies inside geometry
/// In larger grids only cells whose corners disagree are looked into.
constexpr std::size_t kMostCellsTested = 4096;

/// Two probes that stand next to each other.
struct Link {
    uint32_t a = 0;
    uint32_t b = 0;
};

/// Irradiance on the six sides of a small cube.
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

/// By how much two probes disagree, 1 where they need one between them. `floor`: light too faint to matter.
float disagreement(const Probe& a, const Probe& b, float floor)
{
    float most = 0.0f;
    const auto sidesA = irradianceAround(a);
    const auto sidesB = irradianceAround(b);
    for (std::size_t i = 0; i < 6; ++i) {
        const float larger = std::max({sidesA[i], sidesB[i], floor});
        if (larger > 0.0f) most = std::max(most, std::abs(sidesA[i] - sidesB[i]) / larger / kLightDisagrees);
    }
    for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(a.occlusion[c] - b.occlusion[c]) / kShadowDisagrees);
    return most;
}

std::vector<Link> linksOfGrid(ivec3 size)
{
    std::vector<Link> links;
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

/// Cells of space, each to be taken once.
class Places {
public:
    explicit Places(float cell) : cell_(cell) {}
    /// False when the cell around this point is taken already.
    bool take(vec3 point) { return taken_.insert(cellKey(cellOf(point, cell_))).second; }

private:
    float cell_;
    std::unordered_set<uint64_t> taken_;
};

/// Cells of a grid whose probes' occlusion says something else in between than the probes do: where a shadow's edge
/// passes. Places are lattice points, of which a side of the grid's cells has kShadowLevels halvings.
class ShadowCells {
public:
    struct Cell {
        ivec3 low{0};
        int size = 0; ///< lattice points along a side
        float error = 0.0f;
    };
    struct Place {
        vec4 occlusion{1.0f};
        bool valid = false;
        std::optional<uint32_t> probe;
    };

    ShadowCells(const ProbeSet& grid, const std::vector<Probe>& probes) : grid_(grid)
    {
        for (int z = 0; z < grid.size.z; ++z) {
            for (int y = 0; y < grid.size.y; ++y) {
                for (int x = 0; x < grid.size.x; ++x) {
                    const auto index = uint32_t((z * grid.size.y + y) * grid.size.x + x);
                    const ivec3 at = kSide * ivec3(x, y, z);
                    places_[cellKey(at)] = {probes[index].occlusion, probes[index].valid, index};
                    if (x + 1 < grid.size.x && y + 1 < grid.size.y && z + 1 < grid.size.z)
                        cells_.push_back({at, kSide});
                }
            }
        }
        if (cells_.size() > kMostCellsTested) std::erase_if(cells_, [&](const Cell& c) { return !cornersDisagree(c); });
    }

    [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
    [[nodiscard]] vec3 positionOf(ivec3 at) const
    {
        return grid_.origin + grid_.spacingMeters * (vec3(at) / float(kSide));
    }
    [[nodiscard]] Place& at(ivec3 place) { return places_[cellKey(place)]; }

    /// The cell's 27 places: corners, and the middles of edges, faces and the cell. One of three numbers each, 0 to 2.
    template<typename Body> static void forPlaces(const Cell& cell, const Body& body)
    {
        for (int k = 0; k < 27; ++k) {
            const ivec3 number(k % 3, k / 3 % 3, k / 9);
            body(cell.low + number * (cell.size / 2), number);
        }
    }
    /// Places of the cells that nothing is known of.
    [[nodiscard]] std::vector<ivec3> unknownPlaces() const
    {
        std::vector<ivec3> unknown;
        std::unordered_set<uint64_t> listed;
        for (const Cell& cell : cells_) {
            forPlaces(cell, [&](ivec3 place, ivec3) {
                if (places_.count(cellKey(place)) == 0 && listed.insert(cellKey(place)).second)
                    unknown.push_back(place);
            });
        }
        return unknown;
    }
    /// How far interpolation between the corners is off, at most. Corners inside geometry take no part.
    void findErrors()
    {
        for (Cell& cell : cells_) {
            cell.error = 0.0f;
            forPlaces(cell, [&](ivec3 place, ivec3 number) {
                const Place& truth = at(place);
                if (!truth.valid) return;
                vec4 sum(0.0f);
                float weight = 0.0f;
                for (int corner = 0; corner < 8; ++corner) {
                    const ivec3 c(corner & 1, corner >> 1 & 1, corner >> 2);
                    const Place& known = at(cell.low + c * cell.size);
                    const vec3 share = 1.0f - glm::abs(vec3(c) - 0.5f * vec3(number));
                    const float w = known.valid ? share.x * share.y * share.z : 0.0f;
                    sum += w * known.occlusion;
                    weight += w;
                }
                const vec4 off = weight > 0.0f ? glm::abs(sum / weight - truth.occlusion) : vec4(1.0f);
                cell.error = std::max({cell.error, off.x, off.y, off.z, off.w});
            });
        }
        std::erase_if(cells_, [](const Cell& c) { return c.error < kShadowDisagrees; });
        std::stable_sort(cells_.begin(), cells_.end(), [](const Cell& a, const Cell& b) { return a.error > b.error; });
    }
    /// Goes on with the halves of the first `count` cells.
    void descend(std::size_t count)
    {
        std::vector<Cell> halves;
        for (std::size_t i = 0; i < count && cells_[i].size > 2; ++i) {
            const int half = cells_[i].size / 2;
            for (int k = 0; k < 8; ++k)
                halves.push_back({cells_[i].low + half * ivec3(k & 1, k >> 1 & 1, k >> 2), half});
        }
        cells_ = std::move(halves);
    }

private:
    static constexpr int kSide = 1 << kShadowLevels;

    [[nodiscard]] bool cornersDisagree(const Cell& cell)
    {
        vec4 least(1.0f);
        vec4 most(0.0f);
        for (int corner = 0; corner < 8; ++corner) {
            const Place& place = at(cell.low + ivec3(corner & 1, corner >> 1 & 1, corner >> 2) * cell.size);
            if (!place.valid) continue;
            least = glm::min(least, place.occlusion);
            most = glm::max(most, place.occlusion);
        }
        return glm::any(glm::greaterThan(most - least, vec4(kShadowDisagrees)));
    }

    const ProbeSet& grid_;
    std::unordered_map<uint64_t, Place> places_;
    std::vector<Cell> cells_;
};

/// Bakes probes in batches, and knows which stand next to each other.
class ProbeBake {
public:
    ProbeBake(const Gather& gather, const Progress& progress) : gather_(gather), progress_(progress) {}

    std::vector<Probe> probes;
    std::vector<float> variances; ///< of each SH coefficient's luminance, about

    bool add(const std::vector<vec3>& positions)
    {
        std::vector<ProbeEstimate> estimates(positions.size());
        if (!gather_.probes(positions, estimates, batches_++, progress_)) return false;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            probes.push_back({positions[i], estimates[i].radiance, estimates[i].occlusion, estimates[i].valid});
            variances.push_back(estimates[i].variance);
        }
        return true;
    }

    /// One level of refinement between the linked probes; `links` becomes the links of the next level.
    bool refine(std::vector<Link>& links, float spacing, std::size_t most)
    {
        const float wall = kWallShare * spacing;
        std::vector<float> means;
        for (const Probe& probe : probes)
            if (probe.valid) means.push_back(luminance(probe.radiance[0]));
        if (means.empty()) return true;
        std::nth_element(means.begin(), means.begin() + std::ptrdiff_t(means.size() / 2), means.end());
        // Irradiance of the median probe's mean light, a twentieth of it: what is darker than that all looks black.
        const float floor = 0.05f * means[means.size() / 2] * shading::shIrradianceWeight(0, vec3(0, 1, 0));

        struct Split {
            Link link;
            float need = 0.0f;
            bool blocked = false;
            vec2 surfaces{0.0f};
        };
        std::vector<Split> splits(links.size());
        parallelFor(links.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Probe& a = probes[links[i].a];
                const Probe& b = probes[links[i].b];
                Split& split = splits[i];
                split.link = links[i];
                if (!a.valid && !b.valid) continue;
                // Beside geometry, where the neighbour is inside it, light often changes and nobody knows: one for
                // sure.
                split.need = a.valid && b.valid ? disagreement(a, b, floor) : 1.0f;
                if (split.need < 1.0f) continue;
                if (const auto surfaces = gather_.integrator.surfacesBetween(a.position, b.position)) {
                    split.blocked = true;
                    split.surfaces = *surfaces;
                }
            }
        });
        std::erase_if(splits, [](const Split& s) { return s.need < 1.0f; });
        std::stable_sort(splits.begin(), splits.end(), [](const Split& x, const Split& y) { return x.need > y.need; });

        std::vector<vec3> positions;
        std::vector<Link> next;
        const auto addBetween = [&](uint32_t from, vec3 position) {
            const auto index = uint32_t(probes.size() + positions.size());
            positions.push_back(position);
            next.push_back({from, index});
            return index;
        };
        for (const Split& split : splits) {
            if (probes.size() + positions.size() + 2 > most) break;
            const Probe& a = probes[split.link.a];
            const Probe& b = probes[split.link.b];
            const float length = glm::distance(a.position, b.position);
            const vec3 direction = (b.position - a.position) / length;
            if (!split.blocked) {
                if (!a.valid || !b.valid || length < 2.0f * kShortestShare * spacing) continue;
                const uint32_t middle = addBetween(split.link.a, 0.5f * (a.position + b.position));
                next.push_back({middle, split.link.b});
                continue;
            }
            // Where a probe stands close to the wall as it is, the other side's keeps the more distance.
            const float fromA = split.surfaces.x;
            const float fromB = length - split.surfaces.y;
            const bool nearA = a.valid && fromA <= 1.5f * wall;
            const bool nearB = b.valid && fromB <= 1.5f * wall;
            const float offA = nearB ? std::max(wall, 2.0f * wall - fromB) : wall;
            const float offB = nearA ? std::max(wall, 2.0f * wall - fromA) : wall;
            if (a.valid && !nearA && fromA > offA) addBetween(split.link.a, a.position + direction * (fromA - offA));
            if (b.valid && !nearB && fromB > offB) addBetween(split.link.b, b.position - direction * (fromB - offB));
        }
        links = std::move(next);
        return positions.empty() || add(positions);
    }

    /// Probes along the edges of shadows, at most so many; `links` gets theirs. The cells left over are counted.
    bool refineShadows(const ProbeSet& grid, std::size_t most, std::vector<Link>& links, std::size_t& unresolved)
    {
        unresolved = 0;
        ShadowCells shadows(grid, probes);
        Progress quiet;
        quiet.cancel = progress_.cancel;
        std::size_t added = 0;
        for (int level = 0; level < kShadowLevels && !shadows.cells().empty(); ++level) {
            const std::vector<ivec3> places = shadows.unknownPlaces();
            std::vector<vec3> positions;
            positions.reserve(places.size());
            for (const ivec3 place : places) positions.push_back(shadows.positionOf(place));
            std::vector<ProbeEstimate> tests(places.size());
            if (!gather_.integrator.probes(positions, allIndices(places.size()), kTestPaths, tests, quiet))
                return false;
            for (std::size_t i = 0; i < places.size(); ++i)
                shadows.at(places[i]) = {tests[i].occlusion, tests[i].valid, std::nullopt};
            shadows.findErrors();

            positions.clear();
            std::size_t taken = 0;
            for (; taken < shadows.cells().size() && added + positions.size() + 19 <= most; ++taken)
                addCell(shadows, shadows.cells()[taken], positions, links);
            unresolved += shadows.cells().size() - taken;
            added += positions.size();
            shadows.descend(taken);
            if (!positions.empty() && !add(positions)) return false;
        }
        return true;
    }

    // Probes on the floors below the others. Things stand on floors: without these, what is lower than the lowest
    // probes above a floor lies in tetrahedra that go down to probes on the other side of it, or, where nothing is
    // below, to ones far beyond its rim. Other surfaces have no such layer: what touches walls and ceilings is seldom
    // small.
    bool addFloors(std::vector<Link>& links, float spacing, float reachMeters)
    {
        const float height = kFloorShare * spacing;
        std::vector<std::optional<vec3>> feet(probes.size());
        parallelFor(probes.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const vec3 p = probes[i].position;
                if (!probes[i].valid) continue;
                const auto surfaces = gather_.integrator.surfacesBetween(p, p - vec3(0.0f, reachMeters, 0.0f));
                if (surfaces && surfaces->x > 2.0f * height) feet[i] = p - vec3(0.0f, surfaces->x - height, 0.0f);
            }
        });
        Places places(kSamePlaceShare * spacing); // probes of one column have one foot
        std::vector<vec3> positions;
        for (std::size_t i = 0; i < feet.size(); ++i) {
            if (!feet[i] || !places.take(*feet[i])) continue;
            links.push_back({uint32_t(i), uint32_t(probes.size() + positions.size())});
            positions.push_back(*feet[i]);
        }
        return positions.empty() || add(positions);
    }

    // SH coefficients averaged with those of probes that are linked, in sight, and differ by no more than noise
    // explains: all nine with one weight, so that the sum points where its parts do and no band changes its share. The
    // weight is the bilateral filter's (Tomasi and Manduchi 1998), its width the estimates' own variance.
    void denoise(const std::vector<Link>& links)
    {
        std::vector<SphericalHarmonicsL2> sums(probes.size());
        std::vector<float> weights(probes.size(), 1.0f);
        for (std::size_t i = 0; i < probes.size(); ++i) sums[i] = probes[i].radiance;
        std::vector<float> linkWeights(links.size(), 0.0f);
        parallelFor(links.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Probe& a = probes[links[i].a];
                const Probe& b = probes[links[i].b];
                const float noise = 9.0f * (variances[links[i].a] + variances[links[i].b]);
                if (!a.valid || !b.valid || noise <= 0.0f) continue;
                float difference = 0.0f;
                for (std::size_t k = 0; k < 9; ++k) {
                    const float d = luminance(a.radiance[k] - b.radiance[k]);
                    difference += d * d;
                }
                // What two equal lights would differ by through noise alone is no difference.
                const float beyond = std::max(difference - noise, 0.0f);
                if (beyond > noise || gather_.integrator.surfacesBetween(a.position, b.position)) continue;
                linkWeights[i] = std::exp(-2.0f * beyond / noise);
            }
        });
        for (std::size_t i = 0; i < links.size(); ++i) {
            if (linkWeights[i] == 0.0f) continue;
            for (std::size_t k = 0; k < 9; ++k) {
                sums[links[i].a][k] += linkWeights[i] * probes[links[i].b].radiance[k];
                sums[links[i].b][k] += linkWeights[i] * probes[links[i].a].radiance[k];
            }
            weights[links[i].a] += linkWeights[i];
            weights[links[i].b] += linkWeights[i];
        }
        for (std::size_t i = 0; i < probes.size(); ++i) {
            for (std::size_t k = 0; k < 9; ++k) probes[i].radiance[k] = sums[i][k] / weights[i];
        }
    }

private:
    /// Lists the places of a cell that are to have probes, with their links along the axes.
    void addCell(ShadowCells& shadows, const ShadowCells::Cell& cell, std::vector<vec3>& positions,
                 std::vector<Link>& links) const
    {
        ShadowCells::forPlaces(cell, [&](ivec3 place, ivec3 number) {
            ShadowCells::Place& known = shadows.at(place);
            const bool isNew = known.valid && !known.probe;
            if (isNew) {
                known.probe = uint32_t(probes.size() + positions.size());
                positions.push_back(shadows.positionOf(place));
            }
            for (int axis = 0; axis < 3; ++axis) {
                ivec3 before = place;
                before[axis] -= cell.size / 2;
                if (!known.probe || number[axis] == 0 || !shadows.at(before).probe) continue;
                links.push_back({*shadows.at(before).probe, *known.probe});
            }
        });
    }

    const Gather& gather_;
    const Progress& progress_;
    int batches_ = 0;
};

/// Leaves out what lies inside geometry, and of probes (nearly) at one place all but the first.
void tidy(std::vector<Probe>& probes, float cell)
{
    Places places(cell);
    std::erase_if(probes, [&](const Probe& probe) { return !probe.valid || !places.take(probe.position); });
}

} // namespace

ProbeSet probeGrid(const Scene& scene, float spacingMeters, std::vector<std::string>& warnings)
{
    ProbeSet set;
    const Bounds bounds = scene.bounds(true);
    if (bounds.empty()) return set;
    const vec3 size =
        glm::max(bounds.size(), vec3(1.0e-3f * std::max({bounds.size().x, bounds.size().y, bounds.size().z, 1.0e-6f})));
    const auto countAt = [&](double spacing) {
        double count = 1.0;
        for (int axis = 0; axis < 3; ++axis) count *= std::max(2.0, std::ceil(double(size[axis]) / spacing) + 1.0);
        return count;
    };
    double spacing = spacingMeters;
    if (spacing <= 0.0) {
        spacing = std::cbrt(double(size.x) * double(size.y) * double(size.z) / kDefaultProbes);
        while (countAt(spacing) > kDefaultProbes) spacing *= 1.05;
    }
    while (countAt(spacing) > kMaxProbes) spacing *= 1.05;
    if (spacingMeters > 0.0f && spacing > double(spacingMeters)) {
        warnings.push_back("a probe every " + std::to_string(spacingMeters) + " m would be more than " +
                           std::to_string(int(kMaxProbes)) + " probes: there is one every " + std::to_string(spacing) +
                           " m");
    }

    // The grid spans the bounds, drawn in a little so that the outermost probes do not lie in floors and outer walls.
    for (int axis = 0; axis < 3; ++axis) {
        const float inset = std::min(0.1f * float(spacing), 0.05f * size[axis]);
        set.size[axis] = std::max(2, int(std::ceil(double(size[axis]) / spacing)) + 1);
        set.origin[axis] = bounds.min[axis] + inset;
        set.spacingMeters[axis] = (size[axis] - 2.0f * inset) / float(set.size[axis] - 1);
    }
    for (int z = 0; z < set.size.z; ++z) {
        for (int y = 0; y < set.size.y; ++y) {
            for (int x = 0; x < set.size.x; ++x) {
                Probe probe;
                probe.position = set.origin + set.spacingMeters * vec3(x, y, z);
                set.probes.push_back(probe);
            }
        }
    }
    return set;
}

std::optional<ProbeSet> bakeProbes(const Scene& scene, float spacingMeters, bool denoise, const Gather& gather,
                                   std::vector<std::string>& warnings, const Progress& progress)
{
    ProbeBake bake(gather, progress);
    ProbeSet set;
    if (!scene.probePositions.empty()) {
        // The author's: all of them, in their order; those inside geometry are marked.
        if (!bake.add(scene.probePositions)) return std::nullopt;
        set.probes = std::move(bake.probes);
        return set;
    }
    set = probeGrid(scene, spacingMeters, warnings);
    if (set.probes.empty()) return set;
    std::vector<vec3> positions;
    for (const Probe& probe : set.probes) positions.push_back(probe.position);
    if (!bake.add(positions)) return std::nullopt;

    const vec3 s = set.spacingMeters;
    const float spacing = std::min({s.x, s.y, s.z});
    std::vector<Link> links = linksOfGrid(set.size);
    std::vector<Link> all = links;
    for (int level = 0; level < kLevels && !links.empty(); ++level) {
        if (!bake.refine(links, spacing, kGrowth * positions.size())) return std::nullopt;
        all.insert(all.end(), links.begin(), links.end());
    }
    std::size_t unresolved = 0;
    const bool masked = std::any_of(scene.lights.begin(), scene.lights.end(),
                                    [](const Light& light) { return light.baking.occlusionMaskChannel >= 0; });
    if (masked && !bake.refineShadows(set, kShadowGrowth * positions.size(), all, unresolved)) return std::nullopt;
    if (unresolved > 0) {
        warnings.push_back(
            "probes: shadow edges cross " + std::to_string(unresolved) +
            " more places than there are probes for; moving objects there have shadows blurred over up to " +
            std::to_string(std::max({s.x, s.y, s.z})) + " m; --probe-spacing makes all probes denser");
    }
    if (!bake.addFloors(all, spacing, s.y)) return std::nullopt;
    if (denoise) bake.denoise(all);
    const std::size_t before = set.probes.size();
    tidy(bake.probes, kSamePlaceShare * spacing);
    // Still a grid when nothing was added and nothing left out.
    const bool grid = bake.probes.size() == before && bake.variances.size() == before;
    set.probes = std::move(bake.probes);
    if (!grid) set = {vec3(0.0f), vec3(1.0f), ivec3(0), std::move(set.probes)};
    return set;
}

} // namespace halflight
