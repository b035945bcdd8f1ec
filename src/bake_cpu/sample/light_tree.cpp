#include "bake_cpu/sample/light_tree.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

/// Directions within an angle of an axis.
struct Cone {
    vec3 axis{0.0f, 0.0f, 1.0f};
    float cosine = 1.0f; ///< -1 = all directions
};

Cone uniteCones(const Cone& a, const Cone& b)
{
    if (a.cosine <= -1.0f || b.cosine <= -1.0f) return {a.axis, -1.0f};
    const float angleA = std::acos(a.cosine);
    const float angleB = std::acos(b.cosine);
    const float between = std::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0f, 1.0f));
    if (std::min(between + angleB, kPi) <= angleA) return a;
    if (std::min(between + angleA, kPi) <= angleB) return b;
    const float angle = 0.5f * (angleA + between + angleB);
    if (angle >= kPi) return {a.axis, -1.0f};
    // Turn a's axis towards b's.
    const vec3 side = b.axis - a.axis * glm::dot(a.axis, b.axis);
    const float length = glm::length(side);
    if (length < 1.0e-6f) return {a.axis, -1.0f};
    const float turn = angle - angleA;
    return {glm::normalize(a.axis * std::cos(turn) + side * (std::sin(turn) / length)), std::cos(angle)};
}

/// The paper's measure of a node's orientation: the solid angle into which its lights shine, for lights that shine into
/// the hemisphere of each normal.
float orientationMeasure(float cosSpread)
{
    const float spread = std::acos(std::clamp(cosSpread, -1.0f, 1.0f));
    const float widest = std::min(spread + 0.5f * kPi, kPi);
    const float sine = std::sin(spread);
    return 2.0f * kPi * (1.0f - cosSpread) +
           0.5f * kPi * (2.0f * widest * sine - std::cos(spread - 2.0f * widest) - 2.0f * spread * sine + cosSpread);
}

float surfaceArea(const Bounds& b)
{
    const vec3 s = b.size();
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

float sineOf(float cosine)
{
    return std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
}

/// cos(max(0, a - b)) from the cosines of two angles in 0…pi and the sine of the second.
float cosineOfDifference(float cosA, float cosB, float sinB)
{
    return cosA > cosB ? 1.0f : cosA * cosB + sineOf(cosA) * sinB;
}

/// What a node contributes at least of its power over distance squared: keeps every light possible where the bounds of
/// its node are only nearly right.
constexpr float kLeastCosine = 0.02f;

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
    makeQuads();
}

void LightTree::makeQuads()
{
    for (uint32_t n = 0; n < nodes_.size(); ++n) {
        if (nodes_[n].leaf) continue;
        nodes_[n].quad = uint32_t(quads_.size());
        Quad& quad = quads_.emplace_back();
        std::size_t lane = 0;
        const auto add = [&](uint32_t number, const Node& node) {
            quad.nodes.set(lane, node);
            quad.number[lane++] = number;
        };
        for (const uint32_t child : {n + 1, nodes_[n].second}) {
            if (nodes_[child].leaf) {
                add(child, nodes_[child]);
                continue;
            }
            add(child + 1, nodes_[child + 1]);
            add(nodes_[child].second, nodes_[nodes_[child].second]);
        }
        Node none;
        none.center = quad.nodes.center[0];
        while (lane < Quad::kLanes) add(~0u, none);
    }
}

uint32_t LightTree::build(std::span<BuildItem> items, uint32_t parent)
{
    const auto number = uint32_t(nodes_.size());
    nodes_.emplace_back();
    Bounds bounds;
    Bounds centers;
    Cone cone{items[0].light.axis, items[0].light.cosSpread};
    float power = 0.0f;
    float range = 0.0f;
    bool unlimited = false;
    bool twoSided = false;
    for (const BuildItem& item : items) {
        bounds.extend(item.light.bounds);
        centers.extend(item.center);
        cone = uniteCones(cone, {item.light.axis, item.light.cosSpread});
        power += item.light.power;
        range = std::max(range, item.light.range);
        unlimited = unlimited || item.light.range <= 0.0f;
        twoSided = twoSided || item.light.twoSided;
    }
    Node node;
    node.center = bounds.center();
    node.radius = 0.5f * glm::length(bounds.size());
    node.axis = cone.axis;
    node.cosSpread = cone.cosine;
    node.sinSpread = sineOf(cone.cosine);
    node.power = power;
    node.range = unlimited ? 0.0f : range;
    node.twoSided = twoSided;
    node.parent = parent;
    if (items.size() == 1) {
        node.leaf = true;
        node.second = items[0].index;
        leafOfItem_[items[0].index] = number;
        nodes_[number] = node;
        return number;
    }

    // Surface area orientation heuristic over bins of the centres; halves where no plane divides them.
    constexpr int kBins = 12;
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
    const auto leftCount = std::size_t(middle - items.begin());
    nodes_[number] = node;
    build(items.first(leftCount), number);
    nodes_[number].second = build(items.subspan(leftCount), number);
    return number;
}

// Without branches on the point: for points side by side the compiler works on several at once.
float LightTree::importance(const Node& node, vec3 position, vec3 normal)
{
    const vec3 to = node.center - position;
    const float distance2 = glm::dot(to, to);
    const float radius2 = node.radius * node.radius;
    const float within = node.power / std::max(radius2, 1.0e-12f);
    const float reach = node.range > 0.0f ? node.range + node.radius : kInfinity;
    // Angles of the sphere around the node, of the receiver's normal and of the emitters' normals.
    const float inverse = 1.0f / std::sqrt(distance2);
    const vec3 direction = to * inverse;
    const float sinSphere = node.radius * inverse;
    const float cosSphere = sineOf(sinSphere);
    const float cosine = std::min(glm::dot(normal, direction), 1.0f);
    const float facing = std::max(cosineOfDifference(cosine, cosSphere, sinSphere), kLeastCosine);
    const float received = glm::dot(normal, normal) > 0.0f ? facing : 1.0f;
    const float front = std::min(std::max(-glm::dot(node.axis, direction), -1.0f), 1.0f);
    const float cosAxis = node.twoSided ? std::abs(front) : front;
    const float cosOut = cosineOfDifference(cosAxis, node.cosSpread, node.sinSpread);
    const float shining = std::max(cosineOfDifference(cosOut, cosSphere, sinSphere), kLeastCosine);
    const float emitted = node.cosSpread > -1.0f ? shining : 1.0f;
    const float outside = node.power * received * emitted * (inverse * inverse);
    const float weight = distance2 <= radius2 || distance2 < 1.0e-12f ? within : outside;
    return distance2 > reach * reach ? 0.0f : weight;
}

LightTree::Weights LightTree::importance(const Cut::Lanes<uint32_t>& nodes, const Points& positions,
                                         const Points& normals) const
{
    NodeLanes<Cut::kLanes> lanes;
    for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) lanes.set(lane, nodes_[nodes[lane]]);
    Weights weights;
    for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
        weights[lane] = importance(lanes[lane], positions[lane], normals[lane]);
    }
    return weights;
}

float LightTree::total(vec3 position, vec3 normal) const
{
    return importance(nodes_[kRoot], position, normal);
}

LightTree::Quad::Lanes<float> LightTree::probabilities(const Quad& quad, vec3 position, vec3 normal) const
{
    Quad::Lanes<float> weights;
    for (std::size_t lane = 0; lane < Quad::kLanes; ++lane) {
        weights[lane] = importance(quad.nodes[lane], position, normal);
    }
    const float sum = (weights[0] + weights[1]) + (weights[2] + weights[3]);
    if (!(sum > 0.0f && sum < kInfinity)) {
        if (sum <= 0.0f) return {};
        // Sums beyond floats: an even chance is always right.
        const auto count =
            float(std::count_if(quad.number.begin(), quad.number.end(), [](uint32_t n) { return n != ~0u; }));
        for (std::size_t lane = 0; lane < Quad::kLanes; ++lane) {
            weights[lane] = quad.number[lane] != ~0u ? 1.0f / count : 0.0f;
        }
        return weights;
    }
    const float inverse = 1.0f / sum;
    for (float& weight : weights) weight *= inverse;
    return weights;
}

LightTree::Choice LightTree::sample(vec3 position, vec3 normal, float u, uint32_t node) const
{
    Choice choice{~0u, 1.0f, u};
    if (nodes_[node].leaf && nodes_[node].range > 0.0f && importance(nodes_[node], position, normal) <= 0.0f) {
        return {~0u, 0.0f, u};
    }
    while (!nodes_[node].leaf) {
        const Quad& quad = quads_[nodes_[node].quad];
        const Quad::Lanes<float> p = probabilities(quad, position, normal);
        float below = 0.0f;
        std::size_t lane = 0;
        std::size_t last = Quad::kLanes; // that can be chosen
        for (; lane < Quad::kLanes; ++lane) {
            if (!(p[lane] > 0.0f)) continue;
            last = lane;
            if (choice.u < below + p[lane]) break;
            below += p[lane];
        }
        if (last == Quad::kLanes) return {~0u, 0.0f, u};
        if (lane == Quad::kLanes) below -= p[last]; // rounding
        choice.u = std::clamp((choice.u - below) / p[last], 0.0f, 0x1.fffffep-1f);
        choice.probability *= p[last];
        node = quad.number[last];
    }
    choice.item = nodes_[node].second;
    return choice;
}

void LightTree::sample(const Cut& cut, const Points& positions, const Points& normals, const Cut::Lanes<bool>& wanted,
                       const Cut::Lanes<float>& u, Cut::Lanes<Choice>& choices) const
{
    // The last node below which a number lies, for all lanes step by step.
    Cut::Lanes<uint32_t> place{};
    for (auto n = uint32_t(cut.count); n > 1; n -= n / 2) {
        for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
            const uint32_t half = place[lane] + n / 2;
            place[lane] = u[lane] >= cut.below[half][lane] ? half : place[lane];
        }
    }
    Cut::Lanes<float> probability;
    Cut::Lanes<float> rest;
    for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
        probability[lane] = cut.probability[place[lane]][lane];
        rest[lane] = (u[lane] - cut.below[place[lane]][lane]) / probability[lane];
        rest[lane] = std::min(std::max(rest[lane], 0.0f), 0x1.fffffep-1f);
    }
    for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
        choices[lane] = {cut.item[place[lane]][lane], wanted[lane] ? probability[lane] : 0.0f, rest[lane]};
        if (!wanted[lane] || choices[lane].item != ~0u) continue;
        choices[lane] = sample(positions[lane], normals[lane], rest[lane], cut.node[place[lane]][lane]);
        choices[lane].probability *= probability[lane];
    }
}

float LightTree::climb(uint32_t item, const Cut* cut, std::size_t lane, vec3 position, vec3 normal,
                       std::size_t& cutIndex) const
{
    uint32_t node = leafOfItem_[item];
    if (nodes_[node].range > 0.0f && importance(nodes_[node], position, normal) <= 0.0f) return 0.0f;
    // Where the walk down began, and after how many levels it got here.
    const auto isTop = [&](uint32_t n) {
        for (std::size_t i = 0; cut != nullptr && i < cut->count; ++i) {
            if (cut->node[i][lane] != n) continue;
            cutIndex = i;
            return true;
        }
        return cut == nullptr && n == kRoot;
    };
    int levels = 0;
    for (uint32_t n = node; !isTop(n); n = nodes_[n].parent, ++levels) {
        if (n == kRoot) return 0.0f;
    }
    float probability = 1.0f;
    while (levels > 0) {
        // Two at once, but for the last one of an odd number.
        const int step = levels % 2 == 0 ? 2 : 1;
        const uint32_t parent = nodes_[node].parent;
        const uint32_t from = step == 2 ? nodes_[parent].parent : parent;
        const Quad& quad = quads_[nodes_[from].quad];
        const Quad::Lanes<float> p = probabilities(quad, position, normal);
        probability *= p[std::size_t(std::find(quad.number.begin(), quad.number.end(), node) - quad.number.begin())];
        node = from;
        levels -= step;
    }
    return probability;
}

float LightTree::probability(uint32_t item, vec3 position, vec3 normal) const
{
    std::size_t unused = 0;
    return climb(item, nullptr, 0, position, normal, unused);
}

LightTree::Cut LightTree::cut(const Points& positions, const Points& normals) const
{
    Cut cut;
    if (nodes_.empty()) return cut;
    // Each point opens the node that could contribute most, over and over. All have as many.
    std::array<Weights, Cut::kMaxNodes> weight;
    std::array<Weights, Cut::kMaxNodes> toOpen; ///< the same, negative where there is nothing to open
    const auto set = [&](const Cut::Lanes<uint32_t>& places, const Cut::Lanes<uint32_t>& nodes) {
        const Weights w = importance(nodes, positions, normals);
        for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
            const std::size_t place = places[lane];
            const Node& node = nodes_[nodes[lane]];
            cut.node[place][lane] = nodes[lane];
            cut.item[place][lane] = node.leaf && node.range <= 0.0f ? node.second : ~0u;
            weight[place][lane] = w[lane];
            toOpen[place][lane] = node.leaf ? -1.0f : std::max(0.0f, w[lane]); // 0 if that is no number
        }
    };
    set({}, {});
    const std::size_t nodes = std::min(Cut::kMaxNodes, leafOfItem_.size());
    for (cut.count = 1; cut.count < nodes; ++cut.count) {
        Weights most = toOpen[0];
        Cut::Lanes<uint32_t> widest{};
        for (uint32_t i = 1; i < cut.count; ++i) {
            for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
                const bool more = toOpen[i][lane] > most[lane];
                most[lane] = more ? toOpen[i][lane] : most[lane];
                widest[lane] = more ? i : widest[lane];
            }
        }
        Cut::Lanes<uint32_t> last;
        Cut::Lanes<uint32_t> first;
        Cut::Lanes<uint32_t> second;
        for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
            const uint32_t opened = cut.node[widest[lane]][lane];
            first[lane] = opened + 1;
            second[lane] = nodes_[opened].second;
            last[lane] = uint32_t(cut.count);
        }
        set(widest, first);
        set(last, second);
    }
    // The probabilities are worked out at one point and used at others: no node of the cut is left without a share.
    for (std::size_t lane = 0; lane < Cut::kLanes; ++lane) {
        float& total = cut.total[lane];
        for (std::size_t i = 0; i < cut.count; ++i) total += weight[i][lane];
        const bool usable = total > 0.0f && total < kInfinity;
        const float share = (usable ? 0.01f : 1.0f) / float(cut.count);
        float below = 0.0f;
        for (std::size_t i = 0; i < cut.count; ++i) {
            cut.probability[i][lane] = share + (usable ? 0.99f * weight[i][lane] / total : 0.0f);
            cut.below[i][lane] = below;
            below += cut.probability[i][lane];
        }
    }
    return cut;
}

float LightTree::probability(const Cut& cut, std::size_t lane, uint32_t item, vec3 position, vec3 normal) const
{
    std::size_t index = cut.count;
    const float below = climb(item, &cut, lane, position, normal, index);
    return index == cut.count ? 0.0f : below * cut.probability[index][lane];
}

} // namespace halflight
