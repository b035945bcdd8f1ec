#include "bake/lights/light_levels.h"

#include "halflight/shading/light.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace halflight {
namespace {

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

} // namespace

bool hasNoRange(const Light& light)
{
    return light.type != LightType::Directional && light.rangeMeters <= 0.0f;
}

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

} // namespace halflight
