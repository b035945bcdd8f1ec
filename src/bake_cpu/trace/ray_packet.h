#pragma once
// Access to the lanes of Embree's packets of eight rays.

#include "bake_cpu/trace/embree.h"

#include "halflight/base/math.h"

namespace halflight::embree {

/// Sets the default values of all rays; origins and directions are left as they are.
inline void clear(RTCRay8& rays)
{
    for (int i = 0; i < kPacket; ++i) {
        rays.tnear[i] = 0.0f;
        rays.tfar[i] = kInfinity;
        rays.time[i] = 0.0f;
        rays.mask[i] = ~0u;
        rays.id[i] = 0u;
        rays.flags[i] = 0u;
    }
}

inline void setRay(RTCRay8& rays, int lane, vec3 origin, vec3 direction)
{
    rays.org_x[lane] = origin.x;
    rays.org_y[lane] = origin.y;
    rays.org_z[lane] = origin.z;
    rays.dir_x[lane] = direction.x;
    rays.dir_y[lane] = direction.y;
    rays.dir_z[lane] = direction.z;
}

inline vec3 directionOf(const RTCRay8& rays, int lane)
{
    return {rays.dir_x[lane], rays.dir_y[lane], rays.dir_z[lane]};
}

inline vec2 barycentricOf(const RTCRayHit8& rays, int lane)
{
    return {rays.hit.u[lane], rays.hit.v[lane]};
}

/// Geometric normal of the hit, as Embree has it: not normalized, towards the triangle's front.
inline vec3 normalOf(const RTCRayHit8& rays, int lane)
{
    return {rays.hit.Ng_x[lane], rays.hit.Ng_y[lane], rays.hit.Ng_z[lane]};
}

inline bool found(const RTCRayHit8& rays, int lane)
{
    return rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
}

/// Whether a ray hit the back of its triangle.
inline bool hitBack(const RTCRayHit8& rays, int lane)
{
    return glm::dot(normalOf(rays, lane), directionOf(rays.ray, lane)) > 0.0f;
}

} // namespace halflight::embree
