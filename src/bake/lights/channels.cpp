// Shadowmask channels: colouring of the graph of mixed lights whose reaches overlap (spec S9, S10).
#include "bake/lights/channels.h"

#include "halflight/base/cone.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/text.h"
#include "halflight/shading/light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {
constexpr int kChannels = 4;
/// Limit on pairs of lights that one attempt at recolouring compares. A step compares all pairs, so connected groups of
/// more than kMaxRecolored lights are only coloured greedily.
constexpr int kColoringBudget = 4'000'000;
constexpr std::size_t kMaxRecolored = 128;

/// Bounding sphere of the points that a light reaches; of a spot's, the smaller of two spheres around its cone.
struct Reach {
    vec3 center{0.0f};
    float radius = kInfinity;
};

Reach reachOf(const Light& light)
{
    const float range = light.baking.reachMeters;
    if (light.type == LightType::Directional || range <= 0.0f) return {};
    if (light.type != LightType::Spot) return {light.position(), range};
    // With the cone's cap. Narrow cones: the sphere through apex and rim; wide ones: the sphere around the rim.
    const float cosine = math::cos(light.outerConeRadians);
    if (light.outerConeRadians >= kPi / 4.0f) {
        const float along = std::max(range * cosine, 0.0f);
        return {light.position() + along * light.direction(),
                std::max(range * math::sin(std::min(light.outerConeRadians, kPi / 2.0f)), range - along)};
    }
    const float radius = range / (2.0f * cosine);
    return {light.position() + radius * light.direction(), radius};
}

/// Whether a spot's cone reaches into a sphere.
bool spotMeets(const Light& spot, const Reach& sphere)
{
    return !std::isfinite(sphere.radius) ||
           coneMeetsBall(spot.position(), spot.direction(), spot.outerConeRadians, sphere.center, sphere.radius);
}

/// Whether an area light's front faces a sphere.
bool areaMeets(const Light& area, const Reach& sphere)
{
    return !std::isfinite(sphere.radius) ||
           glm::dot(sphere.center - area.position(), area.direction()) > -sphere.radius;
}

/// Whether both lights may reach a common point (conservative).
bool lightsOverlap(const Light& a, const Light& b)
{
    const Reach ra = reachOf(a);
    const Reach rb = reachOf(b);
    if (std::isfinite(ra.radius) && std::isfinite(rb.radius) &&
        glm::distance(ra.center, rb.center) > ra.radius + rb.radius) {
        return false;
    }
    if (a.type == LightType::Spot && !spotMeets(a, rb)) return false;
    if (b.type == LightType::Spot && !spotMeets(b, ra)) return false;
    if (isAreaLight(a.type) && !areaMeets(a, rb)) return false;
    if (isAreaLight(b.type) && !areaMeets(b, ra)) return false;
    return true;
}

/// Order of precedence that does not depend on the order of the lights in the file.
bool moreImportant(const Light& a, const Light& b)
{
    const bool sunA = a.type == LightType::Directional;
    const bool sunB = b.type == LightType::Directional;
    if (sunA != sunB) return sunA;
    const float powerA = luminance(a.color) * a.intensity * a.area();
    const float powerB = luminance(b.color) * b.intensity * b.area();
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

/// The connected component of `node` among the placed nodes; empty if it is too large to recolour.
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

/// Channels of some lights, most important first.
struct Coloring {
    std::vector<int> channel;              ///< by light; -1: none
    std::vector<std::vector<int>> holders; ///< by light without channel: the lights with the four channels
    std::size_t overflow = 0;              ///< lights without channel
};

/// Greedy colouring, important lights first, with the lowest free channel. If none is free, the light's connected
/// component is coloured again; if that fails, the light gets no channel.
Coloring colorLights(const std::vector<const Light*>& lights)
{
    const std::size_t n = lights.size();
    Graph graph(n, std::vector<bool>(n, false));
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) graph[i][j] = graph[j][i] = lightsOverlap(*lights[i], *lights[j]);
    }
    Coloring result;
    result.holders.resize(n);
    std::vector<int>& color = result.channel;
    color.assign(n, -1);
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
        result.holders[std::size_t(i)].assign(holder.begin(), holder.end());
        ++result.overflow;
    }
    return result;
}

/// Shares of the scene's bright level at which the reach of lights without a range may end, smallest first. The first
/// share that leaves no light without channel is used. It bounds the light that leaks through walls beyond a reach.
constexpr std::array kReachShares = {1.0f / 320.0f, 1.0f / 160.0f, 1.0f / 80.0f, 1.0f / 40.0f, 1.0f / 20.0f};

bool hasNoRange(const Light& light)
{
    return light.type != LightType::Directional && light.rangeMeters <= 0.0f;
}

/// Points of a low-discrepancy sequence over the area of static objects.
std::vector<vec3> surfacePoints(const Scene& scene)
{
    struct Triangle {
        vec3 a, ab, ac;
        double areaBefore;
    };
    std::vector<Triangle> triangles;
    double area = 0.0;
    for (const Object& object : scene.objects) {
        if (!object.isStatic || object.mesh < 0) continue;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            const auto at = [&](std::size_t i) {
                return vec3(object.worldFromObject * vec4(part.positions[part.indices[i]], 1.0f));
            };
            for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
                const vec3 a = at(i);
                triangles.push_back({a, at(i + 1) - a, at(i + 2) - a, area});
                area += 0.5 * double(glm::length(glm::cross(triangles.back().ab, triangles.back().ac)));
            }
        }
    }
    std::vector<vec3> points;
    if (!(area > 0.0)) return points;
    constexpr int kPoints = 4096; // a few per cent of error in the level of the light
    for (int i = 0; i < kPoints; ++i) {
        // Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": R3.
        const glm::dvec3 u =
            glm::fract(0.5 + double(i) * glm::dvec3(0.8191725133961645, 0.6710436067037893, 0.5497004779019703));
        const double place = u.x * area;
        const auto after = std::upper_bound(triangles.begin(), triangles.end(), place,
                                            [](double p, const Triangle& t) { return p < t.areaBefore; });
        const Triangle& t = *(after - 1);
        const float root = std::sqrt(float(u.y));
        points.push_back(t.a + root * ((1.0f - float(u.z)) * t.ab + float(u.z) * t.ac));
    }
    return points;
}

/// Unoccluded illuminance in lux. Distances below 1 m count as 1 m, so that a lamp's housing does not set the level.
float illuminanceAt(const Light& light, vec3 point)
{
    const vec3 away = point - light.position();
    const float distance = std::max(glm::length(away), 1.0f);
    float attenuation = shading::distanceAttenuation(distance, light.rangeMeters);
    if (light.type == LightType::Spot) {
        const vec2 cone = shading::spotConstants(light.innerConeRadians, light.outerConeRadians);
        attenuation *= shading::spotAttenuation(glm::dot(away, light.direction()) / distance, cone);
    }
    if (isAreaLight(light.type)) attenuation *= std::max(glm::dot(away, light.direction()) / distance, 0.0f);
    return luminance(light.color) * light.intensity * light.area() * attenuation;
}

/// The level of the light, in the mean over the light: leaks are visible relative to it.
float brightLevel(std::span<const float> levels)
{
    double light = 0.0;
    double squares = 0.0;
    for (const float level : levels) {
        light += double(level);
        squares += double(level) * double(level);
    }
    return light > 0.0 ? float(squares / light) : 0.0f;
}

/// For each light without a range, sqrt(I / E) in metres, with E the bright level of all other point and spot lights.
/// At sqrt(I / E) / sqrt(share) its illuminance I / d² is that share of E. Sun and sky do not count, since a sun may be
/// dimmed at run time. Infinite without other lights.
std::vector<float> levelDistances(const Scene& scene, const std::vector<const Light*>& lights)
{
    const std::vector<vec3> points = surfacePoints(scene);
    std::vector<float> total(points.size(), 0.0f);
    for (const Light& light : scene.lights) {
        if (light.type == LightType::Directional) continue;
        for (std::size_t p = 0; p < points.size(); ++p) total[p] += illuminanceAt(light, points[p]);
    }
    std::vector<float> distances(lights.size(), kInfinity);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (!hasNoRange(*lights[i])) continue;
        std::vector<float> others(points.size());
        for (std::size_t p = 0; p < points.size(); ++p)
            others[p] = std::max(total[p] - illuminanceAt(*lights[i], points[p]), 0.0f);
        const float level = brightLevel(others);
        const float candela = luminance(lights[i]->color) * lights[i]->intensity * lights[i]->area();
        if (level > 0.0f && candela > 0.0f) distances[i] = std::sqrt(candela / level);
    }
    return distances;
}

/// Colours lights. If some get no channel, lights without a range get the longest effective reach that helps.
Coloring colorWithinReach(const Scene& scene, const std::vector<Light*>& mixed)
{
    const std::vector<const Light*> lights(mixed.begin(), mixed.end());
    Coloring best = colorLights(lights);
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
        Coloring coloring = colorLights(lights);
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

/// Why a light is fully baked, and the cure. No range helps against four directional lights, which reach everything.
std::string overflowReason(const Light& light, const std::vector<const Light*>& holders)
{
    std::vector<std::string> names;
    std::vector<std::string> limitless;
    std::vector<std::string> limited;
    for (const Light* holder : holders) {
        names.push_back(holder->name);
        if (holder->type != LightType::Directional) (hasNoRange(*holder) ? limitless : limited).push_back(holder->name);
    }
    const std::string text = "overlaps four other mixed lights that hold all shadowmask channels (" + listOf(names) +
                             "), so it is fully baked; ";
    if (limitless.empty() && limited.empty())
        return text + "these are directional and reach everything: make one of them realtime or baked";
    if (hasNoRange(light)) limitless.insert(limitless.begin(), light.name);
    if (limitless.empty())
        return text + "shorter ranges, until it overlaps one less of " + listOf(limited) + ", free it";
    return text + "give " + listOf(limitless) +
           " a range (halflight_range, or range of KHR_lights_punctual): without " +
           (limitless.size() == 1 ? "one it reaches" : "one they reach") + " everything";
}

void assignShadowmask(Scene& scene, std::vector<int> mixed)
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
    const Coloring coloring = colorWithinReach(scene, lights);
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

void limitBounces(Scene& scene, const IntegrationSettings& settings)
{
    if (settings.bounces > 0) return;
    for (Light& light : scene.lights) light.baking.atBake.indirectMultiplier = 0.0f;
}

} // namespace halflight
