#pragma once
// The functions of base/mathematics.h with arguments, for tests: those of one argument and of two, float and double.

#include "halflight/base/mathematics.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

namespace halflight::test {

template<class T> using Bits = std::conditional_t<sizeof(T) == 4, uint32_t, uint64_t>;

template<class T> struct Function {
    const char* name;
    T (*one)(T) = nullptr;
    T (*two)(T, T) = nullptr;
    long double (*truthOfOne)(long double) = nullptr;
    long double (*truthOfTwo)(long double, long double) = nullptr;
    double ulp = 0.5; ///< the largest error that mathematics.h allows

    T operator()(T x, T y) const { return one != nullptr ? one(x) : two(x, y); }
    long double truth(long double x, long double y) const
    {
        return truthOfOne != nullptr ? truthOfOne(x) : truthOfTwo(x, y);
    }
};

inline const std::vector<Function<float>>& floatFunctions()
{
    static const std::vector<Function<float>> all = {
        {"sin", math::sin, nullptr, std::sin, nullptr, 0.57},
        {"cos", math::cos, nullptr, std::cos, nullptr, 0.78},
        {"tan", math::tan, nullptr, std::tan, nullptr, 0.81},
        {"acos", math::acos, nullptr, std::acos, nullptr, 0.92},
        {"atan", math::atan, nullptr, std::atan, nullptr, 0.86},
        {"exp", math::exp, nullptr, std::exp, nullptr, 0.51},
        {"exp2", math::exp2, nullptr, std::exp2, nullptr, 0.51},
        {"log2", math::log2, nullptr, std::log2, nullptr, 0.76},
        {"cbrt", math::cbrt, nullptr, std::cbrt, nullptr, 0.501},
        {"atan2", nullptr, math::atan, nullptr, std::atan2, 1.5},
        {"pow", nullptr, math::pow, nullptr, std::pow, 0.82},
    };
    return all;
}

inline const std::vector<Function<double>>& doubleFunctions()
{
    static const std::vector<Function<double>> all = {
        {"sin", math::sin, nullptr, std::sin, nullptr, 0.8},
        {"cos", math::cos, nullptr, std::cos, nullptr, 0.8},
        {"acos", math::acos, nullptr, std::acos, nullptr, 0.92},
        {"atan", math::atan, nullptr, std::atan, nullptr, 0.86},
        {"exp2", math::exp2, nullptr, std::exp2, nullptr, 0.51},
        {"log2", math::log2, nullptr, std::log2, nullptr, 0.55},
        {"log10", math::log10, nullptr, std::log10, nullptr, 0.7},
        {"cbrt", math::cbrt, nullptr, std::cbrt, nullptr, 0.67},
        {"atan2", nullptr, math::atan, nullptr, std::atan2, 1.5},
        {"pow", nullptr, math::pow, nullptr, std::pow, 0.53},
    };
    return all;
}

/// Bits of a number; all NaNs are one.
template<class T> Bits<T> bitsOf(T x)
{
    return std::bit_cast<Bits<T>>(std::isnan(x) ? std::numeric_limits<T>::quiet_NaN() : x);
}

/// A number of any sign, size and kind: a quarter of them any bits, others in -1…1, in -20…20, and of 60 powers of two.
template<class T> T anyNumber(std::mt19937_64& random, int kind)
{
    const uint64_t bits = random();
    if (kind == 0) return std::bit_cast<T>(Bits<T>(bits));
    const double unit = std::ldexp(double(bits >> 11), -52) - 1.0;
    if (kind == 1) return T(unit);
    if (kind == 2) return T(20.0 * unit);
    return T(std::ldexp(unit, int(bits % 60) - 30));
}

/// 100,000 pairs of arguments, the same on each system. A function of one argument reads the first.
template<class T> std::vector<std::array<T, 2>> manyArguments()
{
    std::mt19937_64 random(58);
    std::vector<std::array<T, 2>> pairs(100000);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        pairs[i] = {anyNumber<T>(random, int(i % 4)), anyNumber<T>(random, int(i / 4 % 4))};
        if (i % 3 != 0) pairs[i][0] = std::abs(pairs[i][0]); // what logarithms and powers are made of
    }
    return pairs;
}

/// Zeros, infinities, NaN, the largest and smallest numbers, and ordinary ones.
template<class T> const std::vector<T>& someArguments()
{
    using Limits = std::numeric_limits<T>;
    static const std::vector<T> all = {
        T(0),
        T(-0.0),
        T(1),
        T(-1),
        Limits::infinity(),
        -Limits::infinity(),
        Limits::quiet_NaN(),
        Limits::max(),
        Limits::min(),
        Limits::denorm_min(),
        T(0.5),
        T(-0.5),
        T(0.999),
        T(2),
        T(3),
        T(-7.25),
        T(0.1),
        T(1e-6),
        T(3.14159265358979),
        T(1.5707963267949),
        T(100),
        T(-150),
        T(1e10),
        T(1e22),
    };
    return all;
}

} // namespace halflight::test
