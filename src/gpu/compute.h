#pragma once
// Compute shaders, and shaders that trace rays. They read buffers by address alone: one block of push constants holds
// the addresses, and there are no descriptors.

#include "gpu/pipeline.h"

#include <cstddef>
#include <span>

namespace halflight::gpu {

/// Usage of buffers that shaders find by their address.
constexpr VkBufferUsageFlags kAddressed = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                          VK_BUFFER_USAGE_TRANSFER_SRC_BIT;

/// Bytes of push constants that every device has.
constexpr uint32_t kMostPushBytes = 128;

/// The bytes of a block of push constants.
template<typename T> std::span<const std::byte> bytesOf(const T& value)
{
    return std::as_bytes(std::span<const T, 1>(&value, 1));
}

/// All commands before are done, and what they wrote is seen, before those that follow begin. Addresses hide from the
/// validation layer which buffers a shader uses, so that there is one barrier for all.
void fullBarrier(const Device& device, VkCommandBuffer commands);

/// A part of a buffer's bytes to another buffer, after a full barrier.
struct BytesOf {
    const Buffer& buffer;
    VkDeviceSize offset = 0;
};
void copyBytes(const Device& device, VkCommandBuffer commands, const BytesOf& from, const BytesOf& to,
               VkDeviceSize bytes);

class ComputePipeline {
public:
    ComputePipeline() = default;
    /// `push`: bytes of its push constants, at most kMostPushBytes.
    ComputePipeline(const Device& device, std::span<const uint32_t> spirv, uint32_t push);

    /// Runs enough groups of `groupSize` invocations for `count` items, after a full barrier. The shader ignores
    /// invocations beyond `count`.
    void run(VkCommandBuffer commands, std::span<const std::byte> push, uint64_t count, uint32_t groupSize) const;

private:
    const Device* device_ = nullptr;
    UniquePipelineLayout layout_;
    UniquePipeline pipeline_;
};

/// The shaders of a pipeline that traces rays: all rays share one miss shader and one hit group, unless some are of a
/// second kind, which has offset 1 in both tables.
struct RayShaders {
    struct Ends {
        std::span<const uint32_t> miss;    ///< empty: there is no second kind
        std::span<const uint32_t> closest; ///< may be empty
        std::span<const uint32_t> any;     ///< may be empty
    };
    std::span<const uint32_t> generate;
    Ends first;
    Ends second = {};
};

class RayPipeline {
public:
    RayPipeline() = default;
    RayPipeline(Device& device, const RayShaders& shaders, uint32_t push);

    /// Runs the generating shader `count` times, after a full barrier.
    void run(VkCommandBuffer commands, std::span<const std::byte> push, uint32_t count) const;

private:
    void makeTable(Device& device, uint32_t kinds);

    const Device* device_ = nullptr;
    UniquePipelineLayout layout_;
    UniquePipeline pipeline_;
    Buffer table_; ///< handles of all groups
    VkStridedDeviceAddressRegionKHR generate_{};
    VkStridedDeviceAddressRegionKHR miss_{};
    VkStridedDeviceAddressRegionKHR hit_{};
};

} // namespace halflight::gpu
