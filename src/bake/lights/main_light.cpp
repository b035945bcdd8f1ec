// Subtractive's main light. Its direct light in the lightmap is computed from the stored mask. The renderer then
// subtracts exactly the light that the lightmap contains (spec S22).
#include "bake/lights/main_light.h"

#include "bake/cache/cached_integrator.h"
#include "bake/texels/even_texels.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

/// Unoccluded irradiance in lux, the mean over the texel's valid points.
vec3 unshadowedIrradiance(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel, vec3 towardsLight,
                          vec3 illuminance)
{
    float least = kInfinity;
    float most = 0.0f;
    float sum = 0.0f;
    int count = 0;
    std::array<SurfacePoint, kMaxTexelPoints> points;
    for (int batch = 0; batch < kMostBatches; ++batch) {
        const int size = texelPoints(geometry, map, texel, points, batch);
        for (int p = 0; p < size; ++p) {
            if (((texel.validPoints >> p) & 1) == 0) continue;
            const float towards = glm::dot(points[std::size_t(p)].normal, towardsLight);
            const bool mean = geometry.hasMeanTexels(points[std::size_t(p)].triangle); // one side receives nothing
            const float cosine = mean ? 0.5f * std::abs(towards) : std::max(towards, 0.0f);
            sum += cosine;
            least = std::min(least, cosine);
            most = std::max(most, cosine);
            ++count;
        }
        if (most - least <= kEvenIrradiance * most || texel.validPoints != kAllPoints) break;
    }
    return count > 0 ? illuminance * (sum / float(count)) : vec3(0.0f);
}

/// Quantile; reorders the values.
float quantile(std::vector<float>& values, float share)
{
    const auto middle = values.begin() + std::ptrdiff_t(share * float(values.size() - 1));
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace

std::optional<MainLight> findMainLight(const Scene& scene)
{
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (light.baking.mixedMode != MixedLightingMode::Subtractive || light.baking.occlusionMaskChannel < 0) continue;
        MainLight main;
        main.name = light.name;
        main.light = i;
        main.towardsLight = -light.direction();
        main.illuminance = light.color * light.intensity;
        main.shadowStrength = light.shadowStrength;
        main.channel = light.baking.occlusionMaskChannel;
        main.coloredMask = light.baking.coloredMask;
        return main;
    }
    return std::nullopt;
}

Status bakeMainLight(const CachedIntegrator& cached, MainLight& main, const Progress& progress)
{
    const std::size_t count = cached.map.texels.size();
    std::vector<vec4> mask(count);
    if (Status s = cached.shadowmask(0, mask, progress); !s) return s;
    main.unshadowed.assign(count, vec3(0.0f));
    main.transmittance.assign(count, vec3(0.0f));
    parallelFor(count, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (cached.map.texels[i].validPoints == 0) continue;
            const vec3 passed = main.coloredMask ? vec3(mask[i]) : vec3(mask[i][main.channel]);
            main.transmittance[i] = glm::round(passed * 255.0f) / 255.0f; // as the mask stores it
            main.unshadowed[i] = unshadowedIrradiance(cached.geometry, cached.map, cached.map.texels[i],
                                                      main.towardsLight, main.illuminance);
        }
    });
    return {};
}

void MainLight::addTo(std::vector<vec3>& irradiance) const
{
    for (std::size_t i = 0; i < irradiance.size(); ++i) irradiance[i] += at(i);
}

void MainLight::addMomentTo(std::vector<vec3>& moments) const
{
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i] += luminance(at(i)) * towardsLight;
}

std::vector<vec4> MainLight::mask() const
{
    std::vector<vec4> values(transmittance.size(), vec4(1.0f));
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (coloredMask)
            values[i] = vec4(transmittance[i], 1.0f);
        else
            values[i][channel] = transmittance[i].x;
    }
    return values;
}

vec3 chooseShadowColor(const MainLight& main, const std::vector<vec3>& otherLight, const std::vector<uint8_t>& valid,
                       bool hasMask)
{
    // Without a mask the colour is the typical light in the main light's shadows. With a mask it only limits rounding,
    // so that it is the light of the darkest places.
    constexpr float kTypical = 0.5f;
    constexpr float kDarkest = 0.05f;
    constexpr float kCovered = 0.1f; // of the mean: darker texels lie under an object

    const auto faces = [&](std::size_t i) { return luminance(main.unshadowed[i]) > 0.0f; };
    const auto shadowed = [&](std::size_t i) { return faces(i) && main.transmittance[i] == vec3(0.0f); };
    const auto colorOf = [&](const auto& counts) -> std::optional<vec3> {
        double sum = 0.0;
        std::size_t count = 0;
        for (std::size_t i = 0; i < otherLight.size(); ++i) {
            if (valid[i] == 0 || !counts(i)) continue;
            sum += double(luminance(otherLight[i]));
            ++count;
        }
        if (count == 0) return std::nullopt;
        const auto least = float(double(kCovered) * sum / double(count));
        vec3 color;
        for (int c = 0; c < 3; ++c) {
            std::vector<float> values;
            for (std::size_t i = 0; i < otherLight.size(); ++i) {
                if (valid[i] != 0 && counts(i) && luminance(otherLight[i]) >= least) values.push_back(otherLight[i][c]);
            }
            color[c] = quantile(values, hasMask ? kDarkest : kTypical);
        }
        return color;
    };
    if (const auto color = colorOf(shadowed)) return *color;
    if (const auto color = colorOf(faces)) return *color; // no shadow in the scene: the light without the main light
    return colorOf([](std::size_t) { return true; }).value_or(vec3(0.0f));
}

} // namespace halflight
