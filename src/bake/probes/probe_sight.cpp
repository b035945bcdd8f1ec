// How far probes see. Maps go to those probes alone that would otherwise light points behind a surface.
#include "bake/geometry/surfaces_along.h"
#include "bake/probes/probes.h"

#include "halflight/base/parallel.h"
#include "halflight/scene/probe_cells.h"
#include "halflight/shading/sight.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

/// Cells of a map along each side: four to an edge of the octahedron, 22 degrees each.
constexpr int kCells = 8;
constexpr int kCorners = kCells + 1;
/// Rays through each cell, along each side of a grid over it, beside one through each corner.
constexpr int kRaysPerSide = 4;
constexpr int kSide = kCells * kRaysPerSide;
constexpr std::size_t kCornerRays = std::size_t(kCorners) * kCorners;
constexpr std::size_t kRays = kCornerRays + std::size_t(kSide) * kSide; ///< of a probe
/// Largest nearness times range: what 16 bits of its inverse tell apart within a tenth.
constexpr float kNearest = 5000.0f;
/// Probes or tetrahedra whose rays are traced at once: a few megabytes of segments.
constexpr std::size_t kProbesAtOnce = 256;

/// Test points of a tetrahedron: barycentric coordinates a quarter apart, off its faces by a sixteenth.
std::vector<vec4> testPoints()
{
    std::vector<vec4> points;
    for (int a = 0; a <= 3; ++a)
        for (int b = 0; a + b <= 3; ++b)
            for (int c = 0; a + b + c <= 3; ++c) points.push_back((vec4(a, b, c, 3 - a - b - c) + 0.25f) / 4.0f);
    return points;
}

class SightFinder {
public:
    SightFinder(const ProbeSet& set, const Integrator& integrator) : set_(set), integrator_(integrator)
    {
        const ProbeCells cells = probeCells(set);
        for (const Tetrahedron& cell : cells.cells) {
            auto& corners = cells_.emplace_back();
            for (std::size_t i = 0; i < 4; ++i) corners[i] = cells.probeOf[cell.vertex[i]];
        }
        blind_.assign(set.probes.size(), 0);
    }

    Result<ProbeSight> find(const Progress& progress)
    {
        const std::vector<vec4> points = testPoints();
        for (std::size_t begin = 0; begin < cells_.size(); begin += kProbesAtOnce) {
            if (progress.cancelled()) return cancelledError();
            const std::size_t end = std::min(begin + kProbesAtOnce, cells_.size());
            if (Status s = markBlindProbes(begin, end, points); !s) return s.error();
        }
        ProbeSight sight;
        if (std::find(blind_.begin(), blind_.end(), 1) == blind_.end()) return sight;
        sight.size = kCorners;
        sight.rangeMeters = ranges();
        std::vector<uint32_t> mapped;
        for (uint32_t i = 0; i < blind_.size(); ++i)
            if (sight.rangeMeters[i] > 0.0f) mapped.push_back(i);
        for (std::size_t begin = 0; begin < mapped.size(); begin += kProbesAtOnce) {
            if (progress.cancelled()) return cancelledError();
            const std::size_t count = std::min(kProbesAtOnce, mapped.size() - begin);
            if (Status s = addMaps(std::span(mapped).subspan(begin, count), sight); !s) return s.error();
        }
        return sight;
    }

private:
    [[nodiscard]] vec3 positionOf(uint32_t probe) const { return set_.probes[probe].position; }

    /// A probe is blind if it does not see some point of a tetrahedron that another of its corners does see.
    Status markBlindProbes(std::size_t begin, std::size_t end, std::span<const vec4> points)
    {
        std::vector<Segment> segments;
        for (std::size_t i = begin; i < end; ++i) {
            const auto& corners = cells_[i];
            for (const vec4& w : points) {
                vec3 point(0.0f);
                for (int k = 0; k < 4; ++k) point += w[k] * positionOf(corners[std::size_t(k)]);
                for (const uint32_t corner : corners) segments.push_back({positionOf(corner), point});
            }
        }
        const Result<SurfacesAlong> surfaces = surfacesAlong(integrator_, segments);
        if (!surfaces) return surfaces.error();
        std::size_t at = 0;
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t point = 0; point < points.size(); ++point, at += 4) {
                const auto* blocked = &(*surfaces)[at];
                if (blocked[0] && blocked[1] && blocked[2] && blocked[3]) continue;
                for (std::size_t k = 0; k < 4; ++k)
                    if (blocked[k]) blind_[cells_[i][k]] = 1;
            }
        }
        return {};
    }

    /// Of blind probes the longest edge of their tetrahedra, which no point that they light is farther away than.
    [[nodiscard]] std::vector<float> ranges() const
    {
        std::vector<float> ranges(blind_.size(), 0.0f);
        for (const auto& corners : cells_) {
            for (const uint32_t a : corners) {
                if (blind_[a] == 0) continue;
                for (const uint32_t b : corners) {
                    const vec3 edge = glm::abs(positionOf(b) - positionOf(a));
                    ranges[a] = std::max(ranges[a], edge.x + edge.y + edge.z);
                }
            }
        }
        return ranges;
    }

    Status addMaps(std::span<const uint32_t> probes, ProbeSight& sight) const
    {
        const std::vector<vec2> places = placesOfRays();
        std::vector<Segment> segments;
        for (const uint32_t probe : probes) {
            const vec3 from = positionOf(probe);
            for (const vec2 place : places) {
                const vec2 square = place * (2.0f / float(kCells)) - 1.0f;
                const vec3 direction = shading::octahedralDirection(square.x, square.y);
                segments.push_back({from, from + sight.rangeMeters[probe] * direction});
            }
        }
        const Result<SurfacesAlong> surfaces = surfacesAlong(integrator_, segments);
        if (!surfaces) return surfaces.error();
        std::vector<float> nearness(segments.size(), 1.0f);
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const std::optional<vec2>& surface = (*surfaces)[i];
            if (!surface) continue;
            const float length = glm::distance(segments[i].from, segments[i].to);
            nearness[i] = std::clamp(length / std::max(surface->x, 1.0e-6f), 1.0f, kNearest);
        }
        for (std::size_t i = 0; i < probes.size(); ++i) addMap(std::span(nearness).subspan(i * kRays, kRays), sight);
        return {};
    }

    /// In cells of the map: its corners in rows, then places in cells.
    static std::vector<vec2> placesOfRays()
    {
        std::vector<vec2> places;
        for (int i = 0; i < kCorners * kCorners; ++i) places.emplace_back(i % kCorners, i / kCorners);
        for (int i = 0; i < kSide * kSide; ++i)
            places.push_back((vec2(i % kSide, i / kSide) + 0.5f) / float(kRaysPerSide));
        return places;
    }

    /// From the nearness along the rays of a probe.
    static void addMap(std::span<const float> rays, ProbeSight& sight)
    {
        const std::vector<vec2> places = placesOfRays();
        std::array<double, kCornerRays> squares{}; // of differences from the interpolated nearness
        std::array<double, kCornerRays> weights{};
        for (std::size_t i = kCornerRays; i < kRays; ++i) {
            const ivec2 cell(places[i]);
            const vec2 part = places[i] - vec2(cell);
            const bool mirrored = (cell.x < kCells / 2) != (cell.y < kCells / 2);
            std::array<float, 4> shares{};
            std::array<std::size_t, 4> corners{};
            double difference = rays[i];
            for (int k = 0; k < 4; ++k) {
                corners[std::size_t(k)] = std::size_t((cell.y + k / 2) * kCorners + cell.x + k % 2);
                shares[std::size_t(k)] = shading::octahedralShare(k % 2, k / 2, part.x, part.y, mirrored);
                difference -= double(shares[std::size_t(k)] * rays[corners[std::size_t(k)]]);
            }
            for (std::size_t k = 0; k < 4; ++k) {
                squares[corners[k]] += double(shares[k]) * difference * difference;
                weights[corners[k]] += double(shares[k]);
            }
        }
        const auto fraction = [](double x) { return uint16_t(std::lround(65535.0 * std::clamp(x, 0.0, 1.0))); };
        for (std::size_t i = 0; i < kCornerRays; ++i) {
            const double nearness = rays[i];
            sight.corners.push_back(
                {fraction(1.0 / nearness), fraction(std::sqrt(squares[i] / weights[i]) / nearness)});
        }
    }

    const ProbeSet& set_;
    const Integrator& integrator_;
    std::vector<std::array<uint32_t, 4>> cells_; ///< corners of the tetrahedra, as probes
    std::vector<uint8_t> blind_;                 ///< by probe
};

} // namespace

Result<ProbeSight> findProbeSight(const ProbeSet& set, const Integrator& integrator, const Progress& progress)
{
    if (set.probes.empty()) return ProbeSight{};
    return SightFinder(set, integrator).find(progress);
}

} // namespace halflight
