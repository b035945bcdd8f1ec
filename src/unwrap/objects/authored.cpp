#include "unwrap/objects/authored.h"

#include "unwrap/surface/footprint.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/finite.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace halflight::charts {
namespace {

std::string nameOf(const Mesh& mesh, std::size_t triangle)
{
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        const std::size_t count = mesh.parts[p].triangleCount();
        if (triangle < count) return fmt::format("part {}, triangle {}", p, triangle);
        triangle -= count;
    }
    return "no triangle";
}

/// An eighth of a texel at 8192 texels a page: coordinates that were quantized to 16 bits touch, and do not overlap.
constexpr double kOverlapTolerance = 1.0 / 65536.0;

/// Charts are triangles that share an edge on the surface and in uv.
void findCharts(AuthoredLayout& layout, const Surface& surface)
{
    DisjointSets charts(surface.triangleCount());
    for (uint32_t half = 0; half < surface.neighbors.size(); ++half) {
        const uint32_t other = surface.neighbors[half];
        if (other == kNone || half > other) continue;
        const auto& mine = layout.triangles[half / 3].corners;
        const auto& theirs = layout.triangles[other / 3].corners;
        if (mine[half % 3] != theirs[(other % 3 + 1) % 3] || mine[(half % 3 + 1) % 3] != theirs[other % 3]) continue;
        charts.join(half / 3, other / 3);
    }
    layout.chartOfTriangle.assign(surface.triangleCount(), kNone);
    for (uint32_t t = 0; t < surface.triangleCount(); ++t) {
        if (surface.degenerate(t)) continue;
        const uint32_t root = charts.find(t);
        layout.chartOfTriangle[t] = root == t ? layout.chartCount++ : layout.chartOfTriangle[root];
    }
}

} // namespace

bool hasAuthoredLayout(const Mesh& mesh)
{
    return std::any_of(mesh.parts.begin(), mesh.parts.end(), [](const MeshPart& part) { return !part.uv[1].empty(); });
}

AuthoredLayout readAuthoredLayout(const Mesh& mesh, const Surface& surface)
{
    AuthoredLayout layout;
    std::size_t triangle = 0;
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        const MeshPart& part = mesh.parts[p];
        if (part.uv[1].empty() && !part.indices.empty()) {
            layout.fault = fmt::format("part {} has no TEXCOORD_1", p);
            return layout;
        }
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3, ++triangle) {
            FlatTriangle& flat = layout.triangles.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const vec2 uv = part.uv[1][part.indices[i + k]];
                flat.corners[k] = dvec2(uv);
                if (!(uv.x >= 0.0f && uv.x <= 1.0f && uv.y >= 0.0f && uv.y <= 1.0f)) {
                    layout.fault = isFinite(uv) ? fmt::format("TEXCOORD_1 leaves [0,1] ({})", nameOf(mesh, triangle))
                                                : fmt::format("TEXCOORD_1 is not finite ({})", nameOf(mesh, triangle));
                    return layout;
                }
            }
        }
    }
    layout.least = dvec2(1e300);
    layout.most = dvec2(-1e300);
    double stretchSum = 0.0;
    std::vector<FlatTriangle> solid;
    std::vector<uint32_t> solidIndex;
    for (std::size_t t = 0; t < layout.triangles.size(); ++t) {
        const auto& c = layout.triangles[t].corners;
        for (const dvec2 corner : c) {
            layout.least = glm::min(layout.least, corner);
            layout.most = glm::max(layout.most, corner);
        }
        if (surface.degenerate(t)) continue;
        const double doubleArea = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x);
        const double longest2 = std::max({glm::dot(c[1] - c[0], c[1] - c[0]), glm::dot(c[2] - c[1], c[2] - c[1]),
                                          glm::dot(c[0] - c[2], c[0] - c[2])});
        if (!(std::abs(doubleArea) > 1e-7 * longest2)) {
            layout.fault = fmt::format("TEXCOORD_1 gives a triangle no area ({})", nameOf(mesh, t));
            return layout;
        }
        layout.uvArea += 0.5 * std::abs(doubleArea);
        layout.worldArea += surface.areas[t];
        const dvec3 pa = surface.corner(t, 0), pb = surface.corner(t, 1), pc = surface.corner(t, 2);
        const dvec3 alongU = (pa * (c[1].y - c[2].y) + pb * (c[2].y - c[0].y) + pc * (c[0].y - c[1].y)) / doubleArea;
        const dvec3 alongV = (pa * (c[2].x - c[1].x) + pb * (c[0].x - c[2].x) + pc * (c[1].x - c[0].x)) / doubleArea;
        stretchSum += surface.areas[t] * 0.5 * (glm::dot(alongU, alongU) + glm::dot(alongV, alongV));
        solid.push_back(layout.triangles[t]);
        solidIndex.push_back(uint32_t(t));
    }
    if (solid.empty()) {
        layout.fault = "no triangle has an area";
        return layout;
    }
    if (const auto overlap = findOverlap(solid, kOverlapTolerance)) {
        layout.fault = fmt::format("TEXCOORD_1 overlaps itself ({} and {})", nameOf(mesh, solidIndex[overlap->first]),
                                   nameOf(mesh, solidIndex[overlap->second]));
        return layout;
    }
    // Stretch at the scale that keeps the area: metres per uv unit is sqrt(worldArea / uvArea).
    layout.stretch = std::sqrt(stretchSum / layout.worldArea * layout.uvArea / layout.worldArea);
    findCharts(layout, surface);
    return layout;
}

namespace {

constexpr uint32_t kFree = kNone;

/// Who touches which texel, or nothing when a texel is touched by two. The image holds what the layouts touch and no
/// more. `ownerOf(layout, triangle)` is a number below kFree, or kFree for triangles that do not count.
template<typename OwnerOf> std::optional<Image<uint32_t>> ownersOfTexels(std::span<const AuthoredLayout* const> layouts,
                                                                         double texelsPerUnit, OwnerOf ownerOf)
{
    dvec2 least(1e300), most(-1e300);
    for (const AuthoredLayout* layout : layouts) {
        least = glm::min(least, layout->least);
        most = glm::max(most, layout->most);
    }
    const ivec2 corner(glm::floor(least * texelsPerUnit - 2.0 * kRasterMargin));
    const ivec2 size = ivec2(glm::floor(most * texelsPerUnit + 2.0 * kRasterMargin)) + 1 - corner;
    Image<uint32_t> owners(size.x, size.y, kFree);
    bool shared = false;
    for (std::size_t l = 0; l < layouts.size() && !shared; ++l) {
        const AuthoredLayout& layout = *layouts[l];
        for (std::size_t t = 0; t < layout.triangles.size() && !shared; ++t) {
            const uint32_t owner = ownerOf(l, t);
            if (owner == kFree) continue;
            dvec2 corners[3];
            for (int k = 0; k < 3; ++k) corners[k] = layout.triangles[t].corners[k] * texelsPerUnit - dvec2(corner);
            forTouchedTexels(corners, kRasterMargin, [&](int y, int first, int last) {
                if (y < 0 || y >= size.y) return;
                for (int x = std::max(first, 0); x <= std::min(last, size.x - 1); ++x) {
                    shared |= owners(x, y) != kFree && owners(x, y) != owner;
                    owners(x, y) = owner;
                }
            });
        }
    }
    if (shared) return std::nullopt;
    return owners;
}

} // namespace

bool chartsTooClose(std::span<const AuthoredLayout* const> layouts, double texelsPerUnit, int padding)
{
    std::vector<uint32_t> firstChart(layouts.size(), 0);
    for (std::size_t l = 1; l < layouts.size(); ++l) firstChart[l] = firstChart[l - 1] + layouts[l - 1]->chartCount;
    const auto owners = ownersOfTexels(layouts, texelsPerUnit, [&](std::size_t l, std::size_t t) {
        const uint32_t chart = layouts[l]->chartOfTriangle[t];
        return chart == kNone ? kFree : firstChart[l] + chart;
    });
    if (!owners) return true;
    // Along a row, then between rows: a texel of another chart in the square of half side `padding` around one.
    for (int y = 0; y < owners->height(); ++y) {
        for (int x = 0; x < owners->width(); ++x) {
            const uint32_t mine = (*owners)(x, y);
            if (mine == kFree) continue;
            for (int dy = 0; dy <= padding && y + dy < owners->height(); ++dy) {
                for (int i = std::max(x - padding, 0), end = std::min(x + padding, owners->width() - 1); i <= end;
                     ++i) {
                    if ((*owners)(i, y + dy) != kFree && (*owners)(i, y + dy) != mine) return true;
                }
            }
        }
    }
    return false;
}

bool layoutsShareTexel(std::span<const AuthoredLayout* const> layouts, int pageSize)
{
    return !ownersOfTexels(layouts, double(pageSize), [](std::size_t l, std::size_t) { return uint32_t(l); });
}

} // namespace halflight::charts
