#include "bake/probes/probe_tree.h"

#include "bake/geometry/hash_grid.h"

#include <algorithm>
#include <array>
#include <unordered_set>

namespace halflight {
namespace {

/// gridKey() tells apart 2^21 coordinates.
constexpr int kMostCoordinate = 1 << 20;

ivec3 cornerOffset(int corner)
{
    return {corner & 1, corner >> 1 & 1, corner >> 2};
}

float longest(vec3 sides)
{
    return std::max({sides.x, sides.y, sides.z});
}

} // namespace

ProbeTree::ProbeTree(const ProbeSet& grid, std::span<const Probe> probes) : grid_(grid)
{
    const int widest = std::max({grid.size.x, grid.size.y, grid.size.z});
    while (float(side_) * finestMeters() < longest(grid.spacingMeters) && 2 * side_ * widest <= kMostCoordinate)
        side_ *= 2;
    samples_.reserve(probes.size());
    for (uint32_t i = 0; i < probes.size(); ++i) {
        const ivec3 place(int(i) % grid.size.x, int(i) / grid.size.x % grid.size.y, int(i) / grid.size.x / grid.size.y);
        at(side_ * place) = {probes[i].occlusion, probes[i].valid, i};
    }
}

float ProbeTree::finestMeters() const
{
    return std::min(kFinestMeters, longest(grid_.spacingMeters) / 4.0f);
}

uint64_t ProbeTree::key(ivec3 latticePoint)
{
    return gridKey(latticePoint);
}

std::vector<ProbeTree::Cell> ProbeTree::gridCells() const
{
    std::vector<Cell> cells;
    for (int z = 0; z + 1 < grid_.size.z; ++z)
        for (int y = 0; y + 1 < grid_.size.y; ++y)
            for (int x = 0; x + 1 < grid_.size.x; ++x)
                cells.push_back({side_ * ivec3(x, y, z), ivec3(side_), grid_.spacingMeters});
    return cells;
}

std::size_t ProbeTree::gridCellAt(vec3 position) const
{
    const ivec3 count = grid_.size - 1;
    const vec3 at = glm::floor((position - grid_.origin) / grid_.spacingMeters);
    const ivec3 cell(glm::clamp(at, vec3(0.0f), vec3(count - 1)));
    return std::size_t((cell.z * count.y + cell.y) * count.x + cell.x);
}

vec3 ProbeTree::positionOf(ivec3 latticePoint) const
{
    return grid_.origin + grid_.spacingMeters * (vec3(latticePoint) / float(side_));
}

vec3 ProbeTree::sidesOf(const Cell& cell) const
{
    return grid_.spacingMeters * (vec3(cell.size) / float(side_));
}

std::vector<uint32_t> ProbeTree::validCorners(const Cell& cell)
{
    std::vector<uint32_t> corners;
    for (int corner = 0; corner < 8; ++corner) {
        const Sample& sample = at(cell.low + cornerOffset(corner) * cell.size);
        if (sample.valid && sample.probe) corners.push_back(*sample.probe);
    }
    return corners;
}

ivec3 ProbeTree::stepsOf(const Cell& cell) const
{
    const vec3 sides = sidesOf(cell);
    ivec3 steps(2);
    for (int axis = 0; axis < 3; ++axis)
        if (cell.size[axis] > 1 && sides[axis] > 0.5f * longest(sides)) steps[axis] = 1;
    return steps;
}

bool ProbeTree::canHalve(const Cell& cell, float finestMeters) const
{
    return longest(sidesOf(cell)) >= 2.0f * finestMeters && stepsOf(cell) != ivec3(2);
}

std::vector<ProbeTree::Cell> ProbeTree::halves(const Cell& cell) const
{
    const ivec3 steps = stepsOf(cell);
    std::vector<Cell> parts;
    for (int k = 0; k < 8; ++k) {
        const ivec3 part = cornerOffset(k);
        if (glm::any(glm::greaterThan(part, 2 - steps))) continue;
        parts.push_back({cell.low + part * cell.size / 2, cell.size * steps / 2, cell.sides});
    }
    return parts;
}

void ProbeTree::addProbes(const Cell& cell, std::size_t first, AddedProbes& added)
{
    const ivec3 step = stepsOf(cell);
    forPoints(cell, [&](ivec3 point, ivec3 offset) {
        const auto [entry, isNew] = samples_.try_emplace(key(point));
        Sample& sample = entry->second;
        if ((isNew || sample.valid) && !sample.probe) {
            sample.probe = uint32_t(first + added.positions.size());
            added.add(positionOf(point), cell.sides);
        }
        for (int axis = 0; axis < 3; ++axis) {
            if (!sample.probe || offset[axis] == 0) continue;
            ivec3 before = point;
            before[axis] -= cell.size[axis] * step[axis] / 2;
            if (const auto& other = at(before).probe)
                added.links.push_back({*other, *at(point).probe, shortestSide(cell.sides)});
        }
    });
}

void ProbeTree::takeSamples(const Cell& cell, std::span<const Probe> probes)
{
    forPoints(cell, [&](ivec3 point, ivec3) {
        Sample& sample = at(point);
        if (!sample.probe) return;
        sample.occlusion = probes[*sample.probe].occlusion;
        sample.valid = probes[*sample.probe].valid;
    });
}

std::vector<ProbeLink> ProbeTree::linksOf(std::span<const Cell> cells)
{
    std::vector<ProbeLink> links;
    std::array<std::unordered_set<uint64_t>, 3> listed; // by axis: low ends
    for (const Cell& cell : cells) {
        for (int axis = 0; axis < 3; ++axis) {
            for (int corner = 0; corner < 8; ++corner) {
                const ivec3 offset = cornerOffset(corner);
                if (offset[axis] != 0) continue;
                const ivec3 a = cell.low + offset * cell.size;
                ivec3 b = a;
                b[axis] += cell.size[axis];
                const auto middle = samples_.find(key((a + b) / 2));
                const bool isHalved = cell.size[axis] > 1 && middle != samples_.end() && middle->second.probe;
                if (isHalved || !listed[std::size_t(axis)].insert(key(a)).second) continue;
                if (at(a).probe && at(b).probe) links.push_back({*at(a).probe, *at(b).probe, shortestSide(cell.sides)});
            }
        }
    }
    std::sort(links.begin(), links.end(),
              [](const ProbeLink& x, const ProbeLink& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    return links;
}

std::vector<ivec3> ProbeTree::unsampledPoints(std::span<const Cell> cells) const
{
    std::vector<ivec3> points;
    std::unordered_set<uint64_t> listed;
    for (const Cell& cell : cells) {
        forPoints(cell, [&](ivec3 point, ivec3) {
            if (samples_.count(key(point)) == 0 && listed.insert(key(point)).second) points.push_back(point);
        });
    }
    return points;
}

/// Of trilinear interpolation between the valid corners, in the channel where it is largest; 1 where no corner is
/// valid.
float ProbeTree::interpolationError(const Cell& cell, ivec3 offset, const Sample& truth)
{
    MaskValues sum(0.0f);
    float weight = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const ivec3 c = cornerOffset(corner);
        const Sample& sample = at(cell.low + c * cell.size);
        const vec3 share = 1.0f - glm::abs(vec3(c) - 0.5f * vec3(offset));
        const float w = sample.valid ? share.x * share.y * share.z : 0.0f;
        sum += w * sample.occlusion;
        weight += w;
    }
    if (!(weight > 0.0f)) return 1.0f;
    const MaskValues mean = sum / weight;
    return std::max(largestExcess(mean, truth.occlusion), largestExcess(truth.occlusion, mean));
}

void ProbeTree::keepWrong(std::vector<Cell>& cells)
{
    for (Cell& cell : cells) {
        cell.error = 0.0f;
        forPoints(cell, [&](ivec3 point, ivec3 offset) {
            const Sample truth = at(point);
            if (!truth.valid) return;
            cell.error = std::max(cell.error, interpolationError(cell, offset, truth));
        });
    }
    std::erase_if(cells, [](const Cell& c) { return c.error < kDisagrees; });
    std::stable_sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.error > b.error; });
}

} // namespace halflight
