#include "bake/lights/overlaps.h"

#include "halflight/base/cone.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace halflight {
namespace {

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

} // namespace

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

Graph overlapsOf(const std::vector<const Light*>& lights)
{
    const std::size_t n = lights.size();
    std::vector<float> least(n);
    std::vector<float> most(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Reach reach = reachOf(*lights[i]);
        least[i] = reach.center.x - reach.radius;
        most[i] = reach.center.x + reach.radius;
    }
    std::vector<int> alongX(n);
    std::iota(alongX.begin(), alongX.end(), 0);
    std::sort(alongX.begin(), alongX.end(),
              [&](int a, int b) { return least[std::size_t(a)] < least[std::size_t(b)]; });
    Graph graph(n);
    for (auto a = alongX.begin(); a != alongX.end(); ++a) {
        for (auto b = a + 1; b != alongX.end() && least[std::size_t(*b)] <= most[std::size_t(*a)]; ++b) {
            if (!lightsOverlap(*lights[std::size_t(*a)], *lights[std::size_t(*b)])) continue;
            graph[std::size_t(*a)].push_back(*b);
            graph[std::size_t(*b)].push_back(*a);
        }
    }
    for (std::vector<int>& others : graph) std::sort(others.begin(), others.end());
    return graph;
}

} // namespace halflight
