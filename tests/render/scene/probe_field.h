#pragma once
// Probes whose light and occlusion are known at every point.

#include "render/render_test.h"

#include "halflight/render/probes.h"
#include "halflight/shading/sh.h"

namespace halflight::test {

/// A field that is linear in the position, so that tetrahedra and volumes give it exactly; free of ringing.
inline ProbeSample linearField(vec3 p)
{
    const vec3 mean(2.0f + 0.30f * p.x - 0.10f * p.z, 1.6f + 0.25f * p.y, 1.2f - 0.2f * p.x + 0.15f * p.z);
    ProbeSample sample;
    sample.radiance[0] = mean;
    sample.radiance[1] = mean * vec3(0.3f, -0.2f, 0.1f);
    sample.radiance[2] = mean * vec3(-0.1f, 0.2f, 0.3f);
    sample.radiance[3] = mean * vec3(0.2f, 0.1f, -0.3f);
    sample.radiance[6] = mean * 0.05f;
    sample.radiance[8] = mean * -0.04f;
    sample.occlusion.layers[0] = {0.5f + 0.11f * p.x, 0.5f - 0.1f * p.z, 0.4f + 0.09f * p.y,
                                  0.5f + 0.05f * (p.x + p.z)};
    return sample;
}

/// Probes of a field on a grid of 3 x 3 x 3 over [-4, 4]^3.
inline void addProbes(BakedScene& baked, ProbeSample (*field)(vec3))
{
    baked.isBaked = true;
    baked.probes.size = ivec3(3);
    baked.probes.origin = vec3(-4.0f);
    baked.probes.spacingMeters = vec3(4.0f);
    for (int z = 0; z < 3; ++z)
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 3; ++x) {
                Probe probe;
                probe.position = vec3(-4.0f) + 4.0f * vec3(x, y, z);
                const ProbeSample sample = field(probe.position);
                probe.radiance = sample.radiance;
                probe.occlusion = sample.occlusion;
                baked.probes.probes.push_back(probe);
            }
}

inline vec3 irradianceOf(const ProbeSample& sample, vec3 n)
{
    vec3 sum(0.0f);
    for (int i = 0; i < 9; ++i) sum += sample.radiance[std::size_t(i)] * shading::shIrradianceWeight(i, n);
    return sum;
}

} // namespace halflight::test
