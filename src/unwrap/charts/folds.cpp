#include "unwrap/charts/folds.h"

#include "unwrap/surface/overlap.h"

#include <cmath>

namespace halflight::charts {
namespace {

/// The share of a triangle's area that its place in the flattening has; negative where it is turned over.
double shareOf(const Piece& piece, const std::vector<dvec2>& uv, std::size_t t)
{
    return 0.5 * doubleAreaOf(piece, uv, t) / piece.surface.areas[piece.triangles[t]];
}

/// Moves the loose vertices of a patch of triangles to the middle of their neighbours. `sums`: of neighbours, by
/// vertex; what it holds does not matter.
void sink(const Piece& piece, const std::vector<uint32_t>& patch, const std::vector<char>& loose,
          std::vector<dvec3>& sums, std::vector<dvec2>& uv)
{
    for (const uint32_t t : patch) {
        for (std::size_t k = 0; k < 3; ++k) sums[piece.corners[3 * t + k]] = dvec3(0.0);
    }
    for (const uint32_t t : patch) {
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec2 both = uv[piece.corners[3 * t + (k + 1) % 3]] + uv[piece.corners[3 * t + (k + 2) % 3]];
            sums[piece.corners[3 * t + k]] += dvec3(both, 2.0);
        }
    }
    for (const uint32_t t : patch) {
        for (std::size_t k = 0; k < 3; ++k) {
            const uint32_t vertex = piece.corners[3 * t + k];
            if (loose[vertex] && !piece.onBorder[vertex]) uv[vertex] = dvec2(sums[vertex]) / sums[vertex].z;
        }
    }
}

} // namespace

uint32_t findFold(const Piece& piece, const std::vector<dvec2>& uv)
{
    uint32_t worst = kNone;
    double worstShare = 0.02;
    for (std::size_t t = 0; t < piece.triangles.size(); ++t) {
        const double share = shareOf(piece, uv, t);
        if (share < worstShare || !std::isfinite(share)) {
            worstShare = std::isfinite(share) ? share : -1e300;
            worst = uint32_t(t);
        }
    }
    if (worst != kNone) return worst;
    // Around an inner vertex the triangles must turn once, not twice: as many corners as turns span the +x direction.
    std::vector<uint8_t> turns(piece.positions.size(), 0);
    for (std::size_t c = 0; c < piece.corners.size(); ++c) {
        const uint32_t vertex = piece.corners[c];
        if (piece.onBorder[vertex]) continue;
        const std::size_t t = c / 3;
        const dvec2 a = uv[piece.corners[3 * t + (c + 1) % 3]] - uv[vertex];
        const dvec2 b = uv[piece.corners[3 * t + (c + 2) % 3]] - uv[vertex];
        if (a.y < 0.0 && b.y >= 0.0 && ++turns[vertex] > 1) return uint32_t(t);
    }
    return kNone;
}

void unfold(const Piece& piece, std::vector<dvec2>& uv)
{
    constexpr int kMostSteps = 30;
    constexpr int kRounds = 6; // a step
    constexpr double kFoldedShare = 0.05;
    const std::size_t count = piece.triangles.size();
    std::vector<char> loose(uv.size(), 0);
    std::vector<uint32_t> patch; // triangles at loose vertices
    std::vector<dvec3> sums(uv.size());
    for (int step = 0; step < kMostSteps; ++step) {
        bool folded = false;
        for (std::size_t t = 0; t < count; ++t) {
            const double share = shareOf(piece, uv, t);
            if (share > kFoldedShare) continue;
            if (!std::isfinite(share)) return;
            folded = true;
            for (std::size_t k = 0; k < 3; ++k) loose[piece.corners[3 * t + k]] = 1;
        }
        if (!folded) return;
        patch.clear();
        for (uint32_t t = 0; t < count; ++t) {
            const uint32_t* corner = piece.corners.data() + 3 * t;
            if (loose[corner[0]] || loose[corner[1]] || loose[corner[2]]) patch.push_back(t);
        }
        if (20 * patch.size() > count + 1000) return; // this is no small fault
        for (int round = 0; round < kRounds; ++round) sink(piece, patch, loose, sums, uv);
    }
}

std::optional<std::pair<uint32_t, uint32_t>> findSelfOverlap(const Piece& piece, const std::vector<dvec2>& uv)
{
    std::vector<FlatTriangle> flat;
    std::vector<uint32_t> index;
    dvec2 least(1e300), most(-1e300);
    for (uint32_t t = 0; t < piece.triangles.size(); ++t) {
        bool border = false;
        FlatTriangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const uint32_t vertex = piece.corners[3 * t + k];
            border |= piece.onBorder[vertex] != 0;
            triangle.corners[k] = uv[vertex];
            least = glm::min(least, uv[vertex]);
            most = glm::max(most, uv[vertex]);
        }
        if (!border) continue;
        flat.push_back(triangle);
        index.push_back(t);
    }
    const auto found = findOverlap(flat, 1e-6 * glm::length(most - least));
    if (!found) return std::nullopt;
    return std::pair{index[found->first], index[found->second]};
}

} // namespace halflight::charts
