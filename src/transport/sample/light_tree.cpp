#include "transport/sample/light_tree.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

/// Lower bound of both cosines: rounding errors of a node's bounds must not give a light probability 0.
constexpr float kLeastCosine = 0.02f;
/// Share of a cut's samples that its nodes take evenly: the probabilities are of one point and used at others near it.
constexpr float kEvenShare = 0.01f;

} // namespace

/// cos(max(0, a - b)) from the cosines of two angles in 0…pi and the sine of the second.
inline float LightTree::cosineOfDifference(float cosA, float cosB, float sinB)
{
    return cosA > cosB ? 1.0f : cosA * cosB + sineOf(cosA) * sinB;
}

// Without branches on the point, so that loops over points are vectorized.
float LightTree::importance(const Node& node, vec3 position, vec3 normal)
{
    const vec3 to = node.center - position;
    const float distance2 = glm::dot(to, to);
    const float radius2 = node.radius * node.radius;
    const float within = node.power / std::max(radius2, 1.0e-12f);
    const float reach = node.range > 0.0f ? node.range + node.radius : kInfinity;
    // Angles of the node's bounding sphere, the receiver's normal and the emitters' normals.
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
    Weights weights;
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        weights[lane] = importance(nodes_[nodes[lane]], positions[lane], normals[lane]);
    return weights;
}

float LightTree::total(vec3 position, vec3 normal) const
{
    return importance(nodes_[kRoot], position, normal);
}

LightTree::Step LightTree::stepFrom(uint32_t node, vec3 position, vec3 normal) const
{
    Step step;
    for (const uint32_t child : {node + 1, nodes_[node].second}) {
        if (nodes_[child].leaf) {
            step.node[step.count++] = child;
        } else {
            step.node[step.count++] = child + 1;
            step.node[step.count++] = nodes_[child].second;
        }
    }
    std::array<float, 4>& weights = step.probability;
    for (std::size_t i = 0; i < step.count; ++i) weights[i] = importance(nodes_[step.node[i]], position, normal);
    const float sum = (weights[0] + weights[1]) + (weights[2] + weights[3]);
    if (sum <= 0.0f) return step;
    // If the sum overflowed, even probabilities are unbiased.
    const float inverse = 1.0f / sum;
    for (std::size_t i = 0; i < step.count; ++i)
        weights[i] = sum < kInfinity ? weights[i] * inverse : 1.0f / float(step.count);
    return step;
}

LightTree::Choice LightTree::sample(vec3 position, vec3 normal, float u, uint32_t node) const
{
    Choice choice{~0u, 1.0f, u};
    if (nodes_[node].leaf && nodes_[node].range > 0.0f && importance(nodes_[node], position, normal) <= 0.0f) {
        return {~0u, 0.0f, u};
    }
    while (!nodes_[node].leaf) {
        const Step step = stepFrom(node, position, normal);
        float below = 0.0f;
        std::size_t chosen = step.count;
        for (std::size_t i = 0; i < step.count; ++i) {
            if (!(step.probability[i] > 0.0f)) continue;
            if (chosen < step.count) below += step.probability[chosen];
            chosen = i;
            if (choice.u < below + step.probability[i]) break;
        }
        if (chosen == step.count) return {~0u, 0.0f, u};
        const float probability = step.probability[chosen];
        choice.u = std::clamp((choice.u - below) / probability, 0.0f, 0x1.fffffep-1f);
        choice.probability *= probability;
        node = step.node[chosen];
    }
    choice.item = nodes_[node].second;
    return choice;
}

void LightTree::sample(const Cut& cut, const Points& positions, const Points& normals, const Cut::Lanes<bool>& wanted,
                       const Cut::Lanes<float>& u, Cut::Lanes<Choice>& choices) const
{
    // Binary search for the node of each lane's random number, all lanes in step.
    Cut::Lanes<uint32_t> place{};
    for (auto n = uint32_t(cut.count); n > 1; n -= n / 2) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const uint32_t half = place[lane] + n / 2;
            place[lane] = u[lane] >= cut.below[half][lane] ? half : place[lane];
        }
    }
    Cut::Lanes<float> probability;
    Cut::Lanes<float> rest;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        probability[lane] = cut.probability[place[lane]][lane];
        rest[lane] = (u[lane] - cut.below[place[lane]][lane]) / probability[lane];
        rest[lane] = std::min(std::max(rest[lane], 0.0f), 0x1.fffffep-1f);
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
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
    // Number of levels between the leaf and the node where the traversal began.
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
        // One level is left if their number is odd.
        const bool two = levels % 2 == 0;
        const uint32_t parent = nodes_[node].parent;
        const uint32_t from = two ? nodes_[parent].parent : parent;
        const Step step = stepFrom(from, position, normal);
        probability *=
            step.probability[std::size_t(std::find(step.node.begin(), step.node.end(), node) - step.node.begin())];
        node = from;
        levels -= two ? 2 : 1;
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
    // Each point repeatedly opens the node of largest importance. All points have equally many nodes.
    std::array<Weights, Cut::kMaxNodes> weight;
    std::array<Weights, Cut::kMaxNodes> toOpen; ///< weight, negative for leaves
    const auto set = [&](const Cut::Lanes<uint32_t>& places, const Cut::Lanes<uint32_t>& nodes) {
        const Weights w = importance(nodes, positions, normals);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const std::size_t place = places[lane];
            const Node& node = nodes_[nodes[lane]];
            cut.node[place][lane] = nodes[lane];
            cut.item[place][lane] = node.leaf && node.range <= 0.0f ? node.second : ~0u;
            weight[place][lane] = w[lane];
            toOpen[place][lane] = node.leaf ? -1.0f : std::max(0.0f, w[lane]); // 0 if it is NaN
        }
    };
    set({}, {});
    const std::size_t nodes = std::min(Cut::kMaxNodes, leafOfItem_.size());
    for (cut.count = 1; cut.count < nodes; ++cut.count) {
        Weights most = toOpen[0];
        Cut::Lanes<uint32_t> widest{};
        for (uint32_t i = 1; i < cut.count; ++i) {
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const bool more = toOpen[i][lane] > most[lane];
                most[lane] = more ? toOpen[i][lane] : most[lane];
                widest[lane] = more ? i : widest[lane];
            }
        }
        Cut::Lanes<uint32_t> last;
        Cut::Lanes<uint32_t> first;
        Cut::Lanes<uint32_t> second;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const uint32_t opened = cut.node[widest[lane]][lane];
            first[lane] = opened + 1;
            second[lane] = nodes_[opened].second;
            last[lane] = uint32_t(cut.count);
        }
        set(widest, first);
        set(last, second);
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        float& total = cut.total[lane];
        for (std::size_t i = 0; i < cut.count; ++i) total += weight[i][lane];
        const bool usable = total > 0.0f && total < kInfinity;
        const float share = (usable ? kEvenShare : 1.0f) / float(cut.count);
        float below = 0.0f;
        for (std::size_t i = 0; i < cut.count; ++i) {
            cut.probability[i][lane] = share + (usable ? (1.0f - kEvenShare) * weight[i][lane] / total : 0.0f);
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
