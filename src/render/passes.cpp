#include "render/passes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "shaders/depth.vert.h"
#include "shaders/depth_masked.frag.h"
#include "shaders/lit.frag.h"
#include "shaders/mesh.vert.h"
#include "shaders/sky.frag.h"
#include "shaders/sky.vert.h"

namespace halflight {
namespace {

using shading::GpuPush;

/// The texture array is declared this long at most; a scene's set holds as many as it needs.
constexpr uint32_t kMaxTextures = 65536;

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
}

void bindPipeline(const PassContext& context, VkPipeline pipeline)
{
    context.device.vk.CmdBindPipeline(context.commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
}

/// All opaque parts with one pipeline, then all masked ones with the other.
void drawSolid(const PassContext& context, std::span<const Draw> draws, VkPipeline opaque, VkPipeline masked,
               Culling culling)
{
    for (const auto& [mode, pipeline] :
         {std::pair(Material::AlphaMode::Opaque, opaque), std::pair(Material::AlphaMode::Mask, masked)}) {
        bool bound = false;
        for (const Draw& draw : draws) {
            if (draw.part->alphaMode != mode) continue;
            if (!bound) bindPipeline(context, pipeline);
            bound = true;
            drawPart(context, draw, culling);
        }
    }
}

void pushClipFromWorld(const PassContext& context, const mat4& clipFromWorld)
{
    const GpuPush push{clipFromWorld, ivec4(0)};
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

} // namespace

std::vector<gpu::Binding> frameBindings(const gpu::Device& device)
{
    const VkPhysicalDeviceLimits& limits = device.properties().limits;
    const uint32_t textures = std::min({kMaxTextures, limits.maxPerStageDescriptorSampledImages - 8,
                                        limits.maxPerStageDescriptorSamplers - 8, limits.maxPerStageResources - 32,
                                        limits.maxDescriptorSetSamplers - 8, limits.maxDescriptorSetSampledImages - 8});
    std::vector<gpu::Binding> bindings(12);
    bindings[shading::kBindFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    for (int i : {shading::kBindLightmaps, shading::kBindShadowmasks, shading::kBindCascades, shading::kBindAtlas,
                  shading::kBindTextures})
        bindings[std::size_t(i)] = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
    bindings[shading::kBindTextures].count = textures;
    bindings[shading::kBindTextures].variableCount = true;
    return bindings;
}

Pipelines::Pipelines(const gpu::Device& device, VkDescriptorSetLayout set, VkFormat colorFormat)
    : layout(gpu::makePipelineLayout(device, set, sizeof(GpuPush)))
{
    const gpu::UniqueShader depthVertex = gpu::makeShader(device, depth_vert);
    const gpu::UniqueShader maskFragment = gpu::makeShader(device, depth_masked_frag);
    const gpu::UniqueShader meshVertex = gpu::makeShader(device, mesh_vert);
    const gpu::UniqueShader litFragment = gpu::makeShader(device, lit_frag);
    const gpu::UniqueShader skyVertex = gpu::makeShader(device, sky_vert);
    const gpu::UniqueShader skyFragment = gpu::makeShader(device, sky_frag);

    gpu::GraphicsPipelineInfo depthInfo;
    depthInfo.layout = layout.get();
    depthInfo.vertex = depthVertex.get();
    depthInfo.vertexBindings = {{0, sizeof(vec3), VK_VERTEX_INPUT_RATE_VERTEX},
                                {1, sizeof(MaskVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
    depthInfo.vertexAttributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                  {1, 1, VK_FORMAT_R32G32_SFLOAT, offsetof(MaskVertex, uv)},
                                  {2, 1, VK_FORMAT_R32G32_SFLOAT, offsetof(MaskVertex, uv) + sizeof(vec2)},
                                  {3, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(MaskVertex, color)}};
    depthInfo.depthFormat = kDepthFormat;

    gpu::GraphicsPipelineInfo shadowInfo = depthInfo;
    shadowInfo.depthCompare = VK_COMPARE_OP_LESS_OR_EQUAL;
    shadowInfo.depthBias = true;
    shadow = gpu::makePipeline(device, shadowInfo);
    shadowInfo.fragment = maskFragment.get();
    shadowMasked = gpu::makePipeline(device, shadowInfo);

    depthInfo.colorFormat = colorFormat;
    depthInfo.colorWrite = false;
    depth = gpu::makePipeline(device, depthInfo);
    depthInfo.fragment = maskFragment.get();
    depthMasked = gpu::makePipeline(device, depthInfo);

    gpu::GraphicsPipelineInfo litInfo = depthInfo;
    litInfo.vertex = meshVertex.get();
    litInfo.fragment = litFragment.get();
    litInfo.vertexBindings.push_back({2, sizeof(LitVertex), VK_VERTEX_INPUT_RATE_VERTEX});
    litInfo.vertexAttributes.push_back({4, 2, VK_FORMAT_R32G32B32_SFLOAT, offsetof(LitVertex, normal)});
    litInfo.vertexAttributes.push_back({5, 2, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LitVertex, tangent)});
    litInfo.vertexAttributes.push_back({6, 2, VK_FORMAT_R32G32_SFLOAT, offsetof(LitVertex, lightmapUv)});
    litInfo.colorWrite = true;
    litInfo.depthWrite = false;
    litInfo.depthCompare = VK_COMPARE_OP_EQUAL;
    litInfo.constants = {uint32_t(shading::kAlphaOpaque)};
    lit = gpu::makePipeline(device, litInfo);

    gpu::GraphicsPipelineInfo blendInfo = litInfo;
    blendInfo.depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;
    blendInfo.alphaBlend = true;
    blendInfo.constants = {uint32_t(shading::kAlphaBlend)};
    blend = gpu::makePipeline(device, blendInfo);

    gpu::GraphicsPipelineInfo skyInfo;
    skyInfo.layout = layout.get();
    skyInfo.vertex = skyVertex.get();
    skyInfo.fragment = skyFragment.get();
    skyInfo.colorFormat = colorFormat;
    skyInfo.depthFormat = kDepthFormat;
    skyInfo.depthWrite = false;
    sky = gpu::makePipeline(device, skyInfo);
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

void drawShadowLayer(const PassContext& context, const gpu::Image& map, VkImageView layer,
                     std::span<const ShadowDraws> tiles, float slopeBias)
{
    const gpu::Functions& vk = context.device.vk;
    const VkRenderingAttachmentInfo depth{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                          .imageView = layer,
                                          .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                          .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                          .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                          .clearValue = {.depthStencil = {1.0f, 0}}};
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, {map.info().width, map.info().height}},
                                    .layerCount = 1,
                                    .pDepthAttachment = &depth};
    vk.CmdBeginRendering(context.commands, &rendering);
    for (const ShadowDraws& tile : tiles) {
        if (tile.draws.empty()) continue;
        setViewport(context, tile.offset, ivec2(tile.size));
        pushClipFromWorld(context, tile.clipFromWorld);
        vk.CmdSetDepthBias(context.commands, 0.0f, 0.0f, slopeBias);
        // Both sides of every surface cast, as in the bake, whose rays are stopped by both.
        drawSolid(context, tile.draws, context.pipelines.shadow.get(), context.pipelines.shadowMasked.get(),
                  Culling::None);
    }
    vk.CmdEndRendering(context.commands);
}

void beginCamera(const PassContext& context, const gpu::Image& color, const gpu::Image& depth)
{
    const VkRenderingAttachmentInfo colorAttachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                                    .imageView = color.view(),
                                                    .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                                    .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                    .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingAttachmentInfo depthAttachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                                    .imageView = depth.view(),
                                                    .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                                    .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                    .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                    .clearValue = {.depthStencil = {0.0f, 0}}};
    const ivec2 size(int(color.info().width), int(color.info().height));
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, {color.info().width, color.info().height}},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &colorAttachment,
                                    .pDepthAttachment = &depthAttachment};
    context.device.vk.CmdBeginRendering(context.commands, &rendering);
    setViewport(context, ivec2(0), size);
}

void drawDepth(const PassContext& context, const CameraDraws& draws)
{
    pushClipFromWorld(context, draws.clipFromWorld);
    drawSolid(context, draws.solid, context.pipelines.depth.get(), context.pipelines.depthMasked.get(),
              Culling::AsMaterial);
}

void drawLit(const PassContext& context, const CameraDraws& draws)
{
    pushClipFromWorld(context, draws.clipFromWorld);
    drawSolid(context, draws.solid, context.pipelines.lit.get(), context.pipelines.lit.get(), Culling::AsMaterial);
}

void drawSky(const PassContext& context)
{
    bindPipeline(context, context.pipelines.sky.get());
    context.device.vk.CmdSetCullMode(context.commands, VK_CULL_MODE_NONE);
    context.device.vk.CmdSetFrontFace(context.commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    context.device.vk.CmdDraw(context.commands, 3, 1, 0, 0);
}

void drawBlended(const PassContext& context, const CameraDraws& draws)
{
    if (draws.blended.empty()) return;
    pushClipFromWorld(context, draws.clipFromWorld);
    bindPipeline(context, context.pipelines.blend.get());
    for (const Draw& draw : draws.blended) {
        // Of a closed double-sided surface the far side comes first.
        if (draw.part->doubleSided) drawPart(context, draw, Culling::Front);
        drawPart(context, draw, Culling::Back);
    }
}

void endCamera(const PassContext& context)
{
    context.device.vk.CmdEndRendering(context.commands);
}

} // namespace halflight
