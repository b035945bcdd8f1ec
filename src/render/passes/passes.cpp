#include "render/passes/passes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace halflight {
namespace {

using shading::GpuPush;

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
    context.device.vk.CmdSetViewport(context.commands, 0, 1, &viewport);
    setScissor(context, offset, size);
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

} // namespace

void beginRendering(const PassContext& context, std::span<const VkRenderingAttachmentInfo> colors,
                    const std::optional<VkRenderingAttachmentInfo>& depth, ivec2 size, ivec2 offset)
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

void setScissor(const PassContext& context, ivec2 offset, ivec2 size)
{
    const VkRect2D scissor{{offset.x, offset.y}, {uint32_t(size.x), uint32_t(size.y)}};
    context.device.vk.CmdSetScissor(context.commands, 0, 1, &scissor);
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
    VkPipeline bound = VK_NULL_HANDLE;
    const auto drawFaces = [&](const Draw& draw, Culling culling) {
        const VkPipeline once[] = {pipelines.blend.get()};
        const VkPipeline twice[] = {pipelines.pass.get(), pipelines.add.get()};
        for (const VkPipeline pipeline : draw.part->tintsLight ? std::span<const VkPipeline>(twice) : once) {
            if (pipeline != bound) bindPipeline(context, pipeline);
            bound = pipeline;
            drawPart(context, draw, culling);
        }
    };
    for (const Draw& draw : draws.blended) {
        const int closed = draw.part->closedVolume ? 1 : 0;
        context.device.vk.CmdPushConstants(context.commands, context.pipelines.layout.get(),
                                           VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
                                           offsetof(GpuPush, info) + 3 * sizeof(int), sizeof(int), &closed);
        // Of a closed double-sided surface the far side comes first.
        if (draw.part->doubleSided) drawFaces(draw, Culling::Front);
        drawFaces(draw, Culling::Back);
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
    for (const gpu::Image* mask : {&gBuffer.mask, &gBuffer.furtherMask})
        if (mask->get()) attachments.push_back(colorAttachment(*mask, VK_ATTACHMENT_LOAD_OP_DONT_CARE));
    beginRendering(context, attachments, depthAttachment(depth, VK_ATTACHMENT_LOAD_OP_LOAD), imageSize(color));
    pushClipFromWorld(context, draws.clipFromWorld);
    drawSolid(context, draws.deferred, pipelines.gBuffer.get(), pipelines.gBuffer.get(), Culling::AsMaterial);
    endRendering(context);
}

void drawAllFaces(const PassContext& context, VkPipeline pipeline, const gpu::Image& color, const mat4& clipFromWorld,
                  std::span<const Draw> draws)
{
    const VkRenderingAttachmentInfo attachment = colorAttachment(color, VK_ATTACHMENT_LOAD_OP_CLEAR);
    beginRendering(context, {&attachment, 1}, std::nullopt, imageSize(color));
    pushClipFromWorld(context, clipFromWorld);
    bindPipeline(context, pipeline);
    for (const Draw& draw : draws) drawPart(context, draw, Culling::None);
    endRendering(context);
}

void drawOverPicture(const PassContext& context, VkPipeline pipeline, const gpu::Image& color)
{
    const VkRenderingAttachmentInfo attachment = colorAttachment(color, VK_ATTACHMENT_LOAD_OP_LOAD);
    beginRendering(context, {&attachment, 1}, std::nullopt, imageSize(color));
    drawWholePicture(context, pipeline);
    endRendering(context);
}

void endRendering(const PassContext& context)
{
    context.device.vk.CmdEndRendering(context.commands);
}

} // namespace halflight
