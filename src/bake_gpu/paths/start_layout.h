// Structures of whole paths that C++ and shaders share. C++ copies its own structures of the same layout: their names
// follow in brackets.
#ifndef HALFLIGHT_BAKE_GPU_START_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_START_LAYOUT_H

#include "bake_gpu/layout.h"

HL_NAMESPACE_BEGIN

// [DevicePaths::Item, Arrival, Emission]
struct GpuPathItem {
    uint id;
    uint firstPoint;
    uint pointCount;
};
struct GpuArrival {
    vec3 radiance;
    vec3 direction;
    uint rays;
    uint back; // 1: a hidden back; from bit 16 on the component of the emission's emitter
};
struct GpuEmission {
    vec3 ofEmitter;
    vec3 toEmitter;
    vec3 ofSky;
    vec3 toSky;
};

// Numbers of a call.
struct GpuPathCall {
    uint seed;
    uint itemCount;
    uint firstPath;
    uint pathsOfItem;
    uint byComponent; // light is kept by component too
};

HL_NAMESPACE_END

#endif
