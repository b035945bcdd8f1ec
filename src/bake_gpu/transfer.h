#pragma once
// Large lists to a device and back. All threads write and read the memory that both sides see.

#include "gpu/compute.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

namespace halflight {

class Transfer {
public:
    explicit Transfer(gpu::Device& device) : device_(device) {}

    /// Writes items of a buffer: fill(i) is item i. Throws gpu::Failure.
    template<typename T, typename Fill> void upload(const gpu::Buffer& to, std::size_t count, const Fill& fill)
    {
        for (std::size_t first = 0; first < count; first += itemsAtOnce<T>()) {
            const std::size_t some = std::min(itemsAtOnce<T>(), count - first);
            T* const items = reinterpret_cast<T*>(mapped(count * sizeof(T), gpu::MemoryUse::Upload));
            forEachIndex(some, [&](std::size_t i) { items[i] = fill(first + i); });
            copy({staging_}, {to, first * sizeof(T)}, some * sizeof(T));
        }
    }
    template<typename T> void upload(const gpu::Buffer& to, std::span<const T> list)
    {
        upload<T>(to, list.size(), [&](std::size_t i) { return list[i]; });
    }
    /// Reads items of a buffer. Throws gpu::Failure.
    template<typename T> void download(const gpu::Buffer& from, std::span<T> list)
    {
        for (std::size_t first = 0; first < list.size(); first += itemsAtOnce<T>()) {
            const std::size_t some = std::min(itemsAtOnce<T>(), list.size() - first);
            const T* const items = reinterpret_cast<const T*>(mapped(list.size_bytes(), gpu::MemoryUse::Readback));
            copy({from, first * sizeof(T)}, {staging_}, some * sizeof(T));
            forEachIndex(some, [&](std::size_t i) { list[first + i] = items[i]; });
        }
    }

private:
    /// Such memory takes long to get: 4 ms for 16 MiB. Less would make many submissions.
    static constexpr std::size_t kMostBytes = std::size_t(24) << 20;
    template<typename T> static constexpr std::size_t itemsAtOnce() { return kMostBytes / sizeof(T); }

    /// The memory that both sides see, for lists of a size.
    std::byte* mapped(std::size_t bytes, gpu::MemoryUse use)
    {
        bytes = std::min(bytes, kMostBytes);
        if (use != use_ || staging_.size() < bytes) {
            staging_ = {};
            staging_ = {device_, bytes,
                        use == gpu::MemoryUse::Upload ? VK_BUFFER_USAGE_TRANSFER_SRC_BIT
                                                      : VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                        use};
            use_ = use;
        }
        return staging_.mapped();
    }
    void copy(const gpu::BytesOf& from, const gpu::BytesOf& to, VkDeviceSize bytes)
    {
        device_.execute([&](VkCommandBuffer commands) {
            gpu::copyBytes(device_, commands, from, to, bytes);
            gpu::fullBarrier(device_, commands);
        });
    }

    gpu::Device& device_;
    gpu::Buffer staging_;
    gpu::MemoryUse use_ = gpu::MemoryUse::Upload;
};

} // namespace halflight
