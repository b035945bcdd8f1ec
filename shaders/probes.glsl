// What surrounds a point: light and occlusion probes, or the open sky.
#ifndef HALFLIGHT_PROBES_GLSL
#define HALFLIGHT_PROBES_GLSL

#include "bindings.glsl"
#include "halflight/shading/sh.h"

struct ProbeSample {
    vec3 radiance[9]; // SH coefficients
    vec4 occlusion;   // baked attenuation by channel
};

// The probes as they light an object at a point of its surface. Every shader that reads probes does it here.
ProbeSample sampleProbes(uint object, vec3 position)
{
    ProbeSample probes;
    for (int i = 0; i < 9; ++i) probes.radiance[i] = objects[object].probeSh[i].rgb;
    probes.occlusion = objects[object].probeOcclusion;
    return probes;
}

ProbeSample openSky()
{
    ProbeSample probes;
    for (int i = 0; i < 9; ++i) probes.radiance[i] = frame.skySh[i].rgb;
    probes.occlusion = vec4(1.0);
    return probes;
}

vec3 irradianceFrom(ProbeSample probes, vec3 n)
{
    vec3 irradiance = vec3(0.0);
    for (int i = 0; i < 9; ++i) irradiance += probes.radiance[i] * shIrradianceWeight(i, n);
    return max(irradiance, vec3(0.0));
}

#endif
