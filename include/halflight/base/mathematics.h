#pragma once
// The functions of the maths library that are not exact, with one implementation. Those of C libraries differ in last
// bits between systems, versions and processors; these give the same bits on every system and with every compiler.
// Names are GLSL's, so that the shading headers call the same ones. Exact functions (sqrt, floor, fmod, ldexp) are the
// C library's.
//
// The comments give the largest error in units in the last place (ulp) of the result; 0.5 is the best possible. For
// float functions of one argument it was measured at all floats of ordinary size, else at a million arguments or more.
// tests/base/mathematics_test.cpp holds them to it. Arguments outside a domain give NaN, poles infinity,
// results beyond the largest number infinity, as in IEEE 754. Which NaN is not said.
//
// The code in src/base/mathematics comes from musl 1.2.3 and newlib 3.3.0, which took it from FreeBSD (Sun) and from
// Arm's optimized routines.

#include "halflight/base/math.h"

namespace halflight::math {

float sin(float radians);   ///< 0.57 ulp; finite numbers. Arm.
double sin(double radians); ///< 0.8 ulp; finite numbers. FreeBSD.
float cos(float radians);   ///< 0.78 ulp; finite numbers. Arm.
double cos(double radians); ///< 0.8 ulp; finite numbers. FreeBSD.
float tan(float radians);   ///< 0.81 ulp; finite numbers. FreeBSD.

float acos(float x);   ///< In 0…pi. 0.92 ulp; -1…1. FreeBSD.
double acos(double x); ///< In 0…pi. 0.92 ulp; -1…1. FreeBSD.
float atan(float x);   ///< In -pi/2…pi/2. 0.86 ulp; all numbers. FreeBSD.
double atan(double x); ///< In -pi/2…pi/2. 0.86 ulp; all numbers. FreeBSD.
/// Angle of the point (x, y), in -pi…pi; C's atan2. 1.5 ulp; all numbers, 0 at the origin. FreeBSD.
float atan(float y, float x);
double atan(double y, double x);

float exp(float x);     ///< 0.51 ulp; all numbers. Arm.
float exp2(float x);    ///< 0.51 ulp; all numbers. Arm.
double exp2(double x);  ///< 0.51 ulp; all numbers. Arm.
float log2(float x);    ///< 0.76 ulp; from 0 on. Arm.
double log2(double x);  ///< 0.55 ulp; from 0 on. Arm.
double log10(double x); ///< 0.7 ulp; from 0 on. FreeBSD.
/// x to the power of y. 0.82 ulp (float), 0.53 ulp (double); x from 0 on, or whole y. Arm.
float pow(float x, float y);
double pow(double x, double y);
float cbrt(float x);   ///< Cube root. 0.501 ulp; all numbers. FreeBSD.
double cbrt(double x); ///< Cube root. 0.67 ulp; all numbers. FreeBSD.

inline vec3 log2(vec3 x)
{
    return {log2(x.x), log2(x.y), log2(x.z)};
}
inline vec3 pow(vec3 x, vec3 y)
{
    return {pow(x.x, y.x), pow(x.y, y.y), pow(x.z, y.z)};
}

} // namespace halflight::math
