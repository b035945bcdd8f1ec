#include "bake/stages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

constexpr int kChannels = 4;
/// Comparisons of lights that one attempt at recolouring may take. A step compares all pairs, so groups of lights that
/// hang together by the hundred are coloured greedily alone.
constexpr int kColoringBudget = 4'000'000;
constexpr std::size_t kMaxRecolored = 128;

/// Sphere that holds all a light with a range can reach; a spot's is the tighter of its cone's bounding spheres.
struct Reach {
    vec3 center{0.0f};
    float radius = kInfinity;
};

Reach reachOf(const Light& light)
{
    if (light.type == LightType::Directional || light.rangeMeters <= 0.0f) return {};
    if (light.type == LightType::Point) return {light.position(), light.rangeMeters};
    // The cone's cap included. Narrow cones: the sphere through apex and rim; wide ones: around the rim.
    const float range = light.rangeMeters;
    const float cosine = std::cos(light.outerConeRadians);
    if (light.outerConeRadians >= kPi / 4.0f) {
        const float along = std::max(range * cosine, 0.0f);
        return {light.position() + along * light.direction(),
                std::max(range * std::sin(std::min(light.outerConeRadians, kPi / 2.0f)), range - along)};
    }
    const float radius = range / (2.0f * cosine);
    return {light.position() + radius * light.direction(), radius};
}

/// Whether a spot's infinite cone meets a sphere. The sphere's centre is compared with the cone moved back by
/// radius / sin(angle), whose surface is the set of centres of touching spheres; exact but around the apex, where it
/// errs towards "meets".
bool coneMeetsSphere(const Light& spot, const Reach& sphere)
{
    if (!std::isfinite(sphere.radius) || spot.outerConeRadians >= kPi / 2.0f) return true;
    const float sine = std::max(std::sin(spot.outerConeRadians), 1.0e-4f);
    const vec3 apex = spot.position() - spot.direction() * (sphere.radius / sine);
    const vec3 toCenter = sphere.center - apex;
    const float distance = glm::length(toCenter);
    return glm::dot(toCenter, spot.direction()) >= distance * std::cos(spot.outerConeRadians) - 1.0e-5f * distance;
}

/// Whether some point may be reached by both lights. Never false when there is one.
bool lightsOverlap(const Light& a, const Light& b)
{
    const Reach ra = reachOf(a);
    const Reach rb = reachOf(b);
    if (std::isfinite(ra.radius) && std::isfinite(rb.radius) &&
        glm::distance(ra.center, rb.center) > ra.radius + rb.radius) {
        return false;
    }
    if (a.type == LightType::Spot && !coneMeetsSphere(a, rb)) return false;
    if (b.type == LightType::Spot && !coneMeetsSphere(b, ra)) return false;
    return true;
}

/// Order of precedence that does not depend on the order of the lights in the file.
bool moreImportant(const Light& a, const Light& b)
{
    const bool sunA = a.type == LightType::Directional;
    const bool sunB = b.type == LightType::Directional;
    if (sunA != sunB) return sunA;
    const float powerA = luminance(a.color) * a.intensity;
    const float powerB = luminance(b.color) * b.intensity;
    if (powerA != powerB) return powerA > powerB;
    if (a.name != b.name) return a.name < b.name;
    const vec3 pa = a.position();
    const vec3 pb = b.position();
    return std::tie(pa.x, pa.y, pa.z) < std::tie(pb.x, pb.y, pb.z);
}

using Graph = std::vector<std::vector<bool>>;

/// Colours the listed nodes with four colours, most constrained node first (Brelaz 1979, "New Methods to Color the
/// Vertices of a Graph"), with backtracking up to a budget of steps.
bool colorGraph(const Graph& graph, const std::vector<int>& nodes, std::vector<int>& color, int& budget)
{
    int best = -1;
    int bestFree = kChannels + 1;
    std::array<bool, kChannels> bestUsed{};
    for (const int node : nodes) {
        if (color[std::size_t(node)] >= 0) continue;
        std::array<bool, kChannels> used{};
        for (const int other : nodes) {
            const int c = color[std::size_t(other)];
            if (c >= 0 && graph[std::size_t(node)][std::size_t(other)]) used[std::size_t(c)] = true;
        }
        const int freeColors = int(std::count(used.begin(), used.end(), false));
        if (freeColors < bestFree) {
            bestFree = freeColors;
            best = node;
            bestUsed = used;
        }
    }
    if (best < 0) return true;
    for (int c = 0; c < kChannels; ++c) {
        if (bestUsed[std::size_t(c)]) continue;
        if (--budget < 0) return false;
        color[std::size_t(best)] = c;
        if (colorGraph(graph, nodes, color, budget)) return true;
    }
    color[std::size_t(best)] = -1;
    return false;
}

/// `node` and the placed nodes that hang together with it; empty when they are too many to recolour.
std::vector<int> connectedTo(const Graph& graph, const std::vector<int>& placed, int node)
{
    std::vector<int> reached = {node};
    std::vector<bool> seen(graph.size(), false);
    seen[std::size_t(node)] = true;
    for (std::size_t next = 0; next < reached.size(); ++next) {
        for (const int other : placed) {
            if (seen[std::size_t(other)] || !graph[std::size_t(reached[next])][std::size_t(other)]) continue;
            seen[std::size_t(other)] = true;
            reached.push_back(other);
            if (reached.size() > kMaxRecolored) return {};
        }
    }
    return reached;
}

void assignShadowmask(Scene& scene, std::vector<int> mixed)
{
    std::sort(mixed.begin(), mixed.end(),
              [&](int a, int b) { return moreImportant(scene.lights[std::size_t(a)], scene.lights[std::size_t(b)]); });
    // Lights without shadows are lit everywhere: they need no channel.
    std::erase_if(mixed, [&](int l) {
        const Light& light = scene.lights[std::size_t(l)];
        return !light.castShadows || light.shadowStrength <= 0.0f;
    });
    const std::size_t n = mixed.size();
    Graph graph(n, std::vector<bool>(n, false));
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) {
            graph[i][j] = graph[j][i] =
                lightsOverlap(scene.lights[std::size_t(mixed[i])], scene.lights[std::size_t(mixed[j])]);
        }
    }

    // One light after another, the important ones first: the lowest free channel; if none is free, all so far are
    // coloured anew together; if that fails too, this light is baked.
    std::vector<int> color(n, -1);
    std::vector<int> placed;
    for (int i = 0; i < int(n); ++i) {
        std::array<int, kChannels> holder;
        holder.fill(-1);
        for (const int other : placed) {
            if (graph[std::size_t(i)][std::size_t(other)]) holder[std::size_t(color[std::size_t(other)])] = other;
        }
        const auto freeChannel = std::find(holder.begin(), holder.end(), -1);
        if (freeChannel != holder.end()) {
            color[std::size_t(i)] = int(freeChannel - holder.begin());
            placed.push_back(i);
            continue;
        }
        const std::vector<int> candidates = connectedTo(graph, placed, i);
        std::vector<int> recolored = color;
        for (const int candidate : candidates) recolored[std::size_t(candidate)] = -1;
        int budget = candidates.empty() ? 0 : kColoringBudget / int(candidates.size() * candidates.size());
        if (budget > 0 && colorGraph(graph, candidates, recolored, budget)) {
            color = recolored;
            placed.push_back(i);
            continue;
        }
        std::string names;
        for (const int other : holder) {
            names += (names.empty() ? "" : ", ") + scene.lights[std::size_t(mixed[std::size_t(other)])].name;
        }
        BakingOutput& baking = scene.lights[std::size_t(mixed[std::size_t(i)])].baking;
        baking.bakeType = LightMode::Baked;
        baking.reason = "overlaps four other mixed lights that hold all shadowmask channels (" + names +
                        "), so it is fully baked; a shorter range would free it";
    }
    for (const int i : placed) {
        scene.lights[std::size_t(mixed[std::size_t(i)])].baking.occlusionMaskChannel = color[std::size_t(i)];
    }
}

} // namespace

void assignShadowmaskChannels(Scene& scene, MixedLightingMode mode)
{
    std::vector<int> mixed;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        Light& light = scene.lights[i];
        light.baking = {};
        light.baking.isBaked = light.mode != LightMode::Realtime;
        light.baking.bakeType = light.mode;
        light.baking.mixedMode = mode;
        light.baking.worldFromLight = light.worldFromLight;
        light.baking.reachMeters = light.type == LightType::Directional ? 0.0f : light.rangeMeters;
        light.baking.outerConeRadians = light.outerConeRadians;
        light.baking.atBake = lightAtBake(light);
        if (light.mode == LightMode::Mixed) mixed.push_back(int(i));
    }
    if (mode == MixedLightingMode::Shadowmask) {
        assignShadowmask(scene, mixed);
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

} // namespace halflight
