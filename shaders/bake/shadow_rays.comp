#version 460
#extension GL_GOOGLE_include_directive : require
#include "shadows.glsl"

layout(local_size_x = 64) in;

// Makes the shadow rays of all half-batches, with their weights: DirectLight::shadowRay(). `passed` has what the lifted
// rays of shadow_lifts.comp found.
void main()
{
    uint i = invocationOf(kGroupSize);
    if (i >= rayCount()) return;
    GpuRay ray = noRay();
    float weight = 0.0;
    uint item;
    uint number;
    if (shadowRay(i, item, number)) {
        ShadowTarget target = shadowTarget(item, number);
        if (target.light != kNone) weight = target.weight;
        if (shadowsFall(target)) {
            vec3 onTriangle;
            vec3 raised;
            shadowOrigins(target.point, onTriangle, raised);
            bool hidden = isLifted(target.point, onTriangle, raised) && push.lists.passed.at[i] == 0.0;
            ray.origin = hidden ? onTriangle : raised;
            LightRay toLight = sampleLightRay(push.tables.lights.at[target.light], ray.origin, target.disc);
            ray.direction = toLight.direction;
            ray.tMax = toLight.distance * kShortOfSurface;
            atomicAdd(push.lists.counts.at[0], 1u);
        }
    }
    push.lists.rays.at[i] = ray;
    push.lists.weights.at[i] = weight;
}
