#pragma once
// Vector and matrix types for the whole project: GLM, float, column vectors, right-handed, Y up (glTF's conventions).
// Names of transforms read right to left: pWorld = worldFromObject * pObject.

#ifndef GLM_FORCE_DEPTH_ZERO_TO_ONE
#define GLM_FORCE_DEPTH_ZERO_TO_ONE // Vulkan clip space
#endif
#ifndef GLM_ENABLE_EXPERIMENTAL
#define GLM_ENABLE_EXPERIMENTAL
#endif
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_precision.hpp>

#include <limits>

namespace halflight {

using glm::dmat4;
using glm::dvec3;
using glm::ivec2;
using glm::ivec3;
using glm::ivec4;
using glm::mat2;
using glm::mat3;
using glm::mat4;
using glm::quat;
using glm::u16vec4;
using glm::u8vec4;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Axis-aligned box. A default-constructed one is empty: extend() it.
struct Bounds {
    vec3 min{kInfinity};
    vec3 max{-kInfinity};

    void extend(vec3 point)
    {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
    void extend(const Bounds& other)
    {
        min = glm::min(min, other.min);
        max = glm::max(max, other.max);
    }
    [[nodiscard]] bool empty() const { return min.x > max.x; }
    [[nodiscard]] vec3 center() const { return 0.5f * (min + max); }
    [[nodiscard]] vec3 size() const { return empty() ? vec3(0.0f) : max - min; }
};

/// z of the cross product: the signed area of the parallelogram.
inline float cross2(vec2 a, vec2 b)
{
    return a.x * b.y - a.y * b.x;
}

/// CIE luminance of a linear Rec. 709 colour (ITU-R BT.709, section 3).
inline float luminance(vec3 linearRgb)
{
    return glm::dot(linearRgb, vec3(0.2126f, 0.7152f, 0.0722f));
}

} // namespace halflight
