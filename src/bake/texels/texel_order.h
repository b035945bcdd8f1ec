#pragma once
// The order in which a bake in the background computes its texels: what a camera sees comes first.

#include "halflight/bake/integrator.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

struct BakeView {
    Camera camera;
    float aspect = 1.0f; ///< width / height
};

/// A map's texels in pieces, of which each is taken once.
class TexelOrder {
public:
    /// Pieces of single charts. What a texel's samples depend on is on its chart, so that whole charts repeat no work.
    static TexelOrder ofCharts(const BakeGeometry& geometry, const TexelMap& map);
    /// Piece i: texels i * length … (i + 1) * length - 1, those of a part of the tile cache.
    static TexelOrder ofRuns(const BakeGeometry& geometry, const TexelMap& map, std::size_t length);

    /// Numbers of the pieces that are wanted most, of `texels` texels together, or a piece more; none at the end.
    /// Without a view the first ones.
    std::vector<std::size_t> next(const std::optional<BakeView>& view, std::size_t texels);
    /// Ascending.
    [[nodiscard]] std::span<const uint32_t> texelsOf(std::size_t piece) const
    {
        return std::span(texels_).subspan(pieces_[piece].first, pieces_[piece].count);
    }

private:
    struct Piece {
        std::size_t first = 0; ///< index into texels_
        std::size_t count = 0;
        vec3 center{0.0f};         ///< world space, metres
        float radiusMeters = 0.0f; ///< of a sphere about most of it
        vec3 normal{0.0f};         ///< mean, at most 1 long
    };
    struct Rank {
        int sight = 0; ///< 0: in view and facing the camera, 1: in view, 2: neither
        float meters = 0.0f;
        bool operator<(const Rank& other) const
        {
            return sight != other.sight ? sight < other.sight : meters < other.meters;
        }
    };
    void addPiece(const BakeGeometry& geometry, const TexelMap& map, std::size_t first, std::size_t count);
    static Rank rankOf(const Piece& piece, const BakeView& view);

    std::vector<uint32_t> texels_;
    std::vector<Piece> pieces_;
    std::vector<std::size_t> left_; ///< pieces not taken yet, ascending
};

} // namespace halflight
