// The pipelines and the G-buffer of a frame's passes.
#include "render/passes/passes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "shaders/depth.vert.h"
#include "shaders/depth_masked.frag.h"
#include "shaders/gbuffer.frag.h"
#include "shaders/gbuffer_mask.frag.h"
#include "shaders/gbuffer_mask2.frag.h"
#include "shaders/gbuffer_mask4.frag.h"
#include "shaders/light.frag.h"
#include "shaders/light_mask.frag.h"
#include "shaders/light_mask2.frag.h"
#include "shaders/light_mask4.frag.h"
#include "shaders/lit.frag.h"
#include "shaders/mesh.vert.h"
#include "shaders/sky.frag.h"
#include "shaders/sky.vert.h"

namespace halflight {
namespace {

using shading::GpuPush;

/// Layout in shaders/gbuffer.glsl. All formats that every Vulkan device can draw into.
constexpr VkFormat kGBufferFormats[] = {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32_UINT,
                                        VK_FORMAT_R16G16B16A16_UINT};

/// Of the targets that hold mask layers.
std::vector<VkFormat> maskFormats(int maskLayers)
{
    if (maskLayers == 0) return {};
    if (maskLayers == 1) return {VK_FORMAT_R16G16B16A16_UINT};
    return std::vector<VkFormat>(std::size_t(maskLayers / 2), VK_FORMAT_R32G32B32A32_UINT);
}

gpu::UniqueShader gBufferShader(const gpu::Device& device, int maskLayers)
{
    if (maskLayers == 0) return gpu::makeShader(device, gbuffer_frag);
    if (maskLayers == 1) return gpu::makeShader(device, gbuffer_mask_frag);
    return maskLayers == 2 ? gpu::makeShader(device, gbuffer_mask2_frag) : gpu::makeShader(device, gbuffer_mask4_frag);
}

gpu::UniqueShader lightShader(const gpu::Device& device, int maskLayers)
{
    if (maskLayers == 0) return gpu::makeShader(device, light_frag);
    if (maskLayers == 1) return gpu::makeShader(device, light_mask_frag);
    return maskLayers == 2 ? gpu::makeShader(device, light_mask2_frag) : gpu::makeShader(device, light_mask4_frag);
}

/// The specialization constants of shaders that light surfaces.
std::vector<uint32_t> constantsOf(int alphaMode, MaskUse masks)
{
    return {uint32_t(alphaMode), uint32_t(masks.layers), uint32_t(masks.colored)};
}

std::vector<VkVertexInputBindingDescription> depthVertexBindings()
{
    return {{0, sizeof(vec3), VK_VERTEX_INPUT_RATE_VERTEX}, {1, sizeof(MaskVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
}

std::vector<VkVertexInputAttributeDescription> depthVertexAttributes()
{
    return {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
            {1, 1, VK_FORMAT_R32G32_SFLOAT, offsetof(MaskVertex, uv)},
            {2, 1, VK_FORMAT_R32G32_SFLOAT, offsetof(MaskVertex, uv) + sizeof(vec2)},
            {3, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(MaskVertex, color)}};
}

} // namespace

gpu::GraphicsPipelineInfo meshPipelineInfo(VkPipelineLayout layout, VkShaderModule vertex, VkShaderModule fragment)
{
    gpu::GraphicsPipelineInfo info;
    info.layout = layout;
    info.vertex = vertex;
    info.fragment = fragment;
    info.vertexBindings = depthVertexBindings();
    info.vertexBindings.push_back({2, sizeof(LitVertex), VK_VERTEX_INPUT_RATE_VERTEX});
    info.vertexAttributes = depthVertexAttributes();
    info.vertexAttributes.push_back({4, 2, VK_FORMAT_R32G32B32_SFLOAT, offsetof(LitVertex, normal)});
    info.vertexAttributes.push_back({5, 2, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LitVertex, tangent)});
    info.vertexAttributes.push_back({6, 2, VK_FORMAT_R32G32_SFLOAT, offsetof(LitVertex, lightmapUv)});
    info.depthFormat = kDepthFormat;
    info.depthWrite = false;
    info.depthCompare = VK_COMPARE_OP_EQUAL;
    return info;
}

Pipelines::Pipelines(const gpu::Device& device, VkDescriptorSetLayout set, VkFormat colorFormat)
    : layout(gpu::makePipelineLayout(device, set, sizeof(GpuPush)))
{
    const gpu::UniqueShader depthVertex = gpu::makeShader(device, depth_vert);
    const gpu::UniqueShader maskFragment = gpu::makeShader(device, depth_masked_frag);
    const gpu::UniqueShader skyVertex = gpu::makeShader(device, sky_vert);
    const gpu::UniqueShader skyFragment = gpu::makeShader(device, sky_frag);

    gpu::GraphicsPipelineInfo depthInfo;
    depthInfo.layout = layout.get();
    depthInfo.vertex = depthVertex.get();
    depthInfo.vertexBindings = depthVertexBindings();
    depthInfo.vertexAttributes = depthVertexAttributes();
    depthInfo.depthFormat = kDepthFormat;

    gpu::GraphicsPipelineInfo shadowInfo = depthInfo;
    shadowInfo.depthCompare = VK_COMPARE_OP_LESS_OR_EQUAL;
    shadowInfo.depthBias = true;
    shadow = gpu::makePipeline(device, shadowInfo);
    shadowInfo.fragment = maskFragment.get();
    shadowInfo.constants = {uint32_t(shading::kAlphaMask)};
    shadowMasked = gpu::makePipeline(device, shadowInfo);
    shadowInfo.constants = {uint32_t(shading::kAlphaBlend)};
    shadowBlended = gpu::makePipeline(device, shadowInfo);

    depth = gpu::makePipeline(device, depthInfo);
    depthInfo.fragment = maskFragment.get();
    depthInfo.constants = {uint32_t(shading::kAlphaMask)};
    depthMasked = gpu::makePipeline(device, depthInfo);

    gpu::GraphicsPipelineInfo skyInfo;
    skyInfo.layout = layout.get();
    skyInfo.vertex = skyVertex.get();
    skyInfo.fragment = skyFragment.get();
    skyInfo.colorFormats = {colorFormat};
    skyInfo.depthFormat = kDepthFormat;
    skyInfo.depthWrite = false;
    sky = gpu::makePipeline(device, skyInfo);
}

ForwardPipelines::ForwardPipelines(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat,
                                   MaskUse masks)
{
    const gpu::UniqueShader vertex = gpu::makeShader(device, mesh_vert);
    const gpu::UniqueShader fragment = gpu::makeShader(device, lit_frag);
    gpu::GraphicsPipelineInfo info = meshPipelineInfo(layout, vertex.get(), fragment.get());
    info.colorFormats = {colorFormat};
    info.constants = constantsOf(shading::kAlphaOpaque, masks);
    lit = gpu::makePipeline(device, info);
}

void ForwardPipelines::ensureBlend(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat,
                                   MaskUse masks, std::span<const Draw> blended)
{
    const bool tints = std::ranges::any_of(blended, [](const Draw& draw) { return draw.part->tintsLight; });
    const bool greys = std::ranges::any_of(blended, [](const Draw& draw) { return !draw.part->tintsLight; });
    if ((!tints || pass) && (!greys || blend)) return;
    const gpu::UniqueShader vertex = gpu::makeShader(device, mesh_vert);
    const gpu::UniqueShader fragment = gpu::makeShader(device, lit_frag);
    gpu::GraphicsPipelineInfo info = meshPipelineInfo(layout, vertex.get(), fragment.get());
    info.colorFormats = {colorFormat};
    info.depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;
    const auto make = [&](gpu::UniquePipeline& pipeline, gpu::Blend how, int alphaMode) {
        if (pipeline) return;
        info.blend = how;
        info.constants = constantsOf(alphaMode, masks);
        pipeline = gpu::makePipeline(device, info);
    };
    if (greys) make(blend, gpu::Blend::Premultiplied, shading::kAlphaBlend);
    if (!tints) return;
    make(pass, gpu::Blend::Multiply, shading::kAlphaPass);
    make(add, gpu::Blend::Add, shading::kAlphaBlend);
}

void GBuffer::ensure(const gpu::Device& device, ivec2 size, int maskLayers)
{
    const bool sameSize =
        baseColor.get() && baseColor.info().width == uint32_t(size.x) && baseColor.info().height == uint32_t(size.y);
    const std::vector<VkFormat> formats = maskFormats(maskLayers);
    const std::size_t had = std::size_t(bool(mask.get())) + std::size_t(bool(furtherMask.get()));
    if (sameSize && had == formats.size() && (had == 0 || mask.info().format == formats[0])) return;
    device.waitIdle(); // frames in flight use the images before
    auto make = [&](VkFormat format) {
        return gpu::Image(device, {.format = format,
                                   .width = uint32_t(size.x),
                                   .height = uint32_t(size.y),
                                   .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    };
    mask = {};
    furtherMask = {};
    if (!sameSize) {
        *this = {};
        baseColor = make(kGBufferFormats[0]);
        normals = make(kGBufferFormats[1]);
        material = make(kGBufferFormats[2]);
    }
    if (!formats.empty()) mask = make(formats[0]);
    if (formats.size() > 1) furtherMask = make(formats[1]);
}

std::vector<const gpu::Image*> GBuffer::images() const
{
    std::vector<const gpu::Image*> result{&baseColor, &normals, &material};
    for (const gpu::Image* image : {&mask, &furtherMask})
        if (image->get()) result.push_back(image);
    return result;
}

DeferredPipelines::DeferredPipelines(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat,
                                     MaskUse masks)
{
    const gpu::UniqueShader meshVertex = gpu::makeShader(device, mesh_vert);
    const gpu::UniqueShader gBufferFragment = gBufferShader(device, masks.layers);
    const gpu::UniqueShader pictureVertex = gpu::makeShader(device, sky_vert);
    const gpu::UniqueShader lightFragment = lightShader(device, masks.layers);

    gpu::GraphicsPipelineInfo gBufferInfo = meshPipelineInfo(layout, meshVertex.get(), gBufferFragment.get());
    gBufferInfo.constants = constantsOf(shading::kAlphaOpaque, masks);
    gBufferInfo.colorFormats.assign(std::begin(kGBufferFormats), std::end(kGBufferFormats));
    gBufferInfo.colorFormats.push_back(colorFormat);
    for (const VkFormat format : maskFormats(masks.layers)) gBufferInfo.colorFormats.push_back(format);
    if (gBufferInfo.colorFormats.size() > device.properties().limits.maxColorAttachments)
        throw gpu::Failure("the deferred path needs " + std::to_string(gBufferInfo.colorFormats.size()) +
                           " targets, more than the Vulkan device draws into at once; use the forward path");
    gBuffer = gpu::makePipeline(device, gBufferInfo);

    gpu::GraphicsPipelineInfo lightInfo;
    lightInfo.layout = layout;
    lightInfo.vertex = pictureVertex.get();
    lightInfo.fragment = lightFragment.get();
    lightInfo.constants = gBufferInfo.constants;
    lightInfo.colorFormats = {colorFormat};
    lightInfo.depthTest = false;
    lightInfo.depthWrite = false;
    lightInfo.blend = gpu::Blend::Add;
    light = gpu::makePipeline(device, lightInfo);
}

} // namespace halflight
