#include "atlas_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <unordered_map>

namespace halflight {
namespace {

using glm::dvec2;
using glm::dvec3;

struct PageTriangle {
    dvec2 corners[3]; ///< texels
    uint32_t chart;
    int object;
    int page;
    bool degenerate;
    bool first; ///< on the first object with its mesh: overlaps within charts are looked for once
};

double doubleArea(const dvec2 (&c)[3])
{
    return (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x);
}

/// Separating axes of a closed unit square and a closed triangle.
bool touches(const dvec2 (&c)[3], int x, int y)
{
    if (std::max({c[0].x, c[1].x, c[2].x}) < x || std::min({c[0].x, c[1].x, c[2].x}) > x + 1) return false;
    if (std::max({c[0].y, c[1].y, c[2].y}) < y || std::min({c[0].y, c[1].y, c[2].y}) > y + 1) return false;
    for (int k = 0; k < 3; ++k) {
        const dvec2 edge = c[(k + 1) % 3] - c[k];
        const dvec2 normal(-edge.y, edge.x);
        double lowT = 1e300, highT = -1e300, lowS = 1e300, highS = -1e300;
        for (int i = 0; i < 3; ++i) {
            lowT = std::min(lowT, glm::dot(normal, c[i]));
            highT = std::max(highT, glm::dot(normal, c[i]));
        }
        for (int i = 0; i < 4; ++i) {
            const double p = glm::dot(normal, dvec2(x + (i & 1), y + (i >> 1)));
            lowS = std::min(lowS, p);
            highS = std::max(highS, p);
        }
        if (highT < lowS || highS < lowT) return false;
    }
    return true;
}

/// Of a page of size x size.
std::vector<std::array<int, 2>> texelsTouched(const dvec2 (&c)[3], int size)
{
    const int x0 = std::max(int(std::floor(std::min({c[0].x, c[1].x, c[2].x}))), 0);
    const int y0 = std::max(int(std::floor(std::min({c[0].y, c[1].y, c[2].y}))), 0);
    const int x1 = std::min(int(std::floor(std::max({c[0].x, c[1].x, c[2].x}))), size - 1);
    const int y1 = std::min(int(std::floor(std::max({c[0].y, c[1].y, c[2].y}))), size - 1);
    std::vector<std::array<int, 2>> texels;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x)
            if (touches(c, x, y)) texels.push_back({x, y});
    return texels;
}

/// Area that two triangles have in common, by clipping one with the other (Sutherland and Hodgman 1974).
double commonArea(const dvec2 (&a)[3], const dvec2 (&b)[3])
{
    std::vector<dvec2> polygon(a, a + 3), next;
    const double side = doubleArea(b) < 0.0 ? -1.0 : 1.0;
    for (int k = 0; k < 3 && !polygon.empty(); ++k) {
        const dvec2 from = b[k], edge = b[(k + 1) % 3] - from;
        const auto inside = [&](dvec2 p) { return side * (edge.x * (p.y - from.y) - edge.y * (p.x - from.x)); };
        next.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const dvec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
            const double dp = inside(p), dq = inside(q);
            if (dp >= 0.0) next.push_back(p);
            if ((dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0)) next.push_back(p + (q - p) * (dp / (dp - dq)));
        }
        polygon.swap(next);
    }
    double area = 0.0;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
        const dvec2 u = polygon[i] - polygon[0], v = polygon[i + 1] - polygon[0];
        area += 0.5 * (u.x * v.y - u.y * v.x);
    }
    return std::abs(area);
}

/// Triangles on the pages; charts are what hangs together over equal coordinates within an object.
std::string collect(const UnwrappedScene& unwrapped, std::vector<PageTriangle>& triangles, AtlasCheck& check)
{
    std::vector<char> meshSeen(unwrapped.scene.meshes.size(), 0);
    for (const Object& object : unwrapped.scene.objects) {
        const LightmapBinding& binding = object.lightmap;
        if (binding.page < 0) continue;
        if (binding.page >= unwrapped.pageCount) return "an object is on a page that does not exist";
        if (!object.isStatic || !(object.lightmapScale > 0.0f)) return "a dynamic object is on a page";
        std::unordered_map<uint64_t, uint32_t> points;
        std::vector<uint32_t> parent;
        const auto find = [&](uint32_t p) {
            while (parent[p] != p) p = parent[p] = parent[parent[p]];
            return p;
        };
        const std::size_t first = triangles.size();
        for (const MeshPart& part : unwrapped.scene.meshes[std::size_t(object.mesh)].parts) {
            if (!part.indices.empty() && part.lightmapUv.size() != part.positions.size())
                return "a part has no lightmapUv";
            for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
                PageTriangle triangle{};
                uint32_t pointOf[3];
                dvec3 p[3];
                for (std::size_t k = 0; k < 3; ++k) {
                    const uint32_t v = part.indices[i + k];
                    const vec2 uv = part.lightmapUv[v];
                    if (!(uv.x >= 0.0f && uv.x <= 1.0f && uv.y >= 0.0f && uv.y <= 1.0f))
                        return "lightmapUv is not in [0,1]";
                    const vec2 page = binding.scale * uv + binding.offset; // as a renderer has it, in float
                    if (!(page.x >= 0.0f && page.x <= 1.0f && page.y >= 0.0f && page.y <= 1.0f))
                        return "a triangle leaves its page";
                    triangle.corners[k] = dvec2(page) * double(unwrapped.pageSize);
                    const uint64_t key = uint64_t(std::bit_cast<uint32_t>(uv.x)) << 32 | std::bit_cast<uint32_t>(uv.y);
                    const auto [found, inserted] = points.try_emplace(key, uint32_t(parent.size()));
                    if (inserted) parent.push_back(found->second);
                    pointOf[k] = found->second;
                    p[k] = dvec3(glm::dmat4(object.worldFromObject) * glm::dvec4(dvec3(part.positions[v]), 1.0));
                }
                for (int k = 1; k < 3; ++k) parent[find(pointOf[k])] = find(pointOf[0]);
                triangle.page = binding.page;
                triangle.object = int(&object - unwrapped.scene.objects.data());
                triangle.first = meshSeen[std::size_t(object.mesh)] == 0;
                triangle.chart = pointOf[0];
                const double worldArea = 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
                const double longest =
                    std::max({glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
                triangle.degenerate = !(worldArea > 1e-5 * longest * longest);
                const double flat = 0.5 * std::abs(doubleArea(triangle.corners));
                if (!triangle.degenerate) {
                    check.worldArea += worldArea;
                    check.texelArea += flat;
                    // Thinner than a hundredth of a texel, float coordinates may not tell its corners apart.
                    const double height =
                        2.0 * worldArea / longest * double(unwrapped.texelsPerMeter) * double(object.lightmapScale);
                    if (!(flat > 0.0) && height > 0.01) return "a triangle with an area has none on the page";
                }
                triangles.push_back(triangle);
            }
        }
        meshSeen[std::size_t(object.mesh)] = 1;
        std::unordered_map<uint32_t, uint32_t> chartOf;
        for (std::size_t t = first; t < triangles.size(); ++t) {
            const auto [found, inserted] = chartOf.try_emplace(find(triangles[t].chart), uint32_t(check.charts));
            if (inserted) ++check.charts;
            triangles[t].chart = found->second;
        }
    }
    return {};
}

} // namespace

AtlasCheck checkAtlas(const UnwrappedScene& unwrapped, int paddingTexels)
{
    AtlasCheck check;
    std::vector<PageTriangle> triangles;
    check.fault = collect(unwrapped, triangles, check);
    if (!check.fault.empty()) return check;
    const int size = unwrapped.pageSize;
    for (int page = 0; page < unwrapped.pageCount; ++page) {
        constexpr uint32_t kFree = ~0u;
        Image<uint32_t> owner(size, size, kFree);
        std::vector<std::vector<uint32_t>> inTexel(std::size_t(size) * std::size_t(size));
        for (uint32_t t = 0; t < triangles.size(); ++t) {
            const PageTriangle& triangle = triangles[t];
            if (triangle.page != page) continue;
            const auto& c = triangle.corners;
            for (const auto& [x, y] : texelsTouched(c, size)) {
                uint32_t& mine = owner(x, y);
                if (mine == kFree) ++check.coveredTexels;
                if (mine != kFree && mine != triangle.chart) {
                    check.fault = fmt::format("texel {},{} of page {} belongs to charts {} and {}", x, y, page, mine,
                                              triangle.chart);
                    return check;
                }
                mine = triangle.chart;
                if (triangle.degenerate || !triangle.first) continue;
                auto& others = inTexel[std::size_t(y) * std::size_t(size) + std::size_t(x)];
                const double area = 0.5 * std::abs(doubleArea(c));
                for (const uint32_t other : others) {
                    const double least = std::min(area, 0.5 * std::abs(doubleArea(triangles[other].corners)));
                    const double common = commonArea(c, triangles[other].corners);
                    if (common > 1e-3 && common > 0.01 * least) {
                        check.fault = fmt::format("triangles {} and {} overlap by {} texels at texel {},{} of page {}",
                                                  other, t, common, x, y, page);
                        return check;
                    }
                }
                if (others.size() < 256) others.push_back(t);
            }
        }
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                if (owner(x, y) == kFree) continue;
                for (int dy = 0; dy <= paddingTexels && y + dy < size; ++dy) {
                    for (int dx = -paddingTexels; dx <= paddingTexels; ++dx) {
                        if (x + dx < 0 || x + dx >= size) continue;
                        const uint32_t other = owner(x + dx, y + dy);
                        if (other == kFree || other == owner(x, y)) continue;
                        check.fault =
                            fmt::format("charts {} and {} are closer than {} texels at texel {},{} of page {}",
                                        owner(x, y), other, paddingTexels, x, y, page);
                        return check;
                    }
                }
            }
        }
    }
    return check;
}

std::string findSharedTexel(const UnwrappedScene& unwrapped)
{
    AtlasCheck unused;
    std::vector<PageTriangle> triangles;
    if (std::string fault = collect(unwrapped, triangles, unused); !fault.empty()) return fault;
    std::vector<char> kept(unwrapped.scene.meshes.size(), 0);
    for (const MeshUnwrapReport& report : unwrapped.meshes) kept[std::size_t(report.mesh)] |= report.kept ? 1 : 2;
    struct Owner {
        int object = -1;
        uint32_t chart = 0;
        bool solid = false;
    };
    const int size = unwrapped.pageSize;
    std::vector<Image<Owner>> pages(std::size_t(unwrapped.pageCount), Image<Owner>(size, size));
    for (const PageTriangle& triangle : triangles) {
        const Object& object = unwrapped.scene.objects[std::size_t(triangle.object)];
        if (kept[std::size_t(object.mesh)] == 3) return fmt::format("mesh {} is kept and is not", object.mesh);
        const bool chartsMayMeet = kept[std::size_t(object.mesh)] == 1;
        for (const auto& [x, y] : texelsTouched(triangle.corners, size)) {
            Owner& owner = pages[std::size_t(triangle.page)](x, y);
            if (owner.object >= 0 && owner.object != triangle.object) {
                return fmt::format("texel {},{} of page {} belongs to objects {} and {}", x, y, triangle.page,
                                   owner.object, triangle.object);
            }
            if (owner.solid && !triangle.degenerate && !chartsMayMeet && owner.chart != triangle.chart) {
                return fmt::format("texel {},{} of page {} belongs to two charts of object {}", x, y, triangle.page,
                                   triangle.object);
            }
            owner.object = triangle.object;
            if (triangle.degenerate) continue;
            owner.chart = triangle.chart;
            owner.solid = true;
        }
    }
    return {};
}

std::string checkMeshes(const Scene& before, const UnwrappedScene& after)
{
    for (const Object& object : after.scene.objects) {
        const Object& original = before.objects[std::size_t(&object - after.scene.objects.data())];
        const Mesh& mesh = after.scene.meshes[std::size_t(object.mesh)];
        const Mesh& source = before.meshes[std::size_t(original.mesh)];
        if (mesh.sourceMesh != source.sourceMesh || mesh.parts.size() != source.parts.size())
            return "a mesh lost its source or parts";
        for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
            const MeshPart &a = source.parts[p], &b = mesh.parts[p];
            const std::size_t count = b.positions.size();
            const auto whole = [&](std::size_t size, std::size_t was) { return size == (was == 0 ? 0 : count); };
            if (!whole(b.normals.size(), a.normals.size()) || !whole(b.tangents.size(), a.tangents.size()) ||
                !whole(b.uv[0].size(), a.uv[0].size()) || !whole(b.uv[1].size(), a.uv[1].size()) ||
                !whole(b.colors.size(), a.colors.size())) {
                return "vertex arrays differ in length";
            }
            if (!b.sourceVertex.empty() && b.sourceVertex.size() != count) return "sourceVertex differs in length";
            if (b.indices.size() != a.indices.size()) return "triangles were lost";
            for (std::size_t i = 0; i < b.indices.size(); ++i) {
                const uint32_t v = b.indices[i], w = a.indices[i];
                if (v >= count) return "an index is out of range";
                if (b.positions[v] != a.positions[w] || (!a.normals.empty() && b.normals[v] != a.normals[w]))
                    return "a corner changed";
                const uint32_t sourceB = b.sourceVertex.empty() ? v : b.sourceVertex[v];
                const uint32_t sourceA = a.sourceVertex.empty() ? w : a.sourceVertex[w];
                if (sourceA != sourceB) return "sourceVertex does not lead to the source's vertex";
            }
        }
    }
    return {};
}

} // namespace halflight
