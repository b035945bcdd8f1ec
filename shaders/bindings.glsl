// Everything the renderer's shaders read: one descriptor set.
#ifndef HALFLIGHT_BINDINGS_GLSL
#define HALFLIGHT_BINDINGS_GLSL

#include "render/scene/gpu_layout.h"

// Mask layers that the frame reads (S11, S36): 0, 1, 2 or 4.
layout(constant_id = 1) const int kMaskLayers = 4;

// S35. Whether a light of the frame reads a mask that has a colour.
layout(constant_id = 2) const bool kColoredMasks = false;

layout(std140, set = 0, binding = kBindFrame) uniform FrameBlock { GpuFrame frame; };
layout(std430, set = 0, binding = kBindObjects) readonly buffer ObjectBlock { GpuObject objects[]; };
layout(std430, set = 0, binding = kBindMaterials) readonly buffer MaterialBlock { GpuMaterial materials[]; };
layout(std430, set = 0, binding = kBindLights) readonly buffer LightBlock { GpuLight lights[]; };
layout(std430, set = 0, binding = kBindTiles) readonly buffer TileBlock { GpuTile tiles[]; };
layout(std430, set = 0, binding = kBindClusters) readonly buffer ClusterBlock { uint clusterWords[]; };
layout(std430, set = 0, binding = kBindInstances) readonly buffer InstanceBlock { uint instanceObjects[]; };
layout(set = 0, binding = kBindLightmaps) uniform sampler2DArray lightmaps;
layout(set = 0, binding = kBindLightmapDirections) uniform sampler2DArray lightmapDirections;
layout(set = 0, binding = kBindDynamicLightmaps) uniform sampler2DArray dynamicLightmaps;
layout(set = 0, binding = kBindShadowmasks) uniform sampler2DArray shadowmasks;
layout(set = 0, binding = kBindCascades) uniform sampler2DArrayShadow cascadeMaps;
layout(set = 0, binding = kBindAtlas) uniform sampler2DArrayShadow atlasMap;
layout(set = 0, binding = kBindCascadeDepths) uniform sampler2DArray cascadeDepths;
layout(set = 0, binding = kBindAtlasDepths) uniform sampler2DArray atlasDepths;
layout(std430, set = 0, binding = kBindProbeVolumes) readonly buffer ProbeVolumeBlock { GpuProbeVolume probeVolumes[]; };
layout(set = 0, binding = kBindProbeTexture) uniform sampler3D probeTexture;
layout(set = 0, binding = kBindSkyPicture) uniform sampler2D skyPicture;
layout(std430, set = 0, binding = kBindReflectionProbes) readonly buffer ReflectionProbeBlock { GpuReflectionProbe reflectionProbes[]; };
layout(set = 0, binding = kBindReflections) uniform sampler2D reflectionPicture;
layout(set = 0, binding = kBindRadiance) uniform sampler2D radianceSamples;
layout(set = 0, binding = kBindTextures) uniform sampler2D textures[];

layout(push_constant) uniform PushBlock { GpuPush push; };

#endif
