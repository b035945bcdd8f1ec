// A point of a surface, as lights see it. The forward path reads it from a mesh (mesh_surface.glsl), the deferred path's
// light pass from the G-buffer (gbuffer.glsl).
#ifndef HALFLIGHT_SURFACE_GLSL
#define HALFLIGHT_SURFACE_GLSL

#include "bindings.glsl"
#include "halflight/shading/law.h"

struct Surface {
    vec3 position;
    vec3 normal;     // with the normal map
    vec3 faceNormal; // of the triangle, towards the camera: what shadow maps see
    vec3 view;       // unit, to the camera
    float cameraDistance;
    float fade; // t of the law
    vec3 baseColor;
    float metallic;
    float roughness;
    float specular;
    bool lightmapped; // lit by its lightmap; others by probes
    bool receiveShadows;
    mat4 baked; // B by channel: a column for each mask layer
};

vec4 layerOfChannel(Surface s, int channel)
{
    vec4 layer = s.baked[0];
    if (kMaskLayers > 1 && channel >= 4) layer = s.baked[1];
    if (kMaskLayers > 2 && channel >= 8) layer = s.baked[2];
    if (kMaskLayers > 2 && channel >= 12) layer = s.baked[3];
    return layer;
}

float bakedOfChannel(Surface s, int channel) { return layerOfChannel(s, channel)[channel & 3]; }

// B by colour of a light; all alike where its mask is grey.
vec3 bakedByColor(Surface s, int light)
{
    int channel = lights[light].info.z;
    bool colored = (lights[light].info.y & kLightColoredMask) != 0;
    return colored ? layerOfChannel(s, channel).rgb : vec3(bakedOfChannel(s, channel));
}

// The point of the world that this pixel's centre shows at a depth.
vec3 worldPosition(float depth)
{
    vec4 r = frame.depthRange; // depth = (z * r.x + r.z) / (z * r.y + r.w) at view space z
    precise float viewDepth = (r.z - depth * r.w) / (r.x - depth * r.y);
    precise vec2 ndc = gl_FragCoord.xy / frame.pictureSize.xy * 2.0 - 1.0;
    precise vec3 across = ndc.x * frame.cameraRight.xyz - ndc.y * frame.cameraUp.xyz;
    precise vec3 position = frame.cameraPosition.xyz + frame.cameraForward.xyz * viewDepth +
                            across * (frame.cameraForward.w > 0.5 ? 1.0 : viewDepth);
    return position;
}

// From the camera to a point of the world, along the ray of its pixel: an orthographic camera has no place.
vec3 viewRay(vec3 position)
{
    vec3 ray = position - frame.cameraPosition.xyz;
    return frame.cameraForward.w > 0.5 ? frame.cameraForward.xyz * dot(frame.cameraForward.xyz, ray) : ray;
}

// What follows from where the point is. Both paths take it from depth, to the last bit alike: a shadow map's comparison
// that falls the other way is a visible difference, however near the two points are.
void placeSurface(inout Surface s, float depth)
{
    s.position = worldPosition(depth);
    vec3 toCamera = frame.cameraPosition.xyz - s.position;
    s.cameraDistance = length(toCamera);
    s.view = frame.cameraForward.w > 0.5 ? -frame.cameraForward.xyz : toCamera / s.cameraDistance;
    s.fade = shadowFade(s.cameraDistance, frame.fade.xy);
}

#endif
