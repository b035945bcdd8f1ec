#pragma once
// Device memory: blocks of 64 MiB cut first-fit; what is larger than a quarter of a block gets a block of its own. One
// empty block of each kind stays: drivers take 20 ms to make one that the host sees, and each upload needs some.

#include "gpu/vulkan.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace halflight::gpu {

class Memory;

/// A range of device memory; freed when it goes out of scope.
class Allocation {
public:
    Allocation() = default;
    Allocation(Allocation&& other) noexcept { *this = std::move(other); }
    Allocation& operator=(Allocation&& other) noexcept;
    ~Allocation();

    [[nodiscard]] VkDeviceMemory memory() const { return memory_; }
    [[nodiscard]] VkDeviceSize offset() const { return offset_; }
    /// Where the range is mapped; null for memory the host cannot see. Mapped memory is always coherent.
    [[nodiscard]] std::byte* mapped() const { return mapped_; }

private:
    friend class Memory;
    Memory* owner_ = nullptr;
    void* block_ = nullptr;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    VkDeviceSize offset_ = 0;
    VkDeviceSize size_ = 0;
    std::byte* mapped_ = nullptr;
};

enum class MemoryUse {
    Device,   ///< fastest for the device
    Upload,   ///< written by the host, read by the device
    Readback, ///< written by the device, read by the host
};

class Memory {
public:
    /// `addresses`: buffers may have device addresses (feature bufferDeviceAddress).
    /// `most`: DeviceOptions::mostBytes. `fails`: DeviceOptions::fails.
    Memory(const Functions& vk, VkDevice device, const VkPhysicalDeviceMemoryProperties& properties, bool addresses,
           VkDeviceSize most, std::function<bool()> fails);
    ~Memory();
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    /// Allocations may be made and dropped on any thread. `image`: optimally tiled images and buffers never share a
    /// block, so bufferImageGranularity never matters.
    Allocation allocate(const VkMemoryRequirements& requirements, MemoryUse use, bool image);
    /// The most that was taken of the device's own memory at one time, bytes.
    [[nodiscard]] VkDeviceSize peakBytes() const;

private:
    friend class Allocation;
    struct Range {
        VkDeviceSize offset, size;
    };
    struct Block {
        VkDeviceMemory memory = VK_NULL_HANDLE;
        uint32_t type = 0;
        bool image = false;
        bool dedicated = false;
        VkDeviceSize size = 0;
        std::byte* mapped = nullptr;
        std::vector<Range> free; ///< by offset, never adjacent
    };
    [[nodiscard]] static bool isEmpty(const Block& block)
    {
        return !block.free.empty() && block.free.front().size == block.size;
    }
    void destroyEmptyBlocks();
    Block& addBlock(uint32_t type, VkDeviceSize size, bool image, bool dedicated);
    void release(Allocation& allocation);
    void destroyBlock(Block& block);
    [[nodiscard]] bool isOnDevice(uint32_t type) const;

    const Functions& vk_;
    VkDevice device_;
    VkPhysicalDeviceMemoryProperties properties_;
    bool addresses_;
    VkDeviceSize most_;
    std::function<bool()> fails_;
    mutable std::mutex mutex_; ///< guards what follows
    std::vector<std::unique_ptr<Block>> blocks_;
    VkDeviceSize bytes_ = 0; ///< of blocks in the device's own memory
    VkDeviceSize peakBytes_ = 0;
};

} // namespace halflight::gpu
