#include "bake_cpu/radiosity/radiance_cache.h"

#include "bake_cpu/texels/ray_bundle.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/sky.h"

#include <cmath>
#include <numeric>

namespace halflight {
namespace {

constexpr uint32_t kCacheSeed = 0x5eed0005u;
constexpr int kDirections = 6; ///< a chart's triangles are told apart by the axis their normals are nearest to
constexpr std::size_t kRangeItems = 256;
/// Rays and samples of lights for each texel, by the logarithm of the cell's width: 16 and 8 for a cell or more, twice
/// that where texels have so many samples that the cells' noise would show beside their own.
struct Effort {
    int rays;
    int direct;
    int every = 1; ///< in cells that texels cover, or nearly, only one of so many gathers
};
constexpr std::array<Effort, 4> kEffort = {{{16, 8}, {4, 2}, {4, 1, 2}, {4, 1, 4}}};
constexpr std::array<Effort, 4> kMoreEffort = {{{32, 16}, {8, 4}, {4, 2}, {4, 1, 2}}};
constexpr int kManySamples = 96;
constexpr Effort kTriangleEffort = {8, 4};
constexpr Effort kPartEffort = {8, 4};
constexpr Effort kMorePartEffort = {16, 8};
constexpr float kHalfTexel = 0.5f;
/// Covered areas above this are a whole texel, but for rounding.
constexpr float kWhole = 0.999f;
/// A triangle is a cell if no edge is longer than so many cells are wide.
constexpr float kLongestEdgeInCells = 2.0f;
/// Rays shorter than this many cells would see their squares.
constexpr float kNearestInCells = 0.5f;
constexpr float kNearestInParts = 0.25f;

Effort squareEffort(const IntegrationSettings& settings, int cellShift)
{
    return (settings.samples >= kManySamples ? kMoreEffort : kEffort)[std::size_t(cellShift)];
}

int directionOf(vec3 normal)
{
    const vec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
}

float longestEdgeOf(const BakeGeometry& geometry, uint32_t triangle)
{
    const uvec3 t = geometry.triangles[triangle];
    const vec3 a = geometry.positions[t.x];
    const vec3 b = geometry.positions[t.y];
    const vec3 c = geometry.positions[t.z];
    return std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
}

} // namespace

/// What a run of samples found for one cell.
struct RadianceCache::Contribution {
    uint32_t cell = 0;
    uint32_t linkCount = 0; ///< of the cells that its rays hit
    uint32_t rayCount = 0;
    uint32_t directCount = 0;
    vec3 gathered{0.0f}; ///< radiance of sky and emitters
    vec3 direct{0.0f};   ///< irradiance of sampled lights
    vec3 albedo{0.0f};
    float nearest = 0.0f; ///< as Cell::nearest
};

struct RadianceCache::RangeOutput {
    std::vector<Contribution> contributions;
    std::vector<uint32_t> links; ///< of all contributions, one after the other
    /// Light that came by way of surfaces without cells, after so many reflections.
    struct Late {
        uint32_t cell = 0;
        uint32_t reflections = 0;
        vec3 radiance{0.0f};
    };
    std::vector<Late> late;
    std::vector<uint32_t> divided; ///< cells with something standing on them
    std::vector<uint32_t> near;    ///< cells that rays hit from close by

    /// One of a few recent ones, for what has no links.
    Contribution& recent(uint32_t cell)
    {
        constexpr std::size_t kFew = 8 * TexelGroup::kLanes;
        const std::size_t end = contributions.size();
        for (std::size_t i = end; i > 0 && i + kFew > end; --i) {
            if (contributions[i - 1].cell == cell) return contributions[i - 1];
        }
        return at(cell);
    }
    Contribution& at(uint32_t cell)
    {
        if (contributions.empty() || contributions.back().cell != cell) contributions.push_back({cell});
        return contributions.back();
    }
    /// Calls body(contribution, its links) for all of a range that may be const.
    template<typename Range, typename Body> static void forContributions(Range& range, const Body& body)
    {
        std::size_t link = 0;
        for (auto& c : range.contributions) {
            body(c, std::span(range.links).subspan(link, c.linkCount));
            link += c.linkCount;
        }
    }
};

void RadianceCache::layOut(const PathTracer& paths, const TexelMap& map)
{
    const RayTracer& tracer = paths.surfaces();
    const BakeGeometry& geometry = tracer.geometry();

    // Cells as wide as leave some ten thousands of them.
    cellShift_ = 0;
    constexpr std::size_t kFewCells = 24576;
    while (cellShift_ < 3 && map.texels.size() >> (2 * (cellShift_ + 1)) >= kFewCells) ++cellShift_;

    rectangles_.assign(std::size_t(map.chartCount) * kDirections, {});
    rectangleOfTriangle_.assign(geometry.triangles.size(), ~0u);
    for (const Texel& texel : map.texels) {
        const ivec2 block(texel.x >> cellShift_, texel.y >> cellShift_);
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const uint32_t triangle = map.fragments[texel.firstFragment + f].triangle;
            uint32_t& number = rectangleOfTriangle_[triangle];
            if (number == ~0u) {
                number = texel.chart * kDirections + uint32_t(directionOf(geometry.geometricNormal(triangle)));
            }
            Rectangle& r = rectangles_[number];
            r.min = r.texels == 0 ? block : glm::min(r.min, block);
            r.max = glm::max(r.max, block);
            ++r.texels;
        }
    }
    // Charts whose texels are strewn over the page (kept layouts can be like that) would waste memory; paths go on
    // there.
    uint64_t cellCount = 0;
    for (Rectangle& r : rectangles_) {
        const ivec2 size = r.max - r.min + 1;
        const uint64_t area = uint64_t(std::max(size.x, 0)) * uint64_t(std::max(size.y, 0));
        r.firstCell = kNoCells;
        if (area == 0 || area > 64 + 16 * (uint64_t(r.texels) >> (2 * cellShift_)) || cellCount + area > kCellMask / 4)
            continue;
        r.firstCell = uint32_t(cellCount);
        cellCount += area;
    }
    squares_ = uint32_t(cellCount);

    surfaces_.assign(tracer.hitTriangleCount(), {});
    hitIndexOfTriangle_.assign(geometry.triangles.size(), ~0u);
    for (uint32_t index = 0; index < tracer.hitTriangleCount(); ++index) {
        const uint32_t triangle = tracer.triangleAt(index);
        hitIndexOfTriangle_[triangle] = index;
        Surface& s = surfaces_[index];
        s.firstCell = kNoCells;
        if (const uint32_t number = rectangleOfTriangle_[triangle];
            number != ~0u && rectangles_[number].firstCell != kNoCells) {
            const Rectangle& r = rectangles_[number];
            const uvec3 t = geometry.triangles[triangle];
            const float scale = 1.0f / float(1 << cellShift_);
            s.origin = geometry.lightmapTexel[t.x] * scale - vec2(r.min);
            s.edgeU = (geometry.lightmapTexel[t.y] - geometry.lightmapTexel[t.x]) * scale;
            s.edgeV = (geometry.lightmapTexel[t.z] - geometry.lightmapTexel[t.x]) * scale;
            s.firstCell = r.firstCell;
            s.width = uint16_t(r.max.x - r.min.x + 1);
            s.height = uint16_t(r.max.y - r.min.y + 1);
        }
        if (tracer.materialOfTriangle(triangle).emission != vec3(0.0f)) s.firstCell |= kEmissive;
        if (tracer.backIsHidden(triangle)) s.firstCell |= kHiddenBack;
    }
    layOutTriangles(paths, map);
    state_.assign(2 * std::size_t(squares_) + 2 * cellTriangles_.size(), 0);
    firstPart_.assign(state_.size(), kNoCells);
}

/// Small triangles without a lightmap become cells: leaves, grass, small parts.
void RadianceCache::layOutTriangles(const PathTracer& paths, const TexelMap& map)
{
    const RayTracer& tracer = paths.surfaces();
    const BakeGeometry& geometry = tracer.geometry();
    double meters = 0.0;
    double texels = 0.0;
    for (const TexelFragment& f : map.fragments) {
        meters += double(f.area) * double(geometry.texelMeters(f.triangle));
        texels += double(f.area);
    }
    texelMeters_ = texels > 0.0 ? float(meters / texels) : 0.0f;
    const float longest = kLongestEdgeInCells * float(1 << cellShift_) * texelMeters_;
    // More of them than texels would cost more than they save.
    const std::size_t most = map.texels.size();
    cellTriangles_.clear();
    for (uint32_t index = 0; index < tracer.hitTriangleCount() && cellTriangles_.size() < most; ++index) {
        const uint32_t triangle = tracer.triangleAt(index);
        Surface& s = surfaces_[index];
        if ((s.firstCell & kNoCells) == 0 || rectangleOfTriangle_[triangle] != ~0u) continue;
        if (!(longestEdgeOf(geometry, triangle) <= longest)) continue;
        const uint32_t cell = 2 * squares_ + 2 * uint32_t(cellTriangles_.size());
        if (cell + 1 > kCellMask) break;
        cellTriangles_.push_back(triangle);
        s.firstCell = (s.firstCell & ~(kNoCells | kCellMask)) | cell;
        s.width = s.height = 1;
    }
}

uint32_t RadianceCache::partIndex(uint32_t record, vec2 barycentric, uint32_t cell) const
{
    const uint32_t first = firstPart_[cell];
    if (first == kNoCells) return kNoCells;
    const Surface& s = surface(record);
    const vec2 at = s.origin + barycentric.x * s.edgeU + barycentric.y * s.edgeV;
    const int shift = partShift(cell);
    const int width = 1 << shift;
    const auto partOf = [&](float x, int cells) {
        const int whole = std::clamp(int(x), 0, cells - 1);
        return uint32_t(std::clamp(int((x - float(whole)) * float(width)), 0, width - 1));
    };
    return (first & kCellMask) + (partOf(at.y, s.height) << shift) + partOf(at.x, s.width);
}

/// Gives parts to the squares, counted from the first cell of their fronts or backs, that are in any of the given
/// states: of half a texel where something stands on them or where a texel would be no smaller; where cells are of many
/// texels, these are small enough.
void RadianceCache::addParts(uint32_t firstCell, uint8_t of)
{
    for (uint32_t cell = firstCell; cell < firstCell + squares_; ++cell) {
        if ((state_[cell] & of) == 0 || firstPart_[cell] != kNoCells) continue;
        const bool half = cellShift_ == 0 || (cellShift_ == 1 && (state_[cell] & kDivided) != 0);
        const std::size_t next = state_.size() + (std::size_t(1) << (2 * (cellShift_ + (half ? 1 : 0))));
        if (next > kCellMask) return;
        firstPart_[cell] = uint32_t(state_.size()) | (half ? kHalfTexels : 0);
        state_.resize(next, half ? 0 : kTexelWide);
    }
}

/// Which backs and triangles rays hit, and which squares from close by.
void RadianceCache::findWanted(std::vector<RangeOutput>& ranges)
{
    for (RangeOutput& range : ranges) {
        for (const uint32_t cell : range.links) state_[cell] |= kWanted;
        for (const uint32_t cell : range.near) state_[cell] |= kMetNear;
        release(range.near);
    }
}

/// The square that a texel is in, on the front of a triangle, or kNoCells.
uint32_t RadianceCache::cellOf(const Texel& texel, uint32_t triangle) const
{
    const uint32_t number = rectangleOfTriangle_[triangle];
    if (number == ~0u || rectangles_[number].firstCell == kNoCells) return kNoCells;
    const Rectangle& r = rectangles_[number];
    const ivec2 at = ivec2(texel.x >> cellShift_, texel.y >> cellShift_) - r.min;
    return r.firstCell + uint32_t(at.y * (r.max.x - r.min.x + 1) + at.x);
}

/// Texels that lie in cells of a given state, counted from the first cell of the squares' fronts or backs.
std::vector<uint32_t> RadianceCache::texelsOf(const TexelMap& map, uint32_t firstCell, uint8_t state) const
{
    std::vector<uint32_t> texels;
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const Texel& texel = map.texels[i];
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const uint32_t cell = cellOf(texel, map.fragments[texel.firstFragment + f].triangle);
            if (cell == kNoCells || (state_[firstCell + cell] & state) == 0) continue;
            texels.push_back(uint32_t(i));
            break;
        }
    }
    return texels;
}

/// The square that most of a texel is in.
uint32_t RadianceCache::cellOf(const TexelMap& map, uint32_t texel) const
{
    const Texel& t = map.texels[texel];
    return cellOf(t, map.fragments[t.firstFragment].triangle);
}

/// Takes all but one texel of `every` out of cells that texels cover, or nearly, and returns them.
std::vector<uint32_t> RadianceCache::thinOut(std::vector<uint32_t>& texels, const TexelMap& map, int every) const
{
    std::vector<uint32_t> rest;
    if (every == 1) return rest;
    std::vector<uint8_t> counts(squares_);
    for (const uint32_t texel : texels) {
        if (const uint32_t cell = cellOf(map, texel); cell != kNoCells) ++counts[cell];
    }
    const int enough = 3 << (2 * cellShift_ - 2);
    std::erase_if(texels, [&](uint32_t texel) {
        const uint32_t cell = cellOf(map, texel);
        // On lines that are no rows or columns.
        const int line = map.texels[texel].x + every / 2 * map.texels[texel].y;
        if (cell == kNoCells || counts[cell] < enough || line % every == 0) return false;
        rest.push_back(texel);
        return true;
    });
    return rest;
}

/// Leaves those of `rest` that are in a cell with one of `gathered` that turned out to lie inside geometry.
void RadianceCache::keepDoubtful(std::vector<uint32_t>& rest, std::span<const uint32_t> gathered, const TexelMap& map,
                                 const ValidPoints& outside) const
{
    if (rest.empty()) return;
    std::vector<uint8_t> doubtful(squares_);
    for (const uint32_t texel : gathered) {
        if (const uint32_t cell = cellOf(map, texel); cell != kNoCells && outside.masks[texel] != kAllPoints)
            doubtful[cell] = 1;
    }
    std::erase_if(rest, [&](uint32_t texel) { return doubtful[cellOf(map, texel)] == 0; });
}

/// What a round of gathering is for. The first, of the squares, finds what the others are needed for.
enum class RadianceCache::Pass : uint32_t {
    Squares,   ///< items are texels
    Parts,     ///< texels of cells that have parts
    Backs,     ///< texels of cells whose backs are wanted
    BackParts, ///< of those, the ones that have parts
    Triangles  ///< cells that are triangles, counted from the first
};

/// Gathers for one range of items.
class RadianceCache::Gatherer {
public:
    Gatherer(const RadianceCache& cache, Pass pass, const PathTracer& paths, const TexelMap& map,
             const StratifiedPattern& pattern, const IntegrationSettings& settings, ValidPoints& outside,
             RangeOutput& out)
        : cache_(cache), pass_(pass), paths_(paths), map_(map), pattern_(pattern), settings_(settings),
          outside_(outside), out_(out), validity_(paths), seed_(settings.seed ^ (kCacheSeed + (uint32_t(pass) << 16))),
          effort_(effortOf(settings, pass, cache.cellShift_)), byBounce_(std::size_t(std::max(settings.bounces, 1)) + 1)
    {}

    void gather(std::span<const uint32_t> items)
    {
        forGroups(items, [&](const TexelGroup& group) {
            again_.clear();
            gatherGroup(GatherGroup(paths_, group));
            // Texels that turned out to have points inside geometry.
            for (const uint32_t texel : std::vector<uint32_t>(again_)) {
                gatherGroup(GatherGroup(paths_, map_, std::span(&texel, 1), std::span(&outside_.masks[texel], 1)));
            }
        });
    }
    /// Finds cells, or parts, with something standing on them.
    void look(std::span<const uint32_t> items)
    {
        forGroups(items, [&](const TexelGroup& group) {
            for (int lane = 0; lane < group.lanes(); ++lane) {
                if (!group.active(lane)) continue;
                ofParts(pass_) ? lookAcrossParts(group, lane) : lookAcross(group, lane);
            }
        });
    }
    [[nodiscard]] uint64_t rays() const { return rays_; }

private:
    static bool ofParts(Pass pass) { return pass == Pass::Parts || pass == Pass::BackParts; }
    static Effort effortOf(const IntegrationSettings& settings, Pass pass, int cellShift)
    {
        if (pass == Pass::Triangles) return kTriangleEffort;
        if (ofParts(pass)) return settings.samples >= kManySamples ? kMorePartEffort : kPartEffort;
        return squareEffort(settings, cellShift);
    }

    template<typename Body> void forGroups(std::span<const uint32_t> items, const Body& body) const
    {
        std::array<PointMask, TexelGroup::kLanes> masks;
        std::array<TexelGroup::Side, TexelGroup::kLanes> sides;
        for (std::size_t i = 0; i < items.size(); i += TexelGroup::kLanes) {
            const auto some = items.subspan(i, std::min(items.size() - i, std::size_t(TexelGroup::kLanes)));
            if (pass_ == Pass::Triangles) {
                for (std::size_t k = 0; k < some.size(); ++k)
                    sides[k] = {cache_.cellTriangles_[some[k] / 2], some[k] % 2 != 0};
                body(TexelGroup::triangles(paths_, std::span(sides.data(), some.size())));
            } else if (pass_ == Pass::Backs || pass_ == Pass::BackParts) {
                body(TexelGroup::backs(paths_, map_, some));
            } else {
                for (std::size_t k = 0; k < some.size(); ++k) masks[k] = outside_.masks[some[k]];
                body(TexelGroup(paths_, map_, some, std::span(masks.data(), some.size())));
            }
        }
    }

    /// Rays of each texel: few where many texels share a cell. Those few have one ray in each row and each column of
    /// the pattern, and those of the next groups go into the cells they left out.
    int cellsOf(uint32_t group, std::array<uint8_t, StratifiedPattern::kBlock>& cells) const
    {
        const int diagonals = std::min(effort_.rays / 4, 4);
        int count = 0;
        for (int d = 0; d < diagonals; ++d) {
            const uint32_t flip = diagonals == 1   ? group & 3u
                                  : diagonals == 2 ? (group & 1u) ^ uint32_t(2 * d)
                                                   : uint32_t(d);
            for (uint32_t x = 0; x < 4; ++x) cells[std::size_t(count++)] = uint8_t((x << 2) | (x ^ flip));
        }
        return count;
    }

    void gatherGroup(const GatherGroup& group)
    {
        const int blocks = std::max(1, effort_.rays / StratifiedPattern::kBlock);
        std::array<uint8_t, StratifiedPattern::kBlock> cells;
        const auto cellCount =
            std::size_t(cellsOf(group.texel(0) / (TexelGroup::kLanes * uint32_t(effort_.every)), cells));
        std::array<bool, TexelGroup::kLanes> use{};
        for (int lane = 0; lane < group.lanes(); ++lane) use[std::size_t(lane)] = group.active(lane);
        for (int b = 0; b < blocks; ++b) {
            rays_ += uint64_t(bundle_.trace(paths_, pattern_, group, seed_, b, std::span(cells.data(), cellCount)));
            for (int lane = 0; lane < group.lanes(); ++lane) {
                if (!use[std::size_t(lane)]) continue;
                if (b == 0 && pass_ == Pass::Squares && !allOutside(group, lane, std::span(cells.data(), cellCount))) {
                    use[std::size_t(lane)] = false;
                    continue;
                }
                sortByPart(group, lane, b, std::span(cells.data(), cellCount));
                for (std::size_t c = 0; c < cellCount; ++c) addRay(group, lane, b, cells[c]);
            }
        }
        for (int s = 0; s < effort_.direct; ++s) addDirect(group, use, s);
    }

    /// What one part gathers is then one contribution.
    void sortByPart(const GatherGroup& group, int lane, int block, std::span<uint8_t> cells) const
    {
        if (!ofParts(pass_)) return;
        std::array<uint32_t, StratifiedPattern::kBlock> parts{};
        for (const uint8_t cell : cells) {
            const SurfacePoint& point = group.point(lane, group.pointOf(lane, block, cell));
            parts[cell] = sourceOf(group, lane, point);
        }
        std::sort(cells.begin(), cells.end(),
                  [&](uint8_t a, uint8_t b) { return parts[a] != parts[b] ? parts[a] < parts[b] : a < b; });
    }

    /// Looks closer where a ray met the inside of a surface first.
    bool allOutside(const TexelGroup& group, int lane, std::span<const uint8_t> cells)
    {
        const uint32_t texel = group.texel(lane);
        if (outside_.known[texel] != 0) return true;
        const RayTracer& tracer = paths_.surfaces();
        TexelValidity::Met met{int(cells.size()), {}, kAllPoints, outside_.together[texel] != 0};
        for (const int cell : cells) {
            met.others &= PointMask(~(1u << group.pointOf(lane, 0, cell)));
            if (!bundle_.hit(cell, lane)) continue;
            const uint32_t record = recordOfHit(cell, lane);
            if (!cache_.hiddenBack(record)) continue;
            const uint8_t solid = tracer.geometry().solid[tracer.triangleAt(record / 2)];
            met.backs.add({1, solid, bundle_.rays[std::size_t(cell)].ray.tfar[lane]});
        }
        if (met.backs.hidden == 0) return true;
        const PointMask mask =
            validity_.outside(group.points(lane), group.pointCount(lane), met, group.id(lane), rays_);
        setOutside(texel, mask);
        if (mask == kAllPoints) return true;
        if (mask != 0) again_.push_back(texel);
        return false;
    }

    void setOutside(uint32_t texel, PointMask mask)
    {
        outside_.masks[texel] = mask;
        outside_.known[texel] = 1;
    }

    [[nodiscard]] uint32_t recordOfHit(int cell, int lane) const
    {
        return recordOf(paths_.surfaces(), bundle_.rays[std::size_t(cell)], lane);
    }
    [[nodiscard]] uint32_t recordOfPoint(const TexelGroup& group, int lane, const SurfacePoint& point) const
    {
        const uint32_t index = cache_.hitIndexOfTriangle_[point.triangle];
        return index == ~0u ? ~0u : recordOf(index, group.behind(lane));
    }
    [[nodiscard]] uint32_t partOf(uint32_t record, vec2 at, uint32_t cell) const
    {
        const uint32_t part = cache_.partIndex(record, at, cell);
        return part == kNoCells || (cache_.state_[part] & kDivided) != 0 ? kNoCells : part;
    }

    /// The cell, or part of one, that this pass fills from a point, or kNoCells.
    [[nodiscard]] uint32_t sourceOf(const TexelGroup& group, int lane, const SurfacePoint& point) const
    {
        const uint32_t record = recordOfPoint(group, lane, point);
        const vec2 at = point.barycentric;
        if (record == ~0u || !cache_.hasCells(record)) return kNoCells;
        const uint32_t cell = cache_.cellIndex(record, at);
        const uint8_t state = cache_.state_[cell];
        switch (pass_) {
        case Pass::Squares:
            if ((state & kDivided) == 0) return cell;
            [[fallthrough]];
        case Pass::Parts:
        case Pass::BackParts:
            return partOf(record, at, cell);
        case Pass::Backs:
        case Pass::Triangles:
            return (state & kWanted) != 0 && (state & kDivided) == 0 ? cell : kNoCells;
        }
        return kNoCells;
    }
    /// The cell, or part of one, that will know what a ray meets, or kNoCells. While the squares gather, backs and
    /// triangles become wanted.
    [[nodiscard]] uint32_t targetOf(uint32_t record, vec2 at) const
    {
        if (!cache_.hasCells(record)) return kNoCells;
        const uint32_t cell = cache_.cellIndex(record, at);
        const uint8_t state = cache_.state_[cell];
        if ((state & kDivided) != 0) return partOf(record, at, cell);
        const bool filled = cell < cache_.squares_ || pass_ == Pass::Squares || (state & kWanted) != 0;
        return filled ? cell : kNoCells;
    }
    /// Width of a cell.
    [[nodiscard]] float metersOf(uint32_t cell, uint32_t triangle) const
    {
        const BakeGeometry& geometry = paths_.surfaces().geometry();
        if (cell >= 2 * cache_.squares_ && cell < cache_.firstPart_.size()) return longestEdgeOf(geometry, triangle);
        float texels = float(1 << cache_.cellShift_);
        if (cell >= cache_.firstPart_.size()) texels = (cache_.state_[cell] & kTexelWide) != 0 ? 1.0f : kHalfTexel;
        return texels * geometry.texelMeters(triangle);
    }

    void addRay(const GatherGroup& group, int lane, int block, int cell)
    {
        const int number = group.pointOf(lane, block, cell);
        const SurfacePoint& point = group.points(lane)[std::size_t(number)];
        const uint32_t source = sourceOf(group, lane, point);
        if (source == kNoCells) return;
        Contribution& c = out_.at(source);
        ++c.rayCount;
        const vec3 direction = bundle_.direction(cell, lane);
        if (!bundle_.hit(cell, lane)) {
            const Sky& sky = paths_.sky();
            c.gathered += shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, direction);
            return;
        }
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        const uint32_t record = recordOfHit(cell, lane);
        const uint32_t target = targetOf(record, {packet.hit.u[lane], packet.hit.v[lane]});
        const bool known = target != kNoCells;
        if (known) {
            out_.links.push_back(target);
            ++c.linkCount;
            if (pass_ == Pass::Squares) findNear(source, target, packet, lane);
            if (!cache_.emissive(record)) return;
        }
        const GatherGroup::Origin& s = group.origin(lane, number);
        const Receiver receiver{s.position, s.normal};
        const RayHit at = bundle_.at(cell, lane);
        const float pdf = PathTracer::gatherPdf(s.normal, direction);
        if (known) {
            c.gathered += paths_.weightedEmission(paths_.surfaces().surfaceAt(at), direction, receiver, pdf);
            return;
        }
        // No cell there: the path goes on to its end, its light counted by the number of reflections.
        std::fill(byBounce_.begin(), byBounce_.end(), vec3(0.0f));
        Sampler sampler(seed_, group.id(lane), uint32_t(block * StratifiedPattern::kBlock + cell));
        paths_.follow(at, direction, receiver, pdf, settings_.bounces - 1, sampler, rays_, nullptr, byBounce_.data());
        c.gathered += byBounce_[0];
        for (uint32_t r = 1; r < byBounce_.size(); ++r) {
            if (byBounce_[r] != vec3(0.0f)) out_.late.push_back({source, r, byBounce_[r]});
        }
    }

    /// Both ends of a ray will be met by others from as close by.
    void findNear(uint32_t source, uint32_t target, const RTCRayHit8& packet, int lane)
    {
        if (target >= cache_.squares_) return;
        const uint32_t triangle = paths_.surfaces().triangleOf(packet.hit.geomID[lane], packet.hit.primID[lane]);
        if (!(packet.ray.tfar[lane] < kNearestInCells * metersOf(target, triangle))) return;
        out_.near.push_back(target);
        if (source < cache_.squares_) out_.near.push_back(source);
    }

    /// One sample of the lights for each lane in use.
    void addDirect(const TexelGroup& group, const std::array<bool, TexelGroup::kLanes>& use, int sample)
    {
        struct Look {
            uint32_t source = kNoCells;
            const SurfacePoint* point = nullptr;
            Sampler sampler{0, 0, 0};
            PathTracer::LightChoice choice;
        };
        std::array<Look, TexelGroup::kLanes> looks;
        ShadowPacket packet(paths_);
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            Look& look = looks[std::size_t(lane)];
            if (!use[std::size_t(lane)]) continue;
            look.point = &group.point(lane, group.pointOf(lane, 0, sample & (kMaxTexelPoints - 1)));
            look.source = sourceOf(group, lane, *look.point);
            if (look.source == kNoCells) continue;
            look.sampler = Sampler(~seed_, group.id(lane), uint32_t(sample));
            look.choice = paths_.choosePunctual(*look.point, false, look.sampler);
            if (look.choice.light == nullptr) continue;
            packet.add(lane, *look.choice.light, *look.point, look.choice.disc, rays_);
        }
        const std::array<float, TexelGroup::kLanes> shares = packet.trace();
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            Look& look = looks[std::size_t(lane)];
            if (look.source == kNoCells) continue;
            const SurfacePoint& point = *look.point;
            Contribution& c = out_.recent(look.source);
            const vec3 irradiance = look.choice.irradiance(shares[std::size_t(lane)]);
            c.direct += irradiance;
            c.direct += paths_.emitterIrradiance(point, luminance(irradiance), look.sampler, rays_).irradiance;
            c.albedo += paths_.surfaces().albedoAt(point.triangle, point.barycentric);
            ++c.directCount;
            const float cells = look.source < cache_.firstPart_.size() ? kNearestInCells : kNearestInParts;
            c.nearest = std::max(c.nearest, cells * metersOf(look.source, point.triangle));
        }
    }

    /// Whether something stands on a cell: between this texel and the one before it, or between its middle and its rim.
    /// A thin wall has different light on its two sides. Looks along the surface, a tenth of a cell above it.
    void lookAcross(const TexelGroup& group, int lane)
    {
        const TexelPoints& points = group.points(lane);
        const uint32_t cell = sourceOf(group, lane, points[0]);
        if (cell == kNoCells) return;
        const int count = group.pointCount(lane);
        const float lift = 0.1f * metersOf(cell, points[0].triangle);
        const auto overPoint = [&](int number) {
            const SurfacePoint& p = points[std::size_t(std::min(number, count - 1))];
            return p.position + lift * p.geometricNormal;
        };
        const vec3 above = overPoint(0);
        std::array<vec3, embree::kPacket> targets;
        targets[0] = previousCell_ == cell ? previous_ : above;
        const bool whole = count == kMaxTexelPoints && coveredArea(map_, map_.texels[group.texel(lane)]) > kWhole;
        for (int i = 1; i < embree::kPacket; ++i) {
            // As far as the texel's border, or to all points of it.
            const Rim& rim = rim_[std::size_t(i - 1)];
            targets[std::size_t(i)] = whole ? above + rim.toBorder * (overPoint(rim.point) - above) : overPoint(i);
        }
        Between between = lookBetween(above, targets, ~1u);
        if (!whole && count > embree::kPacket) {
            for (int i = 0; i < embree::kPacket; ++i) targets[std::size_t(i)] = overPoint(embree::kPacket + i);
            const Between others = lookBetween(above, targets, ~0u);
            between.divides = between.divides || others.divides;
            between.hides = between.hides || others.hides;
            between.solid = between.solid || others.solid;
        }
        if (between.divides) out_.divided.push_back(cell);
        previousCell_ = cell;
        previous_ = above;
        // Points that do not see one another may lie inside solids, among others that do not.
        if (pass_ != Pass::Squares) return;
        outside_.together[group.texel(lane)] = between.hides ? 0 : 1;
        if (!between.hides) return;
        if (!between.solid && !validity_.firstInSolid(points, group.id(lane), rays_)) return;
        const PointMask mask = validity_.outsideSolids(points, count, group.id(lane), rays_);
        if (mask == kAllPoints) return;
        setOutside(group.texel(lane), validity_.outsideShells(points, count, mask, false, group.id(lane), rays_));
    }

    /// The same for the parts that a texel's points are in: from one of them to the part's border, or to the others.
    void lookAcrossParts(const TexelGroup& group, int lane)
    {
        std::array<uint32_t, kMaxTexelPoints> parts;
        for (int p = 0; p < group.pointCount(lane); ++p) {
            const SurfacePoint& point = group.points(lane)[std::size_t(p)];
            parts[std::size_t(p)] = sourceOf(group, lane, point);
        }
        const auto end = parts.begin() + group.pointCount(lane);
        for (auto part = parts.begin(); part != end; ++part) {
            if (*part == kNoCells || std::find(parts.begin(), part, *part) != part) continue;
            const SurfacePoint& point = group.points(lane)[std::size_t(part - parts.begin())];
            const float lift = 0.1f * metersOf(*part, point.triangle);
            const vec3 above = point.position + lift * point.geometricNormal;
            std::array<vec3, embree::kPacket> targets;
            targets.fill(above);
            if (group.pointCount(lane) < kMaxTexelPoints || !toBorder(group, lane, point, above, targets)) {
                std::size_t count = 0;
                for (auto other = part + 1; other != end && count < targets.size(); ++other) {
                    if (*other != *part) continue;
                    const SurfacePoint& p = group.points(lane)[std::size_t(other - parts.begin())];
                    targets[count++] = p.position + lift * p.geometricNormal;
                }
            }
            if (lookBetween(above, targets, 0).divides) out_.divided.push_back(*part);
        }
    }

    /// Where the corners and the middles of the edges are of the part that a point is in, at the height of `above`.
    /// False where the lightmap's triangle has no area.
    bool toBorder(const TexelGroup& group, int lane, const SurfacePoint& point, vec3 above,
                  std::array<vec3, embree::kPacket>& targets) const
    {
        const uint32_t record = recordOfPoint(group, lane, point);
        const Surface& surface = cache_.surface(record);
        const uint32_t cell = cache_.cellIndex(record, point.barycentric);
        const float size = 1.0f / float(1 << cache_.partShift(cell)); // of a part, in cells
        const vec2 at = surface.origin + point.barycentric.x * surface.edgeU + point.barycentric.y * surface.edgeV;
        const float area = cross2(surface.edgeU, surface.edgeV);
        if (std::abs(area) < 1.0e-12f) return false;
        const BakeGeometry& geometry = paths_.surfaces().geometry();
        const uvec3 t = geometry.triangles[point.triangle];
        const vec3 edge1 = geometry.positions[t.y] - geometry.positions[t.x];
        const vec3 edge2 = geometry.positions[t.z] - geometry.positions[t.x];
        const vec2 corner = size * glm::floor(at / size);
        constexpr std::array<vec2, embree::kPacket> kBorder = {{{0.0f, 0.0f},
                                                                {0.5f, 0.0f},
                                                                {1.0f, 0.0f},
                                                                {1.0f, 0.5f},
                                                                {1.0f, 1.0f},
                                                                {0.5f, 1.0f},
                                                                {0.0f, 1.0f},
                                                                {0.0f, 0.5f}}};
        for (std::size_t i = 0; i < targets.size(); ++i) {
            const vec2 way = corner + size * kBorder[i] - at;
            targets[i] = above + (cross2(way, surface.edgeV) * edge1 + cross2(surface.edgeU, way) * edge2) / area;
        }
        return true;
    }

    /// What stands between a point and others.
    struct Between {
        bool divides = false; ///< something that has two sides: what lies inside a solid is none, nobody sees it
        bool hides = false;   ///< anything, of those asked for
        bool solid = false;   ///< and a solid
    };
    /// `asked`: a bit for each of the others that tells of what hides it, too.
    Between lookBetween(vec3 from, const std::array<vec3, embree::kPacket>& targets, uint32_t asked)
    {
        const RayTracer& tracer = paths_.surfaces();
        RTCRayHit8 packet;
        alignas(32) embree::LaneMask valid;
        std::array<float, embree::kPacket> reach{};
        RayTracer::clear(packet.ray);
        for (int i = 0; i < embree::kPacket; ++i) {
            const vec3 target = targets[std::size_t(i)];
            const float length = glm::distance(from, target);
            valid.lane[i] = length > 0.0f ? -1 : 0;
            if (valid.lane[i] == 0) continue;
            embree::setRay(packet.ray, i, from, (target - from) / length);
            reach[std::size_t(i)] = 0.999f * length;
            packet.ray.tfar[i] = reach[std::size_t(i)];
            ++rays_;
        }
        tracer.intersect(valid, packet);
        const auto solid = [&](int lane) {
            const uint32_t triangle = tracer.triangleOf(packet.hit.geomID[lane], packet.hit.primID[lane]);
            return ((asked >> lane) & 1u) != 0 && tracer.geometry().solid[triangle] != 0;
        };
        Between between;
        // And back again from where the way is blocked.
        bool any = false;
        for (int i = 0; i < embree::kPacket; ++i) {
            if (valid.lane[i] == 0) continue;
            valid.lane[i] = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? -1 : 0;
            if (valid.lane[i] == 0) continue;
            any = true;
            between.hides = between.hides || ((asked >> i) & 1u) != 0;
            between.solid = between.solid || solid(i);
            const vec3 direction = embree::directionOf(packet.ray, i);
            embree::setRay(packet.ray, i, from + reach[std::size_t(i)] * direction, -direction);
            packet.ray.tfar[i] = reach[std::size_t(i)];
            ++rays_;
        }
        if (!any) return between;
        tracer.intersect(valid, packet);
        for (int i = 0; i < embree::kPacket; ++i) {
            if (valid.lane[i] == 0) continue;
            const bool found = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
            between.solid = between.solid || (found && solid(i));
            const bool inside = found && embree::behind(packet, i) &&
                                tracer.backIsHidden(tracer.triangleOf(packet.hit.geomID[i], packet.hit.primID[i]));
            between.divides = between.divides || !inside;
        }
        return between;
    }

    /// Those of texelPoints()'s points that lie farthest out in seven directions, and how much farther the texel's
    /// border is.
    struct Rim {
        int point = 0;
        float toBorder = 1.0f;
    };
    static std::array<Rim, 7> rimPoints()
    {
        std::array<Rim, 7> rim{};
        for (int k = 0; k < 7; ++k) {
            const float angle = 2.0f * kPi * float(k) / 7.0f;
            float farthest = -1.0f;
            for (int i = 1; i < kMaxTexelPoints; ++i) {
                const vec2 place = r2Point(i) - 0.5f;
                const float out = glm::dot(place, vec2(std::cos(angle), std::sin(angle)));
                if (out <= farthest) continue;
                farthest = out;
                rim[std::size_t(k)] = {i, 0.5f / std::max(std::abs(place.x), std::abs(place.y))};
            }
        }
        return rim;
    }
    const std::array<Rim, 7> rim_ = rimPoints();

    const RadianceCache& cache_;
    Pass pass_;
    const PathTracer& paths_;
    const TexelMap& map_;
    const StratifiedPattern& pattern_;
    const IntegrationSettings& settings_;
    ValidPoints& outside_;
    RangeOutput& out_;
    TexelValidity validity_;
    uint32_t seed_;
    Effort effort_;
    RayBundle bundle_;
    std::vector<uint32_t> again_;
    std::vector<vec3> byBounce_;
    uint32_t previousCell_ = kNoCells;
    vec3 previous_{0.0f};
    uint64_t rays_ = 0;
};

bool RadianceCache::build(const PathTracer& paths, const TexelMap& map, const StratifiedPattern& pattern,
                          const IntegrationSettings& settings, ValidPoints& outside, const Progress& progress,
                          std::atomic<uint64_t>& rays)
{
    layOut(paths, map);
    std::vector<uint32_t> all(map.texels.size());
    std::iota(all.begin(), all.end(), 0u);
    const auto forRanges = [&](Pass pass, std::span<const uint32_t> items, std::vector<RangeOutput>& out,
                               const auto& work) {
        const std::size_t first = out.size();
        out.resize(first + (items.size() + kRangeItems - 1) / kRangeItems);
        parallelFor(out.size() - first, 1, progress, "bounces", [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end && !progress.cancelled(); ++r) {
                Gatherer gatherer(*this, pass, paths, map, pattern, settings, outside, out[first + r]);
                const std::size_t item = r * kRangeItems;
                work(gatherer, items.subspan(item, std::min(kRangeItems, items.size() - item)));
                out[first + r].contributions.shrink_to_fit();
                out[first + r].links.shrink_to_fit();
                rays += gatherer.rays();
            }
        });
    };
    const auto look = [&](Pass pass, std::span<const uint32_t> items) {
        std::vector<RangeOutput> found;
        forRanges(pass, items, found, [](Gatherer& g, std::span<const uint32_t> some) { g.look(some); });
        for (const RangeOutput& range : found) {
            for (const uint32_t cell : range.divided) state_[cell] |= kDivided;
        }
    };
    std::vector<RangeOutput> ranges;
    const auto gather = [&](Pass pass, std::span<const uint32_t> items) {
        forRanges(pass, items, ranges, [](Gatherer& g, std::span<const uint32_t> some) { g.gather(some); });
    };
    look(Pass::Squares, all);
    addParts(0, kDivided);
    look(Pass::Parts, texelsOf(map, 0, kDivided));
    std::vector<uint32_t> rest = thinOut(all, map, squareEffort(settings, cellShift_).every);
    gather(Pass::Squares, all);
    keepDoubtful(rest, all, map, outside);
    release(all);
    gather(Pass::Squares, rest);
    release(rest);
    findWanted(ranges);
    addParts(0, kMetNear);
    const std::vector<uint32_t> backs = texelsOf(map, squares_, kWanted);
    std::vector<uint32_t> triangles;
    for (uint32_t i = 0; i < 2 * cellTriangles_.size(); ++i) {
        if ((state_[2 * squares_ + i] & kWanted) != 0) triangles.push_back(i);
    }
    look(Pass::Backs, backs);
    addParts(squares_, kDivided);
    const std::vector<uint32_t> backParts = texelsOf(map, squares_, kDivided);
    look(Pass::BackParts, backParts);
    gather(Pass::Backs, backs);
    gather(Pass::BackParts, backParts);
    gather(Pass::Triangles, triangles);
    gather(Pass::Parts, texelsOf(map, 0, kDivided | kMetNear));
    if (progress.cancelled()) return false;
    bounce(ranges, map, paths.surfaces(), settings.bounces);
    release(rectangleOfTriangle_);
    release(rectangles_);
    release(cellTriangles_);
    release(state_);
    release(ranges);
    releaseFreeMemory();
    return true;
}

/// For triangles that no ray met while the squares gathered: the nearest one of those that the same mesh lists shortly
/// before and after it.
void RadianceCache::findSubstituteTriangles(const std::vector<uint32_t>& rayCount, const BakeGeometry& geometry)
{
    constexpr std::ptrdiff_t kReach = 8;
    const auto count = std::ptrdiff_t(cellTriangles_.size());
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        const uint32_t triangle = cellTriangles_[std::size_t(i)];
        const vec3 from = geometry.centroid(triangle);
        for (uint32_t side = 0; side < 2; ++side) {
            const uint32_t cell = 2 * squares_ + 2 * uint32_t(i) + side;
            float best = longestEdgeOf(geometry, triangle);
            for (std::ptrdiff_t j = std::max(i - kReach, std::ptrdiff_t(0));
                 rayCount[cell] == 0 && j < std::min(i + kReach + 1, count); ++j) {
                const uint32_t other = 2 * squares_ + 2 * uint32_t(j) + side;
                const uint32_t otherTriangle = cellTriangles_[std::size_t(j)];
                if (rayCount[other] == 0 || geometry.partOfTriangle[otherTriangle] != geometry.partOfTriangle[triangle])
                    continue;
                const float distance = glm::distance(from, geometry.centroid(otherTriangle));
                if (distance > best) continue;
                best = distance;
                substitute_[cell] = other;
            }
        }
    }
}

void RadianceCache::findSubstitutes(const std::vector<uint32_t>& rayCount, const BakeGeometry& geometry)
{
    substitute_.resize(rayCount.size());
    std::iota(substitute_.begin(), substitute_.end(), 0u);
    // The nearest one of a rectangle of cells, if any is near.
    const auto nearest = [&](uint32_t first, ivec2 size, ivec2 at) {
        uint32_t found = kNoCells;
        int best = 9;
        for (int dy = -2; dy <= 2; ++dy) {
            for (int dx = -2; dx <= 2; ++dx) {
                const ivec2 p = at + ivec2(dx, dy);
                if (p.x < 0 || p.y < 0 || p.x >= size.x || p.y >= size.y) continue;
                const uint32_t other = first + uint32_t(p.y * size.x + p.x);
                if (rayCount[other] == 0 || dx * dx + dy * dy >= best) continue;
                best = dx * dx + dy * dy;
                found = other;
            }
        }
        return found;
    };
    findSubstituteTriangles(rayCount, geometry);
    for (std::size_t number = 0; number < rectangles_.size(); ++number) {
        const Rectangle& r = rectangles_[number];
        if (r.firstCell == kNoCells) continue;
        const ivec2 size = r.max - r.min + 1;
        for (const uint32_t side : {0u, squares_}) {
            for (uint32_t i = 0; i < uint32_t(size.x * size.y); ++i) {
                const uint32_t cell = side + r.firstCell + i;
                if (rayCount[cell] > 0) continue;
                const ivec2 at(int(i) % size.x, int(i) / size.x);
                if (const uint32_t found = nearest(side + r.firstCell, size, at); found != kNoCells) {
                    substitute_[cell] = found;
                    continue;
                }
                // Else one of the same chart that faces another way.
                for (std::size_t d = 0; d < kDirections && substitute_[cell] == cell; ++d) {
                    const Rectangle& o = rectangles_[number / kDirections * kDirections + d];
                    if (o.firstCell == kNoCells) continue;
                    const ivec2 p = glm::clamp(r.min + at, o.min, o.max) - o.min;
                    const uint32_t other = side + o.firstCell + uint32_t(p.y * (o.max.x - o.min.x + 1) + p.x);
                    if (rayCount[other] > 0) substitute_[cell] = other;
                }
            }
        }
    }
}

void RadianceCache::bounce(std::vector<RangeOutput>& ranges, const TexelMap& map, const RayTracer& tracer, int bounces)
{
    const std::size_t count = state_.size();
    bounces_ = bounces;
    std::vector<uint32_t> rayCount(count);
    {
        std::vector<uint8_t> anyDirect(count);
        for (const RangeOutput& range : ranges) {
            for (const Contribution& c : range.contributions) {
                rayCount[c.cell] += c.rayCount;
                if (c.directCount > 0) anyDirect[c.cell] = 1;
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (anyDirect[i] == 0 || (state_[i] & kDivided) != 0) rayCount[i] = 0;
        }
    }
    findSubstitutes(rayCount, tracer.geometry());

    // Cells that know something, one after the other: many do not.
    std::vector<uint32_t> filled(count, kNoCells);
    uint32_t filledCount = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (rayCount[i] > 0) filled[i] = filledCount++;
    }
    const auto filledFor = [&](std::size_t cell) { return filled[substitute_[cell]]; };
    struct Sum {
        vec3 first{0.0f}; ///< irradiance that rays bring and no cell has to tell
        vec3 direct{0.0f};
        vec3 albedo{0.0f};
        float directCount = 0.0f;
        float rays = 0.0f;
        float nearest = 0.0f;
    };
    std::vector<Sum> sums(filledCount);
    for (RangeOutput& range : ranges) {
        RangeOutput::forContributions(range, [&](Contribution& c, std::span<uint32_t> links) {
            const uint32_t own = filled[c.cell];
            // Rays that met what turned out to be no cell are left out.
            uint32_t lost = 0;
            for (uint32_t& target : links) {
                target = (state_[target] & kDivided) != 0 ? kNoCells : filledFor(target);
                if (target == kNoCells) ++lost;
            }
            c.cell = own;
            if (own == kNoCells) return;
            Sum& sum = sums[own];
            sum.first += kPi * c.gathered;
            sum.direct += c.direct;
            sum.albedo += c.albedo;
            sum.directCount += float(c.directCount);
            sum.rays += float(c.rayCount - lost);
            sum.nearest = std::max(sum.nearest, c.nearest);
        });
        for (RangeOutput::Late& late : range.late) late.cell = filled[late.cell];
    }
    for (Sum& sum : sums) {
        sum.rays = std::max(sum.rays, 1.0f);
        sum.first /= sum.rays;
        sum.direct /= sum.directCount;
        sum.albedo /= sum.directCount;
    }

    // Irradiance of one more bounce at a time: each cell's links to what their cells reflected before.
    std::vector<vec3> reflected(filledCount, vec3(0.0f));
    std::vector<vec3> gathered(filledCount);
    for (int b = 1; b <= bounces; ++b) {
        std::fill(gathered.begin(), gathered.end(), vec3(0.0f));
        for (const RangeOutput& range : ranges) {
            if (b == 1) break;
            RangeOutput::forContributions(range, [&](const Contribution& c, std::span<const uint32_t> links) {
                vec3 sum(0.0f);
                for (const uint32_t target : links) {
                    if (target != kNoCells) sum += reflected[target];
                }
                if (c.cell != kNoCells) gathered[c.cell] += sum;
            });
            for (const RangeOutput::Late& late : range.late) {
                if (late.cell != kNoCells && late.reflections < uint32_t(b)) gathered[late.cell] += late.radiance;
            }
        }
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const vec3 irradiance = sums[i].first + sums[i].direct + gathered[i] * (kPi / sums[i].rays);
            reflected[i] = shading::diffuseRadiance(sums[i].albedo, irradiance);
        }
        if (b == bounces || bounces - b > int(levels_.size())) continue;
        auto& level = levels_[std::size_t(bounces - b - 1)];
        level.resize(firstPart_.size());
        for (std::size_t i = 0; i < level.size(); ++i) {
            level[i] = filledFor(i) != kNoCells ? reflected[filledFor(i)] : vec3(0.0f);
        }
    }
    // From here on, less is needed of each.
    std::vector<Cell> cellOfFilled(filledCount);
    std::vector<float> illuminance(squares_); // that rays bring and no cell has to tell
    for (std::size_t i = 0; i < sums.size(); ++i) cellOfFilled[i] = {reflected[i], sums[i].nearest};
    for (std::size_t i = 0; i < squares_; ++i) {
        if (filledFor(i) != kNoCells) illuminance[i] = luminance(sums[filledFor(i)].first);
    }
    release(gathered);
    release(reflected);
    release(sums);
    cells_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        if (filledFor(i) == kNoCells) continue;
        cells_[i] = cellOfFilled[filledFor(i)];
        if ((state_[i] & kDivided) != 0) cells_[i].nearest = kInfinity;
    }
    release(cellOfFilled);
    fillParts(rayCount);
    // Whose number is whose: parts count as their cell.
    std::vector<uint32_t> owner(filledCount, kNoCells);
    for (uint32_t cell = 0; cell < firstPart_.size(); ++cell) {
        if (filled[cell] != kNoCells) owner[filled[cell]] = cell;
        if (firstPart_[cell] == kNoCells) continue;
        const uint32_t first = firstPart_[cell] & kCellMask;
        for (uint32_t p = first; p < first + partCount(cell); ++p) {
            if (filled[p] != kNoCells) owner[filled[p]] = cell;
        }
    }
    release(filled);
    release(rayCount);
    release(substitute_);
    findBright(ranges, map, tracer, owner, illuminance);
}

/// Parts that no sample fell into are like those around them, where these are like one another.
void RadianceCache::fillParts(const std::vector<uint32_t>& rayCount)
{
    constexpr float kAlike = 1.5f;
    for (uint32_t cell = 0; cell < 2 * squares_; ++cell) {
        if (firstPart_[cell] == kNoCells) continue;
        const uint32_t first = firstPart_[cell] & kCellMask;
        const int width = 1 << partShift(cell);
        for (uint32_t part = first; part < first + partCount(cell); ++part) {
            if (rayCount[part] > 0 || (state_[part] & kDivided) != 0) continue;
            const auto i = int(part - first);
            const ivec2 at(i % width, i / width);
            float least = kInfinity;
            float most = 0.0f;
            float count = 0.0f;
            Cell sum;
            sum.nearest = 0.0f;
            for (int y = std::max(at.y - 1, 0); y <= std::min(at.y + 1, width - 1); ++y) {
                for (int x = std::max(at.x - 1, 0); x <= std::min(at.x + 1, width - 1); ++x) {
                    const uint32_t other = first + uint32_t(y * width + x);
                    if (rayCount[other] == 0) continue;
                    least = std::min(least, luminance(cells_[other].radiance));
                    most = std::max(most, luminance(cells_[other].radiance));
                    sum.radiance += cells_[other].radiance;
                    sum.nearest = std::max(sum.nearest, cells_[other].nearest);
                    ++count;
                }
            }
            if (count == 0.0f || most > kAlike * least) continue;
            cells_[part] = {sum.radiance / count, sum.nearest};
        }
    }
}

/// Tells what squares are like, and which of them rays met, so that the brightest can be sampled. Single triangles,
/// leaves mostly, are left to the rays: knowing them all takes memory.
void RadianceCache::findBright(const std::vector<RangeOutput>& ranges, const TexelMap& map, const RayTracer& tracer,
                               std::span<const uint32_t> ownerOfFilled, std::span<const float> illuminance)
{
    const BakeGeometry& geometry = tracer.geometry();
    std::vector<CellLight> lights(2 * std::size_t(squares_));
    for (const Texel& texel : map.texels) {
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[texel.firstFragment + f];
            const uint32_t cell = cellOf(texel, fragment.triangle);
            if (cell == kNoCells || lights[cell].receives) continue;
            const uvec3 t = geometry.triangles[fragment.triangle];
            const vec3 a = geometry.positions[t.x];
            CellLight& front = lights[cell];
            CellLight& back = lights[backOf(cell)];
            front.position = back.position = a + fragment.barycentric.x * (geometry.positions[t.y] - a) +
                                             fragment.barycentric.y * (geometry.positions[t.z] - a);
            front.direction = uint8_t(rectangleOfTriangle_[fragment.triangle] % kDirections);
            back.direction = front.direction ^ 1u;
            front.receives = true;
        }
    }
    // Of cells that something stands on, the parts know more.
    for (std::size_t i = 0; i < lights.size(); ++i) {
        lights[i].radiance = luminance(cells_[i].radiance);
        if (firstPart_[i] == kNoCells || cells_[i].nearest < kInfinity) continue;
        const uint32_t first = firstPart_[i] & kCellMask;
        float sum = 0.0f;
        float count = 0.0f;
        for (uint32_t p = first; p < first + partCount(uint32_t(i)); ++p) {
            if (!(cells_[p].nearest < kInfinity)) continue;
            sum += luminance(cells_[p].radiance);
            ++count;
        }
        lights[i].radiance = count > 0.0f ? sum / count : 0.0f;
    }
    // Links are numbers of filled cells by now.
    const auto forContributions = [&](const auto& body) {
        for (const RangeOutput& range : ranges) {
            RangeOutput::forContributions(range, [&](const Contribution& c, std::span<const uint32_t> links) {
                if (c.cell != kNoCells && ownerOfFilled[c.cell] < squares_) body(ownerOfFilled[c.cell], c, links);
            });
        }
    };
    std::vector<float> gathered(squares_);
    forContributions([&](uint32_t cell, const Contribution& c, std::span<const uint32_t> links) {
        lights[cell].rays += float(c.rayCount);
        for (const uint32_t target : links) {
            if (target != kNoCells) gathered[cell] += luminance(cells_[ownerOfFilled[target]].radiance);
        }
    });
    for (uint32_t cell = 0; cell < squares_; ++cell) {
        lights[cell].illuminance = illuminance[cell] + kPi * gathered[cell] / std::max(lights[cell].rays, 1.0f);
    }
    bright_ = BrightCells(*this, tracer, lights, texelMeters_, map.texels.size(), [&](const auto& sighting) {
        forContributions([&](uint32_t cell, const Contribution&, std::span<const uint32_t> links) {
            for (const uint32_t target : links) {
                if (target != kNoCells && ownerOfFilled[target] < 2 * squares_) sighting(cell, ownerOfFilled[target]);
            }
        });
    });
    for (uint32_t cell = 0; cell < lights.size(); ++cell) {
        if (bright_.contains(cell)) cells_[cell].nearest = -cells_[cell].nearest;
    }
}

bool RadianceCache::reflected(uint32_t record, vec2 barycentric, float distance, int bounces, vec3& radiance) const
{
    const int fewer = bounces_ - bounces;
    if (fewer < 0 || fewer > int(levels_.size()) || !hasCells(record)) return false;
    const uint32_t cell = cellIndex(record, barycentric);
    const vec3* light = nullptr;
    if (fewer == 0) {
        light = known(record, barycentric, cell, distance);
    } else if (!levels_[std::size_t(fewer - 1)].empty() && cells_[cell].answers(distance)) {
        light = &levels_[std::size_t(fewer - 1)][cell];
    }
    if (light != nullptr) radiance = *light;
    return light != nullptr;
}

} // namespace halflight
