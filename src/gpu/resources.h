#pragma once
// Buffers, images, samplers; and moving data between host and device.

#include "gpu/device.h"

#include <cstddef>
#include <span>
#include <vector>

namespace halflight::gpu {

/// A Vulkan handle that is destroyed when it goes out of scope. The Device must outlive it.
template<typename Handle, auto DestroyFunction> class Unique {
public:
    Unique() = default;
    Unique(const Device& device, Handle handle) : device_(&device), handle_(handle) {}
    Unique(Unique&& other) noexcept { swap(other); }
    Unique& operator=(Unique&& other) noexcept
    {
        Unique moved(std::move(other));
        swap(moved);
        return *this;
    }
    ~Unique()
    {
        if (handle_) (device_->vk.*DestroyFunction)(device_->handle(), handle_, nullptr);
    }
    [[nodiscard]] Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

private:
    void swap(Unique& other) noexcept
    {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
    }
    const Device* device_ = nullptr;
    Handle handle_ = VK_NULL_HANDLE;
};

using UniqueBuffer = Unique<VkBuffer, &Functions::DestroyBuffer>;
using UniqueImage = Unique<VkImage, &Functions::DestroyImage>;
using UniqueView = Unique<VkImageView, &Functions::DestroyImageView>;
using UniqueSampler = Unique<VkSampler, &Functions::DestroySampler>;

class Buffer {
public:
    Buffer() = default;
    /// A size of 0 makes a buffer of 16 bytes, so that it can be bound.
    Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use);

    [[nodiscard]] VkBuffer get() const { return buffer_.get(); }
    [[nodiscard]] VkDeviceSize size() const { return size_; }
    [[nodiscard]] std::byte* mapped() const { return allocation_.mapped(); }
    /// Where shaders find it; 0 unless `usage` has VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT.
    [[nodiscard]] VkDeviceAddress address() const { return address_; }

private:
    Allocation allocation_; // outlives the buffer: members are destroyed in reverse order
    UniqueBuffer buffer_;
    VkDeviceSize size_ = 0;
    VkDeviceAddress address_ = 0;
};

struct ImageInfo {
    VkFormat format = VK_FORMAT_UNDEFINED;
    uint32_t width = 1;
    uint32_t height = 1;
    uint32_t depth = 0; ///< above 0: a 3D image, of one level and layer
    uint32_t mipLevels = 1;
    uint32_t layers = 1;
    bool array = false; ///< viewed as a 2D array even when it has one layer
    VkImageUsageFlags usage = 0;
    /// With VK_IMAGE_USAGE_STORAGE_BIT, how storageView() has the texels: `format`, or another one of the same size
    /// (Device::hasStorageView()). Undefined: `format`.
    VkFormat storageFormat = VK_FORMAT_UNDEFINED;
    VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
};

class Image {
public:
    Image() = default;
    Image(const Device& device, const ImageInfo& info);

    [[nodiscard]] VkImage get() const { return image_.get(); }
    /// All levels and layers.
    [[nodiscard]] VkImageView view() const { return view_.get(); }
    /// The same for compute shaders to write, of images with VK_IMAGE_USAGE_STORAGE_BIT.
    [[nodiscard]] VkImageView storageView() const { return storageView_.get(); }
    [[nodiscard]] const ImageInfo& info() const { return info_; }
    /// One layer as a 2D image, to draw into.
    [[nodiscard]] UniqueView layerView(const Device& device, uint32_t layer) const;

private:
    Allocation allocation_;
    UniqueImage image_;
    UniqueView view_;
    UniqueView storageView_;
    ImageInfo info_;
};

struct SamplerInfo {
    VkFilter magFilter = VK_FILTER_LINEAR;
    VkFilter minFilter = VK_FILTER_LINEAR;
    VkSamplerMipmapMode mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
    VkSamplerAddressMode addressU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    VkSamplerAddressMode addressV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    bool compareLessOrEqual = false;
    float maxAnisotropy = 1.0f; ///< clamped to what the device has
};
UniqueSampler makeSampler(const Device& device, const SamplerInfo& info);

/// Where an image stands between two uses.
struct ImageState {
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    VkPipelineStageFlags2 stage = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
};
namespace state {
inline constexpr ImageState kUndefined{};
/// What is in the image is not kept; whatever used it before has finished.
inline constexpr ImageState kReused{VK_IMAGE_LAYOUT_UNDEFINED, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                    VK_ACCESS_2_MEMORY_WRITE_BIT};
inline constexpr ImageState kColorAttachment{
    VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT};
inline constexpr ImageState kDepthAttachment{
    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT};
inline constexpr ImageState kFragmentRead{VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                          VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT};
inline constexpr ImageState kComputeWrite{VK_IMAGE_LAYOUT_GENERAL, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                          VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
inline constexpr ImageState kTransferSource{VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
                                            VK_ACCESS_2_TRANSFER_READ_BIT};
inline constexpr ImageState kTransferTarget{VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
                                            VK_ACCESS_2_TRANSFER_WRITE_BIT};
} // namespace state
/// Barrier over a part of an image.
void transition(const Device& device, VkCommandBuffer commands, VkImage image, const VkImageSubresourceRange& range,
                const ImageState& before, const ImageState& after);
/// Barrier over the whole image.
void transition(const Device& device, VkCommandBuffer commands, const Image& image, const ImageState& before,
                const ImageState& after);

/// Copies host data to the device through a staging buffer, as many copies to a submission as fit.
class Uploader {
public:
    explicit Uploader(Device& device);

    void buffer(const Buffer& target, const void* data, VkDeviceSize bytes, VkDeviceSize offset = 0);

    struct Level {
        uint32_t level = 0;
        uint32_t layer = 0;
        const void* texels = nullptr; ///< tightly packed rows, read before the call returns
    };
    /// All levels and layers of an image that is then read by fragment shaders.
    void image(const Image& target, std::span<const Level> levels, uint32_t bytesPerTexel);

    /// A box of a 3D image, or a rectangle of a layer, that fragment shaders read before (or nobody: kUndefined) and
    /// read afterwards.
    struct Box {
        VkOffset3D offset{};
        VkExtent3D size{};
        const void* texels = nullptr; ///< tightly packed, read before the call returns
        uint32_t layer = 0;
    };
    void boxes(const Image& target, const ImageState& before, std::span<const Box> boxes, uint32_t bytesPerTexel);

    /// Submits what is left and waits.
    void finish();

private:
    VkDeviceSize reserve(VkDeviceSize bytes);

    Device& device_;
    Buffer staging_;
    VkDeviceSize used_ = 0;
    std::vector<std::function<void(VkCommandBuffer)>> pending_;
};

/// Copies level 0, layer 0 of an image in state kTransferSource to a Readback buffer, where the host sees it once the
/// submission has finished.
void copyToHost(const Device& device, VkCommandBuffer commands, const Image& image, const Buffer& target);

/// Names and durations of the passes of one submission.
class Timer {
public:
    Timer(const Device& device, uint32_t maxPasses);
    void begin(VkCommandBuffer commands);
    /// Ends the pass that began at the last mark, or at begin().
    void mark(VkCommandBuffer commands, const char* name);
    struct Span {
        std::string name;
        double milliseconds = 0.0;
    };
    /// After the submission has finished. Empty on devices without timestamps.
    [[nodiscard]] std::vector<Span> results() const;

private:
    const Device& device_;
    Unique<VkQueryPool, &Functions::DestroyQueryPool> pool_;
    uint32_t capacity_;
    std::vector<const char*> names_;
};

} // namespace halflight::gpu
