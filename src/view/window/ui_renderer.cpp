#include "view/window/ui_renderer.h"

#include <imgui.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "shaders/ui.frag.h"
#include "shaders/ui.vert.h"

namespace halflight::view {
namespace {

struct Push {
    vec2 scale;
    vec2 offset;
};

void ensure(const gpu::Device& device, gpu::Buffer& buffer, std::size_t bytes, VkBufferUsageFlags usage)
{
    if (buffer.get() && buffer.size() >= bytes) return;
    buffer = gpu::Buffer(device, bytes + bytes / 2, usage, gpu::MemoryUse::Upload);
}

} // namespace

UiRenderer::UiRenderer(gpu::Device& device, VkFormat format)
    : device_(device), sampler_(gpu::makeSampler(device, {})), buffers_(kFramesInFlight)
{
    unsigned char* texels = nullptr;
    int width = 0;
    int height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&texels, &width, &height);
    font_ = gpu::Image(device, {.format = VK_FORMAT_R8G8B8A8_UNORM,
                                .width = uint32_t(width),
                                .height = uint32_t(height),
                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    gpu::Uploader uploader(device);
    const gpu::Uploader::Level level{0, 0, texels};
    uploader.image(font_, {&level, 1}, 4);
    uploader.finish();

    const gpu::Binding binding{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
    setLayout_ = gpu::makeSetLayout(device, {&binding, 1});
    set_ = gpu::DescriptorSet(device, setLayout_.get(), {&binding, 1}, 0);
    set_.image(0, font_.view(), sampler_.get());
    layout_ = gpu::makePipelineLayout(device, setLayout_.get(), sizeof(Push));

    const gpu::UniqueShader vertex = gpu::makeShader(device, ui_vert);
    const gpu::UniqueShader fragment = gpu::makeShader(device, ui_frag);
    gpu::GraphicsPipelineInfo info;
    info.layout = layout_.get();
    info.vertex = vertex.get();
    info.fragment = fragment.get();
    info.vertexBindings = {{0, sizeof(ImDrawVert), VK_VERTEX_INPUT_RATE_VERTEX}};
    info.vertexAttributes = {{0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, pos)},
                             {1, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, uv)},
                             {2, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(ImDrawVert, col)}};
    info.colorFormats = {format};
    info.depthTest = false;
    info.depthWrite = false;
    info.blend = gpu::Blend::Premultiplied;
    pipeline_ = gpu::makePipeline(device, info);
}

void UiRenderer::setPicture(const ImageRgba8& picture)
{
    device_.waitIdle(); // frames in flight read the one before
    const ivec2 size = picture.size();
    if (!picture_.get() || picture_.info().width != uint32_t(size.x) || picture_.info().height != uint32_t(size.y)) {
        picture_ = gpu::Image(device_, {.format = VK_FORMAT_R8G8B8A8_UNORM,
                                        .width = uint32_t(size.x),
                                        .height = uint32_t(size.y),
                                        .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
        const gpu::Binding binding{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
        pictureSet_ = gpu::DescriptorSet(device_, setLayout_.get(), {&binding, 1}, 0);
        pictureSet_.image(0, picture_.view(), sampler_.get());
    }
    gpu::Uploader uploader(device_);
    const gpu::Uploader::Level level{0, 0, picture.data()};
    uploader.image(picture_, {&level, 1}, 4);
    uploader.finish();
}

void UiRenderer::upload(const ImDrawData& data, Buffers& buffers) const
{
    ensure(device_, buffers.vertices, std::size_t(data.TotalVtxCount) * sizeof(ImDrawVert),
           VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    ensure(device_, buffers.indices, std::size_t(data.TotalIdxCount) * sizeof(ImDrawIdx),
           VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    std::byte* vertices = buffers.vertices.mapped();
    std::byte* indices = buffers.indices.mapped();
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        const std::size_t vertexBytes = std::size_t(list.VtxBuffer.Size) * sizeof(ImDrawVert);
        const std::size_t indexBytes = std::size_t(list.IdxBuffer.Size) * sizeof(ImDrawIdx);
        std::memcpy(vertices, list.VtxBuffer.Data, vertexBytes);
        std::memcpy(indices, list.IdxBuffer.Data, indexBytes);
        vertices += vertexBytes;
        indices += indexBytes;
    }
}

void UiRenderer::drawLists(VkCommandBuffer commands, ivec2 size, const ImDrawData& data) const
{
    const gpu::Functions& vk = device_.vk;
    const vec2 origin(data.DisplayPos.x, data.DisplayPos.y);
    const vec2 pixels(data.FramebufferScale.x, data.FramebufferScale.y);
    int32_t firstVertex = 0;
    uint32_t firstIndex = 0;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        for (const ImDrawCmd& command : list.CmdBuffer) {
            const vec4 clip(command.ClipRect.x, command.ClipRect.y, command.ClipRect.z, command.ClipRect.w);
            const ivec2 low = glm::max(ivec2((vec2(clip.x, clip.y) - origin) * pixels), ivec2(0));
            const ivec2 high = glm::min(ivec2((vec2(clip.z, clip.w) - origin) * pixels), size);
            if (high.x <= low.x || high.y <= low.y) continue;
            const VkRect2D scissor{{low.x, low.y}, {uint32_t(high.x - low.x), uint32_t(high.y - low.y)}};
            const bool isPicture = reinterpret_cast<std::size_t>(command.GetTexID()) == kPicture;
            VkDescriptorSet set = isPicture ? pictureSet_.get() : set_.get();
            if (set == VK_NULL_HANDLE) continue;
            vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 0, 1, &set, 0, nullptr);
            vk.CmdSetScissor(commands, 0, 1, &scissor);
            vk.CmdDrawIndexed(commands, command.ElemCount, 1, firstIndex + command.IdxOffset,
                              firstVertex + int32_t(command.VtxOffset), 0);
        }
        firstIndex += uint32_t(list.IdxBuffer.Size);
        firstVertex += list.VtxBuffer.Size;
    }
}

void UiRenderer::draw(VkCommandBuffer commands, VkImageView target, ivec2 size, const ImDrawData& data, int slot)
{
    if (data.TotalVtxCount == 0) return;
    Buffers& buffers = buffers_[std::size_t(slot)];
    upload(data, buffers);

    const gpu::Functions& vk = device_.vk;
    const VkRenderingAttachmentInfo attachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                               .imageView = target,
                                               .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                               .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, {uint32_t(size.x), uint32_t(size.y)}},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &attachment};
    vk.CmdBeginRendering(commands, &rendering);
    const VkViewport viewport{0.0f, 0.0f, float(size.x), float(size.y), 0.0f, 1.0f};
    vk.CmdSetViewport(commands, 0, 1, &viewport);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_.get());
    vk.CmdSetCullMode(commands, VK_CULL_MODE_NONE);
    vk.CmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    VkBuffer vertexBuffer = buffers.vertices.get();
    const VkDeviceSize none = 0;
    vk.CmdBindVertexBuffers(commands, 0, 1, &vertexBuffer, &none);
    vk.CmdBindIndexBuffer(commands, buffers.indices.get(), 0,
                          sizeof(ImDrawIdx) == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
    const vec2 origin(data.DisplayPos.x, data.DisplayPos.y);
    const vec2 scale = 2.0f / vec2(data.DisplaySize.x, data.DisplaySize.y);
    const Push push{scale, -1.0f - origin * scale};
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                        sizeof(push), &push);

    drawLists(commands, size, data);
    vk.CmdEndRendering(commands);
}

} // namespace halflight::view
