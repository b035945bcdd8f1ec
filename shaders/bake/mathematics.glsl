// Trigonometric functions, with errors of a few units of a float's last place. Vulkan allows its own to be off by 2^-11
// and more: the solid angle of a distant lamp would be noise. Polynomials: Moshier's Cephes library (single precision)
// and Sun's fdlibm (e_acosf.c). Shaders include this before the headers of halflight/shading.
#ifndef HALFLIGHT_BAKE_MATHEMATICS_GLSL
#define HALFLIGHT_BAKE_MATHEMATICS_GLSL

const float kHalfPi = 1.57079632679489661923;

// Sine for an even quarter, cosine for an odd one; `x` is at most pi / 4.
float sineOfQuarter(float x, int quarter)
{
    float z = x * x;
    float sine = ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1) * z * x + x;
    float cosine =
        ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2) * z * z - 0.5 * z + 1.0;
    float value = (quarter & 1) == 0 ? sine : cosine;
    return (quarter & 2) == 0 ? value : -value;
}
// Quarters of a turn in an angle of a few turns, and what is left: pi / 2 in three parts.
float quarterOf(float x, out int quarter)
{
    float n = floor(x * (1.0 / kHalfPi) + 0.5);
    quarter = int(n);
    return ((x - n * 1.5703125) - n * 4.837512969970703125e-4) - n * 7.54978995489188216e-8;
}
float exactSin(float x)
{
    int quarter;
    float rest = quarterOf(x, quarter);
    return sineOfQuarter(rest, quarter);
}
float exactCos(float x)
{
    int quarter;
    float rest = quarterOf(x, quarter);
    return sineOfQuarter(rest, quarter + 1);
}

// Of a number from 0 to 1.
float atanOfUnit(float x)
{
    bool large = x > 0.4142135623730950;
    float t = large ? (x - 1.0) / (x + 1.0) : x;
    float z = t * t;
    float small =
        (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * t + t;
    return large ? 0.5 * kHalfPi + small : small;
}
float exactAtan(float y, float x)
{
    float least = min(abs(x), abs(y));
    float most = max(abs(x), abs(y));
    float angle = most > 0.0 ? atanOfUnit(least / most) : 0.0;
    if (abs(y) > abs(x)) angle = kHalfPi - angle;
    if (x < 0.0) angle = 2.0 * kHalfPi - angle;
    return y < 0.0 ? -angle : angle;
}
float exactAtan(float x)
{
    return exactAtan(x, 1.0);
}

float exactAcos(float x)
{
    float a = abs(x);
    float z = a < 0.5 ? a * a : 0.5 - 0.5 * a;
    float r = z * (1.6666586697e-1 + z * (-4.2743422091e-2 - z * 8.6563630030e-3)) / (1.0 - 7.0662963390e-1 * z);
    if (a < 0.5) return kHalfPi - (x + x * r);
    float s = sqrt(z);
    float angle = 2.0 * (s + s * r);
    return x < 0.0 ? 2.0 * kHalfPi - angle : angle;
}

#define sin exactSin
#define cos exactCos
#define atan exactAtan
#define acos exactAcos

#endif
