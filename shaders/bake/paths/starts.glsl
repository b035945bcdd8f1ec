// Where whole paths begin, and what they bring: DevicePaths.
#ifndef HALFLIGHT_BAKE_PATH_STARTS_GLSL
#define HALFLIGHT_BAKE_PATH_STARTS_GLSL

#include "lights.glsl"

layout(buffer_reference, scalar) buffer PathItems { GpuPathItem at[]; };
layout(buffer_reference, scalar) buffer Arrivals { GpuArrival at[]; };
layout(buffer_reference, scalar) buffer Emissions { GpuEmission at[]; };

// StartLists of src/bake_gpu/paths/paths.cpp: what a call for whole paths works on, in the place of the gather's lists.
layout(buffer_reference, scalar) buffer PathStarts
{
    Points points; // their positions are on the surface
    PathItems items;
    Arrivals arrivals; // by item, then by path
    Emissions emissions;
    Vectors components; // radiance, by path as arrivals, then by component
    GpuPathCall all;
};

PathStarts starts()
{
    return PathStarts(uvec2(push.lists));
}

// A path of a call. Those of a chunk of items are in a row with neighbouring items first (bake_gpu/layout.h).
struct PathStart {
    uint item;
    uint path; // number among all paths of the item
    uint place; // of its results
};

// False beyond the list of items.
bool startOf(uint ray, out PathStart start)
{
    GpuPathCall all = starts().all;
    start.item = itemOfRay(ray, all.pathsOfItem);
    uint number = numberInItem(ray, all.pathsOfItem);
    start.path = all.firstPath + number;
    start.place = start.item * all.pathsOfItem + number;
    return start.item < all.itemCount;
}

// The point where a path begins, as a surface that has nothing but a place.
PathSurface startSurface(PathStart start)
{
    GpuPathItem item = starts().items.at[start.item];
    GpuPoint point = starts().points.at[item.firstPoint + start.path % item.pointCount];
    PathSurface s;
    s.position = point.position;
    s.normal = point.normal;
    s.geometricNormal = point.geometricNormal;
    return s;
}

// Direction of the first ray.
vec3 startDirection(PathSurface s, vec2 u, out float pdf)
{
    if (isInSpace(s)) {
        pdf = kUniformPdf;
        return sampleSphere(u);
    }
    vec3 direction = gatherDirection(s.normal, s.geometricNormal, u);
    pdf = gatherDirectionPdf(s.normal, direction);
    return direction;
}

#endif
