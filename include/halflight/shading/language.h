// What lets the files of this folder compile as C++20 and as GLSL 4.60: they use GLSL's types and functions, literals
// end in f, arguments are passed by value, and a few words differ by language:
//   HL_FN         begins every function
//   HL_CONST      begins every constant
//   HL_CONST_FN   begins a function that constants can be made of
//   HL_INOUT(T)   an argument that is read and written
//   HL_FN_OF(T)   begins a function for any type T. In GLSL that is the name of one type, which the file that includes
//                 it has defined, with functions that the header names.
//   HL_IN(T)      an argument of such a type
// In C++ everything is in namespace halflight::shading; sin, pow and the like are those of base/mathematics.h. GLSL
// needs GL_GOOGLE_include_directive.
#ifndef HALFLIGHT_SHADING_LANGUAGE_H
#define HALFLIGHT_SHADING_LANGUAGE_H

#ifdef __cplusplus
#include "halflight/base/math.h"
#include "halflight/base/mathematics.h"

#include <bit>
#include <cstdint>

#define HL_FN inline
#define HL_CONST inline constexpr
#define HL_CONST_FN constexpr
#define HL_INOUT(T) T&
#define HL_FN_OF(T) template<typename T> inline
#define HL_IN(T) const T&
#define HL_NAMESPACE_BEGIN namespace halflight::shading {
#define HL_NAMESPACE_END }

namespace halflight::shading {
using uint = uint32_t;
using glm::abs;
using glm::ceil;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::floor;
using glm::inversesqrt;
using glm::length;
using glm::max;
using glm::min;
using glm::mix;
using glm::normalize;
using glm::reflect;
using glm::sqrt;
using math::acos;
using math::atan;
using math::cos;
using math::exp;
using math::exp2;
using math::log2;
using math::pow;
using math::sin;

inline int findLSB(uint x)
{
    return std::countr_zero(x);
}
} // namespace halflight::shading
#else
#define HL_FN
#define HL_CONST const
#define HL_CONST_FN
#define HL_INOUT(T) inout T
#define HL_FN_OF(T)
#define HL_IN(T) T
#define HL_NAMESPACE_BEGIN
#define HL_NAMESPACE_END
#endif

HL_NAMESPACE_BEGIN

HL_CONST float kShadingPi = 3.14159265358979323846f;

HL_FN float saturate(float x)
{
    return clamp(x, 0.0f, 1.0f);
}
HL_FN vec3 saturate(vec3 x)
{
    return clamp(x, vec3(0.0f), vec3(1.0f));
}
HL_FN float square(float x)
{
    return x * x;
}

HL_NAMESPACE_END

#endif
