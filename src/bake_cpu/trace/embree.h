#pragma once
// Embree 3 and 4 behind one interface: headers and the calls whose signatures differ.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "bake_cpu/trace/passed_glass.h"

#include <array>
#include <cstdint>

namespace halflight::embree {

/// Rays of one packet. Packets are fast where their rays start side by side in similar directions.
constexpr int kPacket = 8;
/// Lanes with value 0 are neither read nor written.
struct alignas(32) LaneMask {
    int lane[kPacket]; ///< -1 = trace
};

/// Transmittance of the blended surfaces along one ray.
struct BlendedTransmittance {
    float transmittance = 1.0f;
    int count = 0;                    ///< of `triangle`
    std::array<uint32_t, 4> triangle; ///< surfaces that count; further ones are opaque or transparent by chance
};

/// What a ray passes of solids, all along its way.
struct SolidsPassed {
    static constexpr int kMost = 64; ///< surfaces; a ray through more, of a forest, decides nothing
    int left = 0;                    ///< solids left minus solids entered
    int count = 0;                   ///< of `triangles`
    std::array<uint32_t, kMost> triangles;
};

/// Per-call data of the filter functions. The library's context is the first member, so that one pointer is both.
struct RayContext {
#if RTC_VERSION_MAJOR >= 4
    RTCRayQueryContext base;
#else
    RTCIntersectContext base;
#endif
    bool camera = false;                     ///< camera rays hit objects that cast no shadow; other rays do not
    BlendedTransmittance* blended = nullptr; ///< by ray id; null = blended surfaces are hit by chance
    PassedGlass* glass = nullptr;            ///< by ray id, in place of `blended`; null = no glass has a colour
    bool byChance = true;                    ///< `glass` gets what passes by chance, else all that passes
    SolidsPassed* solids = nullptr;          ///< null = not counted

    explicit RayContext(bool isCamera) : camera(isCamera)
    {
#if RTC_VERSION_MAJOR >= 4
        rtcInitRayQueryContext(&base);
#else
        rtcInitIntersectContext(&base);
#endif
    }
};

/// A scene's rays may have a filter function of their own, which is called after those of geometries.
#if RTC_VERSION_MAJOR >= 4
constexpr RTCSceneFlags kRaysMayFilter = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
constexpr RTCSceneFlags kRaysMayFilter = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif

/// `filter`: of this ray, or null.
inline void intersect(RTCScene scene, RayContext& context, RTCRayHit& ray, RTCFilterFunctionN filter = nullptr)
{
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context.base;
    arguments.filter = filter;
    if (filter != nullptr) arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcIntersect1(scene, &ray, &arguments);
#else
    context.base.filter = filter;
    rtcIntersect1(scene, &context.base, &ray);
#endif
}

/// The same.
inline void occluded(RTCScene scene, RayContext& context, RTCRay& ray, RTCFilterFunctionN filter = nullptr)
{
#if RTC_VERSION_MAJOR >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context.base;
    arguments.filter = filter;
    if (filter != nullptr) arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcOccluded1(scene, &ray, &arguments);
#else
    context.base.filter = filter;
    rtcOccluded1(scene, &context.base, &ray);
#endif
}

/// Whether a device has instructions for packets of eight. Without them (processors without AVX) Embree ignores the
/// lane mask, so the rays are traced one by one.
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
