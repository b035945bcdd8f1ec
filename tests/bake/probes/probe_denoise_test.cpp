// Denoised probes against probes of many paths (spec S14).

#include "bake/cache/cached_integrator.h"
#include "bake/probes/probes.h"
#include "bake/test_room.h"

#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace halflight::test::probe_denoise_test {
namespace {

constexpr int kPage = 64;

/// Noisy probes, denoised, against ones of many paths at the same places: less error, in light and in the direction it
/// comes from, and no light from where there is none.
TEST(ProbesS14, DenoisingComesCloserInLightAndDirection)
{
    const auto probesOf = [&](int samples, bool denoise) {
        IntegrationSettings settings;
        settings.integrator = IntegratorKind::Path;
        settings.probeSamples = samples;
        settings.bounces = 3;
        Bench bench(room(true, true, false), MixedLightingMode::Shadowmask, kPage, settings);
        std::vector<std::string> warnings;
        const CachedIntegrator cached{*bench.integrator, bench.geometry, bench.map, settings};
        std::map<std::array<float, 3>, Probe> byPlace; // refinement depends on noise, the first grid does not
        const auto set = bakeProbes(bench.scene, 0.3f, ProbeLayout::Refined, denoise, cached, warnings, {});
        for (const Probe& probe : set->set.probes)
            byPlace[{probe.position.x, probe.position.y, probe.position.z}] = probe;
        return byPlace;
    };
    const auto truth = probesOf(4096, false);
    struct Errors {
        double light = 0.0;     ///< sum of squares over all coefficients
        double direction = 0.0; ///< sum of 1 - cosine between mean directions
        double negative = 0.0;  ///< sum of the lowest irradiance of any direction where that is below 0
    };
    const auto errorsOf = [&](const auto& probes) {
        Errors errors;
        int compared = 0;
        for (const auto& [place, probe] : probes) {
            const auto found = truth.find(place);
            if (found == truth.end()) continue;
            ++compared;
            const auto directionOf = [](const Probe& p) { // of the linear band
                return vec3(luminance(p.radiance[3]), luminance(p.radiance[1]), luminance(p.radiance[2]));
            };
            for (std::size_t k = 0; k < 9; ++k) {
                const vec3 d = probe.radiance[k] - found->second.radiance[k];
                errors.light += double(glm::dot(d, d));
            }
            errors.direction +=
                1.0 - double(glm::dot(glm::normalize(directionOf(probe)), glm::normalize(directionOf(found->second))));
            for (int i = 0; i < 64; ++i) {
                const float z = 1.0f - 2.0f * (float(i) + 0.5f) / 64.0f;
                const float phi = 2.39996323f * float(i); // golden angle
                const vec3 n(std::sqrt(1.0f - z * z) * vec2(std::cos(phi), std::sin(phi)), z);
                vec3 irradiance(0.0f);
                for (int k = 0; k < 9; ++k)
                    irradiance += probe.radiance[std::size_t(k)] * shading::shIrradianceWeight(k, n);
                errors.negative += std::min(0.0, double(luminance(irradiance)));
            }
        }
        EXPECT_GT(compared, 200);
        return errors;
    };
    const Errors raw = errorsOf(probesOf(64, false));
    const Errors denoised = errorsOf(probesOf(64, true));
    EXPECT_LT(denoised.light, 0.7 * raw.light);
    EXPECT_LT(denoised.direction, 0.6 * raw.direction);
    EXPECT_GE(denoised.negative, raw.negative);
}

} // namespace
} // namespace halflight::test::probe_denoise_test
