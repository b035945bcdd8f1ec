#pragma once
// A baked scene on the device.

#include "gpu/pipeline.h"
#include "gpu/resources.h"
#include "halflight/base/hash.h"
#include "halflight/render/probes.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/baked_scene.h"
#include "render/scene/gpu_layout.h"
#include "render/scene/light_groups.h"
#include "render/scene/probe_volumes.h"
#include "render/scene/reflections.h"
#include "render/scene/sky_picture.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

/// A mesh part within the scene's index and vertex buffers.
struct DrawPart {
    uint32_t firstIndex = 0;
    uint32_t indexCount = 0;
    int32_t firstVertex = 0;
    int material = 0; ///< index into the material buffer
    Material::AlphaMode alphaMode = Material::AlphaMode::Opaque;
    bool tintsLight = false;   ///< what is seen through it takes its colour
    bool closedVolume = false; ///< of glass that takes light on the way through it, by its faces
    bool doubleSided = false;
    bool castShadows = true; ///< its material's switch
    vec3 center{0.0f};       ///< of its bounds, object space
};

struct GpuScene {
    gpu::Buffer positions;  ///< vertex binding 0: vec3
    gpu::Buffer maskInputs; ///< vertex binding 1: MaskVertex
    gpu::Buffer litInputs;  ///< vertex binding 2: LitVertex
    gpu::Buffer indices;
    gpu::Buffer objects;                                     ///< GpuObject
    gpu::Buffer materials;                                   ///< GpuMaterial; the last one is glTF's default
    std::vector<std::shared_ptr<const gpu::Image>> textures; ///< those of two scenes may be the same
    std::vector<Hash128> textureHashes; ///< per element of textures: of what its image was made from
    std::vector<gpu::UniqueSampler> samplers;
    std::vector<uint32_t> samplerOfTexture; ///< per element of textures
    gpu::Image lightmaps;                   ///< of scenes with light groups, and the directions: composed by frames
    gpu::Image lightmapDirections;
    float lightmapUnitLux = 1.0f; ///< lux that a texel of `lightmaps` stands for
    gpu::Image shadowmasks;
    gpu::Image dynamicLightmaps;      ///< one black texel while the application has set none
    bool hasDynamicLightmaps = false; ///< it has
    float dynamicUnitLux = 1.0f;      ///< lux that a texel of 1 stands for

    std::vector<std::vector<DrawPart>> meshes;
    std::vector<bool> mirrored;    ///< per object: its transform turns front faces clockwise
    std::vector<bool> lightmapped; ///< per object: lit by its lightmap, not by probes
    std::vector<Bounds> bounds;    ///< per object, world space
    SkyTexture sky;
    ReflectionTextures reflections;
    vec4 skySh[9];
    vec3 skyFactor{1.0f}; ///< of the sky's picture

    /// What planFrame() reads: no vertices, no pixels. Lights and objects may change between frames. Of groups and
    /// their probes it has all but pages.
    BakedScene outline;
    GroupState groups;
    std::vector<Bounds> meshBounds;          ///< object space
    std::optional<ProbeInterpolator> probes; ///< for objects that move
    ProbeVolumes probeVolumes;
    std::vector<uint32_t> changedObjects; ///< changed in `outline`, not yet on the device
};

/// What depth and shadow passes read for alpha masks.
struct MaskVertex {
    vec2 uv[2];
    vec4 color;
};
struct LitVertex {
    vec3 normal;
    vec4 tangent;
    vec2 lightmapUv;
};

/// FileInvalid or InvalidArgument when the scene's parts do not fit together (an index out of range, say); throws
/// gpu::Failure when the device cannot hold it.
Status checkScene(const BakedScene& baked);
/// What GpuScene::outline has of a bake.
BakedScene outlineOf(const BakedScene& baked);
/// Why a light cannot be drawn; null when it can.
const char* problemOf(const Light& light);
/// Images of textures by the hash of what they were made from.
using TextureImages = std::map<Hash128, std::shared_ptr<const gpu::Image>>;
/// `kept`: of the scene before; those that this scene has too are used again. May run while another thread records
/// frames of another scene. With `cancel` set, textures are left out.
GpuScene uploadScene(gpu::Device& device, const BakedScene& baked, TextureImages kept, TextureDetail detail,
                     const std::atomic<bool>* cancel = nullptr);
/// Irradiance pages (lux) as the scene's dynamic lightmaps; an empty span takes them away. True when the image was made
/// anew, so that its descriptor must be written. Pages have passed checkDynamicLightmaps().
bool uploadDynamicLightmaps(gpu::Device& device, GpuScene& scene, std::span<const ImageRgb32f> irradiance);
Status checkDynamicLightmaps(const BakedScene& baked, std::span<const ImageRgb32f> irradiance);
/// Brings changed objects to the device, with their bounds and the probe light where they are now.
void uploadChangedObjects(gpu::Device& device, GpuScene& scene);

} // namespace halflight
