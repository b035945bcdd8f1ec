// Stored triangles of the scene, placed in the world: BakeGeometry's.
#ifndef HALFLIGHT_BAKE_SURFACES_GLSL
#define HALFLIGHT_BAKE_SURFACES_GLSL

#include "scene.glsl"

layout(buffer_reference, scalar) buffer Corners { uvec3 at[]; };
layout(buffer_reference, scalar) buffer Frames { GpuTriangleFrame at[]; };
layout(buffer_reference, scalar) buffer Instances { GpuInstance at[]; };

// SurfaceAddresses of src/bake_gpu/gpu_surfaces.cpp: the stored triangles, and where they are placed.
layout(buffer_reference, scalar) buffer SurfaceData
{
    Corners corners; // by stored triangle: its vertices
    Frames frames;   // the same
    Vectors positions; // by stored vertex
    Vectors normals;
    Pairs places; // of the vertices on the page, in texels
    Instances instances;
};

// BakeGeometry::verticesOf(). `instance` is kNone of what is stored in world space.
uvec3 cornersOf(SurfaceData surfaces, uint triangle, uint instance)
{
    uvec3 corners = surfaces.corners.at[triangle];
    bool turned = instance != kNone && surfaces.instances.at[instance].mirrored != 0u;
    return turned ? corners.xzy : corners;
}
vec3 positionOf(SurfaceData surfaces, uint instance, uint corner)
{
    vec3 stored = surfaces.positions.at[corner];
    if (instance == kNone) return stored;
    GpuInstance place = surfaces.instances.at[instance];
    return mat3(place.linear[0], place.linear[1], place.linear[2]) * stored + place.origin;
}
vec3 worldNormal(SurfaceData surfaces, uint instance, vec3 stored)
{
    if (instance == kNone) return stored;
    GpuInstance place = surfaces.instances.at[instance];
    vec3 n = mat3(place.worldFromNormal[0], place.worldFromNormal[1], place.worldFromNormal[2]) * stored;
    float size = length(n);
    return size > 0.0 ? n / size : stored;
}
vec3 normalOf(SurfaceData surfaces, uint instance, uint corner)
{
    return worldNormal(surfaces, instance, surfaces.normals.at[corner]);
}

#endif
