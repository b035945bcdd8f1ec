#include "bake_cpu/radiosity/substitutes.h"

#include "bake/refinements.h"

#include "halflight/base/parallel.h"

#include <numeric>

namespace halflight {
namespace {

class SubstituteSearch {
public:
    SubstituteSearch(const Patches& patches, const std::vector<uint32_t>& rayCount, const BakeGeometry& geometry)
        : patches_(patches), rayCount_(rayCount), geometry_(geometry), substitute_(rayCount.size())
    {
        std::iota(substitute_.begin(), substitute_.end(), 0u);
    }

    /// For triangles hit by no ray: the nearest one of the 8 before and after it of the same part.
    void ofTriangles()
    {
        constexpr std::ptrdiff_t kReach = 8; // triangles in the order of the file
        const uint32_t first = 2 * patches_.layout.chartPatches;
        const auto count = std::ptrdiff_t(patches_.triangles.size());
        forEachIndex(patches_.triangles.size(), [&](std::size_t index) {
            const auto i = std::ptrdiff_t(index);
            const uint32_t triangle = patches_.triangles[std::size_t(i)];
            const vec3 from = geometry_.centroid(triangle);
            for (uint32_t side = 0; side < 2; ++side) {
                const PatchId patch = first + 2 * uint32_t(i) + side;
                float best = longestEdgeOf(geometry_, triangle);
                for (std::ptrdiff_t j = std::max(i - kReach, std::ptrdiff_t(0));
                     rayCount_[patch] == 0 && j < std::min(i + kReach + 1, count); ++j) {
                    const PatchId other = first + 2 * uint32_t(j) + side;
                    const uint32_t otherTriangle = patches_.triangles[std::size_t(j)];
                    if (rayCount_[other] == 0 ||
                        geometry_.partOfTriangle[otherTriangle] != geometry_.partOfTriangle[triangle])
                        continue;
                    const float distance = glm::distance(from, geometry_.centroid(otherTriangle));
                    if (distance > best) continue;
                    best = distance;
                    substitute_[patch] = other;
                }
            }
        });
    }

    void ofCharts()
    {
        const auto& rectangles = patches_.charts.rectangles();
        parallelFor(rectangles.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t number = begin; number < end; ++number) {
                if (rectangles[number].firstPatch == kNoPatch) continue;
                for (const uint32_t side : {0u, patches_.layout.chartPatches}) ofRectangle(number, side);
            }
        });
    }

    [[nodiscard]] std::vector<PatchId> take() { return std::move(substitute_); }

private:
    /// `side`: 0 for fronts, chartPatches for backs.
    void ofRectangle(std::size_t number, uint32_t side)
    {
        const auto& rectangles = patches_.charts.rectangles();
        const ChartPatches::Rectangle& r = rectangles[number];
        const ivec2 size = r.size();
        for (uint32_t i = 0; i < uint32_t(size.x * size.y); ++i) {
            const PatchId patch = side + r.firstPatch + i;
            if (rayCount_[patch] > 0) continue;
            const ivec2 at(int(i) % size.x, int(i) / size.x);
            if (const PatchId found = nearest(side + r.firstPatch, size, at); found != kNoPatch) {
                substitute_[patch] = found;
                continue;
            }
            constexpr std::size_t kAxes = ChartPatches::kAxes;
            for (std::size_t d = 0; d < kAxes && substitute_[patch] == patch; ++d) {
                const ChartPatches::Rectangle& o = rectangles[number / kAxes * kAxes + d];
                if (o.firstPatch == kNoPatch) continue;
                const ivec2 p = glm::clamp(r.min + at, o.min, o.max) - o.min;
                const PatchId other = side + o.firstPatch + uint32_t(p.y * o.size().x + p.x);
                if (rayCount_[other] > 0) substitute_[patch] = other;
            }
        }
    }
    /// Nearest patch with rays in the 5 x 5 patches around a place of a rectangle, or kNoPatch.
    [[nodiscard]] PatchId nearest(PatchId first, ivec2 size, ivec2 at) const
    {
        PatchId found = kNoPatch;
        int best = 9;
        for (int dy = -2; dy <= 2; ++dy) {
            for (int dx = -2; dx <= 2; ++dx) {
                const ivec2 p = at + ivec2(dx, dy);
                if (p.x < 0 || p.y < 0 || p.x >= size.x || p.y >= size.y) continue;
                const PatchId other = first + uint32_t(p.y * size.x + p.x);
                if (rayCount_[other] == 0 || dx * dx + dy * dy >= best) continue;
                best = dx * dx + dy * dy;
                found = other;
            }
        }
        return found;
    }

    const Patches& patches_;
    const std::vector<uint32_t>& rayCount_;
    const BakeGeometry& geometry_;
    std::vector<PatchId> substitute_;
};

} // namespace

std::vector<PatchId> findSubstitutes(const Patches& patches, const std::vector<uint32_t>& rayCount,
                                     const BakeGeometry& geometry)
{
    SubstituteSearch search(patches, rayCount, geometry);
    if (refinements.triangleSubstitutes) search.ofTriangles();
    if (refinements.substitutes) search.ofCharts();
    return search.take();
}

} // namespace halflight
