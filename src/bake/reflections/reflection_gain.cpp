#include "bake/reflections/reflection_gain.h"

#include "bake/reflections/reflections.h"
#include "halflight/base/image_filter.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/reflection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace halflight {
namespace {

/// No probe is added that takes less than this share off the error without probes: below lie the paths' noise and
/// what nobody sees.
constexpr double kLeastGainOfProbe = 0.005;
/// Two fades are tried: the probe's own, within a wall, and so many times it, where nothing marks the box's end.
constexpr float kWideFade = 4.0f;
constexpr std::size_t kFades = 2;

/// A probe at a point that it covers.
struct Served {
    uint32_t point = 0;
    std::array<float, kFades> coverage{}; ///< by fade
    float expected = 0.0f;                ///< luminance of the roughest lobe about the normal
    std::vector<float> light;             ///< luminance that it sends to each view
};

/// The picture's radiance about a direction, as shaders/reflections.glsl has it.
vec3 lookUp(const ReflectionPicture& picture, const SpecularPoint& point, const mat4& boxFromWorld, vec3 direction,
            float roughness)
{
    const int size = picture.tile->width();
    const vec3 boxPosition(boxFromWorld * vec4(point.position, 1.0f));
    const vec4 at = shading::lookUpReflection(point.position, direction, boxPosition, mat3(boxFromWorld) * direction,
                                              picture.probe.position, roughness);
    const float level = shading::reflectionLevel(at.w);
    const int low = std::min(int(level), shading::kReflectionLevels - 2);
    const auto of = [&](int l) { return bilinear(*picture.tile, shading::reflectionTexel(size, l, vec3(at))); };
    return glm::mix(of(low), of(low + 1), level - float(low));
}

/// `fades`: metres, one for each coverage; the rest is 0.
std::vector<Served> servedBy(const ReflectionPicture& picture, std::span<const SpecularPoint> points,
                             std::span<const float> fades)
{
    const mat4& box = picture.probe.worldFromBox;
    const mat4 boxFromWorld = glm::inverse(box);
    const vec3 halfSize(glm::length(vec3(box[0])), glm::length(vec3(box[1])), glm::length(vec3(box[2])));
    std::vector<Served> result;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const SpecularPoint& point = points[k];
        Served served;
        served.point = uint32_t(k);
        float most = 0.0f;
        for (std::size_t f = 0; f < fades.size(); ++f) {
            const vec3 place(boxFromWorld * vec4(point.position, 1.0f));
            served.coverage[f] = shading::reflectionCoverage(place, halfSize, fades[f]);
            most = std::max(most, served.coverage[f]);
        }
        if (most <= 0.0f) continue;
        served.expected = luminance(lookUp(picture, point, boxFromWorld, point.normal, 1.0f));
        for (const SpecularView& view : point.views) {
            const vec3 mirror = glm::reflect(-view.direction, point.normal);
            served.light.push_back(
                luminance(view.share * lookUp(picture, point, boxFromWorld, mirror, point.roughness)));
        }
        result.push_back(std::move(served));
    }
    return result;
}

/// One probe in a point's blend.
struct Part {
    float volume = 0.0f; ///< of the probe's box
    float coverage = 0.0f;
    const Served* served = nullptr;
};

/// What a blend of probes makes of each view of a point: shading::reflectedSurroundings(), which is linear in light.
/// Nothing where they do not reach it.
std::vector<float> predicted(const SpecularPoint& point, std::span<const Part> blend)
{
    std::vector<float> light(point.views.size(), 0.0f);
    float expected = 0.0f;
    float left = 1.0f;
    float weights = 0.0f;
    for (const Part& part : blend) {
        const float weight = left * part.coverage;
        left -= weight;
        if (weight <= 0.0f) continue;
        weights += weight;
        expected += weight * part.served->expected;
        for (std::size_t v = 0; v < light.size(); ++v) light[v] += weight * part.served->light[v];
    }
    if (weights <= 1.0e-6f) return {};
    for (std::size_t v = 0; v < light.size(); ++v) {
        light[v] = shading::reflectedSurroundings(vec3(light[v] / weights), vec3(expected / weights), weights, 1.0f,
                                                  vec3(point.views[v].own), vec3(point.local), point.roughness)
                       .x;
    }
    return light;
}

ReflectionTrust trustAt(const SpecularPoint& point, const SpecularError& error, std::span<const float> light)
{
    ReflectionTrust trust{point.position, point.normal};
    for (std::size_t v = 0; v < light.size(); ++v) {
        const SpecularView& view = point.views[v];
        const float change = light[v] - view.own;
        const float weight = error.weight(view, std::max(light[v], view.own));
        trust.along += weight * (view.truth - view.own) * change;
        trust.total += weight * change * change;
    }
    return trust;
}

class GainChoice {
public:
    GainChoice(std::span<const SpecularPoint> points, std::span<const ReflectionPicture> pictures, bool trusting)
        : points_(points), pictures_(pictures), trusting_(trusting), error_(points), blends_(points.size()),
          errors_(points.size()), served_(pictures.size())
    {
        parallelFor(pictures.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) served_[i] = servedBy(pictures[i], points, fadesOf(i));
        });
        for (std::size_t k = 0; k < points.size(); ++k) {
            errors_[k] = errorAt(k, {});
            without_ += errors_[k];
        }
    }

    std::vector<ReflectionProbe> choose()
    {
        std::vector<std::pair<std::size_t, std::size_t>> chosen; // picture and fade
        std::vector<uint8_t> taken(pictures_.size(), 0);
        while (chosen.size() < ReflectionSet::kMost) {
            std::vector<double> gains(pictures_.size() * kFades, 0.0);
            parallelFor(gains.size(), 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    if (taken[i / kFades] == 0) gains[i] = std::max(0.0, gainOf(i / kFades, i % kFades));
            });
            const auto best = std::max_element(gains.begin(), gains.end());
            if (best == gains.end() || *best <= kLeastGainOfProbe * without_) break;
            const auto i = std::size_t(best - gains.begin());
            add(i / kFades, i % kFades);
            taken[i / kFades] = 1;
            chosen.emplace_back(i / kFades, i % kFades);
        }
        std::stable_sort(chosen.begin(), chosen.end(),
                         [&](auto a, auto b) { return volumeOf(a.first) < volumeOf(b.first); });
        std::vector<ReflectionProbe> probes;
        for (const auto& [picture, fade] : chosen) {
            probes.push_back(pictures_[picture].probe);
            probes.back().fadeMeters = fadesOf(picture)[fade];
        }
        return probes;
    }

    [[nodiscard]] bool areWorseWithAll()
    {
        for (std::size_t i = 0; i < pictures_.size(); ++i) add(i, kFades - 1);
        return std::accumulate(errors_.begin(), errors_.end(), 0.0) > (1.0 + kLeastGainOfProbe) * without_;
    }

private:
    [[nodiscard]] float volumeOf(std::size_t picture) const
    {
        return std::abs(glm::determinant(mat3(pictures_[picture].probe.worldFromBox)));
    }
    [[nodiscard]] std::array<float, kFades> fadesOf(std::size_t picture) const
    {
        const float narrow = pictures_[picture].probe.fadeMeters;
        return {kWideFade * narrow, narrow};
    }
    [[nodiscard]] double errorAt(std::size_t k, std::span<const Part> blend) const
    {
        const SpecularPoint& point = points_[k];
        std::vector<float> light = predicted(point, blend);
        float trust = 1.0f;
        if (trusting_ && !light.empty()) {
            const ReflectionTrust at = trustAt(point, error_, light);
            trust = at.total > 0.0f ? std::clamp(at.along / at.total, 0.0f, 1.0f) : 0.0f;
        }
        double sum = 0.0;
        for (std::size_t v = 0; v < point.views.size(); ++v) {
            const SpecularView& view = point.views[v];
            sum += double(error_.at(view, light.empty() ? view.own : glm::mix(view.own, light[v], trust)));
        }
        return sum / double(point.views.size());
    }
    [[nodiscard]] std::vector<Part> with(std::size_t k, const Part& added) const
    {
        std::vector<Part> blend = blends_[k];
        blend.insert(std::find_if(blend.begin(), blend.end(), [&](const Part& p) { return p.volume > added.volume; }),
                     added);
        return blend;
    }
    [[nodiscard]] double gainOf(std::size_t picture, std::size_t fade) const
    {
        double gain = 0.0;
        for (const Served& served : served_[picture]) {
            if (served.coverage[fade] <= 0.0f) continue;
            gain += errors_[served.point] -
                    errorAt(served.point, with(served.point, {volumeOf(picture), served.coverage[fade], &served}));
        }
        return gain;
    }
    void add(std::size_t picture, std::size_t fade)
    {
        for (const Served& served : served_[picture]) {
            if (served.coverage[fade] <= 0.0f) continue;
            blends_[served.point] = with(served.point, {volumeOf(picture), served.coverage[fade], &served});
            errors_[served.point] = errorAt(served.point, blends_[served.point]);
        }
    }

    std::span<const SpecularPoint> points_;
    std::span<const ReflectionPicture> pictures_;
    bool trusting_;
    SpecularError error_;
    std::vector<std::vector<Part>> blends_; ///< by point, of the probes chosen so far
    std::vector<double> errors_;            ///< by point
    double without_ = 0.0;
    std::vector<std::vector<Served>> served_; ///< by picture
};

} // namespace

std::vector<ReflectionProbe> chooseByGain(std::span<const SpecularPoint> points,
                                          std::span<const ReflectionPicture> pictures, bool trusting)
{
    return GainChoice(points, pictures, trusting).choose();
}

bool areWorseWith(std::span<const SpecularPoint> points, std::span<const ReflectionPicture> pictures, bool trusting)
{
    return GainChoice(points, pictures, trusting).areWorseWithAll();
}

std::vector<ReflectionTrust> trustOf(std::span<const SpecularPoint> points, std::span<const ReflectionPicture> pictures)
{
    const SpecularError error(points);
    std::vector<std::vector<Served>> served(pictures.size());
    std::vector<std::vector<Part>> blends(points.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        served[i] = servedBy(pictures[i], points, std::array{pictures[i].probe.fadeMeters});
        for (const Served& s : served[i]) blends[s.point].push_back({0.0f, s.coverage[0], &s});
    }
    std::vector<ReflectionTrust> result;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::vector<float> light = predicted(points[k], blends[k]);
        if (!light.empty()) result.push_back(trustAt(points[k], error, light));
    }
    return result;
}

} // namespace halflight
