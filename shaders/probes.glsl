// What surrounds a point: light and occlusion probes, or the open sky.
#ifndef HALFLIGHT_PROBES_GLSL
#define HALFLIGHT_PROBES_GLSL

#include "bindings.glsl"
#include "halflight/shading/sh.h"

struct ProbeSample {
    vec3 radiance[9]; // SH coefficients
    mat4 occlusion;   // baked attenuation by channel: a column for each mask layer
};

// The object's proxy volume, -1 where it has one sample for all of it.
int proxyVolumeOf(uint object) { return frame.shadow.w != 0 ? objects[object].info.z : -1; }

// Textures 0, 1, … of a proxy volume at a point; filtering keeps to the volume's own texels.
vec4 proxyTexture(int volume, vec3 position, int slab)
{
    vec3 at = (probeVolumes[volume].slabFromWorld * vec4(position, 1.0)).xyz;
    at = clamp(at, probeVolumes[volume].low.xyz, probeVolumes[volume].high.xyz);
    at.z += float(slab) / float(kProbeSlabs + frame.baked.w - 1);
    return textureLod(probeTexture, at, 0.0);
}

// The probes as they light an object at a point of its surface. Every shader that reads probes does it here.
ProbeSample sampleProbes(uint object, vec3 position)
{
    ProbeSample probes;
    probes.occlusion = mat4(vec4(1.0), vec4(1.0), vec4(1.0), vec4(1.0));
    int volume = proxyVolumeOf(object);
    if (volume < 0) {
        for (int i = 0; i < 9; ++i) probes.radiance[i] = objects[object].probeSh[i].rgb;
        probes.occlusion[0] = objects[object].probeOcclusion[0];
        if (kMaskLayers > 1) probes.occlusion[1] = objects[object].probeOcclusion[1];
        if (kMaskLayers > 2) probes.occlusion[2] = objects[object].probeOcclusion[2];
        if (kMaskLayers > 2) probes.occlusion[3] = objects[object].probeOcclusion[3];
        return probes;
    }
    probes.occlusion[0] = proxyTexture(volume, position, 3);
    if (kMaskLayers > 1) probes.occlusion[1] = proxyTexture(volume, position, kProbeSlabs);
    if (kMaskLayers > 2) probes.occlusion[2] = proxyTexture(volume, position, kProbeSlabs + 1);
    if (kMaskLayers > 2 && frame.baked.w > 3) probes.occlusion[3] = proxyTexture(volume, position, kProbeSlabs + 2);
    for (int c = 0; c < 3; ++c) {
        vec4 low = proxyTexture(volume, position, c);
        vec4 high = proxyTexture(volume, position, 4 + c);
        for (int i = 0; i < 4; ++i) {
            probes.radiance[i][c] = low[i];
            probes.radiance[4 + i][c] = high[i];
        }
    }
    probes.radiance[8] = proxyTexture(volume, position, 7).rgb;
    for (int i = 0; i < 9; ++i) probes.radiance[i] *= probeVolumes[volume].low.w;
    return probes;
}

ProbeSample openSky()
{
    ProbeSample probes;
    for (int i = 0; i < 9; ++i) probes.radiance[i] = frame.skySh[i].rgb;
    probes.occlusion = mat4(vec4(1.0), vec4(1.0), vec4(1.0), vec4(1.0));
    return probes;
}

vec3 irradianceFrom(ProbeSample probes, vec3 n)
{
    vec3 irradiance = vec3(0.0);
    for (int i = 0; i < 9; ++i) irradiance += probes.radiance[i] * shIrradianceWeight(i, n);
    return max(irradiance, vec3(0.0));
}

#endif
