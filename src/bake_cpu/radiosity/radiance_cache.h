#pragma once
// Reflected light of the lightmapped surfaces, in cells of a few texels: where the gather's rays end.

#include "bake_cpu/guiding/guides.h"
#include "bake_cpu/sample/path_tracer.h"
#include "bake_cpu/sample/stratified_pattern.h"
#include "bake_cpu/texels/texel_validity.h"

#include "halflight/bake/integrator.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <vector>

namespace halflight {

/// The surface is cut into cells, squares of 1 to 64 lightmap texels that lie on one chart and face one way. A cell's
/// irradiance is gathered once by rays spread over its texels, which also remember the cells they hit, so that each
/// further bounce is a pass over memory: radiosity (Goral et al. 1984, "Modeling the Interaction of Light Between
/// Diffuse Surfaces") with sampled form factors, and a final gather on top of it (Reichert 1992, "A Two-Pass Radiosity
/// Method Driven by Lights and Viewer Position"). What it leaves out is variation within a cell: rays that hit close by
/// do not use it, nor those that hit cells with something standing across them. Such cells have parts that are
/// gathered on their own: a texel wide, or half of one where something stands. The backs of surfaces have cells where
/// rays met them; small triangles without a lightmap are cells themselves, one for each side.
class RadianceCache {
public:
    /// Of a hit triangle: where the cells of its front are. Texture coordinates count cells from the corner of their
    /// rectangle.
    struct Surface {
        vec2 origin{0.0f};
        vec2 edgeU{0.0f};
        vec2 edgeV{0.0f};
        uint32_t firstCell = 0; ///< with flags in the highest bits
        uint16_t width = 0;
        uint16_t height = 0;
    };
    static constexpr uint32_t kNoCells = 0x80000000u;
    static constexpr uint32_t kEmissive = 0x40000000u;
    static constexpr uint32_t kHiddenBack = 0x20000000u; ///< nobody is meant to see its back
    static constexpr uint32_t kCellMask = 0x1fffffffu;

    struct Cell {
        vec3 radiance{0.0f}; ///< reflected, after all bounces
        /// Rays that hit at less than this many metres do not use the cell; negated where the cell is a bright one.
        float nearest = kInfinity;
        [[nodiscard]] bool answers(float distance) const { return distance >= std::abs(nearest); }
        [[nodiscard]] bool bright() const { return std::signbit(nearest); }
    };

    /// Gathers what the cells reflect after up to `settings.bounces` bounces (at least 1). Looks closer at texels whose
    /// rays meet the inside of surfaces, and writes what it finds. False when cancelled.
    bool build(const PathTracer& paths, const TexelMap& map, const StratifiedPattern& pattern,
               const IntegrationSettings& settings, ValidPoints& outside, const Progress& progress,
               std::atomic<uint64_t>& rays);

    /// Number of a side of a hit triangle.
    static uint32_t recordOf(uint32_t hitIndex, bool behind) { return 2 * hitIndex + (behind ? 1u : 0u); }
    static uint32_t recordOf(const RayTracer& tracer, const RTCRayHit8& rays, int lane)
    {
        return recordOf(tracer.hitIndex(rays.hit.geomID[lane], rays.hit.primID[lane]), embree::behind(rays, lane));
    }
    [[nodiscard]] const Surface& surface(uint32_t record) const { return surfaces_[record / 2]; }
    [[nodiscard]] bool hasCells(uint32_t record) const { return (surface(record).firstCell & kNoCells) == 0; }
    [[nodiscard]] bool emissive(uint32_t record) const { return (surface(record).firstCell & kEmissive) != 0; }
    [[nodiscard]] bool hiddenBack(uint32_t record) const
    {
        return record % 2 != 0 && (surface(record).firstCell & kHiddenBack) != 0;
    }
    /// The cell at a place of a side that has some.
    [[nodiscard]] uint32_t cellIndex(uint32_t record, vec2 barycentric) const
    {
        const Surface& s = surface(record);
        const vec2 at = s.origin + barycentric.x * s.edgeU + barycentric.y * s.edgeV;
        const auto x = std::clamp(int(at.x), 0, int(s.width) - 1);
        const auto y = std::clamp(int(at.y), 0, int(s.height) - 1);
        const uint32_t front = (s.firstCell & kCellMask) + uint32_t(y) * s.width + uint32_t(x);
        return record % 2 == 0 ? front : backOf(front);
    }
    /// The back of a front's cell.
    [[nodiscard]] uint32_t backOf(uint32_t front) const { return front + (front < squares_ ? squares_ : 1); }
    /// The part of a cell at a place, or kNoCells.
    [[nodiscard]] uint32_t partIndex(uint32_t record, vec2 barycentric, uint32_t cell) const;
    void prefetchParts(uint32_t cell) const { __builtin_prefetch(&firstPart_[cell]); }
    [[nodiscard]] const Cell* cells() const { return cells_.data(); }
    /// What a cell that a side's place is in, or its part, reflects towards the other end of a ray of some length; null
    /// where that is too close by.
    [[nodiscard]] const vec3* known(uint32_t record, vec2 barycentric, uint32_t cell, float distance) const
    {
        const Cell* c = cells() + cell;
        if (c->answers(distance)) return &c->radiance;
        const uint32_t part = partIndex(record, barycentric, cell);
        if (part == kNoCells) return nullptr;
        c = cells() + part;
        return c->answers(distance) ? &c->radiance : nullptr;
    }
    [[nodiscard]] const BrightCells& bright() const { return bright_; }
    /// What is known of bright cells at a point of a front.
    [[nodiscard]] BrightCells::Guide guide(const SurfacePoint& point) const
    {
        const uint32_t index = hitIndexOfTriangle_[point.triangle];
        if (bright_.empty() || index == ~0u || !hasCells(recordOf(index, false))) return {};
        return bright_.guide(cellIndex(recordOf(index, false), point.barycentric));
    }
    /// Light that the end of a ray of some length reflects after at most `bounces` reflections, if a cell knows it.
    [[nodiscard]] bool reflected(uint32_t record, vec2 barycentric, float distance, int bounces, vec3& radiance) const;

private:
    struct Contribution;
    struct RangeOutput;
    enum class Pass : uint32_t;
    class Gatherer;
    void layOut(const PathTracer& paths, const TexelMap& map);
    void layOutTriangles(const PathTracer& paths, const TexelMap& map);
    void addParts(uint32_t firstCell, uint8_t of);
    void findWanted(std::vector<RangeOutput>& ranges);
    [[nodiscard]] uint32_t cellOf(const Texel& texel, uint32_t triangle) const;
    [[nodiscard]] uint32_t cellOf(const TexelMap& map, uint32_t texel) const;
    std::vector<uint32_t> thinOut(std::vector<uint32_t>& texels, const TexelMap& map, int every) const;
    void keepDoubtful(std::vector<uint32_t>& rest, std::span<const uint32_t> gathered, const TexelMap& map,
                      const ValidPoints& outside) const;
    [[nodiscard]] std::vector<uint32_t> texelsOf(const TexelMap& map, uint32_t firstCell, uint8_t state) const;
    void findSubstituteTriangles(const std::vector<uint32_t>& rayCount, const BakeGeometry& geometry);
    void findSubstitutes(const std::vector<uint32_t>& rayCount, const BakeGeometry& geometry);
    void bounce(std::vector<RangeOutput>& ranges, const TexelMap& map, const RayTracer& tracer, int bounces);
    void fillParts(const std::vector<uint32_t>& rayCount);
    void findBright(const std::vector<RangeOutput>& ranges, const TexelMap& map, const RayTracer& tracer,
                    std::span<const uint32_t> ownerOfFilled, std::span<const float> illuminance);

    /// In firstPart_: parts are half a texel wide, else a texel.
    static constexpr uint32_t kHalfTexels = 0x40000000u;
    [[nodiscard]] int partShift(uint32_t cell) const ///< a cell is 2^shift parts wide
    {
        return cellShift_ + ((firstPart_[cell] & kHalfTexels) != 0 ? 1 : 0);
    }
    [[nodiscard]] uint32_t partCount(uint32_t cell) const { return 1u << (2 * partShift(cell)); }
    int cellShift_ = 0;        ///< a cell is 2^shift texels wide
    float texelMeters_ = 0.0f; ///< mean width of a texel
    int bounces_ = 0;
    uint32_t squares_ = 0;            ///< cells of the squares' fronts, and as many of their backs
    std::vector<Surface> surfaces_;   ///< by hit triangle
    std::vector<Cell> cells_;         ///< the squares' fronts, their backs, single triangles, parts
    std::vector<uint32_t> firstPart_; ///< by cell, but for parts; row by row from there
    /// What cells reflect after bounces_ - 1, bounces_ - 2, … reflections, for paths that reach one after some of
    /// their own.
    std::array<std::vector<vec3>, 3> levels_;

    std::vector<uint32_t> hitIndexOfTriangle_; ///< or ~0
    BrightCells bright_;

    // While building.
    struct Rectangle {
        ivec2 min{0};
        ivec2 max{-1};
        uint32_t texels = 0;
        uint32_t firstCell = 0;
    };
    std::vector<Rectangle> rectangles_;         ///< by chart and direction, six for each chart
    std::vector<uint32_t> rectangleOfTriangle_; ///< or ~0
    std::vector<uint32_t> cellTriangles_;       ///< that are cells themselves: front and back of each
    /// By cell.
    static constexpr uint8_t kDivided = 1;   ///< something stands on it
    static constexpr uint8_t kMetNear = 2;   ///< rays hit it from close by
    static constexpr uint8_t kWanted = 4;    ///< rays hit it: of backs and triangles, the only ones that are gathered
    static constexpr uint8_t kTexelWide = 8; ///< of parts
    std::vector<uint8_t> state_;
    std::vector<uint32_t> substitute_; ///< for cells that no sample fell into, another one
};

} // namespace halflight
