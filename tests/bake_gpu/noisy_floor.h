#pragma once
// Noisy light for the denoiser on a device, and what it is compared by.

#include "bake/denoise/component_signals.h"
#include "bake/geometry/flatten.h"
#include "bake/seams/patchwork_floor.h"
#include "bake/seams/seams.h"
#include "bake/texels/rasterize.h"
#include "bake/texels/texel_places.h"
#include "bake_gpu/test_device.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace halflight::test {

constexpr int kFloorPage = 96;
constexpr float kNoise = 0.1f; ///< standard deviation of gathered light, lux
constexpr float kMean = 2.0f;  ///< of light, lux

/// Which parts of the denoiser a run has.
struct Parts {
    bool direct = false; ///< light of baked lights
    bool directions = false;
};

/// A patchwork floor, its coarser part on another page, and a wall on it.
struct Floor {
    Floor()
    {
        const int grey = addMaterial(scene, vec3(0.5f));
        addPatchworkFloor(scene, grey, kFloorPage);
        addRectangle(scene, {vec3(0, 0, 0), vec3(6, 0, 0), vec3(0, 2, 0)}, grey, kFloorPage,
                     {vec2(3.5f, 66.2f), vec2(63.5f, 86.2f)});
        scene.objects[3].lightmap.page = 1;
        geometry = flattenGeometry(scene, kFloorPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kFloorPage, 2);
        seams = findSeams(geometry, kFloorPage);
    }

    /// Noisy light with fireflies, dark specks and texels inside geometry.
    [[nodiscard]] std::vector<IrradianceEstimate> estimates(Parts parts, uint32_t seed = 7) const
    {
        std::mt19937 random(seed);
        std::normal_distribution<float> noise(0.0f, kNoise);
        std::uniform_real_distribution<float> unit;
        std::vector<IrradianceEstimate> list(map.texels.size());
        for (std::size_t i = 0; i < list.size(); ++i) {
            const vec3 at = placeOf(geometry, map, map.texels[i]).position;
            const float light = kMean + 0.5f * std::sin(1.5f * at.x) + 0.3f * std::cos(2.0f * at.z + at.y);
            const float dice = unit(random);
            const float factor = dice < 0.01f ? 8.0f : dice < 0.02f ? 0.1f : 1.0f;
            IrradianceEstimate& e = list[i];
            e.irradiance = factor * vec3(light + noise(random), light + noise(random), 0.7f * light);
            e.moment = vec3(noise(random), 0.5f * factor * light, noise(random));
            e.varianceOfMean = kNoise * kNoise * (0.5f + 2.0f * unit(random)) * factor;
            e.samples = dice < 0.015f ? 32 : 256;
            e.valid = dice < 0.98f;
            if (!parts.direct || at.x < 3.0f) continue;
            e.direct = vec3(1.0f + 0.05f * noise(random));
            e.irradiance += e.direct;
            e.varianceOfDirect = 0.001f;
            e.varianceOfMean += e.varianceOfDirect;
        }
        return list;
    }

    /// What the processor gives, or a device.
    [[nodiscard]] std::vector<IrradianceEstimate> denoised(Parts parts, const DeviceDenoiser& device,
                                                           Status* status = nullptr) const
    {
        std::vector<IrradianceEstimate> list = estimates(parts);
        const Status outcome = denoise(geometry, map, seams, list, parts.directions, device);
        if (status != nullptr) *status = outcome;
        return list;
    }

    /// Components with all parts, without any, with directions alone, and black with all parts.
    [[nodiscard]] ComponentSignals components() const
    {
        const std::vector<ComponentSignals::Content> contents{
            {true, true}, {false, false}, {false, true}, {true, true}};
        ComponentSignals components(map.texels.size(), contents);
        for (std::size_t c = 0; c < 3; ++c) {
            const Parts parts{contents[c].direct, contents[c].directions};
            const std::vector<IrradianceEstimate> list = estimates(parts, uint32_t(11 + c));
            for (std::size_t i = 0; i < list.size(); ++i) components.set(i, c, list[i]);
        }
        return components;
    }

    /// Denoises components on the processor, or on a device.
    Status denoiseAll(std::span<Signals> components, const DeviceDenoiser& device) const
    {
        std::vector<uint8_t> valid;
        std::vector<uint8_t> samples;
        for (const IrradianceEstimate& e : estimates({})) {
            valid.push_back(e.valid ? 1 : 0);
            samples.push_back(DenoiserTexels::samplesOf(e));
        }
        return denoiseComponents({geometry, map, SurfaceGrid(map, seams), valid, samples}, components, device);
    }

    Scene scene;
    BakeGeometry geometry;
    TexelMap map;
    std::vector<SeamSample> seams;
};

/// What the denoiser gives a texel.
struct TexelLight {
    vec3 irradiance{0.0f};
    vec3 direct{0.0f};
    vec3 moment{0.0f};
    float variance = 0.0f;
};
inline std::vector<TexelLight> lightOf(const std::vector<IrradianceEstimate>& estimates)
{
    std::vector<TexelLight> light;
    for (const IrradianceEstimate& e : estimates) light.push_back({e.irradiance, e.direct, e.moment, e.varianceOfMean});
    return light;
}
inline std::vector<TexelLight> lightOf(const Signals& signals)
{
    std::vector<TexelLight> light;
    for (std::size_t i = 0; i < signals.gathered.size(); ++i) {
        const NoisyLight direct = signals.direct.empty() ? NoisyLight{} : signals.direct[i];
        light.push_back({signals.irradiance(i), direct.irradiance,
                         signals.moments.empty() ? vec3(0.0f) : signals.moments[i],
                         signals.gathered[i].variance + direct.variance});
    }
    return light;
}

/// Numbers differ by rounding. Where that turns the choice between curve and slope over, a texel is off by what the
/// filter leaves of noise: by less than the noise before it.
inline void expectNear(const std::vector<TexelLight>& cpu, const std::vector<TexelLight>& gpu, const TexelMap& map)
{
    ASSERT_EQ(cpu.size(), gpu.size());
    std::size_t off = 0;
    for (std::size_t i = 0; i < cpu.size(); ++i) {
        const float light = glm::distance(cpu[i].irradiance, gpu[i].irradiance);
        const float rest =
            std::max(glm::distance(cpu[i].direct, gpu[i].direct), glm::distance(cpu[i].moment, gpu[i].moment));
        const float variance = std::abs(cpu[i].variance - gpu[i].variance);
        off += std::max(light, rest) > 1.0e-4f * kMean || variance > 1.0e-3f * kNoise * kNoise ? 1 : 0;
        EXPECT_LT(std::max(light, rest), kNoise) << map.texels[i].x << ", " << map.texels[i].y;
    }
    EXPECT_LE(off, cpu.size() / 1000);
}

/// Over the texels that are not black afterwards, as invalid ones are.
inline double meanChange(const std::vector<TexelLight>& before, const std::vector<TexelLight>& after)
{
    double change = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (after[i].irradiance == vec3(0.0f)) continue;
        change += double(glm::distance(before[i].irradiance, after[i].irradiance));
        ++count;
    }
    return count > 0 ? change / double(count) : 0.0;
}

class DeviceDenoise : public BakeDeviceTest {
protected:
    static DeviceDenoiser denoiser() { return gpuIntegrators(device).denoise; }
};

} // namespace halflight::test
