#include "gpu/resources.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace halflight::gpu {
namespace {

constexpr VkDeviceSize kStagingBytes = VkDeviceSize(16) << 20;

VkImageSubresourceRange wholeImage(const ImageInfo& info)
{
    return {info.aspect, 0, info.mipLevels, 0, info.layers};
}

/// Its storage view has another format.
bool isCast(const ImageInfo& info)
{
    return info.storageFormat != VK_FORMAT_UNDEFINED && info.storageFormat != info.format;
}

/// All levels and layers, for some of the image's usages.
UniqueView wholeView(const Device& device, VkImage image, const ImageInfo& info, VkFormat format,
                     VkImageUsageFlags usage)
{
    const VkImageViewUsageCreateInfo usageInfo{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO, .usage = usage};
    const VkImageViewCreateInfo viewInfo{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                         .pNext = &usageInfo,
                                         .image = image,
                                         .viewType = info.depth > 0                  ? VK_IMAGE_VIEW_TYPE_3D
                                                     : info.array || info.layers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                                                     : VK_IMAGE_VIEW_TYPE_2D,
                                         .format = format,
                                         .subresourceRange = wholeImage(info)};
    VkImageView view = VK_NULL_HANDLE;
    check(device.vk.CreateImageView(device.handle(), &viewInfo, nullptr, &view), "create an image view");
    return {device, view};
}

} // namespace

Buffer::Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use)
    : size_(std::max<VkDeviceSize>(bytes, 16))
{
    const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size_, .usage = usage};
    VkBuffer buffer = VK_NULL_HANDLE;
    check(device.vk.CreateBuffer(device.handle(), &info, nullptr, &buffer), "create a buffer");
    buffer_ = UniqueBuffer(device, buffer);
    VkMemoryRequirements requirements;
    device.vk.GetBufferMemoryRequirements(device.handle(), buffer, &requirements);
    allocation_ = device.memory().allocate(requirements, use, false);
    check(device.vk.BindBufferMemory(device.handle(), buffer, allocation_.memory(), allocation_.offset()),
          "bind a buffer's memory");
    if ((usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) == 0) return;
    const VkBufferDeviceAddressInfo whose{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer};
    address_ = device.vk.GetBufferDeviceAddress(device.handle(), &whose);
}

Image::Image(const Device& device, const ImageInfo& info) : info_(info)
{
    const VkPhysicalDeviceLimits& limits = device.properties().limits;
    if (std::max(info.width, info.height) > limits.maxImageDimension2D || info.layers > limits.maxImageArrayLayers)
        throw Failure("an image of " + std::to_string(info.width) + " x " + std::to_string(info.height) + " x " +
                      std::to_string(info.layers) + " is larger than the Vulkan device allows");
    const VkImageCreateInfo imageInfo{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                      .flags = VkImageCreateFlags(isCast(info) ? VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT |
                                                                                     VK_IMAGE_CREATE_EXTENDED_USAGE_BIT
                                                                               : 0),
                                      .imageType = info.depth > 0 ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D,
                                      .format = info.format,
                                      .extent = {info.width, info.height, std::max(info.depth, 1u)},
                                      .mipLevels = info.mipLevels,
                                      .arrayLayers = info.layers,
                                      .samples = VK_SAMPLE_COUNT_1_BIT,
                                      .tiling = VK_IMAGE_TILING_OPTIMAL,
                                      .usage = info.usage};
    VkImage image = VK_NULL_HANDLE;
    check(device.vk.CreateImage(device.handle(), &imageInfo, nullptr, &image), "create an image");
    image_ = UniqueImage(device, image);
    VkMemoryRequirements requirements;
    device.vk.GetImageMemoryRequirements(device.handle(), image, &requirements);
    allocation_ = device.memory().allocate(requirements, MemoryUse::Device, true);
    check(device.vk.BindImageMemory(device.handle(), image, allocation_.memory(), allocation_.offset()),
          "bind an image's memory");
    // A view may have only usages that its own format allows.
    const VkImageUsageFlags viewUsage =
        isCast(info) ? info.usage & ~VkImageUsageFlags(VK_IMAGE_USAGE_STORAGE_BIT) : info.usage;
    view_ = wholeView(device, image, info, info.format, viewUsage);
    if ((info.usage & VK_IMAGE_USAGE_STORAGE_BIT) == 0) return;
    storageView_ =
        wholeView(device, image, info, isCast(info) ? info.storageFormat : info.format, VK_IMAGE_USAGE_STORAGE_BIT);
}

UniqueView Image::layerView(const Device& device, uint32_t layer) const
{
    assert(layer < info_.layers);
    const VkImageViewCreateInfo viewInfo{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                         .image = get(),
                                         .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                         .format = info_.format,
                                         .subresourceRange = {info_.aspect, 0, 1, layer, 1}};
    VkImageView view = VK_NULL_HANDLE;
    check(device.vk.CreateImageView(device.handle(), &viewInfo, nullptr, &view), "create an image view");
    return {device, view};
}

UniqueSampler makeSampler(const Device& device, const SamplerInfo& info)
{
    const float anisotropy =
        device.anisotropy() ? std::min(info.maxAnisotropy, device.properties().limits.maxSamplerAnisotropy) : 1.0f;
    const VkSamplerCreateInfo samplerInfo{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                          .magFilter = info.magFilter,
                                          .minFilter = info.minFilter,
                                          .mipmapMode = info.mipmapMode,
                                          .addressModeU = info.addressU,
                                          .addressModeV = info.addressV,
                                          .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                          .anisotropyEnable = anisotropy > 1.0f,
                                          .maxAnisotropy = anisotropy,
                                          .compareEnable = info.compareLessOrEqual,
                                          .compareOp = VK_COMPARE_OP_LESS_OR_EQUAL,
                                          .maxLod = VK_LOD_CLAMP_NONE};
    VkSampler sampler = VK_NULL_HANDLE;
    check(device.vk.CreateSampler(device.handle(), &samplerInfo, nullptr, &sampler), "create a sampler");
    return {device, sampler};
}

void transition(const Device& device, VkCommandBuffer commands, VkImage image, const VkImageSubresourceRange& range,
                const ImageState& before, const ImageState& after)
{
    const VkImageMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                        .srcStageMask = before.stage,
                                        .srcAccessMask = before.access,
                                        .dstStageMask = after.stage,
                                        .dstAccessMask = after.access,
                                        .oldLayout = before.layout,
                                        .newLayout = after.layout,
                                        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                        .image = image,
                                        .subresourceRange = range};
    const VkDependencyInfo dependency{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    device.vk.CmdPipelineBarrier2(commands, &dependency);
}

void transition(const Device& device, VkCommandBuffer commands, const Image& image, const ImageState& before,
                const ImageState& after)
{
    transition(device, commands, image.get(), wholeImage(image.info()), before, after);
}

Uploader::Uploader(Device& device)
    : device_(device), staging_(device, kStagingBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::Upload)
{}

VkDeviceSize Uploader::reserve(VkDeviceSize bytes)
{
    assert(bytes <= kStagingBytes);
    if (used_ + bytes > kStagingBytes) finish();
    const VkDeviceSize at = used_;
    used_ += (bytes + 15) / 16 * 16;
    return at;
}

void Uploader::buffer(const Buffer& target, const void* data, VkDeviceSize bytes, VkDeviceSize offset)
{
    assert(offset + bytes <= target.size());
    for (VkDeviceSize done = 0; done < bytes;) {
        const VkDeviceSize chunk = std::min(bytes - done, kStagingBytes);
        const VkDeviceSize at = reserve(chunk);
        std::memcpy(staging_.mapped() + at, static_cast<const std::byte*>(data) + done, chunk);
        pending_.push_back([this, source = staging_.get(), to = target.get(), at, begin = offset + done,
                            chunk](VkCommandBuffer commands) {
            const VkBufferCopy region{at, begin, chunk};
            device_.vk.CmdCopyBuffer(commands, source, to, 1, &region);
        });
        done += chunk;
    }
}

void Uploader::image(const Image& target, std::span<const Level> levels, uint32_t bytesPerTexel)
{
    pending_.push_back([this, &target](VkCommandBuffer commands) {
        transition(device_, commands, target, state::kUndefined, state::kTransferTarget);
    });
    const ImageInfo& info = target.info();
    for (const Level& level : levels) {
        const uint32_t width = std::max(info.width >> level.level, 1u);
        const uint32_t height = std::max(info.height >> level.level, 1u);
        const VkDeviceSize rowBytes = VkDeviceSize(width) * bytesPerTexel;
        const uint32_t rowsPerChunk = uint32_t(std::max<VkDeviceSize>(kStagingBytes / rowBytes, 1));
        for (uint32_t row = 0; row < height;) {
            const uint32_t rows = std::min(height - row, rowsPerChunk);
            const VkDeviceSize at = reserve(rowBytes * rows);
            std::memcpy(staging_.mapped() + at, static_cast<const std::byte*>(level.texels) + rowBytes * row,
                        rowBytes * rows);
            const VkBufferImageCopy region{.bufferOffset = at,
                                           .imageSubresource = {info.aspect, level.level, level.layer, 1},
                                           .imageOffset = {0, int32_t(row), 0},
                                           .imageExtent = {width, rows, 1}};
            pending_.push_back([this, source = staging_.get(), to = target.get(), region](VkCommandBuffer commands) {
                device_.vk.CmdCopyBufferToImage(commands, source, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
            });
            row += rows;
        }
    }
    pending_.push_back([this, &target](VkCommandBuffer commands) {
        transition(device_, commands, target, state::kTransferTarget, state::kFragmentRead);
    });
}

void Uploader::boxes(const Image& target, const ImageState& before, std::span<const Box> boxes, uint32_t bytesPerTexel)
{
    pending_.push_back([this, &target, before](VkCommandBuffer commands) {
        transition(device_, commands, target, before, state::kTransferTarget);
    });
    for (const Box& box : boxes) {
        const VkDeviceSize sliceBytes = VkDeviceSize(box.size.width) * box.size.height * bytesPerTexel;
        assert(sliceBytes <= kStagingBytes);
        for (uint32_t slice = 0; slice < box.size.depth;) {
            const uint32_t slices =
                std::min(box.size.depth - slice, uint32_t(std::max<VkDeviceSize>(kStagingBytes / sliceBytes, 1)));
            const VkDeviceSize at = reserve(sliceBytes * slices);
            std::memcpy(staging_.mapped() + at, static_cast<const std::byte*>(box.texels) + sliceBytes * slice,
                        sliceBytes * slices);
            const VkBufferImageCopy region{.bufferOffset = at,
                                           .imageSubresource = {target.info().aspect, 0, box.layer, 1},
                                           .imageOffset = {box.offset.x, box.offset.y, box.offset.z + int32_t(slice)},
                                           .imageExtent = {box.size.width, box.size.height, slices}};
            pending_.push_back([this, source = staging_.get(), to = target.get(), region](VkCommandBuffer commands) {
                device_.vk.CmdCopyBufferToImage(commands, source, to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
            });
            slice += slices;
        }
    }
    pending_.push_back([this, &target](VkCommandBuffer commands) {
        transition(device_, commands, target, state::kTransferTarget, state::kFragmentRead);
    });
}

void Uploader::finish()
{
    if (!pending_.empty())
        device_.execute([this](VkCommandBuffer commands) {
            for (const auto& copy : pending_) copy(commands);
            waitForEarlier(device_, commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
        });
    pending_.clear();
    used_ = 0;
}

void copyToHost(const Device& device, VkCommandBuffer commands, const Image& image, const Buffer& target)
{
    const VkBufferImageCopy region{.imageSubresource = {image.info().aspect, 0, 0, 1},
                                   .imageExtent = {image.info().width, image.info().height, 1}};
    device.vk.CmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target.get(), 1,
                                   &region);
    const VkMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                   .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                                   .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                   .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
                                   .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    const VkDependencyInfo dependency{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    device.vk.CmdPipelineBarrier2(commands, &dependency);
}

Timer::Timer(const Device& device, uint32_t maxPasses) : device_(device), capacity_(maxPasses + 1)
{
    if (!device.timestamps()) return;
    const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                     .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                     .queryCount = capacity_};
    VkQueryPool pool = VK_NULL_HANDLE;
    check(device.vk.CreateQueryPool(device.handle(), &info, nullptr, &pool), "create a query pool");
    pool_ = {device, pool};
}

void Timer::begin(VkCommandBuffer commands)
{
    names_.clear();
    if (!pool_) return;
    device_.vk.CmdResetQueryPool(commands, pool_.get(), 0, capacity_);
    device_.vk.CmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_.get(), 0);
}

void Timer::mark(VkCommandBuffer commands, const char* name)
{
    if (!pool_) return;
    assert(names_.size() + 1 < capacity_);
    names_.push_back(name);
    device_.vk.CmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_.get(), uint32_t(names_.size()));
}

std::vector<Timer::Span> Timer::results() const
{
    if (!pool_ || names_.empty()) return {};
    std::vector<uint64_t> ticks(names_.size() + 1);
    check(device_.vk.GetQueryPoolResults(device_.handle(), pool_.get(), 0, uint32_t(ticks.size()),
                                         ticks.size() * sizeof(uint64_t), ticks.data(), sizeof(uint64_t),
                                         VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "read its timestamps");
    std::vector<Span> spans;
    for (std::size_t i = 0; i < names_.size(); ++i)
        spans.push_back(
            {names_[i], double(ticks[i + 1] - ticks[i]) * device_.properties().limits.timestampPeriod * 1e-6});
    return spans;
}

} // namespace halflight::gpu
