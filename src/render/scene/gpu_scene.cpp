#include "render/scene/gpu_scene.h"

#include "render/scene/frame_bindings.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/render/frame.h"
#include "halflight/shading/coverage.h"
#include "render/frame/frame_internal.h"
#include "render/scene/mipmaps.h"
#include "render/scene/upload_pages.h"
#include "scene/model/closed_part.h"
#include "scene/model/tint.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <tuple>

namespace halflight {
namespace {

using shading::GpuMaterial;
using shading::GpuObject;
using shading::GpuTextureRef;

static_assert(kGlassTransmittance == shading::kFaceTransmittance);

constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
constexpr float kMaxAnisotropy = 8.0f;

template<typename T> gpu::Buffer uploadVector(gpu::Device& device, gpu::Uploader& uploader,
                                              const std::vector<T>& values, VkBufferUsageFlags usage)
{
    gpu::Buffer buffer(device, values.size() * sizeof(T), usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                       gpu::MemoryUse::Device);
    uploader.buffer(buffer, values.data(), values.size() * sizeof(T));
    return buffer;
}

/// The two texture coordinate sets that vertices of the material carry: 0 and 1, or those that its textures read.
std::array<int, 2> setsOf(const Material& material)
{
    std::set<int> read;
    for (const TextureRef* ref : material.textureRefs()) {
        if (*ref) read.insert(ref->texCoord);
    }
    if (read.empty() || *read.rbegin() < 2) return {0, 1};
    return {*read.begin(), *read.rbegin()};
}

void uploadMeshes(gpu::Device& device, gpu::Uploader& uploader, const Scene& scene, GpuScene& result)
{
    std::vector<vec3> positions;
    std::vector<MaskVertex> maskInputs;
    std::vector<LitVertex> litInputs;
    std::vector<uint32_t> indices;
    for (const Mesh& mesh : scene.meshes) {
        std::vector<DrawPart>& parts = result.meshes.emplace_back();
        for (const MeshPart& part : mesh.parts) {
            if (part.indices.empty()) continue;
            const Material& material = materialOf(scene, part);
            DrawPart draw;
            draw.firstIndex = uint32_t(indices.size());
            draw.indexCount = uint32_t(part.indices.size());
            draw.firstVertex = int32_t(positions.size());
            draw.material = part.material >= 0 ? part.material : int(scene.materials.size());
            draw.alphaMode = material.isBlended() ? Material::AlphaMode::Blend : material.alphaMode;
            draw.closedVolume = material.attenuates() && isClosed(part);
            draw.tintsLight =
                (passesBaseColor(material) &&
                 (material.baseColorTexture || vec3(material.baseColor) != vec3(1.0f) || !part.colors.empty())) ||
                (material.attenuates() && !draw.closedVolume);
            draw.doubleSided = isDoubleSided(scene, part);
            draw.castShadows = material.castShadows;
            Bounds bounds;
            for (const vec3& position : part.positions) bounds.extend(position);
            draw.center = bounds.center();
            parts.push_back(draw);

            positions.insert(positions.end(), part.positions.begin(), part.positions.end());
            indices.insert(indices.end(), part.indices.begin(), part.indices.end());
            auto at = [](const auto& values, std::size_t i, auto absent) {
                return values.empty() ? absent : values[i];
            };
            const std::array<int, 2> sets = setsOf(material);
            const std::vector<vec2>& uvA = part.uv[std::size_t(sets[0])];
            const std::vector<vec2>& uvB = part.uv[std::size_t(sets[1])];
            for (std::size_t i = 0; i < part.positions.size(); ++i) {
                maskInputs.push_back(
                    {{at(uvA, i, vec2(0.0f)), at(uvB, i, vec2(0.0f))}, at(part.colors, i, vec4(1.0f))});
                litInputs.push_back({at(part.normals, i, vec3(0.0f)), at(part.tangents, i, vec4(0.0f)),
                                     at(part.lightmapUv, i, vec2(0.0f))});
            }
            if (positions.size() > std::size_t(INT32_MAX) || indices.size() > std::size_t(UINT32_MAX))
                throw gpu::Failure("the scene has more than two billion vertices");
        }
    }
    result.positions = uploadVector(device, uploader, positions, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    result.maskInputs = uploadVector(device, uploader, maskInputs, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    result.litInputs = uploadVector(device, uploader, litInputs, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    result.indices = uploadVector(device, uploader, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
}

/// Elements of the shader's texture array: a texture that is read both as colour and as data has two.
class TextureSlots {
public:
    int slot(int texture, bool srgb)
    {
        if (texture < 0) return -1;
        return slots_.try_emplace({texture, srgb}, int(slots_.size())).first->second;
    }
    [[nodiscard]] const std::map<std::pair<int, bool>, int>& all() const { return slots_; }

private:
    std::map<std::pair<int, bool>, int> slots_;
};

/// `sets`: those of the material's vertices.
GpuTextureRef gpuTextureRef(const Scene& scene, const TextureRef& ref, std::array<int, 2> sets, bool srgb,
                            TextureSlots& slots)
{
    const bool usable = ref && !scene.textures[std::size_t(ref.texture)].pixels.empty();
    const float c = math::cos(ref.rotationRadians);
    const float s = math::sin(ref.rotationRadians);
    GpuTextureRef result{};
    result.matrix = {c * ref.scale.x, s * ref.scale.y, -s * ref.scale.x, c * ref.scale.y};
    result.offset = vec4(ref.offset, 0.0f, 0.0f);
    result.info = ivec4(usable ? slots.slot(ref.texture, srgb) : -1, ref.texCoord == sets[0] ? 0 : 1, 0, 0);
    return result;
}

GpuMaterial gpuMaterial(const Scene& scene, const Material& material, TextureSlots& slots)
{
    GpuMaterial result{};
    result.baseColor = material.baseColor;
    result.emissiveMetallic = vec4(material.emissiveNits, material.metallic);
    result.parameters = {material.roughness, material.normalScale, material.occlusionStrength,
                         material.alphaMode == Material::AlphaMode::Mask ? material.alphaCutoff : 0.0f};
    result.info = ivec4(material.unlit ? 1 : 0, material.receiveShadows ? 1 : 0,
                        material.alphaMode == Material::AlphaMode::Blend ? 1 : 0, 0);
    result.reflection =
        vec4(material.specular, kGlassTransmittance * material.transmission, material.tinted ? 1.0f : 0.0f, 0.0f);
    result.volume = vec4(attenuationOf(material), material.thickness);
    const std::array<int, 2> sets = setsOf(material);
    const auto ref = [&](int slot, const TextureRef& texture, bool srgb) {
        result.textures[slot] = gpuTextureRef(scene, texture, sets, srgb, slots);
    };
    ref(shading::kTextureBaseColor, material.baseColorTexture, true);
    ref(shading::kTextureMetallicRoughness, material.metallicRoughnessTexture, false);
    ref(shading::kTextureNormal, material.normalTexture, false);
    ref(shading::kTextureOcclusion, material.occlusionTexture, false);
    ref(shading::kTextureEmissive, material.emissiveTexture, true);
    ref(shading::kTextureTransmission, material.transmissionTexture, false);
    ref(shading::kTextureThickness, material.thicknessTexture, false);
    return result;
}

VkSamplerAddressMode addressMode(Texture::Wrap wrap)
{
    switch (wrap) {
    case Texture::Wrap::ClampToEdge:
        return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    case Texture::Wrap::MirroredRepeat:
        return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
    case Texture::Wrap::Repeat:
        break;
    }
    return VK_SAMPLER_ADDRESS_MODE_REPEAT;
}

Hash128 textureHash(const ImageRgba8& pixels, bool srgb)
{
    Hasher hasher;
    hasher.add(pixels.width()).add(pixels.height()).add(srgb);
    return hasher.bytes(pixels.data(), pixels.texelCount() * sizeof(u8vec4)).hash();
}

/// The image of a texture with all its levels.
std::shared_ptr<const gpu::Image> uploadTexture(gpu::Device& device, gpu::Uploader& uploader, const ImageRgba8& pixels,
                                                bool srgb)
{
    const std::vector<ImageRgba8> mips = mipLevels(pixels, srgb);
    auto image = std::make_shared<gpu::Image>(
        device, gpu::ImageInfo{.format = srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
                               .width = uint32_t(pixels.width()),
                               .height = uint32_t(pixels.height()),
                               .mipLevels = uint32_t(mips.size()) + 1,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    std::vector<gpu::Uploader::Level> levels{{0, 0, pixels.data()}};
    for (std::size_t i = 0; i < mips.size(); ++i) levels.push_back({uint32_t(i) + 1, 0, mips[i].data()});
    uploader.image(*image, levels, 4);
    return image;
}

/// The mean of four texels of each block, without regard to the sRGB curve.
ImageRgba8 coarseTexture(const ImageRgba8& pixels)
{
    constexpr int kSide = 128;
    const int block = (std::max(pixels.width(), pixels.height()) + kSide - 1) / kSide;
    if (block < 2) return pixels;
    ImageRgba8 coarse(std::max(pixels.width() / block, 1), std::max(pixels.height() / block, 1));
    const auto at = [&](int x, int y) {
        return ivec4(pixels(std::min(x, pixels.width() - 1), std::min(y, pixels.height() - 1)));
    };
    for (int y = 0; y < coarse.height(); ++y) {
        for (int x = 0; x < coarse.width(); ++x) {
            const ivec2 low = ivec2(x, y) * block + block / 4;
            const ivec2 high = low + block / 2;
            coarse(x, y) =
                u8vec4((at(low.x, low.y) + at(high.x, low.y) + at(low.x, high.y) + at(high.x, high.y) + 2) / 4);
        }
    }
    return coarse;
}

void uploadTextures(gpu::Device& device, gpu::Uploader& uploader, const Scene& scene, const TextureSlots& slots,
                    TextureImages images, TextureDetail detail, const std::atomic<bool>* cancel, GpuScene& result)
{
    std::map<int, ImageRgba8> coarse;
    const auto pixelsOf = [&](int index) -> const ImageRgba8& {
        const ImageRgba8& pixels = scene.textures[std::size_t(index)].pixels;
        if (detail == TextureDetail::Full) return pixels;
        const auto [it, isNew] = coarse.try_emplace(index);
        if (isNew) it->second = coarseTexture(pixels);
        return it->second;
    };
    std::vector<std::pair<int, bool>> bySlot(slots.all().size());
    for (const auto& [key, slot] : slots.all()) bySlot[std::size_t(slot)] = key;
    if (bySlot.size() > frameBindings(device)[shading::kBindTextures].count)
        throw gpu::Failure("the scene has more textures than the Vulkan device allows");

    for (const auto& [index, srgb] : bySlot) result.textureHashes.push_back(textureHash(pixelsOf(index), srgb));
    const std::set<Hash128> needed(result.textureHashes.begin(), result.textureHashes.end());
    std::erase_if(images, [&](const auto& image) { return !needed.contains(image.first); });

    std::map<std::tuple<VkSamplerAddressMode, VkSamplerAddressMode, bool>, uint32_t> samplers;
    for (std::size_t slot = 0; slot < bySlot.size() && !(cancel != nullptr && *cancel); ++slot) {
        const auto [index, srgb] = bySlot[slot];
        const Texture& texture = scene.textures[std::size_t(index)];
        std::shared_ptr<const gpu::Image>& image = images[result.textureHashes[slot]];
        if (!image) image = uploadTexture(device, uploader, pixelsOf(index), srgb);
        result.textures.push_back(image);

        const std::tuple key(addressMode(texture.wrapU), addressMode(texture.wrapV), texture.nearest);
        const auto [it, isNew] = samplers.try_emplace(key, uint32_t(result.samplers.size()));
        if (isNew)
            result.samplers.push_back(
                gpu::makeSampler(device, {.magFilter = texture.nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR,
                                          .addressU = std::get<0>(key),
                                          .addressV = std::get<1>(key),
                                          .maxAnisotropy = texture.nearest ? 1.0f : kMaxAnisotropy}));
        result.samplerOfTexture.push_back(it->second);
    }
}

bool isLightmapped(const BakedScene& baked, const Object& object)
{
    if (!baked.isBaked || !object.isStatic || object.lightmap.page < 0 || object.mesh < 0) return false;
    const auto& parts = baked.scene.meshes[std::size_t(object.mesh)].parts;
    return std::all_of(parts.begin(), parts.end(),
                       [](const MeshPart& part) { return part.positions.empty() || !part.lightmapUv.empty(); });
}

GpuObject gpuObject(const Object& object, const Bounds& bounds, bool lightmapped, int volume,
                    const ProbeInterpolator& probes)
{
    GpuObject result{};
    result.worldFromObject = object.worldFromObject;
    // A flattened object (a scale of 0) has no inverse: its normals are lost, and the shader takes the triangle's.
    const mat3 linear(object.worldFromObject);
    const float determinant = glm::determinant(linear);
    const mat3 normalFromObject = determinant != 0.0f ? glm::transpose(glm::inverse(linear)) : mat3(0.0f);
    for (int i = 0; i < 3; ++i) result.normalFromObject[i] = vec4(normalFromObject[i], 0.0f);
    result.normalFromObject[0].w = determinant < 0.0f ? -1.0f : 1.0f;
    result.lightmapScaleOffset = vec4(object.lightmap.scale, object.lightmap.offset);
    result.info.x =
        (lightmapped ? shading::kObjectLightmapped : 0) | (object.receiveShadows ? shading::kObjectReceiveShadows : 0);
    result.info.y = std::max(object.lightmap.page, 0);
    result.info.z = volume;
    const ProbeSample probe = probes.sample(probeAnchor(object, bounds));
    for (std::size_t k = 0; k < 4; ++k) result.probeOcclusion[k] = probe.occlusion.layers[k];
    for (std::size_t i = 0; i < 9; ++i) result.probeSh[i] = vec4(probe.radiance[i], 0.0f);
    return result;
}

bool isMirrored(const Object& object)
{
    return glm::determinant(mat3(object.worldFromObject)) < 0.0f;
}

} // namespace

GpuScene uploadScene(gpu::Device& device, const BakedScene& baked, TextureImages kept, TextureDetail detail,
                     const std::atomic<bool>* cancel)
{
    const Scene& scene = baked.scene;
    GpuScene result;
    gpu::Uploader uploader(device);
    TextureSlots slots;
    std::vector<GpuMaterial> materials;
    for (const Material& material : scene.materials) materials.push_back(gpuMaterial(scene, material, slots));
    materials.push_back(gpuMaterial(scene, defaultMaterial(), slots));
    result.materials = uploadVector(device, uploader, materials, kStorage);
    uploadTextures(device, uploader, scene, slots, std::move(kept), detail, cancel, result);
    uploadMeshes(device, uploader, scene, result);
    uploader.finish();

    result.outline = outlineOf(baked);
    result.probes.emplace(baked);
    const ProbeSample sky = skyProbe(scene.sky);
    for (std::size_t i = 0; i < 9; ++i) result.skySh[i] = vec4(sky.radiance[i], 0.0f);
    if (!baked.groups.empty()) {
        uploadGroups(device, uploader, baked, result);
    } else {
        result.lightmaps =
            uploadPages(device, uploader, baked.lightmaps, VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, uint32_t(0));
        result.lightmapDirections =
            uploadPages(device, uploader, baked.lightmapDirections, VK_FORMAT_R8G8B8A8_UNORM, u8vec4(128));
        result.lightmapUnitLux = baked.lightmapUnitLux;
        result.reflections = uploadReflections(device, uploader, baked.reflections);
    }
    result.dynamicLightmaps =
        uploadPages(device, uploader, std::vector<Image<uint32_t>>(), VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, uint32_t(0));
    result.shadowmasks = uploadPages(device, uploader, baked.shadowmasks, VK_FORMAT_R8G8B8A8_UNORM, u8vec4(255));

    result.bounds = objectBounds(scene);
    for (const Mesh& mesh : scene.meshes) {
        Bounds& bounds = result.meshBounds.emplace_back();
        for (const MeshPart& part : mesh.parts)
            for (const vec3& position : part.positions) bounds.extend(position);
    }
    for (const Object& object : scene.objects) {
        result.mirrored.push_back(isMirrored(object));
        result.lightmapped.push_back(isLightmapped(baked, object));
    }
    result.probeVolumes = ProbeVolumes(
        device, planProxyVolumes(scene, result.meshBounds, result.lightmapped, *result.probes), baked.maskLayers);
    result.probeVolumes.upload(uploader, scene, result.meshBounds, *result.probes);
    const std::vector<int>& volumeOf = result.probeVolumes.plan().volumeOf;
    std::vector<GpuObject> objects(scene.objects.size());
    parallelFor(objects.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            objects[i] =
                gpuObject(scene.objects[i], result.bounds[i], result.lightmapped[i], volumeOf[i], *result.probes);
    });
    result.objects = uploadVector(device, uploader, objects, kStorage);
    result.sky = uploadSky(device, uploader, scene.sky);
    uploader.finish();
    return result;
}

void uploadChangedObjects(gpu::Device& device, GpuScene& scene)
{
    if (scene.changedObjects.empty()) return;
    std::vector<uint32_t>& changed = scene.changedObjects;
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    gpu::Uploader uploader(device);
    std::vector<GpuObject> data(changed.size());
    for (const uint32_t i : changed) {
        const Object& object = scene.outline.scene.objects[i];
        scene.mirrored[i] = isMirrored(object);
        scene.bounds[i] = object.mesh < 0
                              ? Bounds{}
                              : worldBounds(scene.meshBounds[std::size_t(object.mesh)], object.worldFromObject);
    }
    parallelFor(changed.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const uint32_t i = changed[k];
            data[k] = gpuObject(scene.outline.scene.objects[i], scene.bounds[i], scene.lightmapped[i],
                                scene.probeVolumes.plan().volumeOf[i], *scene.probes);
        }
    });
    for (std::size_t k = 0; k < changed.size();) { // a copy for each run of neighbours
        std::size_t end = k + 1;
        while (end < changed.size() && changed[end] == changed[end - 1] + 1) ++end;
        uploader.buffer(scene.objects, &data[k], (end - k) * sizeof(GpuObject), changed[k] * sizeof(GpuObject));
        k = end;
    }
    scene.probeVolumes.update(uploader, scene.outline.scene, scene.meshBounds, *scene.probes, changed);
    uploader.finish();
    changed.clear();
}

} // namespace halflight
