#include "render/passes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "shaders/depth.vert.h"
#include "shaders/depth_masked.frag.h"
#include "shaders/gbuffer.frag.h"
#include "shaders/gbuffer_mask.frag.h"
#include "shaders/light.frag.h"
#include "shaders/light_mask.frag.h"
#include "shaders/lit.frag.h"
#include "shaders/mesh.vert.h"
#include "shaders/sky.frag.h"
#include "shaders/sky.vert.h"

namespace halflight {
namespace {

using shading::GpuPush;

/// The texture array is declared this long at most; a scene's set holds as many as it needs.
constexpr uint32_t kMaxTextures = 65536;

/// Layout in shaders/gbuffer.glsl. All formats that every Vulkan device can draw into.
constexpr VkFormat kGBufferFormats[] = {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32_UINT,
                                        VK_FORMAT_R16G16B16A16_UINT};
constexpr VkFormat kGBufferMaskFormat = VK_FORMAT_R16G16B16A16_UINT;

enum class Culling { None, AsMaterial, Front, Back };

VkCullModeFlags cullMode(Culling culling, const DrawPart& part)
{
    switch (culling) {
    case Culling::None:
        return VK_CULL_MODE_NONE;
    case Culling::Front:
        return VK_CULL_MODE_FRONT_BIT;
    case Culling::Back:
        return VK_CULL_MODE_BACK_BIT;
    case Culling::AsMaterial:
        break;
    }
    return part.doubleSided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT;
}

void drawPart(const PassContext& context, const Draw& draw, Culling culling)
{
    const gpu::Functions& vk = context.device.vk;
    const int material = draw.part->material;
    vk.CmdPushConstants(context.commands, context.pipelines.layout.get(),
                        VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, offsetof(GpuPush, info), sizeof(int),
                        &material);
    vk.CmdSetCullMode(context.commands, cullMode(culling, *draw.part));
    vk.CmdSetFrontFace(context.commands, draw.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
    vk.CmdDrawIndexed(context.commands, draw.part->indexCount, draw.instanceCount, draw.part->firstIndex,
                      draw.part->firstVertex, draw.firstInstance);
    ++context.counts.draws;
    context.counts.instances += draw.instanceCount;
    context.counts.triangles += int64_t(draw.part->indexCount / 3) * draw.instanceCount;
}

void bindPipeline(const PassContext& context, VkPipeline pipeline)
{
    context.device.vk.CmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
}

/// All parts of one alpha mode.
void drawMode(const PassContext& context, std::span<const Draw> draws, Material::AlphaMode mode, VkPipeline pipeline,
              Culling culling)
{
    bool bound = false;
    for (const Draw& draw : draws) {
        if (draw.part->alphaMode != mode) continue;
        if (!bound) bindPipeline(context, pipeline);
        bound = true;
        drawPart(context, draw, culling);
    }
}

/// All opaque parts with one pipeline, then all masked ones with the other.
void drawSolid(const PassContext& context, std::span<const Draw> draws, VkPipeline opaque, VkPipeline masked,
               Culling culling)
{
    drawMode(context, draws, Material::AlphaMode::Opaque, opaque, culling);
    drawMode(context, draws, Material::AlphaMode::Mask, masked, culling);
}

void pushClipFromWorld(const PassContext& context, const mat4& clipFromWorld, ivec2 firstTexel = ivec2(0))
{
    const GpuPush push{clipFromWorld, ivec4(0, firstTexel, 0)};
    context.device.vk.CmdPushConstants(context.commands, context.pipelines.layout.get(),
                                       VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(push),
                                       &push);
}

void setViewport(const PassContext& context, ivec2 offset, ivec2 size)
{
    const VkViewport viewport{float(offset.x), float(offset.y), float(size.x), float(size.y), 0.0f, 1.0f};
    const VkRect2D scissor{{offset.x, offset.y}, {uint32_t(size.x), uint32_t(size.y)}};
    context.device.vk.CmdSetViewport(context.commands, 0, 1, &viewport);
    context.device.vk.CmdSetScissor(context.commands, 0, 1, &scissor);
}

/// Where alpha thresholds count from. Cascades move in whole texels, and the world's origin moves in the map with them,
/// so that thresholds rest on what they cover. Other tiles rest anyway.
ivec2 firstAlphaTexel(const ShadowDraws& tile)
{
    const glm::dmat4 m(tile.clipFromWorld);
    if (m[0].w != 0.0 || m[1].w != 0.0 || m[2].w != 0.0) return tile.offset; // perspective
    const auto wrapped = [&](double clip) {
        constexpr double kPeriod = shading::kAlphaPeriod;
        // A quarter of a texel off the integers on which the origin lies, so that rounding changes nothing.
        const double texel = std::floor((0.5 * clip + 0.5) * double(tile.size) + 0.25);
        return int(texel - std::floor(texel / kPeriod) * kPeriod);
    };
    return tile.offset + ivec2(wrapped(m[3].x), wrapped(m[3].y));
}

ivec2 imageSize(const gpu::Image& image)
{
    return {int(image.info().width), int(image.info().height)};
}

/// Cleared to 0 if so asked.
VkRenderingAttachmentInfo colorAttachment(const gpu::Image& image, VkAttachmentLoadOp load)
{
    return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
            .imageView = image.view(),
            .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
            .loadOp = load,
            .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

VkRenderingAttachmentInfo depthAttachment(const gpu::Image& image, VkAttachmentLoadOp load)
{
    VkRenderingAttachmentInfo info = colorAttachment(image, load);
    info.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    return info;
}

void beginRendering(const PassContext& context, std::span<const VkRenderingAttachmentInfo> colors,
                    const std::optional<VkRenderingAttachmentInfo>& depth, ivec2 size, ivec2 offset = ivec2(0))
{
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{offset.x, offset.y}, {uint32_t(size.x), uint32_t(size.y)}},
                                    .layerCount = 1,
                                    .colorAttachmentCount = uint32_t(colors.size()),
                                    .pColorAttachments = colors.data(),
                                    .pDepthAttachment = depth ? &*depth : nullptr};
    context.device.vk.CmdBeginRendering(context.commands, &rendering);
    setViewport(context, offset, size);
}

void drawWholePicture(const PassContext& context, VkPipeline pipeline)
{
    bindPipeline(context, pipeline);
    context.device.vk.CmdSetCullMode(context.commands, VK_CULL_MODE_NONE);
    context.device.vk.CmdSetFrontFace(context.commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    context.device.vk.CmdDraw(context.commands, 3, 1, 0, 0);
    ++context.counts.draws;
    ++context.counts.instances;
    ++context.counts.triangles;
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

std::vector<gpu::Binding> frameBindings(const gpu::Device& device)
{
    const VkPhysicalDeviceLimits& limits = device.properties().limits;
    const uint32_t images = std::min({limits.maxPerStageDescriptorSampledImages, limits.maxPerStageDescriptorSamplers,
                                      limits.maxDescriptorSetSamplers, limits.maxDescriptorSetSampledImages});
    const uint32_t textures = std::min({kMaxTextures, images - 14 /* others */, limits.maxPerStageResources - 32});
    std::vector<gpu::Binding> bindings(shading::kBindTextures + 1);
    bindings[shading::kBindFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    for (int i = shading::kBindLightmaps; i <= shading::kBindTextures; ++i)
        bindings[std::size_t(i)] = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
    bindings[shading::kBindProbeVolumes].type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    bindings[shading::kBindReflectionProbes].type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    bindings[shading::kBindTextures].count = textures;
    bindings[shading::kBindTextures].variableCount = true;
    return bindings;
}

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
                                   bool readsMask)
{
    const gpu::UniqueShader meshVertex = gpu::makeShader(device, mesh_vert);
    const gpu::UniqueShader litFragment = gpu::makeShader(device, lit_frag);
    gpu::GraphicsPipelineInfo litInfo = meshPipelineInfo(layout, meshVertex.get(), litFragment.get());
    litInfo.colorFormats = {colorFormat};
    litInfo.constants = {uint32_t(shading::kAlphaOpaque), uint32_t(readsMask)};
    lit = gpu::makePipeline(device, litInfo);

    gpu::GraphicsPipelineInfo blendInfo = litInfo;
    blendInfo.depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;
    blendInfo.blend = gpu::Blend::Premultiplied;
    blendInfo.constants = {uint32_t(shading::kAlphaBlend), uint32_t(readsMask)};
    blend = gpu::makePipeline(device, blendInfo);
}

bool GBuffer::ensure(const gpu::Device& device, ivec2 size, bool usesMask)
{
    const bool sameSize = baseColor.get() && imageSize(baseColor) == size;
    if (sameSize && bool(mask.get()) == usesMask) return false;
    auto make = [&](VkFormat format) {
        return gpu::Image(device, {.format = format,
                                   .width = uint32_t(size.x),
                                   .height = uint32_t(size.y),
                                   .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    };
    mask = {};
    if (!sameSize) {
        *this = {};
        baseColor = make(kGBufferFormats[0]);
        normals = make(kGBufferFormats[1]);
        material = make(kGBufferFormats[2]);
    }
    if (usesMask) mask = make(kGBufferMaskFormat);
    return true;
}

std::vector<const gpu::Image*> GBuffer::images() const
{
    std::vector<const gpu::Image*> result{&baseColor, &normals, &material};
    if (mask.get()) result.push_back(&mask);
    return result;
}

DeferredPipelines::DeferredPipelines(const gpu::Device& device, VkPipelineLayout layout, VkFormat colorFormat,
                                     bool usesMask)
{
    const gpu::UniqueShader meshVertex = gpu::makeShader(device, mesh_vert);
    const gpu::UniqueShader gBufferFragment =
        usesMask ? gpu::makeShader(device, gbuffer_mask_frag) : gpu::makeShader(device, gbuffer_frag);
    const gpu::UniqueShader pictureVertex = gpu::makeShader(device, sky_vert);
    const gpu::UniqueShader lightFragment =
        usesMask ? gpu::makeShader(device, light_mask_frag) : gpu::makeShader(device, light_frag);

    gpu::GraphicsPipelineInfo gBufferInfo = meshPipelineInfo(layout, meshVertex.get(), gBufferFragment.get());
    gBufferInfo.constants = {uint32_t(shading::kAlphaOpaque), uint32_t(usesMask)};
    gBufferInfo.colorFormats.assign(std::begin(kGBufferFormats), std::end(kGBufferFormats));
    gBufferInfo.colorFormats.push_back(colorFormat);
    if (usesMask) gBufferInfo.colorFormats.push_back(kGBufferMaskFormat);
    if (gBufferInfo.colorFormats.size() > device.properties().limits.maxColorAttachments)
        throw gpu::Failure("the deferred path needs " + std::to_string(gBufferInfo.colorFormats.size()) +
                           " targets, more than the Vulkan device draws into at once; use the forward path");
    gBuffer = gpu::makePipeline(device, gBufferInfo);

    gpu::GraphicsPipelineInfo lightInfo;
    lightInfo.layout = layout;
    lightInfo.vertex = pictureVertex.get();
    lightInfo.fragment = lightFragment.get();
    lightInfo.colorFormats = {colorFormat};
    lightInfo.depthTest = false;
    lightInfo.depthWrite = false;
    lightInfo.blend = gpu::Blend::Add;
    light = gpu::makePipeline(device, lightInfo);
}

void bindScene(const PassContext& context)
{
    const gpu::Functions& vk = context.device.vk;
    const VkBuffer buffers[] = {context.scene.positions.get(), context.scene.maskInputs.get(),
                                context.scene.litInputs.get()};
    const VkDeviceSize offsets[] = {0, 0, 0};
    vk.CmdBindVertexBuffers(context.commands, 0, 3, buffers, offsets);
    vk.CmdBindIndexBuffer(context.commands, context.scene.indices.get(), 0, VK_INDEX_TYPE_UINT32);
    vk.CmdBindDescriptorSets(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.pipelines.layout.get(), 0, 1,
                             &context.set, 0, nullptr);
}

void beginShadowLayer(const PassContext& context, VkImageView layer, ivec2 low, ivec2 high)
{
    VkRenderingAttachmentInfo depth{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                    .imageView = layer,
                                    .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                    .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                    .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    depth.clearValue.depthStencil = {1.0f, 0};
    beginRendering(context, {}, depth, high - low, low);
}

void drawShadowTiles(const PassContext& context, std::span<const ShadowDraws> tiles)
{
    for (const ShadowDraws& tile : tiles) {
        if (tile.draws.empty()) continue;
        setViewport(context, tile.offset, ivec2(tile.size));
        pushClipFromWorld(context, tile.clipFromWorld, firstAlphaTexel(tile));
        context.device.vk.CmdSetDepthBias(context.commands, 0.0f, 0.0f, tile.slopeBias);
        // Both sides of every surface cast, as in the bake, whose rays are stopped by both.
        drawSolid(context, tile.draws, context.pipelines.shadow.get(), context.pipelines.shadowMasked.get(),
                  Culling::None);
        drawMode(context, tile.draws, Material::AlphaMode::Blend, context.pipelines.shadowBlended.get(), Culling::None);
    }
}

void drawDepth(const PassContext& context, const gpu::Image& depth, const CameraDraws& draws)
{
    beginRendering(context, {}, depthAttachment(depth, VK_ATTACHMENT_LOAD_OP_CLEAR), imageSize(depth));
    pushClipFromWorld(context, draws.clipFromWorld);
    for (const std::vector<Draw>* list : {&draws.deferred, &draws.forward})
        drawSolid(context, *list, context.pipelines.depth.get(), context.pipelines.depthMasked.get(),
                  Culling::AsMaterial);
    endRendering(context);
}

void beginForward(const PassContext& context, const gpu::Image& color, const gpu::Image& depth,
                  VkAttachmentLoadOp loadColor)
{
    const VkRenderingAttachmentInfo attachment = colorAttachment(color, loadColor);
    beginRendering(context, {&attachment, 1}, depthAttachment(depth, VK_ATTACHMENT_LOAD_OP_LOAD), imageSize(color));
}

void drawLit(const PassContext& context, const ForwardPipelines& pipelines, const CameraDraws& draws)
{
    pushClipFromWorld(context, draws.clipFromWorld);
    drawSolid(context, draws.forward, pipelines.lit.get(), pipelines.lit.get(), Culling::AsMaterial);
}

void drawSky(const PassContext& context)
{
    drawWholePicture(context, context.pipelines.sky.get());
}

void drawBlended(const PassContext& context, const ForwardPipelines& pipelines, const CameraDraws& draws)
{
    if (draws.blended.empty()) return;
    pushClipFromWorld(context, draws.clipFromWorld);
    bindPipeline(context, pipelines.blend.get());
    for (const Draw& draw : draws.blended) {
        // Of a closed double-sided surface the far side comes first.
        if (draw.part->doubleSided) drawPart(context, draw, Culling::Front);
        drawPart(context, draw, Culling::Back);
    }
}

void drawGBuffer(const PassContext& context, const DeferredPipelines& pipelines, const GBuffer& gBuffer,
                 const gpu::Image& color, const gpu::Image& depth, const CameraDraws& draws)
{
    // Where nothing is drawn, flags of 0 tell the light pass so.
    std::vector<VkRenderingAttachmentInfo> attachments{
        colorAttachment(gBuffer.baseColor, VK_ATTACHMENT_LOAD_OP_DONT_CARE),
        colorAttachment(gBuffer.normals, VK_ATTACHMENT_LOAD_OP_DONT_CARE),
        colorAttachment(gBuffer.material, VK_ATTACHMENT_LOAD_OP_CLEAR),
        colorAttachment(color, VK_ATTACHMENT_LOAD_OP_CLEAR)};
    if (gBuffer.mask.get()) attachments.push_back(colorAttachment(gBuffer.mask, VK_ATTACHMENT_LOAD_OP_DONT_CARE));
    beginRendering(context, attachments, depthAttachment(depth, VK_ATTACHMENT_LOAD_OP_LOAD), imageSize(color));
    pushClipFromWorld(context, draws.clipFromWorld);
    drawSolid(context, draws.deferred, pipelines.gBuffer.get(), pipelines.gBuffer.get(), Culling::AsMaterial);
    endRendering(context);
}

void drawDeferredLight(const PassContext& context, const DeferredPipelines& pipelines, const gpu::Image& color)
{
    const VkRenderingAttachmentInfo attachment = colorAttachment(color, VK_ATTACHMENT_LOAD_OP_LOAD);
    beginRendering(context, {&attachment, 1}, std::nullopt, imageSize(color));
    drawWholePicture(context, pipelines.light.get());
    endRendering(context);
}

void endRendering(const PassContext& context)
{
    context.device.vk.CmdEndRendering(context.commands);
}

} // namespace halflight
