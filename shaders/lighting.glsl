// Direct light and its shadows: the one place where a shader asks the law (halflight/shading/law.h) how baked and
// realtime shadow mix. Forward and deferred light their surfaces here.
#ifndef HALFLIGHT_LIGHTING_GLSL
#define HALFLIGHT_LIGHTING_GLSL

#include "shadow_map.glsl"
#include "surface.glsl"
#include "halflight/shading/area_light.h"
#include "halflight/shading/brdf.h"

// Of an area light: the direction to its middle, and its light on a surface that faces it.
LightSample sampleFrameLight(int light, vec3 position)
{
    if (isAreaLight(lights[light].info.x)) {
        LightSample s;
        vec3 toCenter = lights[light].positionRange.xyz - position;
        s.distance = max(length(toCenter), 1.0e-6);
        s.direction = toCenter / s.distance;
        s.illuminance = lights[light].colorIntensity.rgb *
                        (rangeWindow(s.distance * s.distance, lights[light].positionRange.w) *
                         areaIrradiance(lights[light].info.x, s.direction, toCenter, lights[light].halfX.xyz,
                                        lights[light].halfY.xyz));
        return s;
    }
    return sampleLight(lights[light].info.x, lights[light].colorIntensity.rgb, lights[light].positionRange.xyz,
                       lights[light].axis.xyz, lights[light].positionRange.w, lights[light].spot.xy, position);
}

bool hasRealtime(int light) { return (lights[light].info.y & kLightHasRealtime) != 0; }

// R where it is wanted.
float readRealtime(int light, Surface s, LightSample incoming)
{
    if (!readsShadowMap(hasRealtime(light), s.fade)) return 1.0;
    vec3 n = dot(s.faceNormal, incoming.direction) < 0.0 ? -s.faceNormal : s.faceNormal;
    return realtimeAttenuation(light, s.position, n, incoming.direction, s.cameraDistance);
}

// B of a light that has a channel, where its mask says `baked`.
float withinReach(int light, Surface s, float baked)
{
    vec3 fromLight = s.position - lights[light].bakedReach.xyz;
    float distanceMeters = max(length(fromLight), 1.0e-6);
    float cosAngle = dot(fromLight, lights[light].bakedCone.xyz) / distanceMeters;
    return bakedWithinReach(baked, distanceMeters, lights[light].bakedReach.w, cosAngle, lights[light].bakedCone.w);
}

// What the point gets of a light after shadows, by colour.
vec3 shadowAttenuation(int light, Surface s, LightSample incoming)
{
    if (!s.receiveShadows) return vec3(1.0);
    bool hasBaked = (lights[light].info.y & kLightHasBaked) != 0;
    float realtime = readRealtime(light, s, incoming);
    float strength = lights[light].colorIntensity.w;
    if (kColoredMasks) {
        vec3 baked = hasBaked ? max(bakedByColor(s, light), vec3(withinReach(light, s, 0.0))) : vec3(1.0);
        return mixShadowsByColor(frame.mode.x, hasBaked, baked, hasRealtime(light), realtime, s.fade, strength);
    }
    float baked = hasBaked ? withinReach(light, s, bakedOfChannel(s, lights[light].info.z)) : 1.0;
    return vec3(mixShadows(frame.mode.x, hasBaked, baked, hasRealtime(light), realtime, s.fade, strength));
}

// Subtractive: the lightmap's irradiance at a point with this interpolated normal, less what dynamic objects keep from it
// of the main light. s.baked is the main light's own mask where the file has one, else 1.
vec3 subtractDynamicShadows(vec3 lightmap, Surface s, vec3 vertexNormal)
{
    int mainLight = frame.mode.z;
    if (frame.mode.x != kModeSubtractive || mainLight < 0 || !s.receiveShadows) return lightmap;
    LightSample incoming = sampleFrameLight(mainLight, s.position);
    vec3 mainIrradiance = incoming.illuminance * saturate(dot(vertexNormal, incoming.direction));
    float faded = mixShadowsFullStrength(frame.mode.x, false, 1.0, hasRealtime(mainLight),
                                         readRealtime(mainLight, s, incoming), s.fade);
    vec3 shadowColor = frame.subtractiveShadowColor.rgb;
    float strength = lights[mainLight].colorIntensity.w;
    if (kColoredMasks)
        return subtractiveIrradianceByColor(lightmap, mainIrradiance, bakedByColor(s, mainLight), faded, shadowColor,
                                            strength);
    return subtractiveIrradiance(lightmap, mainIrradiance, bakedOfChannel(s, lights[mainLight].info.z), faded,
                                 shadowColor, strength);
}

// Cluster of the fragment: picture tile and exponential depth slice (see LightClusters in frame.h).
int clusterOf(vec3 position)
{
    ivec3 size = frame.clusterSize.xyz;
    float depth = dot(position - frame.cameraPosition.xyz, frame.cameraForward.xyz);
    ivec2 tile = ivec2(gl_FragCoord.xy * vec2(size.xy) / frame.pictureSize.xy);
    int slice = int(floor(log2(max(depth, 1.0e-6) / frame.clusterRange.x) * frame.clusterRange.z));
    ivec3 cell = clamp(ivec3(tile, slice), ivec3(0), size - 1);
    return ((cell.z * size.y + cell.y) * size.x + cell.x) * 8;
}

bool skipsLight(int light, bool lightmapped)
{
    return (lights[light].info.y & (lightmapped ? kLightSkipStatic : kLightSkipDynamic)) != 0;
}

// What a surface reflects to the camera of an area light that nothing is before. Its shadow is then that of `middle`.
vec3 areaLight(int light, Surface s, out LightSample middle)
{
    vec3 toCenter = lights[light].positionRange.xyz - s.position;
    float d2 = dot(toCenter, toCenter);
    vec3 radiance = lights[light].colorIntensity.rgb * rangeWindow(d2, lights[light].positionRange.w);
    middle.distance = sqrt(d2);
    middle.direction = toCenter / middle.distance;
    middle.illuminance = radiance;
    if (dot(toCenter, lights[light].axis.xyz) >= 0.0 || radiance == vec3(0.0)) return vec3(0.0);
    return reflectAreaLight(s.baseColor, s.metallic, s.roughness, s.specular, s.normal, s.view, lights[light].info.x,
                            toCenter, lights[light].halfX.xyz, lights[light].halfY.xyz, radiance);
}

// The same of a punctual light.
vec3 punctualLight(int light, Surface s, out LightSample incoming)
{
    incoming = sampleFrameLight(light, s.position);
    if (dot(s.normal, incoming.direction) <= 0.0 || incoming.illuminance == vec3(0.0)) return vec3(0.0);
    return reflectLight(s.baseColor, s.metallic, s.roughness, s.specular, s.normal, s.view, incoming.direction,
                        incoming.illuminance);
}

// Radiance towards the camera by all lights of the fragment's cluster.
vec3 directLight(Surface s)
{
    int cluster = clusterOf(s.position);
    vec3 radiance = vec3(0.0);
    for (int word = 0; word * 32 < frame.mode.w; ++word) {
        uint bits = clusterWords[cluster + word];
        while (bits != 0u) {
            int light = word * 32 + findLSB(bits);
            bits &= bits - 1u;
            if (skipsLight(light, s.lightmapped)) continue;
            LightSample incoming;
            vec3 reflected = isAreaLight(lights[light].info.x) ? areaLight(light, s, incoming)
                                                               : punctualLight(light, s, incoming);
            if (reflected != vec3(0.0)) radiance += reflected * shadowAttenuation(light, s, incoming);
        }
    }
    return radiance;
}

#endif
