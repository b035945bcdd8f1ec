#pragma once
// Choosing one of many lights in time that grows with the logarithm of their number.

#include "bake_cpu/trace/lanes.h"

#include "halflight/base/math.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// What the tree knows of a light: where it is, how strong, and where it shines.
struct LightItem {
    Bounds bounds;
    vec3 axis{0.0f};        ///< mean direction of its normals; unused when spread is all around
    float cosSpread = 1.0f; ///< cosine of the half angle around the axis that holds all normals; -1 = all around
    bool twoSided = false;
    float power = 0.0f; ///< flux, in any unit that all items share
    float range = 0.0f; ///< metres beyond which it gives nothing; 0 = unlimited
};

/// Bounding volume hierarchy over lights: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with
/// Adaptive Tree Splitting". A light is chosen by walking down, at each node in proportion to what either side could
/// contribute at the receiving point, without shadows. No light in range has probability 0.
class LightTree {
public:
    static constexpr uint32_t kRoot = 0;

    LightTree() = default;
    explicit LightTree(std::span<const LightItem> items);
    [[nodiscard]] bool empty() const { return nodes_.empty(); }

    struct Choice {
        uint32_t item = ~0u;
        float probability = 0.0f; ///< given the node that the walk began at; 0: nothing in range
        float u = 0.0f;           ///< what is left of the random number, again uniform in [0, 1)
    };
    /// `normal` zero: the point is in space and receives from all sides.
    [[nodiscard]] Choice sample(vec3 position, vec3 normal, float u, uint32_t node = kRoot) const;
    /// Probability with which sample() chooses `item` from the root.
    [[nodiscard]] float probability(uint32_t item, vec3 position, vec3 normal) const;

    /// About what all lights together give a point unshadowed, in the unit of power over area.
    [[nodiscard]] float total(vec3 position, vec3 normal) const;

    /// For each of some points a level through the tree that suits all places near it (the paper's tree splitting, here
    /// once for all the samples of a texel): every item is below exactly one of its nodes. Side by side only because
    /// that is faster.
    struct Cut {
        static constexpr std::size_t kLanes = 8;
        static constexpr std::size_t kMaxNodes = 32;
        template<typename T> using Lanes = std::array<T, kLanes>;
        std::size_t count = 0;
        Lanes<float> total{}; ///< about what all lights give without shadows, as total()
        std::array<Lanes<uint32_t>, kMaxNodes> node;
        std::array<Lanes<uint32_t>, kMaxNodes>
            item; ///< where the node is a single light that reaches everywhere, or ~0
        std::array<Lanes<float>, kMaxNodes> probability;
        std::array<Lanes<float>, kMaxNodes> below; ///< probability of the nodes before
    };
    using Points = Vec3Lanes<Cut::kLanes>;
    [[nodiscard]] Cut cut(const Points& positions, const Points& normals) const;
    /// Chooses a light for those lanes that are wanted; none for the others.
    void sample(const Cut& cut, const Points& positions, const Points& normals, const Cut::Lanes<bool>& wanted,
                const Cut::Lanes<float>& u, Cut::Lanes<Choice>& choices) const;
    [[nodiscard]] float probability(const Cut& cut, std::size_t lane, uint32_t item, vec3 position, vec3 normal) const;

private:
    struct Node {
        vec3 center{0.0f};
        float radius = 0.0f; ///< of the sphere around the bounds
        vec3 axis{0.0f};
        float cosSpread = 1.0f;
        float sinSpread = 0.0f;
        float power = 0.0f;
        float range = 0.0f;  ///< the largest below; 0 = unlimited
        uint32_t second = 0; ///< second child (the first one follows its parent); of a leaf: the item
        uint32_t parent = ~0u;
        uint32_t quad = 0; ///< but for leaves
        bool leaf = false;
        bool twoSided = false;
    };
    /// What importance() reads of nodes, side by side.
    template<std::size_t N> struct NodeLanes {
        Vec3Lanes<N> center;
        Vec3Lanes<N> axis;
        std::array<float, N> radius;
        std::array<float, N> cosSpread;
        std::array<float, N> sinSpread;
        std::array<float, N> power;
        std::array<float, N> range;
        std::array<int32_t, N> twoSided;

        void set(std::size_t lane, const Node& node)
        {
            center.set(lane, node.center);
            axis.set(lane, node.axis);
            radius[lane] = node.radius;
            cosSpread[lane] = node.cosSpread;
            sinSpread[lane] = node.sinSpread;
            power[lane] = node.power;
            range[lane] = node.range;
            twoSided[lane] = node.twoSided ? 1 : 0;
        }
        [[nodiscard]] Node operator[](std::size_t lane) const
        {
            Node node;
            node.center = center[lane];
            node.axis = axis[lane];
            node.radius = radius[lane];
            node.cosSpread = cosSpread[lane];
            node.sinSpread = sinSpread[lane];
            node.power = power[lane];
            node.range = range[lane];
            node.twoSided = twoSided[lane] != 0;
            return node;
        }
    };
    /// A node's grandchildren, and those of its children that are leaves. Walks take two levels at once.
    struct Quad {
        static constexpr std::size_t kLanes = 4;
        template<typename T> using Lanes = std::array<T, kLanes>;
        NodeLanes<kLanes> nodes;
        Lanes<uint32_t> number; ///< ~0 where there is none, of no power
    };
    struct BuildItem;
    uint32_t build(std::span<BuildItem> items, uint32_t parent);
    [[nodiscard]] static inline float importance(const Node& node, vec3 position, vec3 normal);
    using Weights = Cut::Lanes<float>;
    [[nodiscard]] Weights importance(const Cut::Lanes<uint32_t>& nodes, const Points& positions,
                                     const Points& normals) const;
    void makeQuads();
    /// Probabilities of what a quad holds; all zero when nothing is in range.
    [[nodiscard]] Quad::Lanes<float> probabilities(const Quad& quad, vec3 position, vec3 normal) const;
    /// Walks up from an item's leaf; stops at the root or at a node of the cut and tells which.
    float climb(uint32_t item, const Cut* cut, std::size_t lane, vec3 position, vec3 normal,
                std::size_t& cutIndex) const;

    std::vector<Node> nodes_;
    std::vector<Quad> quads_;
    std::vector<uint32_t> leafOfItem_;
};

} // namespace halflight
