// Structures of the validity of points that C++ and shaders share. C++ copies its own structures of the same layout:
// their names follow in brackets.
#ifndef HALFLIGHT_BAKE_GPU_VALIDITY_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_VALIDITY_LAYOUT_H

#include "bake_gpu/layout.h"

HL_NAMESPACE_BEGIN

// [DeviceValidity::Point]
struct GpuValidityPoint {
    vec3 origin;
    vec3 normal;
    vec3 geometricNormal;
};
// [DeviceValidity::Texel]
struct GpuValidityTexel {
    uint id;
    uint pointCount;
    GpuValidityPoint points[16];
};

HL_NAMESPACE_END

#endif
