// Structures of the paths of open gather rays, and of emitters, that C++ and shaders share.
#ifndef HALFLIGHT_BAKE_GPU_PATH_LAYOUT_H
#define HALFLIGHT_BAKE_GPU_PATH_LAYOUT_H

#include "bake_gpu/layout.h"

HL_NAMESPACE_BEGIN

// A triangle that rays hit.
struct GpuPathFace {
    uint stored;  // number among BakeGeometry::triangles
    uint part;    // and kHiddenBack
    uint emitter; // number among the emitters; kNone
};
HL_CONST uint kHiddenBack = 0x80000000u;

// BakeGeometry::Part.
struct GpuPathPart {
    uint material;
    uint instance; // kNone: stored in world space
    uint receivesShadows;
};

// TransportMaterial. Of its textures `set` is the number of the texture coordinates; kNone: they are zero. A picture's
// `first` is a texel of four bytes.
struct GpuPathMaterial {
    vec3 baseColor;
    float metallic;
    float roughness;
    float specular;
    vec3 emission;
    uint component; // of its emission
    GpuTextureUse baseColorTexture;
    GpuTextureUse metallicRoughnessTexture;
    GpuTextureUse emissiveTexture;
};

// Emitters::Emissive.
struct GpuEmitter {
    vec3 origin;
    vec3 edge1;
    vec3 edge2;
    vec3 normal;
    vec3 radiance; // if uniform
    float inverseArea;
    uint hitIndex;
    uint masked; // its masked triangle; kNone: it is opaque
    uint flags;
};
HL_CONST uint kUniform = 1u;
HL_CONST uint kDoubleSided = 2u;
HL_CONST uint kRayVisible = 4u;
HL_CONST uint kComponentShift = 8u; // of the emitter's component

HL_CONST int kPathTextureSets = 8; // kTexCoordSets
HL_CONST int kPathLevels = 3;      // RadianceCache::kLevels

// Numbers that all paths of a map share.
struct GpuPathConstants {
    int bounces;
    int levelOfFirst;    // level of the radiance cache at the path's first surface: 0 is the solution
    int levelsPerBounce; // 0: the solution serves paths of any length
    uint levels;         // bit i: there is level i + 1
    uint glossy;         // surfaces have specular lobes
    uint anyLights;      // the scene has lights, though perhaps none of them bounces
    uint choosers;       // SceneLight::choosers()
    uint emitterNodes;
    uint cutNodes;    // of a texel's cut through the tree of emitters
    uint brightAreas; // of the sky's picture
    float brightIlluminance;
    uint coloredVertices; // there are vertex colours
};

HL_NAMESPACE_END

#endif
