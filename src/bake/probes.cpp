#include "bake/stages.h"

#include <algorithm>
#include <cmath>

namespace halflight {

ProbeSet placeProbes(const Scene& scene, float spacingMeters)
{
    ProbeSet set;
    if (!scene.probePositions.empty()) {
        for (const vec3 position : scene.probePositions) {
            Probe probe;
            probe.position = position;
            set.probes.push_back(probe);
        }
        return set;
    }
    const Bounds bounds = scene.bounds(true);
    if (bounds.empty()) return set;

    // About 1,500 probes unless the caller asks for a spacing, and never more than half a million.
    constexpr double kDefaultProbes = 1500.0;
    constexpr double kMaxProbes = 500000.0;
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
        while (countAt(spacing) > kDefaultProbes) spacing *= 1.1;
    }
    while (countAt(spacing) > kMaxProbes) spacing *= 1.1;

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

} // namespace halflight
