#pragma once
// Shadow rays shared among many lights.

#include <cassert>
#include <cstddef>
#include <span>

namespace halflight {

/// Shares shadow rays among lights. Up to `most` lights get `each` rays. More lights share `most * each` rays in
/// proportion to their weights: those of light. Calls visit(index, rays, scale) for lights that get some; the mean over
/// a light's rays times `scale` is its estimate. Estimates have the right expectation if every light that gives
/// something has a positive weight. Systematic sampling: `u`, from 0 to below 1, is the only random number (Madow 1949,
/// "On the Theory of Systematic Sampling, II").
template<typename Visit>
void shareRays(std::span<const float> weights, int each, std::size_t most, float u, const Visit& visit)
{
    assert(each > 0 && most > 0);
    if (weights.size() <= most) {
        for (std::size_t i = 0; i < weights.size(); ++i) visit(i, each, 1.0f);
        return;
    }
    double total = 0.0;
    for (const float weight : weights) total += double(weight);
    if (!(total > 0.0)) return;
    const double perRay = total / (double(most) * double(each));
    double next = double(u) * perRay;
    double sum = 0.0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        sum += double(weights[i]);
        int rays = 0;
        for (; next < sum; next += perRay) ++rays;
        // Lights with a ray or more for sure are estimated by their own rays alone.
        if (rays > 0) visit(i, rays, double(weights[i]) < perRay ? float(perRay / double(weights[i])) : 1.0f);
    }
}

} // namespace halflight
