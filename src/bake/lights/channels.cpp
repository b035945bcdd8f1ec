// Shadowmask channels: colouring of the graph of mixed lights whose reaches overlap (spec S9, S10, S36).
#include "bake/lights/channels.h"

#include "bake/lights/light_levels.h"
#include "bake/lights/overlaps.h"
#include "halflight/base/text.h"
#include "halflight/scene/turning_lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace halflight {
namespace {
constexpr int kMostChannels = kMostMaskLayers * kLayerChannels;
/// Limit on pairs of lights that one attempt at recolouring compares, on its lights, and on the pairs of all attempts:
/// a second of one core.
constexpr int kColoringBudget = 4'000'000;
constexpr std::size_t kMaxRecolored = 128;
constexpr int64_t kPairsOfAllAttempts = 500'000'000;
/// Steps of backtracking that take as long as colouring all in smallest-last order.
constexpr int kSmallestLastSteps = 8;

/// Colours the listed nodes with so many colours, beside those that have one; most constrained node first (Brelaz 1979,
/// "New Methods to Color the Vertices of a Graph"), with backtracking up to a budget of steps.
bool colorGraph(const Graph& graph, std::span<const int> nodes, int colors, std::vector<int>& color, int& budget)
{
    int best = -1;
    int bestFree = colors + 1;
    std::array<bool, kMostChannels> bestUsed{};
    for (const int node : nodes) {
        if (color[std::size_t(node)] >= 0) continue;
        std::array<bool, kMostChannels> used{};
        for (const int other : graph[std::size_t(node)]) {
            const int c = color[std::size_t(other)];
            if (c >= 0) used[std::size_t(c)] = true;
        }
        const int freeColors = int(std::count(used.begin(), used.begin() + colors, false));
        if (freeColors < bestFree) {
            bestFree = freeColors;
            best = node;
            bestUsed = used;
        }
    }
    if (best < 0) return true;
    for (int c = 0; c < colors; ++c) {
        if (bestUsed[std::size_t(c)]) continue;
        if (--budget < 0) return false;
        color[std::size_t(best)] = c;
        if (colorGraph(graph, nodes, colors, color, budget)) return true;
    }
    color[std::size_t(best)] = -1;
    return false;
}

/// The nodes with a colour that are connected to `node`, and it; nearest first.
std::vector<int> connectedTo(const Graph& graph, const std::vector<int>& color, int node)
{
    std::vector<int> reached = {node};
    std::vector<bool> seen(graph.size(), false);
    seen[std::size_t(node)] = true;
    for (std::size_t next = 0; next < reached.size(); ++next) {
        for (const int other : graph[std::size_t(reached[next])]) {
            if (seen[std::size_t(other)] || color[std::size_t(other)] < 0) continue;
            seen[std::size_t(other)] = true;
            reached.push_back(other);
        }
    }
    return reached;
}

/// Channels of some lights, most important first.
struct Coloring {
    std::vector<int> channel;              ///< by light; -1: none
    std::vector<std::vector<int>> holders; ///< by light without channel: the lights with the channels
    std::size_t overflow = 0;              ///< lights without channel
};

/// Colours the listed nodes greedily, each before those that have fewer others left when it is taken away ("smallest
/// last": Matula and Beck 1983, "Smallest-Last Ordering and Clustering and Graph Coloring Algorithms"). Along a street
/// or in a plane few colours more than overlap at one point do.
bool colorSmallestLast(const Graph& graph, std::span<const int> nodes, int colors, std::vector<int>& color)
{
    std::vector<int> left(graph.size(), -1); // overlaps with nodes that are not taken away; -1: not listed, or taken
    for (const int node : nodes) left[std::size_t(node)] = 0;
    std::vector<std::vector<int>> byLeft(nodes.size()); // nodes that had so many left; `left` tells who still has
    for (const int node : nodes) {
        for (const int other : graph[std::size_t(node)]) left[std::size_t(node)] += left[std::size_t(other)] >= 0;
        byLeft[std::size_t(left[std::size_t(node)])].push_back(node);
    }
    std::vector<int> order;
    for (int fewest = 0; order.size() < nodes.size();) {
        std::vector<int>& some = byLeft[std::size_t(fewest)];
        if (some.empty()) {
            ++fewest;
            continue;
        }
        const int node = some.back();
        some.pop_back();
        if (left[std::size_t(node)] != fewest) continue;
        left[std::size_t(node)] = -1;
        order.push_back(node);
        for (const int other : graph[std::size_t(node)]) {
            if (left[std::size_t(other)] < 0) continue;
            const int count = --left[std::size_t(other)];
            byLeft[std::size_t(count)].push_back(other);
            fewest = std::min(fewest, count);
        }
    }
    for (auto node = order.rbegin(); node != order.rend(); ++node) {
        std::array<bool, kMostChannels> used{};
        for (const int other : graph[std::size_t(*node)])
            if (color[std::size_t(other)] >= 0) used[std::size_t(color[std::size_t(other)])] = true;
        const auto free = std::find(used.begin(), used.begin() + colors, false);
        if (free == used.begin() + colors) return false;
        color[std::size_t(*node)] = int(free - used.begin());
    }
    return true;
}

/// Frees a colour for a node: all lights that are connected to it are coloured again.
class Recoloring {
public:
    Recoloring(const Graph& graph, int colors) : graph_(graph), colors_(colors) {}

    bool place(int node, std::vector<int>& color)
    {
        const std::vector<int> nodes = connectedTo(graph_, color, node);
        const bool few = nodes.size() <= kMaxRecolored;
        std::size_t overlaps = 0;
        for (const int other : nodes) overlaps += graph_[std::size_t(other)].size();
        int budget = few ? kColoringBudget / int(nodes.size() * nodes.size()) : kSmallestLastSteps;
        pairsLeft_ -= int64_t(overlaps) * budget;
        if (pairsLeft_ < 0) return false;
        std::vector<int> recolored = color;
        for (const int other : nodes) recolored[std::size_t(other)] = -1;
        const bool done = few ? colorGraph(graph_, nodes, colors_, recolored, budget)
                              : colorSmallestLast(graph_, nodes, colors_, recolored);
        if (done) color = std::move(recolored);
        return done;
    }

private:
    const Graph& graph_;
    int colors_;
    int64_t pairsLeft_ = kPairsOfAllAttempts;
};

/// Greedy colouring, important lights first, with the lowest free channel. If none is free, the lights connected to it
/// are coloured again; if that fails, the light gets no channel.
Coloring colorLights(const std::vector<const Light*>& lights, int channels)
{
    const std::size_t n = lights.size();
    const Graph graph = overlapsOf(lights);
    Coloring result;
    result.holders.resize(n);
    std::vector<int>& color = result.channel;
    color.assign(n, -1);
    Recoloring recoloring(graph, channels);
    for (int i = 0; i < int(n); ++i) {
        std::vector<int> holder(std::size_t(channels), -1);
        for (const int other : graph[std::size_t(i)])
            if (color[std::size_t(other)] >= 0) holder[std::size_t(color[std::size_t(other)])] = other;
        const auto freeChannel = std::find(holder.begin(), holder.end(), -1);
        if (freeChannel != holder.end()) {
            color[std::size_t(i)] = int(freeChannel - holder.begin());
            continue;
        }
        if (recoloring.place(i, color)) continue;
        result.holders[std::size_t(i)] = std::move(holder);
        ++result.overflow;
    }
    return result;
}

/// Shares of the scene's bright level at which the reach of lights without a range may end, smallest first. The first
/// share that leaves no light without channel is used. It bounds the light that leaks through walls beyond a reach.
constexpr std::array kReachShares = {1.0f / 320.0f, 1.0f / 160.0f, 1.0f / 80.0f, 1.0f / 40.0f, 1.0f / 20.0f};

/// Colours lights. If some get no channel, lights without a range get the longest effective reach that helps.
Coloring colorWithinReach(const Scene& scene, const std::vector<Light*>& mixed, int channels)
{
    const std::vector<const Light*> lights(mixed.begin(), mixed.end());
    Coloring best = colorLights(lights, channels);
    const bool limitless = std::any_of(lights.begin(), lights.end(), [](const Light* l) { return hasNoRange(*l); });
    if (best.overflow == 0 || !limitless) return best;
    const std::vector<float> distances = levelDistances(scene, lights);
    const auto setReach = [&](float share) { // 0: none
        for (std::size_t i = 0; i < mixed.size(); ++i) {
            if (!hasNoRange(*mixed[i])) continue;
            const float reach = share > 0.0f ? distances[i] / std::sqrt(share) : 0.0f;
            mixed[i]->baking.reachMeters = std::isfinite(reach) ? reach : 0.0f;
        }
    };
    float bestShare = 0.0f;
    for (const float share : kReachShares) {
        setReach(share);
        Coloring coloring = colorLights(lights, channels);
        if (coloring.overflow >= best.overflow) continue;
        best = std::move(coloring);
        bestShare = share;
        if (best.overflow == 0) break;
    }
    setReach(bestShare);
    // A light with a channel of its own needs no limit.
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        const auto users = std::count(best.channel.begin(), best.channel.end(), best.channel[i]);
        if (hasNoRange(*mixed[i]) && (best.channel[i] < 0 || users == 1)) mixed[i]->baking.reachMeters = 0.0f;
    }
    return best;
}

/// Why a light is fully baked, and the cure. No range helps against directional lights, which reach everything.
std::string overflowReason(const Light& light, const std::vector<const Light*>& holders)
{
    std::vector<std::string> names;
    std::vector<std::string> limitless;
    std::vector<std::string> limited;
    for (const Light* holder : holders) {
        names.push_back(holder->name);
        if (holder->type != LightType::Directional) (hasNoRange(*holder) ? limitless : limited).push_back(holder->name);
    }
    const bool oneLayer = holders.size() == std::size_t(kLayerChannels);
    const std::string text = std::string("overlaps ") + (oneLayer ? "four" : "sixteen") +
                             " other mixed lights that hold all shadowmask channels (" + listOf(names) +
                             "), so it is fully baked; ";
    const std::string orLayers = oneLayer ? "; or bake with --mask-layers auto" : "";
    if (limitless.empty() && limited.empty())
        return text + "these are directional and reach everything: make one of them realtime or baked" + orLayers;
    if (hasNoRange(light)) limitless.insert(limitless.begin(), light.name);
    if (limitless.empty())
        return text + "shorter ranges, until it overlaps one less of " + listOf(limited) + ", free it" + orLayers;
    return text + "give " + listOf(limitless) +
           " a range (halflight_range, or range of KHR_lights_punctual): without " +
           (limitless.size() == 1 ? "one it reaches" : "one they reach") + " everything" + orLayers;
}

void assignShadowmask(Scene& scene, std::vector<int> mixed, int channels)
{
    std::sort(mixed.begin(), mixed.end(),
              [&](int a, int b) { return moreImportant(scene.lights[std::size_t(a)], scene.lights[std::size_t(b)]); });
    // Lights without shadows need no channel.
    std::erase_if(mixed, [&](int l) {
        const Light& light = scene.lights[std::size_t(l)];
        return !light.castShadows || light.shadowStrength <= 0.0f;
    });
    std::vector<Light*> lights;
    for (const int l : mixed) lights.push_back(&scene.lights[std::size_t(l)]);
    const Coloring coloring = colorWithinReach(scene, lights, channels);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        BakingOutput& baking = lights[i]->baking;
        baking.occlusionMaskChannel = coloring.channel[i];
        if (coloring.channel[i] >= 0) continue;
        std::vector<const Light*> holders;
        for (const int h : coloring.holders[i]) holders.push_back(lights[std::size_t(h)]);
        baking.bakeType = LightMode::Baked;
        baking.reason = overflowReason(*lights[i], holders);
    }
}

} // namespace

void assignShadowmaskChannels(Scene& scene, MixedLightingMode mode, int mostLayers)
{
    std::vector<int> mixed;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        Light& light = scene.lights[i];
        light.baking = BakingOutput{.turning = std::move(light.baking.turning)};
        light.baking.isBaked = light.mode != LightMode::Realtime;
        light.baking.bakeType = light.mode;
        light.baking.mixedMode = mode;
        light.baking.worldFromLight = light.worldFromLight;
        light.baking.reachMeters = light.type == LightType::Directional ? 0.0f : light.rangeMeters;
        light.baking.outerConeRadians = light.outerConeRadians;
        light.baking.atBake = lightAtBake(light);
        // Shadows of a light that turns are of run time.
        if (light.mode == LightMode::Mixed && !turns(light)) mixed.push_back(int(i));
    }
    if (mode == MixedLightingMode::Shadowmask) {
        assignShadowmask(scene, std::move(mixed), mostLayers * kLayerChannels);
    } else if (mode == MixedLightingMode::Subtractive) {
        // The main light alone has occlusion in the probes, in channel 0 (spec S25).
        int main = -1;
        for (const int i : mixed) {
            const Light& light = scene.lights[std::size_t(i)];
            if (light.type != LightType::Directional) continue;
            if (main < 0 || moreImportant(light, scene.lights[std::size_t(main)])) main = i;
        }
        if (main >= 0) scene.lights[std::size_t(main)].baking.occlusionMaskChannel = 0;
    }
}

void limitBounces(Scene& scene, const IntegrationSettings& settings)
{
    if (settings.bounces > 0) return;
    for (Light& light : scene.lights) light.baking.atBake.indirectMultiplier = 0.0f;
}

} // namespace halflight
