#include "bake/probes/probe_placement.h"
#include "bake/probes/probes.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

constexpr double kDefaultProbes = 600.0; ///< of the grid, unless a spacing is asked for
constexpr double kMaxProbes = 500000.0;  ///< of the grid, whatever spacing is asked for
/// Cells have sides of a multiple of this many steps of the lattice: they can be halved eight times before their points
/// are rounded, and rows and diagonals of probes are exactly straight.
constexpr float kStepsOfCell = 256.0f;

/// Probes of a grid over a box (metres) with the given spacing.
double countAt(vec3 size, double spacing)
{
    double count = 1.0;
    for (int axis = 0; axis < 3; ++axis) count *= std::max(2.0, std::ceil(double(size[axis]) / spacing) + 1.0);
    return count;
}

/// The smallest spacing from a given one on, in steps of 5 %, that gives no more than `most` probes.
double coarsened(vec3 size, double spacing, double most)
{
    while (countAt(size, spacing) > most) spacing *= 1.05;
    return spacing;
}

} // namespace

ProbeSet probeGrid(const Scene& scene, float spacingMeters, std::vector<std::string>& warnings)
{
    ProbeSet set;
    const Bounds bounds = scene.bounds(true);
    if (bounds.empty()) return set;
    const vec3 size =
        glm::max(bounds.size(), vec3(1.0e-3f * std::max({bounds.size().x, bounds.size().y, bounds.size().z, 1.0e-6f})));
    double spacing = spacingMeters;
    if (spacing <= 0.0) {
        spacing = math::cbrt(double(size.x) * double(size.y) * double(size.z) / kDefaultProbes);
        spacing = coarsened(size, spacing, kDefaultProbes);
    }
    spacing = coarsened(size, spacing, kMaxProbes);
    if (spacingMeters > 0.0f && spacing > double(spacingMeters)) {
        warnings.push_back("a probe every " + std::to_string(spacingMeters) + " m would be more than " +
                           std::to_string(int(kMaxProbes)) + " probes: there is one every " + std::to_string(spacing) +
                           " m");
    }

    // The inset keeps the outermost probes out of floors and outer walls.
    const float step = probeStep(size);
    for (int axis = 0; axis < 3; ++axis) {
        const float inset = std::min(0.1f * float(spacing), 0.05f * size[axis]);
        set.size[axis] = std::max(2, int(std::ceil(double(size[axis]) / spacing)) + 1);
        const float side = (size[axis] - 2.0f * inset) / float(set.size[axis] - 1);
        const float exact = std::floor(side / (kStepsOfCell * step)) * kStepsOfCell * step;
        set.spacingMeters[axis] = exact > 0.0f ? exact : side;
        set.origin[axis] = bounds.min[axis] + 0.5f * (size[axis] - float(set.size[axis] - 1) * set.spacingMeters[axis]);
    }
    set.origin = onProbeLattice(set.origin, step);
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

void fillInvalidProbes(ProbeSet& grid)
{
    const ivec3 size = grid.size;
    const ivec3 stride(1, size.x, size.x * size.y);
    std::vector<uint8_t> known;
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < grid.probes.size(); ++i) {
        known.push_back(grid.probes[i].valid);
        if (!grid.probes[i].valid) open.push_back(i);
    }
    // Each pass fills the probes next to known ones.
    while (!open.empty()) {
        std::vector<std::size_t> filled;
        for (const std::size_t i : open) {
            const ivec3 place(int(i) % size.x, int(i) / size.x % size.y, int(i) / (size.x * size.y));
            Probe sum{};
            sum.occlusion = MaskValues(0.0f);
            float count = 0.0f;
            const auto take = [&](std::size_t neighbour) {
                if (known[neighbour] == 0) return;
                const Probe& probe = grid.probes[neighbour];
                for (std::size_t k = 0; k < sum.radiance.size(); ++k) sum.radiance[k] += probe.radiance[k];
                sum.occlusion += probe.occlusion;
                count += 1.0f;
            };
            for (int axis = 0; axis < 3; ++axis) {
                if (place[axis] > 0) take(i - std::size_t(stride[axis]));
                if (place[axis] + 1 < size[axis]) take(i + std::size_t(stride[axis]));
            }
            if (count == 0.0f) continue;
            for (std::size_t k = 0; k < sum.radiance.size(); ++k) grid.probes[i].radiance[k] = sum.radiance[k] / count;
            grid.probes[i].occlusion = sum.occlusion / count;
            filled.push_back(i);
        }
        if (filled.empty()) return; // no probe is valid
        for (const std::size_t i : filled) known[i] = 1;
        std::erase_if(open, [&](std::size_t i) { return known[i] != 0; });
    }
}

} // namespace halflight
