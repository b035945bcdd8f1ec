// Structures that the renderer's C++ and its shaders share. Members are 16 bytes wide (or arrays of such), so that
// std140, std430 and C++ lay them out alike.
#ifndef HALFLIGHT_RENDER_GPU_LAYOUT_H
#define HALFLIGHT_RENDER_GPU_LAYOUT_H

#include "halflight/shading/language.h"

HL_NAMESPACE_BEGIN

#ifdef __cplusplus
using halflight::ivec4;
using halflight::mat4;
using halflight::vec4;
#endif

// Descriptor bindings of set 0.
HL_CONST int kBindFrame = 0;
HL_CONST int kBindObjects = 1;
HL_CONST int kBindMaterials = 2;
HL_CONST int kBindLights = 3;
HL_CONST int kBindTiles = 4;
HL_CONST int kBindClusters = 5;
HL_CONST int kBindInstances = 6;
HL_CONST int kBindLightmaps = 7;
HL_CONST int kBindShadowmasks = 8;
HL_CONST int kBindCascades = 9;
HL_CONST int kBindAtlas = 10;
HL_CONST int kBindGBufferBaseColor = 11; // the deferred path's light pass: see shaders/gbuffer.glsl
HL_CONST int kBindGBufferNormals = 12;
HL_CONST int kBindGBufferMaterial = 13;
HL_CONST int kBindGBufferMask = 14;
HL_CONST int kBindDepth = 15;
HL_CONST int kBindProbeVolumes = 16;
HL_CONST int kBindProbeTexture = 17;
HL_CONST int kBindLightmapDirections = 18;
HL_CONST int kBindDynamicLightmaps = 19;
HL_CONST int kBindSkyPicture = 20;
HL_CONST int kBindReflectionProbes = 21;
HL_CONST int kBindReflections = 22;
HL_CONST int kBindRadiance = 23;      // the finished frame's samples: shaders/display.frag
HL_CONST int kBindCascadeDepths = 24; // the images of kBindCascades and kBindAtlas, without comparison
HL_CONST int kBindAtlasDepths = 25;
HL_CONST int kBindGBufferFurtherMask = 26;
HL_CONST int kBindOpticalDepths = 27; // of glass volumes: shaders/absorb.frag
HL_CONST int kBindTextures = 28;      // the last: its length varies

// Debug views: the values of DebugView in renderer.h.
HL_CONST int kViewLit = 0;
HL_CONST int kViewShadowmask = 1;
HL_CONST int kViewLightmap = 2;
HL_CONST int kViewProbes = 3;
HL_CONST int kViewCascades = 4;
HL_CONST int kViewFade = 5;
HL_CONST int kViewOverlap = 6;
HL_CONST int kViewTexels = 7;

// Half-width of the shadow filter's tent in texels, by ShadowFilter; 0 = one bilinear tap.
HL_CONST int kFilterHalfWidthPcf = 2;
HL_CONST int kFilterHalfWidthSoft = 4;

// Thresholds of blended surfaces in shadow maps repeat after so many texels; a power of two.
HL_CONST int kAlphaPeriod = 32;

// How cascades blend: the values of CascadeBlend in frame.h.
HL_CONST int kBlendHard = 0;
HL_CONST int kBlendDithered = 1;
HL_CONST int kBlendSoft = 2;

HL_CONST int kAlphaOpaque = 0;
HL_CONST int kAlphaMask = 1;
HL_CONST int kAlphaBlend = 2;
HL_CONST int kAlphaPass = 3; // what a blended surface lets through, by colour

struct GpuFrame {
    vec4 cameraPosition; // xyz world
    vec4 cameraForward;  // xyz unit; w = 1 for orthographic cameras
    vec4 cameraRight;    // xyz unit times half the picture's width in metres, at 1 m for perspective cameras
    vec4 cameraUp;       // xyz unit times half the picture's height
    vec4 depthRange;     // of clipFromView, columns 2 and 3: xy their z and w in column 2, zw in column 3
    vec4 pictureSize;    // xy pixels
    vec4 fade;           // xy: fadeConstants()
    vec4 cascadeFar;     // radial metres where each cascade ends
    vec4 shadowBias;     // z cascade blend fraction; the biases are in GpuLight
    vec4 skyZenith;      // rgb cd/m2
    vec4 skyHorizon;
    vec4 skyGround;
    vec4 skyPicture;             // xy cosine and sine of its rotation, z width in texels (0 = the gradient)
    vec4 skyPictureNits;         // rgb cd/m2 of 1
    vec4 subtractiveShadowColor; // rgb lux; w lux that a lightmap texel of 1 stands for
    vec4 maskRange[4];           // by mask layer and channel, MaskChannel::rangeTexels
    vec4 maskPenumbra[4];        // by mask layer and channel, MaskChannel::penumbraTexels
    vec4 clusterRange;           // x near, y far (metres of view depth), z slices / log2(far / near)
    ivec4 clusterSize;           // xyz
    ivec4 mode;                  // x run mode, y debug view, z main light (-1 none), w light count
    ivec4 shadow;                // x filter half-width, y cascades per directional light, z how cascades blend,
                                 // w 1 = objects that have a proxy volume take probe light from it
    ivec4 baked;                 // x 1 = the lightmap has directions, y 1 = dynamic lightmap pages are set,
                                 // z 1 = surfaces are diffuse, of transportAlbedo(), w mask layers of the scene
    vec4 dynamicLightmap;        // x lux that a texel of 1 stands for
    vec4 reflections;            // x probes, 0 where none are used; y width of a tile in texels; z cd/m2 of 1
    vec4 display;     // x exposure factor; y samples along a pixel's side; z 1 = samples are values from 0 to 1
                      // and shown as they are; w 1 = the target encodes sRGB
    vec4 displaySize; // xy pixels in which the picture is shown
    vec4 skySh[9];    // rgb radiance coefficients of the sky
};

HL_CONST int kObjectLightmapped = 1; // lit by its lightmap; others by probes
HL_CONST int kObjectReceiveShadows = 2;

struct GpuObject {
    mat4 worldFromObject;
    vec4 normalFromObject[3]; // columns of the inverse transpose; [0].w = sign of the transform's determinant
    vec4 lightmapScaleOffset; // xy scale, zw offset
    ivec4 info;               // x flags, y lightmap page, z proxy volume (-1 none)
    vec4 probeOcclusion[4];   // baked attenuation by mask layer and channel
    vec4 probeSh[9];          // rgb radiance coefficients
};

// A proxy volume is a box of one 3D texture that holds them all, once for each slab of its depth: slab i is texture i
// of ProxyVolume (probes.h). Each mask layer beyond the first has one more.
HL_CONST int kProbeSlabs = 8;

struct GpuProbeVolume {
    mat4 slabFromWorld; // to coordinates of the texture, slab 0
    vec4 low;           // xyz: the first texel's centre; w factor on the radiance stored
    vec4 high;          // xyz: the last texel's centre
};

struct GpuReflectionProbe {
    mat4 boxFromWorld; // to the cube [-1, 1]^3
    vec4 position;     // xyz world; w fade in metres
    vec4 halfSize;     // xyz metres: of the box
};

HL_CONST int kTextureBaseColor = 0;
HL_CONST int kTextureMetallicRoughness = 1;
HL_CONST int kTextureNormal = 2;
HL_CONST int kTextureOcclusion = 3;
HL_CONST int kTextureEmissive = 4;
HL_CONST int kTextureTransmission = 5;
HL_CONST int kTextureThickness = 6;
HL_CONST int kMaterialTextures = 7;

struct GpuTextureRef {
    vec4 matrix; // rows (x, y) and (z, w): uv' = matrix * uv + offset
    vec4 offset; // xy
    ivec4 info;  // x index into the texture array, -1 none; y coordinate set 0 or 1
};

struct GpuMaterial {
    vec4 baseColor;
    vec4 emissiveMetallic; // rgb cd/m2, a metallic
    vec4 parameters;       // x roughness, y normal scale, z occlusion strength, w alpha cutoff
    ivec4 info;            // x 1 = unlit, y 1 = receives shadows, z 1 = alpha is coverage
    vec4 reflection;       // x specular factor, y what glass lets through where its texture says 1 and metallic is 0,
                           // z 1 = what alpha leaves open takes the base colour
    vec4 volume;           // rgb attenuation in 1/m, a thickness in the mesh's space
    GpuTextureRef textures[kMaterialTextures];
};

// Descriptor bindings of the compose pass (S33), in a set of its own.
HL_CONST int kBindSourcePages = 0;      // of the rest and of groups, a layer for each page with light
HL_CONST int kBindSourceDirections = 1; // of those that have directions
HL_CONST int kBindSources = 2;
HL_CONST int kBindComposedPages = 3;
HL_CONST int kBindComposedDirections = 4;
HL_CONST int kComposeSide = 8; // texels along a side of a group of invocations

// What a page is composed of. The first one is the rest's.
struct GpuLightSource {
    vec4 weight; // rgb: its unit times its weight, over the unit of the sum
    ivec4 info;  // x layer of its page, -1 where the list ends; y layer of its directions, -1 none
};

struct GpuCompose {
    ivec4 size; // xy texels of a page, z sources in the list of each page, w 1 = pages have directions
};

HL_CONST int kLightHasBaked = 1;
HL_CONST int kLightHasRealtime = 2;
HL_CONST int kLightSkipStatic = 4;
HL_CONST int kLightSkipDynamic = 8;
HL_CONST int kLightOverflowed = 16;  // there for the overlap view alone
HL_CONST int kLightColoredMask = 32; // B has a colour: R, G and B of the channel's layer

struct GpuLight {
    vec4 positionRange;  // xyz world, w range in metres (0 = unlimited)
    vec4 colorIntensity; // rgb lux, candela, or cd/m2 of area lights; w shadow strength
    vec4 axis;           // xyz unit, along which the light shines
    vec4 spot;           // xy: spotConstants(); z number of shadow tiles
    ivec4 info;          // x type, y flags, z channel, w first tile
    vec4 shadowBias;     // x depth bias, y normal bias, in texels; z half the source's width: tangent of its angle
                         // (directional) or metres, 0 = penumbrae do not depend on it; w slope bias
    vec4 bakedReach;     // xyz world: where the light was baked; w metres from there its channel holds for, 0 = all
    vec4 bakedCone;      // xyz unit: axis at the bake; w cosine of the cone its channel holds for, -2 = all
    vec4 halfX;          // xyz metres: area lights, from the middle to the edges along their X and Y
    vec4 halfY;
};

struct GpuTile {
    mat4 clipFromWorld;
    mat4 planeFromWorld; // planes (n, d) of the world to planes of clip space: the inverse transpose of clipFromWorld
    vec4 rectangle;      // xy offset in texels, z size in texels, w layer
    vec4 parameters;     // x metres of a texel (at 1 m distance for perspective tiles); y 0 = it has no caster and
                         // was not drawn; zw metres from the light along the tile's axis of depth 0 and 1
};

struct GpuPush {
    mat4 clipFromWorld;
    ivec4
        info; // x material; yz in shadow maps: the texel from which alpha thresholds count (shaders/hashed_alpha.glsl);
              // w of blended parts: 1 = closed, so that its volume is drawn by its faces (shaders/volume.frag)
};

HL_NAMESPACE_END

#endif
