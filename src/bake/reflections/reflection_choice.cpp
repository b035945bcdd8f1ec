// Which of many reflection probes a file gets.

#include "bake/reflections/reflections.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/reflection.h"

#include <algorithm>

namespace halflight {
namespace {

/// No probe is added that gains less than this share of what a probe at every place would be worth.
constexpr double kLeastGain = 0.04;
/// Most probes that are placed: 16 tiles of 128 texels are 1.5 MiB.
constexpr std::size_t kMostPlaced = 16;

/// Coverage of each place by the probe at each other one, as in the renderer's blend.
std::vector<std::vector<float>> coverageOf(std::span<const ReflectionProbe> probes)
{
    std::vector<std::vector<float>> coverage;
    for (const ReflectionProbe& from : probes) {
        const mat4& box = from.worldFromBox;
        const mat4 boxFromWorld = glm::inverse(box);
        const vec3 halfSize(glm::length(vec3(box[0])), glm::length(vec3(box[1])), glm::length(vec3(box[2])));
        std::vector<float>& row = coverage.emplace_back();
        for (const ReflectionProbe& to : probes) {
            const vec3 place(boxFromWorld * vec4(to.position, 1.0f));
            row.push_back(shading::reflectionCoverage(place, halfSize, from.fadeMeters));
        }
    }
    return coverage;
}

/// Chooses probes by what the renderer's blend of their probes is worth: a probe whose box holds another's hides it.
class PlaceChoice {
public:
    PlaceChoice(std::span<const ReflectionProbe> probes, std::vector<std::vector<float>> uses)
        : uses_(std::move(uses)), coverage_(coverageOf(probes))
    {
        for (const ReflectionProbe& probe : probes) volume_.push_back(glm::determinant(mat3(probe.worldFromBox)));
    }

    /// Adds the place that gains most, while one gains enough (Nemhauser, Wolsey and Fisher 1978, "An Analysis of
    /// Approximations for Maximizing Submodular Set Functions"). Small boxes come first.
    [[nodiscard]] std::vector<std::size_t> choose() const
    {
        std::vector<std::size_t> chosen;
        double most = 0.0; // if each place served itself
        for (std::size_t k = 0; k < uses_.size(); ++k) most += uses_[k][k];
        double worth = 0.0;
        while (chosen.size() < kMostPlaced) {
            std::vector<double> worthWith(uses_.size());
            parallelFor(uses_.size(), 8, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) worthWith[i] = worthOf(with(chosen, i));
            });
            const auto best = std::max_element(worthWith.begin(), worthWith.end());
            if (best == worthWith.end() || *best - worth <= kLeastGain * most) break;
            worth = *best;
            chosen = with(chosen, std::size_t(best - worthWith.begin()));
        }
        return chosen;
    }

private:
    [[nodiscard]] std::vector<std::size_t> with(std::vector<std::size_t> chosen, std::size_t place) const
    {
        const auto larger = std::find_if(chosen.begin(), chosen.end(),
                                         [&](std::size_t other) { return volume_[other] > volume_[place]; });
        chosen.insert(larger, place);
        return chosen;
    }
    [[nodiscard]] double worthOf(std::span<const std::size_t> chosen) const
    {
        double worth = 0.0;
        for (std::size_t k = 0; k < uses_.size(); ++k) {
            float left = 1.0f;
            float sum = 0.0f;
            float weights = 0.0f;
            for (const std::size_t i : chosen) {
                const float weight = left * coverage_[i][k];
                left -= weight;
                if (weight <= 0.0f) continue;
                sum += weight * uses_[i][k];
                weights += weight;
            }
            if (weights > 0.0f) worth += double(sum / weights);
        }
        return worth;
    }

    std::vector<std::vector<float>> uses_;     ///< by probe and place, as in chooseReflections()
    std::vector<std::vector<float>> coverage_; ///< by probe and place
    std::vector<float> volume_;                ///< of boxes, over that of the cube
};

} // namespace

std::vector<std::size_t> chooseReflections(std::span<const ReflectionProbe> probes,
                                           std::vector<std::vector<float>> uses)
{
    return PlaceChoice(probes, std::move(uses)).choose();
}

} // namespace halflight
