#include "transport/sample/light_tree.h"

#include "halflight/base/mathematics.h"

#include <algorithm>

namespace halflight {
namespace {

constexpr int kBins = 12; ///< along each axis, as in the paper

/// Directions within an angle of an axis.
struct Cone {
    vec3 axis{0.0f, 0.0f, 1.0f};
    float cosine = 1.0f; ///< -1 = all directions
};

Cone uniteCones(const Cone& a, const Cone& b)
{
    if (a.cosine <= -1.0f || b.cosine <= -1.0f) return {a.axis, -1.0f};
    const float angleA = math::acos(a.cosine);
    const float angleB = math::acos(b.cosine);
    const float between = math::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0f, 1.0f));
    if (std::min(between + angleB, kPi) <= angleA) return a;
    if (std::min(between + angleA, kPi) <= angleB) return b;
    const float angle = 0.5f * (angleA + between + angleB);
    if (angle >= kPi) return {a.axis, -1.0f};
    // Rotate a's axis towards b's.
    const vec3 side = b.axis - a.axis * glm::dot(a.axis, b.axis);
    const float length = glm::length(side);
    if (length < 1.0e-6f) return {a.axis, -1.0f};
    const float turn = angle - angleA;
    return {glm::normalize(a.axis * math::cos(turn) + side * (math::sin(turn) / length)), math::cos(angle)};
}

/// Orientation measure of Conty Estevez and Kulla 2018: the solid angle that lights illuminate which emit into the
/// hemisphere around each normal.
float orientationMeasure(float cosSpread)
{
    const float spread = math::acos(std::clamp(cosSpread, -1.0f, 1.0f));
    const float widest = std::min(spread + 0.5f * kPi, kPi);
    const float sine = math::sin(spread);
    return 2.0f * kPi * (1.0f - cosSpread) +
           0.5f * kPi * (2.0f * widest * sine - math::cos(spread - 2.0f * widest) - 2.0f * spread * sine + cosSpread);
}

float surfaceArea(const Bounds& b)
{
    const vec3 s = b.size();
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

/// Lights whose centres are in one slab.
struct Bin {
    Bounds bounds;
    Cone cone;
    float power = 0.0f;
    int count = 0;
    void add(const LightItem& light)
    {
        cone = count == 0 ? Cone{light.axis, light.cosSpread} : uniteCones(cone, {light.axis, light.cosSpread});
        bounds.extend(light.bounds);
        power += light.power;
        ++count;
    }
    void add(const Bin& other)
    {
        if (other.count == 0) return;
        cone = count == 0 ? other.cone : uniteCones(cone, other.cone);
        bounds.extend(other.bounds);
        power += other.power;
        count += other.count;
    }
    [[nodiscard]] float cost() const
    {
        return count == 0 ? 0.0f : power * orientationMeasure(cone.cosine) * surfaceArea(bounds);
    }
};

} // namespace

struct LightTree::BuildItem {
    LightItem light;
    uint32_t index = 0;
    vec3 center{0.0f};
};

LightTree::LightTree(std::span<const LightItem> items)
{
    if (items.empty()) return;
    std::vector<BuildItem> build(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) build[i] = {items[i], uint32_t(i), items[i].bounds.center()};
    nodes_.reserve(2 * items.size());
    leafOfItem_.resize(items.size());
    this->build(build, ~0u);
}

LightTree::Node LightTree::nodeOf(std::span<const BuildItem> items)
{
    Bounds bounds;
    Cone cone{items[0].light.axis, items[0].light.cosSpread};
    Node node{};
    bool unlimited = false;
    bool twoSided = false;
    for (const BuildItem& item : items) {
        bounds.extend(item.light.bounds);
        cone = uniteCones(cone, {item.light.axis, item.light.cosSpread});
        node.power += item.light.power;
        node.range = std::max(node.range, item.light.range);
        unlimited = unlimited || item.light.range <= 0.0f;
        twoSided = twoSided || item.light.twoSided;
    }
    if (unlimited) node.range = 0.0f;
    node.center = bounds.center();
    node.radius = 0.5f * glm::length(bounds.size());
    node.axis = cone.axis;
    node.cosSpread = cone.cosine;
    node.sinSpread = shading::sineOfCosine(cone.cosine);
    node.twoSided = twoSided ? 1 : 0;
    return node;
}

/// Reorders the items and returns the number of those in the first child: surface area orientation heuristic over bins
/// of the centres; halves where no plane separates them.
std::size_t LightTree::split(std::span<BuildItem> items)
{
    Bounds centers;
    for (const BuildItem& item : items) centers.extend(item.center);
    const vec3 extent = centers.size();
    const auto binOf = [&](const BuildItem& item, int axis) {
        return std::clamp(int(float(kBins) * (item.center[axis] - centers.min[axis]) / extent[axis]), 0, kBins - 1);
    };
    float bestCost = kInfinity;
    int bestAxis = -1;
    int bestBin = 0;
    const float longest = std::max({extent.x, extent.y, extent.z});
    for (int axis = 0; axis < 3; ++axis) {
        if (!(extent[axis] > 0.0f)) continue;
        std::array<Bin, kBins> bins;
        for (const BuildItem& item : items) bins[std::size_t(binOf(item, axis))].add(item.light);
        std::array<float, kBins> below{};
        Bin left;
        for (int b = 0; b + 1 < kBins; ++b) {
            left.add(bins[std::size_t(b)]);
            below[std::size_t(b)] = left.count == 0 ? kInfinity : left.cost();
        }
        Bin right;
        for (int b = kBins - 1; b > 0; --b) {
            right.add(bins[std::size_t(b)]);
            if (right.count == 0) continue;
            // Thin nodes are penalized, as in the paper.
            const float cost = longest / extent[axis] * (below[std::size_t(b - 1)] + right.cost());
            if (cost < bestCost) {
                bestCost = cost;
                bestAxis = axis;
                bestBin = b;
            }
        }
    }
    auto middle = items.begin() + std::ptrdiff_t(items.size() / 2);
    if (bestAxis >= 0) {
        const auto split = std::stable_partition(
            items.begin(), items.end(), [&](const BuildItem& item) { return binOf(item, bestAxis) < bestBin; });
        if (split != items.begin() && split != items.end()) middle = split;
    }
    return std::size_t(middle - items.begin());
}

uint32_t LightTree::build(std::span<BuildItem> items, uint32_t parent)
{
    const auto number = uint32_t(nodes_.size());
    Node node = nodeOf(items);
    node.parent = parent;
    if (items.size() == 1) {
        node.leaf = 1;
        node.second = items[0].index;
        leafOfItem_[items[0].index] = number;
    }
    nodes_.push_back(node);
    if (node.leaf != 0) return number;
    const std::size_t leftCount = split(items);
    build(items.first(leftCount), number);
    const uint32_t second = build(items.subspan(leftCount), number);
    nodes_[number].second = second;
    return number;
}

} // namespace halflight
