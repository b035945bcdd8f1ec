// What the sources of this folder ask of musl's internal header of this name, and of newlib's math_config.h. Written
// for this project: no long double, no exceptions, no errno, no directed rounding, no fused multiply-add. It leaves out
// halflight/base/mathematics.h and <cmath>, which take a compiler several times as long as one of these sources.
#pragma once

#include <bit>
#include <cfloat>
#include <cstdint>
#include <limits>
#ifndef __GNUC__
#include <cmath>
#endif

#ifdef __FAST_MATH__
#error "these functions give the same bits with exact arithmetic alone: no -ffast-math"
#endif
// GCC takes -ffp-contract=off from cmake/HalflightModule.cmake.
#if defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract(off)
#elif defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#ifndef INFINITY
#define INFINITY std::numeric_limits<float>::infinity()
#endif
#ifndef M_PI_2
#define M_PI_2 1.57079632679489661923
#endif
#define WANT_ROUNDING 1
#define TOINT_INTRINSICS 0
#define FORCE_EVAL(x) ((void)0)
#define issignaling_inline(x) 0
#define issignalingf_inline(x) 0
#define EXTRACT_WORDS(hi, lo, d) ((hi) = uint32_t(asuint64(d) >> 32), (lo) = uint32_t(asuint64(d)))
#define GET_HIGH_WORD(hi, d) ((hi) = uint32_t(asuint64(d) >> 32))
#define GET_LOW_WORD(lo, d) ((lo) = uint32_t(asuint64(d)))
#define SET_HIGH_WORD(d, hi) ((d) = asdouble((uint64_t(hi) << 32) | uint32_t(asuint64(d))))
#define SET_LOW_WORD(d, lo) ((d) = asdouble((asuint64(d) & 0xffffffff00000000) | uint32_t(lo)))
#define GET_FLOAT_WORD(w, d) ((w) = asuint(d))
#define SET_FLOAT_WORD(d, w) ((d) = asfloat(w))
#ifdef __GNUC__
#define predict_true(x) __builtin_expect(!!(x), 1)
#define predict_false(x) __builtin_expect(!!(x), 0)
#else
#define predict_true(x) (x)
#define predict_false(x) (x)
#endif

namespace halflight::math {

static_assert(FLT_EVAL_METHOD == 0, "float and double are computed in their own precision: SSE2, not x87");
#ifdef __GNUC__
// The C library's exact functions.
inline float fabsf(float x)
{
    return __builtin_fabsf(x);
}
inline double fabs(double x)
{
    return __builtin_fabs(x);
}
inline float sqrtf(float x)
{
    return __builtin_sqrtf(x);
}
inline double sqrt(double x)
{
    return __builtin_sqrt(x);
}
inline double floor(double x)
{
    return __builtin_floor(x);
}
inline double ldexp(double x, int exponent)
{
    return __builtin_ldexp(x, exponent);
}
inline bool isnan(float x)
{
    return __builtin_isnan(x);
}
inline bool isnan(double x)
{
    return __builtin_isnan(x);
}
#else
using std::isnan;
#endif
using float_t = float;
using double_t = double;

inline uint32_t asuint(float x)
{
    return std::bit_cast<uint32_t>(x);
}
inline float asfloat(uint32_t x)
{
    return std::bit_cast<float>(x);
}
inline uint64_t asuint64(double x)
{
    return std::bit_cast<uint64_t>(x);
}
inline double asdouble(uint64_t x)
{
    return std::bit_cast<double>(x);
}
inline float eval_as_float(float x)
{
    return x;
}
inline double eval_as_double(double x)
{
    return x;
}
inline double fp_barrier(double x)
{
    return x;
}
inline float fp_barrierf(float x)
{
    return x;
}
inline void fp_force_eval(double) {}
inline void force_eval_float(double) {}

/// Results out of range: `sign` is not 0 where they are negative.
inline double math_oflow(uint32_t sign)
{
    return sign ? -INFINITY : INFINITY;
}
inline double math_uflow(uint32_t sign)
{
    return sign ? -0.0 : 0.0;
}
inline double math_divzero(uint32_t sign)
{
    return math_oflow(sign);
}
inline double math_invalid(double x)
{
    return (x - x) / (x - x);
}
inline float math_oflowf(uint32_t sign)
{
    return sign ? -INFINITY : INFINITY;
}
inline float math_uflowf(uint32_t sign)
{
    return sign ? -0.0f : 0.0f;
}
inline float math_divzerof(uint32_t sign)
{
    return math_oflowf(sign);
}
inline float math_invalidf(float x)
{
    return (x - x) / (x - x);
}

float atan(float x);
double atan(double x);
int rem_pio2_large(double* x, double* y, int e0, int nx, int prec);
int rem_pio2(double x, double* y);
double k_sin(double x, double y, int iy);
double k_cos(double x, double y);
int rem_pio2f(float x, double* y);
float k_tanf(double x, int odd);

} // namespace halflight::math
