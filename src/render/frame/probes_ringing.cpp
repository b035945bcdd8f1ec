// Band-limited light rings: opposite a narrow bright light, L2 irradiance falls below zero. Sloan 2008, "Stupid
// Spherical Harmonics (SH) Tricks", windows the bands until it does not. Here the window is the one number that mixes
// the function with its own mean: for irradiance it keeps more of the light's direction than windows that fall off with
// the band, because band 2 is what lifts the far side (a point light keeps 86 % of band 1; the Laplacian window leaves
// it less than 60 %). It is found exactly from the function's minimum, and moves continuously with the coefficients.
#include "halflight/render/probes.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

using glm::dmat3;
using glm::dvec3;

/// Eigenvalues of a symmetric matrix and its eigenvectors as columns (Jacobi 1846, cyclic rotations).
struct Eigensystem {
    dvec3 values{0.0};
    dmat3 vectors{1.0};
};

Eigensystem eigenOf(dmat3 m)
{
    Eigensystem result;
    for (int sweep = 0; sweep < 12; ++sweep) {
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (m[p][q] == 0.0) continue;
                const double theta = 0.5 * (m[q][q] - m[p][p]) / m[p][q];
                const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0);
                dmat3 rotation(1.0);
                rotation[p][p] = rotation[q][q] = c;
                rotation[q][p] = t * c;
                rotation[p][q] = -t * c;
                m = glm::transpose(rotation) * m * rotation;
                m[p][q] = m[q][p] = 0.0;
                result.vectors = result.vectors * rotation;
            }
        }
    }
    result.values = {m[0][0], m[1][1], m[2][2]};
    return result;
}

/// A lower bound, tight to a part in 10^9, of n·A·n + b·n over unit vectors n: the maximum of the dual problem
/// −μ − b·(A + μ)⁻¹·b/4 over μ > −(least eigenvalue), whose derivative falls and is 0 where |(A + μ)⁻¹ b| = 2 (Moré and
/// Sorensen 1983, "Computing a Trust Region Step").
double minimumOnSphere(const dmat3& a, const dvec3& b)
{
    const Eigensystem eigen = eigenOf(a);
    const dvec3 beta = b * eigen.vectors; // in the eigenvectors' basis
    const double least = std::min({eigen.values.x, eigen.values.y, eigen.values.z});
    const double length = glm::length(b);
    double low = -least + 1.0e-10 * std::max(length, std::abs(least));
    double high = std::max(low, -least + 0.5 * length);
    for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (low + high);
        const dvec3 step = beta / (eigen.values + middle);
        (glm::dot(step, step) > 4.0 ? low : high) = middle;
    }
    return -high - 0.25 * glm::dot(beta, beta / (eigen.values + high));
}

} // namespace

SphericalHarmonicsL2 withoutRinging(const SphericalHarmonicsL2& radiance)
{
    SphericalHarmonicsL2 result = radiance;
    for (int channel = 0; channel < 3; ++channel) {
        // Irradiance as mean + b·n + n·A·n; the basis functions of band 1 are y, z, x.
        std::array<double, 9> c{};
        for (int i = 0; i < 9; ++i)
            c[std::size_t(i)] = double(radiance[std::size_t(i)][channel]) * double(shading::shCosineLobe(i));
        const double mean = 0.282094792 * c[0];
        const dvec3 b = 0.488602512 * dvec3(c[3], c[1], c[2]);
        const double xy = 0.5 * 1.092548431 * c[4];
        const double yz = 0.5 * 1.092548431 * c[5];
        const double xz = 0.5 * 1.092548431 * c[7];
        const double zz = 0.315391565 * c[6];
        const double xx = 0.546274215 * c[8];
        const dmat3 a(-zz + xx, xy, xz, xy, -zz - xx, yz, xz, yz, 2.0 * zz);

        // Most probes are nowhere near: no eigenvalue of a matrix without trace lies below −√(2/3) of its norm.
        const double norm = std::sqrt(glm::dot(a[0], a[0]) + glm::dot(a[1], a[1]) + glm::dot(a[2], a[2]));
        if (mean - glm::length(b) - 0.8165 * norm >= 0.0) continue;
        const double least = minimumOnSphere(a, b);
        if (!(least < 0.0) || mean + least >= 0.0) continue;
        const double window = std::max(mean, 0.0) / -least * (1.0 - 1.0e-6); // and rounding to float does no harm
        for (std::size_t i = 1; i < 9; ++i) result[i][channel] = float(window * double(radiance[i][channel]));
    }
    return result;
}

} // namespace halflight
