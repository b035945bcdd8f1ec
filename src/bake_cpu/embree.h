#pragma once
// Embree 3 and 4 behind one face: headers and the calls whose shape differs.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace halflight::embree {

/// What a ray carries to the filter function. The library's context comes first, so that one pointer is both.
struct RayContext {
#if RTC_VERSION_MAJOR >= 4
    RTCRayQueryContext base;
#else
    RTCIntersectContext base;
#endif
    bool camera = false; ///< camera rays see objects that cast no shadow; others pass through them

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

/// Eight rays at once, for rays that start side by side in similar directions. Lanes with valid 0 are left alone.
constexpr int kPacket = 8;
struct alignas(32) LaneMask {
    int lane[kPacket]; ///< -1 = trace
};

inline void intersect8(RTCScene scene, RayContext& context, const LaneMask& valid, RTCRayHit8& rays)
{
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    rtcIntersect8(valid.lane, scene, &rays, &arguments);
#else
    rtcIntersect8(valid.lane, scene, &context.base, &rays);
#endif
}

inline void occluded8(RTCScene scene, RayContext& context, const LaneMask& valid, RTCRay8& rays)
{
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
