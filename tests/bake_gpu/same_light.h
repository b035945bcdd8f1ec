#pragma once
// Light of texels on the processor and on a device, compared texel by texel. Both take the same samples: but for
// rounding, and rays that hit another triangle by it, texels are the same.

#include "bake/test_scene.h"
#include "bake_gpu/test_device.h"

#include <cmath>
#include <string>

namespace halflight::test {

/// Every n-th texel of a scene.
inline std::vector<IrradianceEstimate> lightOn(const IntegratorFactory& factory, const Scene& scene, int page,
                                               const IntegrationSettings& settings, uint32_t step = 1)
{
    Bench bench(scene, MixedLightingMode::Shadowmask, page, settings, 1, factory);
    std::vector<uint32_t> texels;
    for (uint32_t i = 0; i < bench.map.texels.size(); i += step) texels.push_back(i);
    std::vector<IrradianceEstimate> estimates(texels.size());
    EXPECT_TRUE(bench.irradiance({texels}, estimates));
    return estimates;
}

/// `near`: difference that counts as rounding, relative to a texel's light.
inline void expectSameLight(const std::vector<IrradianceEstimate>& cpu, const std::vector<IrradianceEstimate>& gpu,
                            float near)
{
    ASSERT_EQ(cpu.size(), gpu.size());
    double mean = 0.0;
    double difference = 0.0;
    std::size_t other = 0;
    for (std::size_t i = 0; i < cpu.size(); ++i) {
        const double a = double(luminance(cpu[i].irradiance));
        mean += a / double(cpu.size());
        difference += (double(luminance(gpu[i].irradiance)) - a) / double(cpu.size());
        other += glm::distance(cpu[i].irradiance, gpu[i].irradiance) > near * float(a + 1.0e-3) ||
                 cpu[i].samples != gpu[i].samples ||
                 glm::distance(cpu[i].moment, gpu[i].moment) > 2.0f * near * float(a + 1.0e-3);
    }
    EXPECT_GT(mean, 0.01);
    EXPECT_LT(std::abs(difference), 1.0e-3 * mean);
    // A number that falls on the other side of a threshold by rounding makes another path.
    EXPECT_LT(other, cpu.size() / 20);
    testing::Test::RecordProperty("other", std::to_string(other) + " of " + std::to_string(cpu.size()));
}

} // namespace halflight::test
