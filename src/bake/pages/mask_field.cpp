// Shadowmask channels as signed distance fields (shading/mask.h).
#include "bake/pages/mask_field.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/mask.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

constexpr float kRangeTexels = 4.0f;
constexpr int kReach = 5; ///< texels searched for edges: the range, and half a texel between an edge and its texel
/// Channels with wider penumbrae (texels) stay attenuation: bilinear filtering suffices, and a distance in range on
/// both sides loses their shape.
constexpr float kWidestPenumbra = 0.5f * kRangeTexels;

/// A shadow's edge in one texel: a point relative to the texel's centre, and the direction of the lit side.
struct ShadowEdge {
    vec2 point{0.0f};
    vec2 towardsLight{0.0f};
    bool found = false;
};

/// Distance of a texel's centre from a straight edge that leaves the share `a` of the texel lit, the light in direction
/// (gx, gy): above 0 when the centre is lit. Gustavson and Strand 2011, "Anti-aliased Euclidean Distance Transform".
float centerDistance(vec2 g, float a)
{
    g = glm::abs(g);
    if (g.x < g.y) std::swap(g.x, g.y);
    const float corner = 0.5f * g.y / g.x; // largest share for which the edge cuts off a corner
    if (a < corner) return -(0.5f * (g.x + g.y) - std::sqrt(2.0f * g.x * g.y * a));
    if (a < 1.0f - corner) return -(0.5f - a) * g.x;
    return 0.5f * (g.x + g.y) - std::sqrt(2.0f * g.x * g.y * (1.0f - a));
}

/// Mean width of a channel's penumbrae in texels, less 1, the width of a sampled hard edge: the number of partly lit
/// texels over the number of adjacent pairs on different sides of 0.5. Negative without such pairs.
float meanPenumbra(const TexelMap& map, const TexelGrid& grid, const std::vector<vec4>& mask, int channel)
{
    uint64_t partial = 0;
    uint64_t crossings = 0;
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        const float a = mask[i][channel];
        partial += a > 0.0f && a < 1.0f ? 1u : 0u;
        for (const ivec2 d : {ivec2(1, 0), ivec2(0, 1)}) {
            const uint32_t j = grid.at(map.texels[i], d.x, d.y);
            if (j != kNoTexel && (a >= 0.5f) != (mask[j][channel] >= 0.5f)) ++crossings;
        }
    }
    return crossings == 0 ? -1.0f : std::max(0.0f, float(partial) / float(crossings) - 1.0f);
}

ShadowEdge edgeIn(const TexelMap& map, const TexelGrid& grid, const std::vector<vec4>& mask, int channel, std::size_t i)
{
    const Texel& texel = map.texels[i];
    const float a = mask[i][channel];
    // Sobel's gradient with Gustavson's weights; a missing neighbour is extrapolated from the opposite one.
    const auto value = [&](int dx, int dy) {
        if (const uint32_t j = grid.at(texel, dx, dy); j != kNoTexel) return mask[j][channel];
        if (const uint32_t j = grid.at(texel, -dx, -dy); j != kNoTexel)
            return glm::clamp(2.0f * a - mask[j][channel], 0.0f, 1.0f);
        return a;
    };
    constexpr float kStraight = 1.41421356f;
    vec2 g(0.0f);
    g.x =
        value(1, -1) + kStraight * value(1, 0) + value(1, 1) - value(-1, -1) - kStraight * value(-1, 0) - value(-1, 1);
    g.y =
        value(-1, 1) + kStraight * value(0, 1) + value(1, 1) - value(-1, -1) - kStraight * value(0, -1) - value(1, -1);
    const float length = glm::length(g);
    if (length < 1.0e-3f) return {};
    g /= length;
    if (a > 0.0f && a < 1.0f) return {-centerDistance(g, a) * g, g, true};
    // Fully lit beside fully shadowed: the edge lies between both texels.
    for (const ivec2 d : {ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1)}) {
        const uint32_t j = grid.at(texel, d.x, d.y);
        if (j != kNoTexel && mask[j][channel] == 1.0f - a) return {0.5f * vec2(d), g, true};
    }
    return {};
}

} // namespace

std::array<MaskChannel, kLayerChannels> maskToDistances(const TexelMap& map, std::vector<vec4>& mask, int first)
{
    const TexelGrid grid(map);

    std::array<MaskChannel, kLayerChannels> channels{};
    std::vector<ShadowEdge> edges(map.texels.size());
    std::vector<float> distances(map.texels.size());
    for (int channel = first; channel < kLayerChannels; ++channel) {
        const float penumbra = meanPenumbra(map, grid, mask, channel);
        if (penumbra < 0.0f || penumbra > kWidestPenumbra) continue;
        channels[std::size_t(channel)] = {kRangeTexels, penumbra};
        parallelFor(edges.size(), 2048, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) edges[i] = edgeIn(map, grid, mask, channel, i);
        });
        // Distance to the nearest edge; each edge is a straight segment as long as a texel's diagonal.
        parallelFor(edges.size(), 512, [&](std::size_t begin, std::size_t end) {
            constexpr float kHalfPiece = 0.70710678f;
            for (std::size_t i = begin; i < end; ++i) {
                const Texel& texel = map.texels[i];
                float nearest = kRangeTexels;
                for (int dy = -kReach; dy <= kReach; ++dy) {
                    for (int dx = -kReach; dx <= kReach; ++dx) {
                        const uint32_t j = grid.at(texel, dx, dy);
                        if (j == kNoTexel || !edges[j].found) continue;
                        const vec2 to = vec2(dx, dy) + edges[j].point;
                        const vec2 tangent(-edges[j].towardsLight.y, edges[j].towardsLight.x);
                        const float along = glm::clamp(-glm::dot(to, tangent), -kHalfPiece, kHalfPiece);
                        nearest = std::min(nearest, glm::length(to + along * tangent));
                    }
                }
                const float a = mask[i][channel];
                const bool lit = edges[i].found && a > 0.0f && a < 1.0f
                                     ? glm::dot(edges[i].point, edges[i].towardsLight) < 0.0f
                                     : a >= 0.5f;
                distances[i] = lit ? nearest : -nearest;
            }
        });
        for (std::size_t i = 0; i < mask.size(); ++i)
            mask[i][channel] = shading::encodeMaskDistance(distances[i], kRangeTexels);
    }
    return channels;
}

} // namespace halflight
