#include "bake/texels/texel_order.h"

#include "bake/texels/texel_places.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

/// Larger charts come in several pieces; sample plans read two texels beyond their rims, a tenth of so many.
constexpr std::size_t kMostTexels = 8192;
/// Texels that tell where a piece is.
constexpr std::size_t kPlaces = 32;

} // namespace

void TexelOrder::addPiece(const BakeGeometry& geometry, const TexelMap& map, std::size_t first, std::size_t count)
{
    Piece piece{first, count, {}, {}, {}};
    const std::size_t step = (count + kPlaces - 1) / kPlaces;
    std::vector<vec3> positions;
    for (std::size_t i = 0; i < count; i += step) {
        const TexelPlace place = placeOf(geometry, map, map.texels[texels_[first + i]]);
        positions.push_back(place.position);
        piece.center += place.position;
        piece.normal += place.normal;
    }
    const float share = 1.0f / float(positions.size());
    piece.center *= share;
    piece.normal *= share;
    for (const vec3 position : positions)
        piece.radiusMeters = std::max(piece.radiusMeters, glm::distance(position, piece.center));
    left_.push_back(pieces_.size());
    pieces_.push_back(piece);
}

TexelOrder TexelOrder::ofCharts(const BakeGeometry& geometry, const TexelMap& map)
{
    TexelOrder order;
    std::vector<std::size_t> begins(map.chartCount + 1, 0);
    for (const Texel& texel : map.texels) ++begins[texel.chart + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    order.texels_.resize(map.texels.size());
    std::vector<std::size_t> at(begins.begin(), begins.end() - 1);
    for (std::size_t i = 0; i < map.texels.size(); ++i) order.texels_[at[map.texels[i].chart]++] = uint32_t(i);
    for (uint32_t chart = 0; chart < map.chartCount; ++chart) {
        const std::size_t count = begins[chart + 1] - begins[chart];
        const std::size_t pieces = (count + kMostTexels - 1) / kMostTexels;
        for (std::size_t p = 0; p < pieces; ++p) {
            const std::size_t first = count * p / pieces;
            order.addPiece(geometry, map, begins[chart] + first, count * (p + 1) / pieces - first);
        }
    }
    return order;
}

TexelOrder TexelOrder::ofRuns(const BakeGeometry& geometry, const TexelMap& map, std::size_t length)
{
    TexelOrder order;
    order.texels_.resize(map.texels.size());
    std::iota(order.texels_.begin(), order.texels_.end(), 0u);
    for (std::size_t first = 0; first < map.texels.size(); first += length)
        order.addPiece(geometry, map, first, std::min(length, map.texels.size() - first));
    return order;
}

TexelOrder::Rank TexelOrder::rankOf(const Piece& piece, const BakeView& view)
{
    const Camera& camera = view.camera;
    const mat3 axes(camera.worldFromCamera);
    const vec3 toPiece = piece.center - vec3(camera.worldFromCamera[3]);
    const float radius = piece.radiusMeters;
    const float ahead = -glm::dot(toPiece, axes[2]);
    const float tangent = camera.orthographic ? 0.0f : math::tan(0.5f * camera.verticalFovRadians);
    const float half = camera.orthographic ? 0.5f * camera.orthographicHeightMeters : 0.0f;
    // The distance from the centre to a plane of the pyramid is at most the radius.
    const auto within = [&](float offset, float width) {
        const float t = tangent * width;
        return std::abs(offset) - half * width - ahead * t <= radius * std::sqrt(1.0f + t * t);
    };
    Rank rank{2, std::max(glm::length(toPiece) - radius, 0.0f)};
    if (ahead < -radius || !within(glm::dot(toPiece, axes[0]), view.aspect) ||
        !within(glm::dot(toPiece, axes[1]), 1.0f))
        return rank;
    const vec3 towards = camera.orthographic ? -axes[2] : toPiece;
    rank.sight = glm::dot(piece.normal, towards) > 0.0f ? 1 : 0;
    return rank;
}

std::vector<std::size_t> TexelOrder::next(const std::optional<BakeView>& view, std::size_t texels)
{
    if (view) {
        std::vector<Rank> ranks(pieces_.size());
        for (const std::size_t i : left_) ranks[i] = rankOf(pieces_[i], *view);
        std::stable_sort(left_.begin(), left_.end(), [&](std::size_t a, std::size_t b) { return ranks[a] < ranks[b]; });
    }
    std::vector<std::size_t> taken;
    for (std::size_t sum = 0; sum < texels && taken.size() < left_.size();) {
        taken.push_back(left_[taken.size()]);
        sum += pieces_[taken.back()].count;
    }
    left_.erase(left_.begin(), left_.begin() + std::ptrdiff_t(taken.size()));
    return taken;
}

} // namespace halflight
