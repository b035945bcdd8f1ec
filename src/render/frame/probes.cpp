// What the baked probes say at a point.
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/scene/sky_picture.h"
#include "halflight/shading/sh.h"
#include "halflight/shading/sky.h"
#include "render/frame/probes_mesh.h"

#include <algorithm>

namespace halflight {

/// The coefficients of a picture: a sum over its texels. Nine of them resolve no detail of a 1024th of a turn.
static std::array<vec3, 9> pictureRadiance(const ImageRgb32f& full, float rotation)
{
    const ImageRgb32f picture = reducedSkyPicture(full, 1024);
    const vec2 turn(math::cos(rotation), math::sin(rotation));
    const vec2 size(picture.size());
    std::array<glm::dvec3, 9> sum{};
    for (int y = 0; y < picture.height(); ++y) {
        const float steradians =
            2.0f * kPi / size.x * (math::cos(float(y) / size.y * kPi) - math::cos(float(y + 1) / size.y * kPi));
        for (int x = 0; x < picture.width(); ++x) {
            const vec3 direction = shading::skyPictureDirection((vec2(x, y) + 0.5f) / size, turn);
            for (int i = 0; i < 9; ++i)
                sum[std::size_t(i)] += glm::dvec3(picture(x, y) * (shading::shBasis(i, direction) * steradians));
        }
    }
    std::array<vec3, 9> radiance;
    std::copy(sum.begin(), sum.end(), radiance.begin());
    return radiance;
}

// The gradient sky is constant plus two clamped cosines: horizon + (zenith - horizon) max(y, 0) + (ground - horizon)
// max(-y, 0). The projection of a clamped cosine about an axis on basis function i is shIrradianceWeight(i, axis)
// (Ramamoorthi and Hanrahan 2001), so this is exact.
ProbeSample skyProbe(const Sky& sky)
{
    ProbeSample sample;
    if (sky.picture) {
        sample.radiance = pictureRadiance(*sky.picture, sky.rotationRadians);
        return sample;
    }
    sample.radiance[0] = sky.horizon * (4.0f * kPi * shading::shBasis(0, vec3(0, 1, 0)));
    for (int i = 0; i < 9; ++i) {
        sample.radiance[std::size_t(i)] += (sky.zenith - sky.horizon) * shading::shIrradianceWeight(i, vec3(0, 1, 0)) +
                                           (sky.ground - sky.horizon) * shading::shIrradianceWeight(i, vec3(0, -1, 0));
    }
    return sample;
}

ProbeInterpolator::ProbeInterpolator(const BakedScene& baked, ProbeOptions options)
    : mesh_(std::make_shared<const ProbeMesh>(baked)), options_(options)
{}

ProbeInterpolator ProbeInterpolator::withLight(std::span<const SphericalHarmonicsL2> radiance,
                                               const SphericalHarmonicsL2& sky) const
{
    auto light = std::make_shared<Light>();
    for (const uint32_t source : mesh_->sources()) light->radiance.push_back(radiance[source]);
    light->sky = sky;
    ProbeInterpolator other = *this;
    other.light_ = std::move(light);
    return other;
}

const SphericalHarmonicsL2& ProbeInterpolator::radianceOf(uint32_t place) const
{
    return light_ ? light_->radiance[place] : mesh_->probes()[place].radiance;
}

ProbeSample ProbeInterpolator::sample(vec3 position) const
{
    ProbeSample sum = mesh_->sky();
    if (light_) sum.radiance = light_->sky;
    if (!mesh_->empty()) {
        const ProbeWeights weights = mesh_->weights(position);
        // As the difference from the probe with the largest share: what all four agree on stays what it is to the bit,
        // a channel without a light exactly 1.
        const auto largest = std::max_element(weights.weights.begin(), weights.weights.end());
        const uint32_t basePlace = weights.probes[std::size_t(largest - weights.weights.begin())];
        const Probe& base = mesh_->probes()[basePlace];
        const SphericalHarmonicsL2& baseRadiance = radianceOf(basePlace);
        sum.radiance = baseRadiance;
        sum.occlusion = base.occlusion;
        for (std::size_t i = 0; i < 4; ++i) {
            const Probe& probe = mesh_->probes()[weights.probes[i]];
            if (&probe == &base || weights.weights[i] == 0.0f) continue;
            const SphericalHarmonicsL2& radiance = radianceOf(weights.probes[i]);
            for (std::size_t k = 0; k < 9; ++k) sum.radiance[k] += weights.weights[i] * (radiance[k] - baseRadiance[k]);
            sum.occlusion += weights.weights[i] * (probe.occlusion - base.occlusion);
        }
        sum.occlusion = saturate(sum.occlusion);
    }
    // After interpolation: the sum of probes may ring less than each of them.
    if (options_.withoutRinging) sum.radiance = withoutRinging(sum.radiance);
    return sum;
}

ProbeWeights ProbeInterpolator::weights(vec3 position) const
{
    ProbeWeights weights = mesh_->weights(position);
    if (mesh_->empty()) return weights;
    for (uint32_t& probe : weights.probes) probe = mesh_->sources()[probe];
    return weights;
}

vec3 ProbeInterpolator::spacingMeters() const
{
    return mesh_->spacingMeters();
}
std::size_t ProbeInterpolator::probeCount() const
{
    return mesh_->probes().size();
}
std::size_t ProbeInterpolator::tetrahedronCount() const
{
    return mesh_->tetrahedronCount();
}

std::vector<ProbeSample> sampleProbes(const ProbeInterpolator& probes, std::span<const vec3> positions)
{
    std::vector<ProbeSample> samples(positions.size());
    parallelFor(positions.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) samples[i] = probes.sample(positions[i]);
    });
    return samples;
}

ProbeSample sampleProbes(const BakedScene& baked, vec3 position)
{
    return ProbeInterpolator(baked).sample(position);
}

vec3 probeAnchor(const Object& object, const Bounds& worldBounds)
{
    return worldBounds.empty() ? vec3(object.worldFromObject[3]) : worldBounds.center();
}

} // namespace halflight
