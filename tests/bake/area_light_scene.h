#pragma once
// Area lights of tests, and their light by brute force: the light in small pieces, without the formulas of the library.

#include "bake/test_scene.h"

#include <algorithm>
#include <cmath>

namespace halflight::test {

inline Light areaLight(LightType type, vec3 position, vec3 direction, vec2 size, float nits, LightMode mode)
{
    Light light = makeLight(type, position, direction, nits, mode);
    light.sizeMeters = size;
    return light;
}

/// Calls visit(point, direction from `from`, steradians) for side x side pieces of the light's front.
template<typename Visit> void forPieces(const Light& light, vec3 from, int side, const Visit& visit)
{
    const double width = double(light.sizeMeters.x);
    const double height = light.type == LightType::Disk ? width : double(light.sizeMeters.y);
    const auto axisX = glm::dvec3(light.worldFromLight[0]);
    const auto axisY = glm::dvec3(light.worldFromLight[1]);
    for (int i = 0; i < side * side; ++i) {
        const glm::dvec2 at = (glm::dvec2(i % side, i / side) + 0.5) / double(side) - 0.5;
        if (light.type == LightType::Disk && glm::length(at) > 0.5) continue;
        const glm::dvec3 point = glm::dvec3(light.position()) + at.x * width * axisX + at.y * height * axisY;
        const glm::dvec3 way = point - glm::dvec3(from);
        const double d = glm::length(way);
        const double cosine = -glm::dot(way, glm::dvec3(light.direction())) / d;
        if (cosine > 0.0) visit(vec3(point), vec3(way / d), cosine * width * height / (double(side * side) * d * d));
    }
}

/// Irradiance of the points of the light that `sees` returns true for.
template<typename Sees>
double irradianceByHand(const Light& light, vec3 position, vec3 normal, const Sees& sees, int side = 100)
{
    double sum = 0.0;
    forPieces(light, position, side, [&](vec3 point, vec3 direction, double solidAngle) {
        if (sees(point)) sum += std::max(double(glm::dot(normal, direction)), 0.0) * solidAngle;
    });
    return sum * double(light.intensity);
}
inline double irradianceByHand(const Light& light, vec3 position, vec3 normal)
{
    return irradianceByHand(light, position, normal, [](vec3) { return true; });
}

/// An emissive surface in place of an area light. It reflects nothing and throws no shadow.
inline void addEmissive(Scene& scene, const Light& light)
{
    const vec3 x = 2.0f * light.halfWidth();
    const vec3 y = 2.0f * light.halfHeight();
    addRectangle(scene, {light.position() - 0.5f * x - 0.5f * y, y, x},
                 addMaterial(scene, vec3(0.0f), light.color * light.intensity), 1);
    scene.objects.back().castShadows = false;
}

} // namespace halflight::test
