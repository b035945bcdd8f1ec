#pragma once
// Probe sets for tests: fields sampled on grids and at free places.

#include "plan_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace halflight::test {

/// A probe whose light is `value` in every channel: coefficient i holds value + i; occlusion holds it too.
inline Probe probeOf(vec3 position, float value, bool valid = true)
{
    Probe probe;
    probe.position = position;
    for (std::size_t i = 0; i < 9; ++i) probe.radiance[i] = vec3(value + float(i));
    probe.occlusion.layers[0] = vec4(value, 1.0f - value, 0.5f * value, 1.0f);
    probe.valid = valid;
    return probe;
}

using Field = std::function<float(vec3)>;

inline float linear(vec3 p)
{
    return 0.5f + 0.03f * p.x - 0.02f * p.y + 0.01f * p.z;
}

/// Any field, to see which probes are read.
inline float rough(vec3 p)
{
    return 0.5f + 0.5f * std::sin(37.0f * p.x + 91.0f * p.y + 53.0f * p.z);
}

inline const vec3 kGridOrigin{-2, 1, 5};
inline const vec3 kGridSpacing{1.5f, 2.0f, 0.75f};

inline BakedScene probeGrid(ivec3 size, const Field& value)
{
    BakedScene baked = emptyScene();
    ProbeSet& set = baked.probes;
    set.size = size;
    set.origin = kGridOrigin;
    set.spacingMeters = kGridSpacing;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const vec3 position = kGridOrigin + kGridSpacing * vec3(x, y, z);
                set.probes.push_back(probeOf(position, value(position)));
            }
        }
    }
    return baked;
}

inline BakedScene probeList(const std::vector<vec3>& positions, const Field& value)
{
    BakedScene baked = emptyScene();
    for (const vec3& position : positions) baked.probes.probes.push_back(probeOf(position, value(position)));
    return baked;
}

inline std::vector<vec3> randomPoints(uint32_t seed, int count, vec3 low, vec3 high)
{
    Random random(seed);
    std::vector<vec3> points;
    for (int i = 0; i < count; ++i) points.push_back(random.in(low, high));
    return points;
}

/// Fields of these tests are no light: they are compared as they are.
inline ProbeInterpolator rawProbes(const BakedScene& baked)
{
    return ProbeInterpolator(baked, {.withoutRinging = false});
}

inline void expectSample(const ProbeSample& sample, float value, float tolerance = 1.0e-5f)
{
    for (std::size_t i = 0; i < 9; ++i) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sample.radiance[i][c], value + float(i), 10.0f * tolerance);
    }
    EXPECT_NEAR(sample.occlusion[0], value, tolerance);
    EXPECT_NEAR(sample.occlusion[1], 1.0f - value, tolerance);
    EXPECT_NEAR(sample.occlusion[2], 0.5f * value, tolerance);
    EXPECT_NEAR(sample.occlusion[3], 1.0f, 1.0e-6f);
}

} // namespace halflight::test
