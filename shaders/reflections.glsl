// Reflection probes at a point of a surface.
#ifndef HALFLIGHT_REFLECTIONS_GLSL
#define HALFLIGHT_REFLECTIONS_GLSL

#include "bindings.glsl"
#include "halflight/shading/reflection.h"

bool hasReflections() { return frame.reflections.x > 0.0; }

vec3 reflectionAt(int probe, int level, vec3 direction)
{
    int size = int(frame.reflections.y);
    vec2 texel = reflectionTexel(size, level, direction) + vec2(0.0, float(probe * reflectionTileHeight(size)));
    return textureLod(reflectionPicture, texel / vec2(textureSize(reflectionPicture, 0)), 0.0).rgb;
}

// Radiance that a lobe of this roughness about a direction meets, by one probe.
vec3 reflectionOf(int probe, vec3 position, vec3 direction, float roughness)
{
    mat4 boxFromWorld = reflectionProbes[probe].boxFromWorld;
    vec3 boxPosition = (boxFromWorld * vec4(position, 1.0)).xyz;
    vec4 at = lookUpReflection(position, direction, boxPosition, mat3(boxFromWorld) * direction,
                               reflectionProbes[probe].position.xyz, roughness);
    float level = reflectionLevel(at.w);
    int low = min(int(level), kReflectionLevels - 2);
    return mix(reflectionAt(probe, low, at.xyz), reflectionAt(probe, low + 1, at.xyz), level - float(low));
}

// The same by all probes that count at the position.
struct Reflections {
    vec3 radiance;
    vec3 expected; // of the roughest lobe about the normal
    float coverage;
};
Reflections reflectionsAt(vec3 position, vec3 direction, float roughness, vec3 normal)
{
    Reflections result;
    result.radiance = vec3(0.0);
    result.expected = vec3(0.0);
    float left = 1.0;
    float weights = 0.0;
    for (int i = 0; i < int(frame.reflections.x) && left > 0.0; ++i) {
        vec3 boxPosition = (reflectionProbes[i].boxFromWorld * vec4(position, 1.0)).xyz;
        float coverage = reflectionCoverage(boxPosition, reflectionProbes[i].halfSize.xyz, reflectionProbes[i].position.w);
        float weight = left * coverage;
        left -= weight;
        if (weight <= 0.0) continue;
        result.radiance += weight * reflectionOf(i, position, direction, roughness);
        result.expected += weight * reflectionOf(i, position, normal, 1.0);
        weights += weight;
    }
    float scale = frame.reflections.z / max(weights, 1.0e-20);
    result.radiance *= scale;
    result.expected *= scale;
    result.coverage = weights;
    return result;
}

#endif
