// The compose pass (S33): each texel of the lightmap is the sum of the rest's and the groups', times their weights.
#ifndef HALFLIGHT_COMPOSE_GLSL
#define HALFLIGHT_COMPOSE_GLSL

#include "halflight/base/rgb9e5_texel.h"
#include "halflight/shading/directional.h"
#include "render/scene/gpu_layout.h"

layout(local_size_x = 8, local_size_y = 8) in; // kComposeSide
layout(set = 0, binding = kBindSourcePages) uniform sampler2DArray sourcePages;
layout(set = 0, binding = kBindSourceDirections) uniform sampler2DArray sourceDirections;
layout(std430, set = 0, binding = kBindSources) readonly buffer SourceBlock { GpuLightSource sources[]; };
layout(rgba8, set = 0, binding = kBindComposedDirections) writeonly uniform image2DArray composedDirections;
layout(push_constant) uniform ComposeBlock { GpuCompose compose; };

// By the format that the device lets shaders write: compose.comp, compose_half.comp.
void storeLight(ivec3 at, vec3 irradiance);

void main()
{
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, compose.size.xy))) return;
    bool directional = compose.size.w != 0;
    vec3 irradiance = vec3(0.0);
    vec3 moment = vec3(0.0);
    float trust = 1.0; // in reflection probes: the rest's
    int first = at.z * compose.size.z;
    for (int i = first; i < first + compose.size.z; ++i) {
        ivec2 layers = sources[i].info.xy;
        if (layers.x < 0) break;
        vec3 own = texelFetch(sourcePages, ivec3(at.xy, layers.x), 0).rgb * sources[i].weight.rgb;
        irradiance += own;
        if (!directional || layers.y < 0) continue;
        vec4 encoded = texelFetch(sourceDirections, ivec3(at.xy, layers.y), 0);
        moment += directionMoment(own, encoded.rgb);
        if (i == first) trust = encoded.a;
    }
    storeLight(at, irradiance);
    if (directional) imageStore(composedDirections, at, vec4(encodeMomentDirection(irradiance, moment), trust));
}

#endif
