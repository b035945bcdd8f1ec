#version 460
#extension GL_GOOGLE_include_directive : require
#include "shadows.glsl"

layout(local_size_x = 64) in;

// Makes the rays from triangles up to the curved surfaces that vertex normals describe, where shadow rays start unless
// another surface is between: DirectLight::shadowOrigin().
void main()
{
    uint i = invocationOf(kGroupSize);
    if (i >= rayCount()) return;
    GpuRay ray = noRay();
    uint item;
    uint number;
    if (shadowRay(i, item, number)) {
        ShadowTarget target = shadowTarget(item, number);
        if (shadowsFall(target)) {
            vec3 onTriangle;
            vec3 raised;
            shadowOrigins(target.point, onTriangle, raised);
            if (isLifted(target.point, onTriangle, raised)) {
                float lift = distance(onTriangle, raised);
                ray.origin = onTriangle;
                ray.direction = (raised - onTriangle) / lift;
                ray.tMax = lift;
                atomicAdd(push.lists.counts.at[0], 1u);
            }
        }
    }
    push.lists.rays.at[i] = ray;
}
