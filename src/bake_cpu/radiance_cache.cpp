#include "bake_cpu/radiance_cache.h"

#include "bake_cpu/texel_group.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/sky.h"

#include <cmath>

namespace halflight {
namespace {

constexpr uint32_t kCacheSeed = 0x5eed0005u;
constexpr int kDirections = 6; ///< a chart's triangles are told apart by the axis their normals are nearest to
constexpr std::size_t kRangeTexels = 256;
/// Rays and samples of lights for each texel, by the logarithm of the cell's width: 16 and 8 for a cell or more, twice
/// that where texels have so many samples that the cells' noise would show beside their own.
struct Effort {
    int rays;
    int direct;
};
constexpr std::array<Effort, 4> kEffort = {{{16, 8}, {4, 2}, {4, 1}, {4, 1}}};
constexpr std::array<Effort, 4> kMoreEffort = {{{32, 16}, {8, 4}, {4, 2}, {4, 1}}};
constexpr int kManySamples = 96;
Effort effortOf(const IntegrationSettings& settings, int cellShift)
{
    return (settings.samples >= kManySamples ? kMoreEffort : kEffort)[std::size_t(cellShift)];
}
/// Rays shorter than this many cells would see their squares.
constexpr float kNearestInCells = 0.5f;

int directionOf(vec3 normal)
{
    const vec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
}

float cross2(vec2 a, vec2 b)
{
    return a.x * b.y - a.y * b.x;
}

/// Metres per texel at a triangle; 0 where its lightmap triangle has no area.
float texelMetersOf(const BakeGeometry& geometry, uint32_t triangle)
{
    const uvec3 t = geometry.triangles[triangle];
    const vec2 a = geometry.lightmapTexel[t.y] - geometry.lightmapTexel[t.x];
    const vec2 b = geometry.lightmapTexel[t.z] - geometry.lightmapTexel[t.x];
    const float texels = std::abs(cross2(a, b));
    const float meters2 = glm::length(glm::cross(geometry.positions[t.y] - geometry.positions[t.x],
                                                 geometry.positions[t.z] - geometry.positions[t.x]));
    return texels > 0.0f ? std::sqrt(meters2 / texels) : 0.0f;
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
    float texelMeters = 0.0f;
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

    Contribution& at(uint32_t cell)
    {
        if (contributions.empty() || contributions.back().cell != cell) contributions.push_back({cell});
        return contributions.back();
    }
};

void RadianceCache::layOut(const PathTracer& paths, const TexelMap& map)
{
    const SurfaceTracer& tracer = paths.surfaces();
    const BakeGeometry& geometry = tracer.geometry();

    // Cells as wide as leave some ten thousands of them.
    cellShift_ = 0;
    constexpr std::size_t kFewCells = 24576;
    while (cellShift_ < 3 && map.texels.size() >> (2 * (cellShift_ + 1)) >= kFewCells) ++cellShift_;

    rectangles_.assign(std::size_t(map.chartCount) * kDirections, {});
    std::vector<uint32_t> rectangleOf(geometry.triangles.size(), ~0u);
    for (const Texel& texel : map.texels) {
        const ivec2 block(texel.x >> cellShift_, texel.y >> cellShift_);
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const uint32_t triangle = map.fragments[texel.firstFragment + f].triangle;
            uint32_t& number = rectangleOf[triangle];
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
        if (area == 0 || area > 64 + 16 * (uint64_t(r.texels) >> (2 * cellShift_)) || cellCount + area > kCellMask)
            continue;
        r.firstCell = uint32_t(cellCount);
        cellCount += area;
    }
    cells_.assign(cellCount, {});

    surfaces_.assign(tracer.hitTriangleCount(), {});
    recordOfTriangle_.assign(geometry.triangles.size(), ~0u);
    for (uint32_t index = 0; index < tracer.hitTriangleCount(); ++index) {
        const uint32_t triangle = tracer.triangleAt(index);
        Surface& s = surfaces_[index];
        recordOfTriangle_[triangle] = index;
        const TransportMaterial& material = tracer.materialOfTriangle(triangle);
        s.firstCell = kNoCells;
        if (const uint32_t number = rectangleOf[triangle]; number != ~0u && rectangles_[number].firstCell != kNoCells) {
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
        if (material.emission != vec3(0.0f)) s.firstCell |= kEmissive;
        if (tracer.backIsHidden(triangle)) s.firstCell |= kHiddenBack;
    }
}

/// Gathers for one range of texels.
class RadianceCache::Gatherer {
public:
    Gatherer(const RadianceCache& cache, const PathTracer& paths, const TexelMap& map, const GatherPattern& pattern,
             const IntegrationSettings& settings, OutsidePoints& outside, RangeOutput& out)
        : cache_(cache), paths_(paths), map_(map), pattern_(pattern), settings_(settings), outside_(outside), out_(out),
          validity_(paths, settings.seed), seed_(settings.seed ^ kCacheSeed),
          effort_(effortOf(settings, cache.cellShift_)), byBounce_(std::size_t(std::max(settings.bounces, 1)) + 1)
    {}

    void gather(std::size_t begin, std::size_t end)
    {
        std::array<uint32_t, TexelGroup::kLanes> texels;
        for (std::size_t i = begin; i < end; i += TexelGroup::kLanes) {
            const std::size_t count = std::min(end - i, std::size_t(TexelGroup::kLanes));
            for (std::size_t k = 0; k < count; ++k) texels[k] = uint32_t(i + k);
            again_.clear();
            gatherGroup(GatherGroup(paths_, map_, std::span(texels.data(), count), masks(i, count)), false);
            // Texels that turned out to have points inside geometry.
            for (const uint32_t texel : std::vector<uint32_t>(again_)) {
                gatherGroup(GatherGroup(paths_, map_, std::span(&texel, 1), masks(texel, 1)), true);
            }
        }
    }
    void look(std::size_t begin, std::size_t end)
    {
        std::array<uint32_t, TexelGroup::kLanes> texels;
        for (std::size_t i = begin; i < end; i += TexelGroup::kLanes) {
            const std::size_t count = std::min(end - i, std::size_t(TexelGroup::kLanes));
            for (std::size_t k = 0; k < count; ++k) texels[k] = uint32_t(i + k);
            const TexelGroup group(paths_, map_, std::span(texels.data(), count), masks(i, count));
            for (int lane = 0; lane < group.lanes(); ++lane) {
                if (group.active(lane)) lookAcross(group, lane);
            }
        }
    }
    [[nodiscard]] uint64_t rays() const { return rays_; }

private:
    /// Rays of each texel: few where many texels share a cell. Those few have one ray in each row and each column of
    /// the pattern, and those of the next groups go into the cells they left out.
    int cellsOf(uint32_t group, std::array<uint8_t, GatherPattern::kBlock>& cells) const
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

    void gatherGroup(const GatherGroup& group, bool checked)
    {
        const int blocks = std::max(1, effort_.rays / GatherPattern::kBlock);
        std::array<uint8_t, GatherPattern::kBlock> cells;
        const auto cellCount = std::size_t(cellsOf(group.texel(0) / TexelGroup::kLanes, cells));
        std::array<bool, TexelGroup::kLanes> use{};
        for (int lane = 0; lane < group.lanes(); ++lane) use[std::size_t(lane)] = group.active(lane);
        for (int b = 0; b < blocks; ++b) {
            rays_ += uint64_t(bundle_.trace(paths_, pattern_, group, seed_, b, std::span(cells.data(), cellCount)));
            for (int lane = 0; lane < group.lanes(); ++lane) {
                if (!use[std::size_t(lane)]) continue;
                if (b == 0 && !checked && !allOutside(group, lane, std::span(cells.data(), cellCount))) {
                    use[std::size_t(lane)] = false;
                    continue;
                }
                for (std::size_t c = 0; c < cellCount; ++c) addRay(group, lane, b, cells[c]);
            }
        }
        for (int lane = 0; lane < group.lanes(); ++lane) {
            if (!use[std::size_t(lane)]) continue;
            addDirect(group, lane);
        }
    }

    /// Looks closer where a ray met the inside of a surface first. Where all rays, from as many points, met the inside
    /// of solids, there is nothing to look for.
    bool allOutside(const TexelGroup& group, int lane, std::span<const uint8_t> cells)
    {
        constexpr std::size_t kEnough = 8;
        std::size_t suspicious = 0;
        std::size_t inSolid = 0;
        for (const int cell : cells) {
            if (!bundle_.hit(cell, lane) || !bundle_.behind(cell, lane)) continue;
            suspicious += (surfaceOf(cell, lane).firstCell & kHiddenBack) != 0 ? 1 : 0;
            const RTCHit8& h = bundle_.rays[std::size_t(cell)].hit;
            const uint32_t triangle = paths_.surfaces().triangleOf(h.geomID[lane], h.primID[lane]);
            inSolid += paths_.surfaces().geometry().solid[triangle];
        }
        if (suspicious == 0) return true;
        if (inSolid == cells.size() && inSolid >= kEnough && group.pointCount(lane) == kMaxTexelPoints) {
            setOutside(group.texel(lane), 0);
            return false;
        }
        const PointMask mask = validity_.outside(group.points(lane), group.pointCount(lane), group.id(lane), rays_);
        const bool all = mask == PointMask((1u << group.pointCount(lane)) - 1u);
        setOutside(group.texel(lane), all ? kAllPoints : mask);
        if (all) return true;
        if (mask != 0) again_.push_back(group.texel(lane));
        return false;
    }

    void setOutside(uint32_t texel, PointMask mask)
    {
        outside_.masks[texel] = mask;
        outside_.known[texel] = 1;
    }
    [[nodiscard]] std::span<const PointMask> masks(std::size_t first, std::size_t count) const
    {
        return std::span(outside_.masks).subspan(first, count);
    }

    [[nodiscard]] const Surface& surfaceOf(int cell, int lane) const
    {
        const RTCHit8& h = bundle_.rays[std::size_t(cell)].hit;
        return cache_.surfaces_[paths_.surfaces().hitIndex(h.geomID[lane], h.primID[lane])];
    }

    /// Cell of a point of a texel, or kNoCells.
    [[nodiscard]] uint32_t cellOf(const SurfacePoint& point) const
    {
        const uint32_t record = cache_.recordOfTriangle_[point.triangle];
        if (record == ~0u || (cache_.surfaces_[record].firstCell & kNoCells) != 0) return kNoCells;
        return cache_.cellIndex(cache_.surfaces_[record], point.barycentric.x, point.barycentric.y);
    }

    void addRay(const GatherGroup& group, int lane, int block, int cell)
    {
        const int slot = group.slotOf(lane, block, cell);
        const uint32_t source = cellOf(group.pointOfSlot(lane, slot));
        if (source == kNoCells) return;
        Contribution& c = out_.at(source);
        ++c.rayCount;
        const vec3 direction = bundle_.direction(cell, lane);
        if (!bundle_.hit(cell, lane)) {
            const Sky& sky = paths_.sky();
            c.gathered += shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, direction);
            return;
        }
        const Surface& surface = surfaceOf(cell, lane);
        const bool behind = bundle_.behind(cell, lane);
        const RTCHit8& h = bundle_.rays[std::size_t(cell)].hit;
        bool known = !behind && (surface.firstCell & kNoCells) == 0;
        const uint32_t target = known ? cache_.cellIndex(surface, h.u[lane], h.v[lane]) : 0;
        known = known && cache_.divided_[target] == 0;
        if (known) {
            out_.links.push_back(target);
            ++c.linkCount;
            if ((surface.firstCell & kEmissive) == 0) return;
        }
        const GatherGroup::Slot& s = group.slot(lane, slot);
        const Receiver receiver{s.origin, s.normal};
        const SurfaceHit hit = bundle_.surface(paths_, cell, lane);
        const float pdf = std::max(glm::dot(direction, s.normal), 1.0e-4f) / kPi;
        if (known) {
            c.gathered += paths_.weightedEmission(hit, direction, receiver, pdf);
            return;
        }
        // No cell there: the path goes on to its end, its light counted by the number of reflections.
        std::fill(byBounce_.begin(), byBounce_.end(), vec3(0.0f));
        Sampler sampler(seed_, group.id(lane), uint32_t(block * GatherPattern::kBlock + cell));
        paths_.follow(hit, direction, receiver, pdf, settings_.bounces - 1, sampler, rays_, nullptr, byBounce_.data());
        c.gathered += byBounce_[0];
        for (uint32_t r = 1; r < byBounce_.size(); ++r) {
            if (byBounce_[r] != vec3(0.0f)) out_.late.push_back({source, r, byBounce_[r]});
        }
    }

    void addDirect(const TexelGroup& group, int lane)
    {
        const int samples = effort_.direct;
        for (int s = 0; s < samples; ++s) {
            const SurfacePoint& point = group.pointOfSlot(lane, group.slotOf(lane, s, 5 * s & 15));
            const uint32_t source = cellOf(point);
            if (source == kNoCells) continue;
            Sampler sampler(~seed_, group.id(lane), uint32_t(s));
            Contribution& c = out_.at(source);
            const vec3 irradiance = paths_.punctualIrradiance(point, false, sampler, rays_);
            c.direct += irradiance;
            c.direct += paths_.emitterIrradiance(point, luminance(irradiance), sampler, rays_).irradiance;
            c.albedo += paths_.surfaces().albedoAt(point.triangle, point.barycentric);
            ++c.directCount;
            c.texelMeters = std::max(c.texelMeters, texelMetersOf(paths_.surfaces().geometry(), point.triangle));
        }
    }

    /// Whether something stands on a cell: between this texel and the one before it, or between its middle and its rim.
    /// A thin wall has different light on its two sides. Looks along the surface, a tenth of a cell above it.
    void lookAcross(const TexelGroup& group, int lane)
    {
        const SurfacePoint& point = group.points(lane)[0];
        const uint32_t cell = cellOf(point);
        if (cell == kNoCells) return;
        const float lift =
            0.1f * float(1 << cache_.cellShift_) * texelMetersOf(paths_.surfaces().geometry(), point.triangle);
        const vec3 above = point.position + lift * point.geometricNormal;
        RTCRay8 packet;
        alignas(32) embree::LaneMask valid;
        std::array<float, embree::kPacket> reach{};
        SurfaceTracer::clear(packet);
        for (int i = 0; i < embree::kPacket; ++i) {
            vec3 target = previous_;
            const int count = group.pointCount(lane);
            if (i > 0 && count == kMaxTexelPoints) {
                // The surface fills the whole texel: as far as its border.
                const Rim& rim = rim_[std::size_t(i - 1)];
                const SurfacePoint& p = group.points(lane)[std::size_t(rim.point)];
                target = above + rim.toBorder * (p.position + lift * p.geometricNormal - above);
            } else if (i > 0) {
                const SurfacePoint& p = group.points(lane)[std::size_t(i * (count - 1) / (embree::kPacket - 1))];
                target = p.position + lift * p.geometricNormal;
            }
            const float length = glm::distance(above, target);
            valid.lane[i] = length > 0.0f && (i > 0 || previousCell_ == cell) ? -1 : 0;
            if (valid.lane[i] == 0) continue;
            const vec3 direction = (target - above) / length;
            embree::setRay(packet, i, above, direction);
            reach[std::size_t(i)] = 0.999f * length;
            packet.tfar[i] = reach[std::size_t(i)];
            ++rays_;
        }
        paths_.surfaces().occluded(valid, packet);
        for (int i = 0; i < embree::kPacket; ++i) {
            if (valid.lane[i] == 0 || packet.tfar[i] >= 0.0f) continue;
            // What lies inside a solid is no other side: nobody sees it.
            const vec3 direction(packet.dir_x[i], packet.dir_y[i], packet.dir_z[i]);
            const vec3 end = above + reach[std::size_t(i)] * direction;
            ++rays_;
            if (paths_.surfaces().intersect(end, -direction, 0.0f, reach[std::size_t(i)]).backFace) continue;
            out_.divided.push_back(cell);
            break;
        }
        previousCell_ = cell;
        previous_ = above;
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
                const vec2 place = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) - 0.5f;
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
    const PathTracer& paths_;
    const TexelMap& map_;
    const GatherPattern& pattern_;
    const IntegrationSettings& settings_;
    OutsidePoints& outside_;
    RangeOutput& out_;
    PointValidity validity_;
    uint32_t seed_;
    Effort effort_;
    RayBundle bundle_;
    std::vector<uint32_t> again_;
    std::vector<vec3> byBounce_;
    uint32_t previousCell_ = kNoCells;
    vec3 previous_{0.0f};
    uint64_t rays_ = 0;
};

bool RadianceCache::build(const PathTracer& paths, const TexelMap& map, const GatherPattern& pattern,
                          const IntegrationSettings& settings, OutsidePoints& outside, const Progress& progress,
                          std::atomic<uint64_t>& rays)
{
    layOut(paths, map);
    const std::size_t rangeCount = (map.texels.size() + kRangeTexels - 1) / kRangeTexels;
    std::vector<RangeOutput> ranges(rangeCount);
    parallelFor(rangeCount, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end && !progress.cancelled(); ++r) {
            Gatherer gatherer(*this, paths, map, pattern, settings, outside, ranges[r]);
            gatherer.look(r * kRangeTexels, std::min((r + 1) * kRangeTexels, map.texels.size()));
            rays += gatherer.rays();
        }
    });
    divided_.assign(cells_.size(), 0);
    for (const RangeOutput& range : ranges) {
        for (const uint32_t cell : range.divided) divided_[cell] = 1;
    }
    const bool finished = parallelFor(rangeCount, 1, progress, "bounces", [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end && !progress.cancelled(); ++r) {
            Gatherer gatherer(*this, paths, map, pattern, settings, outside, ranges[r]);
            gatherer.gather(r * kRangeTexels, std::min((r + 1) * kRangeTexels, map.texels.size()));
            rays += gatherer.rays();
        }
    });
    if (!finished || progress.cancelled()) return false;
    bounce(ranges, settings.bounces);
    recordOfTriangle_ = {};
    rectangles_ = {};
    substitute_ = {};
    divided_ = {};
    return true;
}

void RadianceCache::findSubstitutes(const std::vector<uint32_t>& rayCount)
{
    substitute_.resize(cells_.size());
    for (std::size_t i = 0; i < cells_.size(); ++i) substitute_[i] = uint32_t(i);
    for (std::size_t number = 0; number < rectangles_.size(); ++number) {
        const Rectangle& r = rectangles_[number];
        if (r.firstCell == kNoCells) continue;
        const ivec2 size = r.max - r.min + 1;
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const uint32_t cell = r.firstCell + uint32_t(y * size.x + x);
                if (rayCount[cell] > 0) continue;
                // The nearest cell of the rectangle, else one of the same chart that faces another way.
                int best = 9;
                for (int dy = -2; dy <= 2; ++dy) {
                    for (int dx = -2; dx <= 2; ++dx) {
                        const ivec2 p(x + dx, y + dy);
                        if (p.x < 0 || p.y < 0 || p.x >= size.x || p.y >= size.y) continue;
                        const uint32_t other = r.firstCell + uint32_t(p.y * size.x + p.x);
                        if (rayCount[other] == 0 || dx * dx + dy * dy >= best) continue;
                        best = dx * dx + dy * dy;
                        substitute_[cell] = other;
                    }
                }
                for (std::size_t d = 0; d < kDirections && substitute_[cell] == cell; ++d) {
                    const Rectangle& o = rectangles_[number / kDirections * kDirections + d];
                    if (o.firstCell == kNoCells) continue;
                    const ivec2 p = glm::clamp(r.min + ivec2(x, y), o.min, o.max) - o.min;
                    const uint32_t other = o.firstCell + uint32_t(p.y * (o.max.x - o.min.x + 1) + p.x);
                    if (rayCount[other] > 0) substitute_[cell] = other;
                }
            }
        }
    }
}

void RadianceCache::bounce(const std::vector<RangeOutput>& ranges, int bounces)
{
    const std::size_t count = cells_.size();
    bounces_ = bounces;
    std::vector<uint32_t> rayCount(count);
    std::vector<uint32_t> directCount(count);
    std::vector<vec3> first(count, vec3(0.0f)); // irradiance that needs no cells
    std::vector<vec3> direct(count, vec3(0.0f));
    std::vector<vec3> albedo(count, vec3(0.0f));
    std::vector<float> nearest(count, 0.0f);
    const float cellTexels = float(1 << cellShift_);
    for (const RangeOutput& range : ranges) {
        for (const Contribution& c : range.contributions) {
            rayCount[c.cell] += c.rayCount;
            directCount[c.cell] += c.directCount;
            first[c.cell] += kPi * c.gathered;
            direct[c.cell] += c.direct;
            albedo[c.cell] += c.albedo;
            nearest[c.cell] = std::max(nearest[c.cell], kNearestInCells * cellTexels * c.texelMeters);
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (directCount[i] == 0) rayCount[i] = 0;
        if (rayCount[i] == 0) continue;
        first[i] = first[i] / float(rayCount[i]) + direct[i] / float(directCount[i]);
        albedo[i] /= float(directCount[i]);
    }
    direct = {};
    findSubstitutes(rayCount);

    // Irradiance of one more bounce at a time: each cell's links to what their cells reflected before.
    std::vector<vec3> reflected(count, vec3(0.0f));
    std::vector<vec3> gathered(count);
    for (int b = 1; b <= bounces; ++b) {
        std::fill(gathered.begin(), gathered.end(), vec3(0.0f));
        for (const RangeOutput& range : ranges) {
            if (b == 1) break;
            std::size_t link = 0;
            for (const Contribution& c : range.contributions) {
                vec3 sum(0.0f);
                for (uint32_t l = 0; l < c.linkCount; ++l) sum += reflected[substitute_[range.links[link++]]];
                gathered[c.cell] += sum;
            }
            for (const RangeOutput::Late& late : range.late) {
                if (late.reflections < uint32_t(b)) gathered[late.cell] += late.radiance;
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (rayCount[i] == 0) continue;
            const vec3 irradiance = first[i] + gathered[i] * (kPi / float(rayCount[i]));
            reflected[i] = shading::diffuseRadiance(albedo[i], irradiance);
        }
        // Level 0 is the last bounce.
        if (bounces - b < kLevels) levels_[std::size_t(bounces - b)] = reflected;
    }
    for (auto& level : levels_) {
        if (level.empty()) continue;
        for (std::size_t i = 0; i < count; ++i) level[i] = level[substitute_[i]];
    }
    for (std::size_t i = 0; i < count; ++i) {
        const uint32_t s = substitute_[i];
        cells_[i] = {levels_[0][i], rayCount[s] > 0 && divided_[i] == 0 ? nearest[s] : kInfinity};
    }
}

bool RadianceCache::reflected(const SurfaceHit& hit, int bounces, vec3& radiance) const
{
    const int level = bounces_ - bounces;
    if (level < 0 || level >= kLevels || levels_[std::size_t(level)].empty()) return false;
    const Surface& s = surfaces_[hit.index];
    if ((s.firstCell & kNoCells) != 0 || hit.behind) return false;
    const uint32_t cell = cellIndex(s, hit.point.barycentric.x, hit.point.barycentric.y);
    if (!(hit.distance >= cells_[cell].nearest)) return false;
    radiance = levels_[std::size_t(level)][cell];
    return true;
}

} // namespace halflight
