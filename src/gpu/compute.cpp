#include "gpu/compute.h"

#include <array>
#include <cassert>
#include <cstring>

namespace halflight::gpu {
namespace {

constexpr VkShaderStageFlags kRayStages =
    VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR | VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR;

UniquePipelineLayout pushLayout(const Device& device, VkShaderStageFlags stages, uint32_t push)
{
    assert(push <= kMostPushBytes);
    const VkPushConstantRange range{stages, 0, push};
    const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &range};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(device.vk.CreatePipelineLayout(device.handle(), &info, nullptr, &layout), "create a pipeline layout");
    return {device, layout};
}

VkPipelineShaderStageCreateInfo stageOf(VkShaderStageFlagBits stage, const UniqueShader& shader)
{
    return {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
            .stage = stage,
            .module = shader.get(),
            .pName = "main"};
}

} // namespace

void fullBarrier(const Device& device, VkCommandBuffer commands)
{
    waitForEarlier(device, commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                   VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
}

void copyBytes(const Device& device, VkCommandBuffer commands, const BytesOf& from, const BytesOf& to,
               VkDeviceSize bytes)
{
    fullBarrier(device, commands);
    const VkBufferCopy region{from.offset, to.offset, bytes};
    device.vk.CmdCopyBuffer(commands, from.buffer.get(), to.buffer.get(), 1, &region);
}

ComputePipeline::ComputePipeline(const Device& device, std::span<const uint32_t> spirv, uint32_t push)
    : device_(&device), layout_(pushLayout(device, VK_SHADER_STAGE_COMPUTE_BIT, push)),
      pipeline_(makeComputePipeline(device, layout_.get(), spirv))
{}

void ComputePipeline::run(VkCommandBuffer commands, std::span<const std::byte> push, uint64_t count,
                          uint32_t groupSize) const
{
    if (count == 0) return;
    // A row of groups has at most as many as every device allows; the shader finds its item from both numbers.
    constexpr uint64_t kRow = 65535;
    const uint64_t groups = (count + groupSize - 1) / groupSize;
    const uint64_t rows = (groups + kRow - 1) / kRow;
    fullBarrier(*device_, commands);
    const Functions& vk = device_->vk;
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vk.CmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, uint32_t(push.size()), push.data());
    vk.CmdDispatch(commands, uint32_t(rows > 1 ? kRow : groups), uint32_t(rows), 1);
}

RayPipeline::RayPipeline(Device& device, const RayShaders& shaders, uint32_t push)
    : device_(&device), layout_(pushLayout(device, kRayStages, push))
{
    std::vector<UniqueShader> modules;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    const auto add = [&](VkShaderStageFlagBits stage, std::span<const uint32_t> spirv) -> uint32_t {
        if (spirv.empty()) return VK_SHADER_UNUSED_KHR;
        modules.push_back(makeShader(device, spirv));
        stages.push_back(stageOf(stage, modules.back()));
        return uint32_t(stages.size() - 1);
    };
    const auto group = [](VkRayTracingShaderGroupTypeKHR type) {
        VkRayTracingShaderGroupCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR,
                                                  .type = type};
        info.generalShader = info.closestHitShader = info.anyHitShader = info.intersectionShader = VK_SHADER_UNUSED_KHR;
        return info;
    };
    std::vector<RayShaders::Ends> kinds{shaders.first};
    if (!shaders.second.miss.empty()) kinds.push_back(shaders.second);
    std::vector<VkRayTracingShaderGroupCreateInfoKHR> groups;
    const auto addGeneral = [&](VkShaderStageFlagBits stage, std::span<const uint32_t> spirv) {
        groups.push_back(group(VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR));
        groups.back().generalShader = add(stage, spirv);
    };
    addGeneral(VK_SHADER_STAGE_RAYGEN_BIT_KHR, shaders.generate);
    for (const RayShaders::Ends& kind : kinds) addGeneral(VK_SHADER_STAGE_MISS_BIT_KHR, kind.miss);
    for (const RayShaders::Ends& kind : kinds) {
        groups.push_back(group(VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR));
        groups.back().closestHitShader = add(VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, kind.closest);
        groups.back().anyHitShader = add(VK_SHADER_STAGE_ANY_HIT_BIT_KHR, kind.any);
    }
    const VkRayTracingPipelineCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR,
                                                 .stageCount = uint32_t(stages.size()),
                                                 .pStages = stages.data(),
                                                 .groupCount = uint32_t(groups.size()),
                                                 .pGroups = groups.data(),
                                                 .maxPipelineRayRecursionDepth = 1,
                                                 .layout = layout_.get()};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(device.vk.CreateRayTracingPipelinesKHR(device.handle(), VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &info, nullptr,
                                                 &pipeline),
          "create a pipeline that traces rays");
    pipeline_ = UniquePipeline(device, pipeline);
    makeTable(device, uint32_t(kinds.size()));
}

void RayPipeline::makeTable(Device& device, uint32_t kinds)
{
    const VkPhysicalDeviceRayTracingPipelinePropertiesKHR limits = device.rayLimits();
    const VkDeviceSize handle = limits.shaderGroupHandleSize;
    const VkDeviceSize base = limits.shaderGroupBaseAlignment;
    const VkDeviceSize stride = (handle + base - 1) / base * base;
    const uint32_t groups = 1 + 2 * kinds; // generate, misses, hits
    std::vector<std::byte> handles(groups * handle);
    check(device.vk.GetRayTracingShaderGroupHandlesKHR(device.handle(), pipeline_.get(), 0, groups, handles.size(),
                                                       handles.data()),
          "name its shaders");
    // One base more, so that the table may begin at an aligned address.
    table_ = Buffer(device, (groups + 1) * stride, kAddressed | VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR,
                    MemoryUse::Device);
    const VkDeviceAddress begin = (table_.address() + base - 1) / base * base;
    Uploader uploader(device);
    for (VkDeviceSize i = 0; i < groups; ++i)
        uploader.buffer(table_, handles.data() + i * handle, handle, begin - table_.address() + i * stride);
    uploader.finish();
    generate_ = {begin, stride, stride};
    miss_ = {begin + stride, stride, kinds * stride};
    hit_ = {begin + (1 + kinds) * stride, stride, kinds * stride};
}

void RayPipeline::run(VkCommandBuffer commands, std::span<const std::byte> push, uint32_t count) const
{
    if (count == 0) return;
    fullBarrier(*device_, commands);
    const Functions& vk = device_->vk;
    const VkStridedDeviceAddressRegionKHR callable{};
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, pipeline_.get());
    vk.CmdPushConstants(commands, layout_.get(), kRayStages, 0, uint32_t(push.size()), push.data());
    vk.CmdTraceRaysKHR(commands, &generate_, &miss_, &hit_, &callable, count, 1, 1);
}

} // namespace halflight::gpu
