#include "halflight/scene/turning_lights.h"

#include "halflight/base/mathematics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace halflight {
namespace {

/// What a weight costs, over the square of its direction's distance. Beside a day's arc the nearest directions share
/// the weight, though mornings and evenings would add up to the direction exactly. Between neighbours 20 degrees apart
/// it takes 0.06 % of the light.
constexpr double kCost = 0.02;
/// Of the nearest direction where a light is turned away from all: invisible, but the weights still say its colour.
constexpr float kLeastWeight = 1.0e-6f;
/// Of a Gram matrix's determinant: directions in one plane, or equal.
constexpr double kSingular = 1.0e-9;

double costOf(const dvec3& direction, const dvec3& target)
{
    return kCost * glm::dot(direction - target, direction - target);
}

/// Some of the directions, ascending, and their weights.
struct Blend {
    std::array<std::size_t, 3> of{};
    std::size_t count = 0;
    dvec3 weights{0.0};
};

/// The minimum over these directions' weights of either sign; nothing where they are not independent.
std::optional<dvec3> stationary(std::span<const vec3> directions, const Blend& blend, const dvec3& target)
{
    glm::dmat3 gram(1.0);
    dvec3 right(0.0);
    for (std::size_t i = 0; i < blend.count; ++i) {
        const dvec3 own(directions[blend.of[i]]);
        right[int(i)] = glm::dot(own, target) - costOf(own, target);
        for (std::size_t j = 0; j < blend.count; ++j)
            gram[int(i)][int(j)] = glm::dot(own, dvec3(directions[blend.of[j]]));
    }
    if (std::abs(glm::determinant(gram)) < kSingular) return std::nullopt;
    return glm::inverse(gram) * right;
}

double objective(std::span<const vec3> directions, const Blend& blend, const dvec3& target)
{
    dvec3 sum = -target;
    double cost = 0.0;
    for (std::size_t i = 0; i < blend.count; ++i) {
        sum += blend.weights[int(i)] * dvec3(directions[blend.of[i]]);
        cost += costOf(dvec3(directions[blend.of[i]]), target) * blend.weights[int(i)];
    }
    return 0.5 * glm::dot(sum, sum) + cost;
}

/// Tries all sets of one to three directions that begin with `blend`: a minimum needs no more (Caratheodory).
void search(std::span<const vec3> directions, const dvec3& target, const Blend& blend, Blend& best, double& least)
{
    const std::size_t first = blend.count == 0 ? 0 : blend.of[blend.count - 1] + 1;
    for (std::size_t i = first; i < directions.size(); ++i) {
        Blend next = blend;
        next.of[next.count++] = i;
        if (const auto weights = stationary(directions, next, target)) {
            next.weights = *weights;
            bool positive = true;
            for (std::size_t k = 0; k < next.count; ++k) positive = positive && next.weights[int(k)] >= 0.0;
            if (const double value = objective(directions, next, target); positive && value < least) {
                best = next;
                least = value;
            }
        }
        if (next.count < 3) search(directions, target, next, best, least);
    }
}

float angleBetween(vec3 a, vec3 b)
{
    return math::acos(std::clamp(glm::dot(a, b), -1.0f, 1.0f));
}

std::size_t nearestOf(std::span<const vec3> directions, vec3 direction)
{
    const auto nearer = [&](vec3 a, vec3 b) { return glm::dot(a, direction) < glm::dot(b, direction); };
    return std::size_t(std::ranges::max_element(directions, nearer) - directions.begin());
}

std::string degrees(float radians)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g degrees", double(glm::degrees(radians)));
    return text.data();
}

} // namespace

std::vector<float> weightsOfDirections(std::span<const vec3> directions, vec3 direction)
{
    std::vector<float> weights(directions.size(), 0.0f);
    if (directions.empty()) return weights;
    Blend best;
    double least = std::numeric_limits<double>::max();
    search(directions, dvec3(direction), {}, best, least);
    for (std::size_t i = 0; i < best.count; ++i) weights[best.of[i]] = float(best.weights[int(i)]);
    float& nearest = weights[nearestOf(directions, direction)];
    nearest = std::max(nearest, kLeastWeight);
    return weights;
}

std::string nameOfDirection(const std::string& light, std::size_t index)
{
    return light + "." + std::to_string(index + 1);
}

float largestStep(std::span<const vec3> directions)
{
    std::vector<vec3> left(directions.begin(), directions.end());
    if (left.empty()) return 0.0f;
    std::vector<vec3> reached = {left.back()};
    left.pop_back();
    float largest = 0.0f;
    while (!left.empty()) { // Prim 1957, "Shortest Connection Networks and Some Generalizations"
        const auto farther = [&](vec3 a, vec3 b) { return angleToNearest(reached, a) < angleToNearest(reached, b); };
        const auto next = std::ranges::min_element(left, farther);
        largest = std::max(largest, angleToNearest(reached, *next));
        reached.push_back(*next);
        left.erase(next);
    }
    return largest;
}

float angleToNearest(std::span<const vec3> directions, vec3 direction)
{
    return directions.empty() ? 0.0f : angleBetween(directions[nearestOf(directions, direction)], direction);
}

std::vector<std::string> sparseDirections(const Light& light)
{
    std::vector<std::string> sentences;
    constexpr float kRounding = 1.0e-3f; // radians
    if (const float step = largestStep(light.directions); step > kMostStepRadians + kRounding)
        sentences.push_back("the directions of light \"" + light.name + "\" are up to " + degrees(step) +
                            " apart, so that its bounced light is off between them: halflight_directions at most 20 "
                            "degrees apart are right in the open, and 15 between walls");
    if (const float away = angleToNearest(light.directions, light.direction()); away > kMostStepRadians + kRounding)
        sentences.push_back("light \"" + light.name + "\" shines " + degrees(away) +
                            " away from the nearest of its halflight_directions: its bounced light is that of there, "
                            "dimmed");
    return sentences;
}

} // namespace halflight
