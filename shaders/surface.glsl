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
    vec4 baked; // B by channel
};

// What follows from where the point is.
void placeSurface(inout Surface s, vec3 position)
{
    s.position = position;
    vec3 toCamera = frame.cameraPosition.xyz - position;
    s.cameraDistance = length(toCamera);
    s.view = frame.cameraForward.w > 0.5 ? -frame.cameraForward.xyz : toCamera / s.cameraDistance;
    s.fade = shadowFade(s.cameraDistance, frame.fade.xy);
}

#endif
