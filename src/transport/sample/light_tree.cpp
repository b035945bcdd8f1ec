#include "transport/sample/light_tree.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

using shading::lightImportance;

} // namespace

LightTree::Weights LightTree::importance(const Cut::Lanes<uint32_t>& nodes, const Points& positions,
                                         const Points& normals) const
{
    Weights weights;
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        weights[lane] = lightImportance(nodes_[nodes[lane]], positions[lane], normals[lane]);
    return weights;
}

float LightTree::total(vec3 position, vec3 normal) const
{
    return lightImportance(nodes_[kRoot], position, normal);
}

LightTree::Choice LightTree::sample(vec3 position, vec3 normal, float u, uint32_t node) const
{
    const shading::ChosenLight chosen = shading::sampleLightsBelow(nodes_, node, position, normal, u);
    return {chosen.item, chosen.probability, chosen.u};
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
    const uint32_t leaf = leafOfItem_[item];
    if (shading::lightEndsBefore(nodes_[leaf], position, normal)) return 0.0f;
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
    for (uint32_t n = leaf; !isTop(n); n = nodes_[n].parent, ++levels) {
        if (n == kRoot) return 0.0f;
    }
    return shading::probabilityOfLeaf(nodes_, leaf, levels, position, normal);
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
            cut.item[place][lane] = node.leaf != 0 && node.range <= 0.0f ? node.second : ~0u;
            weight[place][lane] = w[lane];
            toOpen[place][lane] = node.leaf != 0 ? -1.0f : std::max(0.0f, w[lane]); // 0 if it is NaN
        }
    };
    set({}, {});
    const std::size_t nodes = cutNodes();
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
        float below = 0.0f;
        for (std::size_t i = 0; i < cut.count; ++i) {
            cut.probability[i][lane] = shading::cutProbability(weight[i][lane], total, int(cut.count));
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
