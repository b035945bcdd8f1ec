#pragma once
// Importance sampling of many lights in logarithmic time.

#include "transport/random/stratified_pattern.h"
#include "transport/sample/light_walk.h"
#include "transport/trace/lanes.h"

#include "halflight/base/math.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// A light reduced to bounds of its position, its directions and its flux.
struct LightItem {
    Bounds bounds;
    vec3 axis{0.0f};        ///< mean direction of its normals; unused if cosSpread is -1
    float cosSpread = 1.0f; ///< cosine of the half angle of the cone of normals; -1 = all directions
    bool twoSided = false;
    float power = 0.0f; ///< flux, in any unit common to all items
    float range = 0.0f; ///< metres; no light beyond; 0 = unlimited
};

namespace shading {
/// For light_walk.h.
inline const LightNode& lightNodeAt(const std::vector<LightNode>& nodes, uint node)
{
    return nodes[node];
}
} // namespace shading

/// Bounding volume hierarchy over lights (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with
/// Adaptive Tree Splitting"). sample() descends from the root, at each node in proportion to the unshadowed
/// contribution that its children may have. It has probability 0 for lights whose range ends before the receiver.
class LightTree {
public:
    static constexpr uint32_t kRoot = 0;

    LightTree() = default;
    explicit LightTree(std::span<const LightItem> items);
    [[nodiscard]] bool empty() const { return nodes_.empty(); }
    /// The first one is the root.
    [[nodiscard]] std::span<const shading::LightNode> nodes() const { return nodes_; }
    [[nodiscard]] std::span<const uint32_t> leafOfItem() const { return leafOfItem_; }

    struct Choice {
        uint32_t item = ~0u;
        float probability = 0.0f; ///< given the node of the cut; 0 = no light in range
        float u = 0.0f;           ///< the random number, rescaled to [0, 1)
    };
    /// `normal` zero = the point receives from all directions.
    [[nodiscard]] Choice sample(vec3 position, vec3 normal, float u, uint32_t node = kRoot) const;
    /// Probability with which sample() chooses `item` from the root.
    [[nodiscard]] float probability(uint32_t item, vec3 position, vec3 normal) const;

    /// Estimate of the unshadowed illuminance from all lights, in units of power per area.
    [[nodiscard]] float total(vec3 position, vec3 normal) const;

    /// Cuts through the tree of eight points, by lane: every item is below exactly one node of a cut. A texel's samples
    /// choose among the nodes of one cut (the paper's tree splitting, once per texel).
    struct Cut {
        static constexpr std::size_t kMaxNodes = shading::kMostCutNodes;
        template<typename T> using Lanes = std::array<T, kLanes>;
        std::size_t count = 0;
        Lanes<float> total{}; ///< as total()
        std::array<Lanes<uint32_t>, kMaxNodes> node;
        std::array<Lanes<uint32_t>, kMaxNodes> item; ///< of a node that is one light without a range, else ~0
        std::array<Lanes<float>, kMaxNodes> probability;
        std::array<Lanes<float>, kMaxNodes> below; ///< cumulative probability of the nodes before
    };
    using Points = Vec3Lanes;
    /// Of each cut: Cut::count.
    [[nodiscard]] std::size_t cutNodes() const { return std::min(Cut::kMaxNodes, leafOfItem_.size()); }
    [[nodiscard]] Cut cut(const Points& positions, const Points& normals) const;
    /// Chooses a light for the lanes in `wanted`; the other lanes have none.
    void sample(const Cut& cut, const Points& positions, const Points& normals, const Cut::Lanes<bool>& wanted,
                const Cut::Lanes<float>& u, Cut::Lanes<Choice>& choices) const;
    [[nodiscard]] float probability(const Cut& cut, std::size_t lane, uint32_t item, vec3 position, vec3 normal) const;

private:
    using Node = shading::LightNode;
    struct BuildItem;
    static Node nodeOf(std::span<const BuildItem> items);
    static std::size_t split(std::span<BuildItem> items);
    uint32_t build(std::span<BuildItem> items, uint32_t parent);
    using Weights = Cut::Lanes<float>;
    [[nodiscard]] Weights importance(const Cut::Lanes<uint32_t>& nodes, const Points& positions,
                                     const Points& normals) const;
    /// Probability of an item given the root, or given the node of the cut above it, whose index is written.
    float climb(uint32_t item, const Cut* cut, std::size_t lane, vec3 position, vec3 normal,
                std::size_t& cutIndex) const;

    std::vector<Node> nodes_;
    std::vector<uint32_t> leafOfItem_;
};

} // namespace halflight
