#pragma once
// Embree 3 and 4 behind one face: headers and the calls whose shape differs.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "halflight/base/math.h"

#include <array>
#include <cstdint>

namespace halflight::embree {

/// Eight rays at once, for rays that start side by side in similar directions. Lanes with valid 0 are left alone.
constexpr int kPacket = 8;
struct alignas(32) LaneMask {
    int lane[kPacket]; ///< -1 = trace
};

/// What blended surfaces leave of a ray's light.
struct BlendedTransmittance {
    float share = 1.0f;
    int count = 0;                    ///< of those met
    std::array<uint32_t, 4> triangle; ///< those met; at others the ray passes by chance
};

/// What a ray carries to the filter function. The library's context comes first, so that one pointer is both.
struct RayContext {
#if RTC_VERSION_MAJOR >= 4
    RTCRayQueryContext base;
#else
    RTCIntersectContext base;
#endif
    bool camera = false;                     ///< camera rays see objects that cast no shadow; others pass through them
    BlendedTransmittance* blended = nullptr; ///< by ray id: of rays that are not to pass blended surfaces by chance

    explicit RayContext(bool isCamera) : camera(isCamera)
    {
#if RTC_VERSION_MAJOR >= 4
        rtcInitRayQueryContext(&base);
#else
        rtcInitIntersectContext(&base);
#endif
    }
};

inline void intersect(RTCScene scene, RayContext& context, RTCRayHit& ray)
{
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    rtcIntersect1(scene, &ray, &arguments);
#else
    rtcIntersect1(scene, &context.base, &ray);
#endif
}

inline void occluded(RTCScene scene, RayContext& context, RTCRay& ray)
{
#if RTC_VERSION_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context.base;
    rtcOccluded1(scene, &ray, &arguments);
#else
    rtcOccluded1(scene, &context.base, &ray);
#endif
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

/// Whether a ray met the back of what it hit.
inline bool behind(const RTCRayHit8& rays, int lane)
{
    const RTCHit8& h = rays.hit;
    return glm::dot(vec3(h.Ng_x[lane], h.Ng_y[lane], h.Ng_z[lane]), directionOf(rays.ray, lane)) > 0.0f;
}

/// Whether a device has instructions for eight rays. Without them (processors without AVX) the library takes packets of
/// eight for full ones, whatever lanes are valid; there they are to be traced ray by ray.
[[nodiscard]] inline bool takesPackets(RTCDevice device)
{
    return rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0;
}

inline void intersect8(RTCScene scene, RayContext& context, const LaneMask& valid, RTCRayHit8& rays, bool asPacket)
{
    if (!asPacket) {
        for (unsigned lane = 0; lane < kPacket; ++lane) {
            if (valid.lane[lane] == 0) continue;
            RTCRayHit ray = rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&rays), kPacket, lane);
            intersect(scene, context, ray);
            rays.ray.tfar[lane] = ray.ray.tfar;
            rtcCopyHitToHitN(reinterpret_cast<RTCHitN*>(&rays.hit), &ray.hit, kPacket, lane);
        }
        return;
    }
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    rtcIntersect8(valid.lane, scene, &rays, &arguments);
#else
    rtcIntersect8(valid.lane, scene, &context.base, &rays);
#endif
}

inline void occluded8(RTCScene scene, RayContext& context, const LaneMask& valid, RTCRay8& rays, bool asPacket)
{
    if (!asPacket) {
        for (unsigned lane = 0; lane < kPacket; ++lane) {
            if (valid.lane[lane] == 0) continue;
            RTCRay ray = rtcGetRayFromRayN(reinterpret_cast<RTCRayN*>(&rays), kPacket, lane);
            occluded(scene, context, ray);
            rays.tfar[lane] = ray.tfar;
        }
        return;
    }
#if RTC_VERSION_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context.base;
    rtcOccluded8(valid.lane, scene, &rays, &arguments);
#else
    rtcOccluded8(valid.lane, scene, &context.base, &rays);
#endif
}

} // namespace halflight::embree
