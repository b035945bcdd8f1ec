#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require
// The forward lit pass: material, direct lights of the fragment's cluster, baked indirect light.
#include "material.glsl"
#include "shadow_map.glsl"
#include "halflight/shading/brdf.h"
#include "halflight/shading/law.h"
#include "halflight/shading/sh.h"
#include "halflight/shading/sky.h"

layout(constant_id = 0) const int kAlphaMode = kAlphaOpaque;

layout(location = 0) in vec3 inPosition;
layout(location = 1) in vec3 inNormal;
layout(location = 2) in vec4 inTangent;
layout(location = 3) in vec4 inUv;
layout(location = 4) in vec2 inLightmapUv;
layout(location = 5) in vec4 inColor;
layout(location = 6) flat in uint inObject;

layout(location = 0) out vec4 outRadiance;

struct Surface {
    vec3 position;
    vec3 normal;       // with the normal map
    vec3 vertexNormal; // interpolated: what the lightmap was baked with
    vec3 faceNormal;   // of the triangle: what shadow maps see
    vec3 view;         // unit, to the camera
    float cameraDistance;
    float fade;        // t of the law
    vec3 baseColor;
    float alpha;
    float metallic;
    float roughness;
    float specular;
    float occlusion;
    vec3 emissive;
    bool lightmapped;
    bool receiveShadows;
    vec4 baked;        // B by channel
};

Surface readSurface()
{
    Surface s;
    s.position = inPosition;
    vec3 toCamera = frame.cameraPosition.xyz - inPosition;
    s.cameraDistance = length(toCamera);
    s.view = frame.cameraForward.w > 0.5 ? -frame.cameraForward.xyz : toCamera / s.cameraDistance;
    s.fade = shadowFade(s.cameraDistance, frame.fade.xy);

    int material = push.info.x;
    vec4 base = materials[material].baseColor * inColor *
                materialTexture(material, kTextureBaseColor, inUv, vec4(1.0));
    s.baseColor = base.rgb;
    s.alpha = base.a;
    vec4 metallicRoughness = materialTexture(material, kTextureMetallicRoughness, inUv, vec4(1.0));
    s.roughness = saturate(materials[material].parameters.x * metallicRoughness.g);
    s.specular = materials[material].reflection.x;
    s.metallic = saturate(materials[material].emissiveMetallic.a * metallicRoughness.b);
    float occlusion = materialTexture(material, kTextureOcclusion, inUv, vec4(1.0)).r;
    s.occlusion = 1.0 + materials[material].parameters.z * (occlusion - 1.0);
    s.emissive = materials[material].emissiveMetallic.rgb *
                 materialTexture(material, kTextureEmissive, inUv, vec4(1.0)).rgb;

    // Back faces of double-sided surfaces turn their whole tangent frame around, normal map included. A normal of no
    // length (a degenerate vertex) gives way to the triangle's.
    float side = gl_FrontFacing ? 1.0 : -1.0;
    vec3 face = cross(dFdx(inPosition), dFdy(inPosition));
    face = dot(face, face) > 0.0 ? normalize(face) : s.view;
    s.faceNormal = dot(face, s.view) < 0.0 ? -face : face;
    s.vertexNormal = dot(inNormal, inNormal) > 0.0 ? side * normalize(inNormal) : s.faceNormal;
    s.normal = s.vertexNormal;
    if (materials[material].textures[kTextureNormal].info.x >= 0 && dot(inTangent.xyz, inTangent.xyz) > 0.0) {
        vec3 n = side * s.vertexNormal;
        vec3 t = inTangent.xyz - n * dot(n, inTangent.xyz);
        t = dot(t, t) > 0.0 ? normalize(t) : vec3(0.0);
        vec3 b = cross(n, t) * (inTangent.w < 0.0 ? -1.0 : 1.0);
        vec3 m = materialTexture(material, kTextureNormal, inUv, vec4(0.5, 0.5, 1.0, 1.0)).xyz * 2.0 - 1.0;
        m.xy *= materials[material].parameters.y;
        vec3 mapped = t * m.x + b * m.y + n * m.z;
        if (dot(mapped, mapped) > 0.0) s.normal = side * normalize(mapped);
    }

    ivec4 info = objects[inObject].info;
    s.lightmapped = (info.x & kObjectLightmapped) != 0;
    s.receiveShadows = (info.x & kObjectReceiveShadows) != 0;
    s.baked = s.lightmapped ? textureLod(shadowmasks, vec3(inLightmapUv, info.y), 0.0) : objects[inObject].probeOcclusion;
    return s;
}

vec3 probeRadianceSum(bool sky, vec3 direction)
{
    vec3 irradiance = vec3(0.0);
    for (int i = 0; i < 9; ++i)
        irradiance += (sky ? frame.skySh[i].rgb : objects[inObject].probeSh[i].rgb) * shIrradianceWeight(i, direction);
    return max(irradiance, vec3(0.0));
}

vec3 lightmapIrradiance() { return textureLod(lightmaps, vec3(inLightmapUv, objects[inObject].info.y), 0.0).rgb; }

LightSample sampleFrameLight(int light, vec3 position)
{
    return sampleLight(lights[light].info.x, lights[light].colorIntensity.rgb, lights[light].positionRange.xyz,
                       lights[light].axis.xyz, lights[light].positionRange.w, lights[light].spot.xy, position);
}

// R where it is wanted: a shadow map that exists, at a fragment within the shadow distance.
float readRealtime(int light, Surface s, LightSample incoming)
{
    bool hasRealtime = (lights[light].info.y & kLightHasRealtime) != 0;
    if (!hasRealtime || s.fade >= 1.0) return 1.0;
    vec3 n = dot(s.faceNormal, incoming.direction) < 0.0 ? -s.faceNormal : s.faceNormal;
    return realtimeAttenuation(light, s.position, n, incoming.direction, s.cameraDistance);
}

// What the fragment gets of a light after shadows: always by the law.
float shadowAttenuation(int light, Surface s, LightSample incoming)
{
    if (!s.receiveShadows) return 1.0;
    int flags = lights[light].info.y;
    bool hasBaked = (flags & kLightHasBaked) != 0;
    float baked = hasBaked ? s.baked[lights[light].info.z] : 1.0;
    return mixShadows(frame.mode.x, hasBaked, baked, (flags & kLightHasRealtime) != 0, readRealtime(light, s, incoming),
                      s.fade, lights[light].colorIntensity.w);
}

// Cluster of the fragment: picture tile and exponential depth slice (see LightClusters in frame.h).
int clusterBase()
{
    ivec3 size = frame.clusterSize.xyz;
    float depth = dot(inPosition - frame.cameraPosition.xyz, frame.cameraForward.xyz);
    ivec2 tile = ivec2(gl_FragCoord.xy * vec2(size.xy) / frame.pictureSize.xy);
    int slice = int(floor(log2(max(depth, 1.0e-6) / frame.clusterRange.x) * frame.clusterRange.z));
    ivec3 cell = clamp(ivec3(tile, slice), ivec3(0), size - 1);
    return ((cell.z * size.y + cell.y) * size.x + cell.x) * 8;
}

bool skipsLight(int light, bool lightmapped)
{
    return (lights[light].info.y & (lightmapped ? kLightSkipStatic : kLightSkipDynamic)) != 0;
}

vec3 directLight(Surface s, int cluster)
{
    vec3 radiance = vec3(0.0);
    for (int word = 0; word * 32 < frame.mode.w; ++word) {
        uint bits = clusterWords[cluster + word];
        while (bits != 0u) {
            int light = word * 32 + findLSB(bits);
            bits &= bits - 1u;
            if (skipsLight(light, s.lightmapped)) continue;
            LightSample incoming = sampleFrameLight(light, s.position);
            if (dot(s.normal, incoming.direction) <= 0.0 || incoming.illuminance == vec3(0.0)) continue;
            float attenuation = shadowAttenuation(light, s, incoming);
            if (attenuation <= 0.0) continue;
            radiance += reflectLight(s.baseColor, s.metallic, s.roughness, s.specular, s.normal, s.view,
                                     incoming.direction, incoming.illuminance * attenuation);
        }
    }
    return radiance;
}

// Irradiance of everything that is not a direct light, on the side of `n`.
vec3 indirectIrradiance(Surface s, vec3 n)
{
    if (frame.mode.x == kModeRealtime) return probeRadianceSum(true, n);
    if (!s.lightmapped) return probeRadianceSum(false, n);
    vec3 irradiance = lightmapIrradiance();
    int mainLight = frame.mode.z;
    if (frame.mode.x == kModeSubtractive && mainLight >= 0 && s.receiveShadows) {
        LightSample incoming = sampleFrameLight(mainLight, s.position);
        vec3 mainIrradiance = incoming.illuminance * saturate(dot(s.vertexNormal, incoming.direction));
        bool hasRealtime = (lights[mainLight].info.y & kLightHasRealtime) != 0;
        float faded = mixShadowsFullStrength(frame.mode.x, false, 1.0, hasRealtime,
                                             readRealtime(mainLight, s, incoming), s.fade);
        irradiance = subtractiveIrradiance(irradiance, mainIrradiance, faded, frame.subtractiveShadowColor.rgb,
                                           lights[mainLight].colorIntensity.w);
    }
    return irradiance;
}

vec3 indirectLight(Surface s)
{
    vec3 irradiance = indirectIrradiance(s, s.normal);
    vec3 diffuse = diffuseRadiance(diffuseAlbedoOf(s.baseColor, s.metallic), irradiance);

    // Surroundings in the mirror: a lightmap knows one value, probes and sky know directions, the blurrier the rougher.
    float nDotV = max(abs(dot(s.normal, s.view)), 1.0e-4);
    vec3 mirror = reflect(-s.view, s.normal);
    vec3 surroundings = irradiance;
    if (frame.mode.x == kModeRealtime || !s.lightmapped) {
        bool sky = frame.mode.x == kModeRealtime;
        surroundings = probeRadianceSum(sky, normalize(mix(mirror, s.normal, s.roughness * s.roughness)));
    }
    surroundings *= 1.0 / kShadingPi;
    if (frame.mode.x == kModeRealtime)
        surroundings = mix(skyRadiance(frame.skyZenith.rgb, frame.skyHorizon.rgb, frame.skyGround.rgb, mirror),
                           surroundings, s.roughness);
    vec3 specular = environmentSpecular(specularF0Of(s.baseColor, s.metallic, s.specular),
                                        specularF90Of(s.metallic, s.specular), s.roughness, nDotV) *
                    surroundings;
    return (diffuse + specular) * s.occlusion;
}

// S31. Debug views.
vec3 debugView(Surface s, int cluster)
{
    float shade = 0.25 + 0.75 * abs(dot(s.normal, s.view));
    if (frame.mode.y == kViewShadowmask) return s.baked.rgb * mix(0.5, 1.0, s.baked.a);
    if (frame.mode.y == kViewLightmap) return s.lightmapped ? lightmapIrradiance() * (1.0 / kShadingPi) : vec3(0.0);
    if (frame.mode.y == kViewProbes) return probeRadianceSum(false, s.normal) * (1.0 / kShadingPi);
    if (frame.mode.y == kViewFade) return vec3(s.fade);
    if (frame.mode.y == kViewCascades) {
        vec3 colors[4] = vec3[4](vec3(1.0, 0.3, 0.3), vec3(0.3, 1.0, 0.3), vec3(0.3, 0.4, 1.0), vec3(1.0, 1.0, 0.3));
        float nextWeight;
        int cascade = selectCascade(s.cameraDistance, nextWeight);
        vec3 color = mix(colors[cascade], colors[min(cascade + 1, 3)], nextWeight);
        return mix(color, vec3(1.0), s.fade) * shade;
    }
    // Lights with a mask channel that reach the fragment: none black, 1 blue, 2 green, 3 yellow, 4 red, more white.
    int count = 0;
    for (int light = 0; light < frame.mode.w; ++light) {
        if ((clusterWords[cluster + light / 32] >> (light % 32) & 1u) == 0u) continue;
        if ((lights[light].info.y & kLightHasBaked) == 0) continue;
        if (sampleFrameLight(light, s.position).illuminance != vec3(0.0)) ++count;
    }
    vec3 ramp[6] = vec3[6](vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0),
                           vec3(1.0));
    return ramp[min(count, 5)];
}

void main()
{
    Surface s = readSurface();
    vec3 radiance;
    int cluster = clusterBase();
    if (frame.mode.y != kViewLit)
        radiance = debugView(s, cluster);
    else if (materials[push.info.x].info.x != 0)
        radiance = s.baseColor;
    else
        radiance = s.emissive + indirectLight(s) + directLight(s, cluster);
    float alpha = kAlphaMode == kAlphaBlend ? saturate(s.alpha) : 1.0;
    outRadiance = vec4(radiance * alpha, alpha);
}
