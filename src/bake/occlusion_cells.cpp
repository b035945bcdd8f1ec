#include "bake/occlusion_cells.h"

#include "bake/hash_grid.h"

#include <algorithm>
#include <unordered_set>

namespace halflight {
namespace {

constexpr int kSide = 1 << OcclusionCells::kLevels;
/// In grids of more cells, only those whose corners disagree are sampled.
constexpr std::size_t kMostSampledCells = 4096;

ivec3 cornerOffset(int corner)
{
    return {corner & 1, corner >> 1 & 1, corner >> 2};
}

} // namespace

OcclusionCells::OcclusionCells(const ProbeSet& grid, std::span<const Probe> probes) : grid_(grid)
{
    for (int z = 0; z < grid.size.z; ++z) {
        for (int y = 0; y < grid.size.y; ++y) {
            for (int x = 0; x < grid.size.x; ++x) {
                const auto index = uint32_t((z * grid.size.y + y) * grid.size.x + x);
                const ivec3 point = kSide * ivec3(x, y, z);
                samples_[gridKey(point)] = {probes[index].occlusion, probes[index].valid, index};
                if (x + 1 < grid.size.x && y + 1 < grid.size.y && z + 1 < grid.size.z) cells_.push_back({point, kSide});
            }
        }
    }
    if (cells_.size() > kMostSampledCells) std::erase_if(cells_, [&](const Cell& c) { return !cornersDisagree(c); });
}

vec3 OcclusionCells::positionOf(ivec3 latticePoint) const
{
    return grid_.origin + grid_.spacingMeters * (vec3(latticePoint) / float(kSide));
}

OcclusionCells::Sample& OcclusionCells::at(ivec3 latticePoint)
{
    return samples_[gridKey(latticePoint)];
}

std::vector<ivec3> OcclusionCells::unsampledPoints() const
{
    std::vector<ivec3> points;
    std::unordered_set<uint64_t> listed;
    for (const Cell& cell : cells_) {
        forPoints(cell, [&](ivec3 point, ivec3) {
            if (samples_.count(gridKey(point)) == 0 && listed.insert(gridKey(point)).second) points.push_back(point);
        });
    }
    return points;
}

/// Of trilinear interpolation between the valid corners; 1 where no corner is valid.
vec4 OcclusionCells::interpolationError(const Cell& cell, ivec3 offset, const Sample& truth)
{
    vec4 sum(0.0f);
    float weight = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const ivec3 c = cornerOffset(corner);
        const Sample& sample = at(cell.low + c * cell.size);
        const vec3 share = 1.0f - glm::abs(vec3(c) - 0.5f * vec3(offset));
        const float w = sample.valid ? share.x * share.y * share.z : 0.0f;
        sum += w * sample.occlusion;
        weight += w;
    }
    return weight > 0.0f ? glm::abs(sum / weight - truth.occlusion) : vec4(1.0f);
}

void OcclusionCells::estimateErrors()
{
    for (Cell& cell : cells_) {
        cell.error = 0.0f;
        forPoints(cell, [&](ivec3 point, ivec3 offset) {
            const Sample& truth = at(point);
            if (!truth.valid) return;
            const vec4 error = interpolationError(cell, offset, truth);
            cell.error = std::max({cell.error, error.x, error.y, error.z, error.w});
        });
    }
    std::erase_if(cells_, [](const Cell& c) { return c.error < kDisagrees; });
    std::stable_sort(cells_.begin(), cells_.end(), [](const Cell& a, const Cell& b) { return a.error > b.error; });
}

void OcclusionCells::subdivide(std::size_t count)
{
    std::vector<Cell> octants;
    for (std::size_t i = 0; i < count && cells_[i].size > 2; ++i) {
        const int half = cells_[i].size / 2;
        for (int k = 0; k < 8; ++k) octants.push_back({cells_[i].low + half * cornerOffset(k), half});
    }
    cells_ = std::move(octants);
}

bool OcclusionCells::cornersDisagree(const Cell& cell)
{
    vec4 least(1.0f);
    vec4 most(0.0f);
    for (int corner = 0; corner < 8; ++corner) {
        const Sample& sample = at(cell.low + cornerOffset(corner) * cell.size);
        if (!sample.valid) continue;
        least = glm::min(least, sample.occlusion);
        most = glm::max(most, sample.occlusion);
    }
    return glm::any(glm::greaterThan(most - least, vec4(kDisagrees)));
}

} // namespace halflight
