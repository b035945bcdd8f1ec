#pragma once
// Memory that Embree's device holds.

#include "bake_cpu/trace/embree.h"

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace halflight::embree {

/// Counts the bytes of one device.
class DeviceBytes {
public:
    /// The object outlives the device.
    void watch(RTCDevice device) { rtcSetDeviceMemoryMonitorFunction(device, count, this); }
    /// Most bytes so far.
    [[nodiscard]] std::size_t most() const { return std::size_t(most_.load()); }

private:
    static bool count(void* counter, ssize_t bytes, bool /*post*/)
    {
        auto& self = *static_cast<DeviceBytes*>(counter);
        const int64_t now = self.now_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
        int64_t most = self.most_.load(std::memory_order_relaxed);
        while (now > most && !self.most_.compare_exchange_weak(most, now, std::memory_order_relaxed)) {
        }
        return true;
    }

    std::atomic<int64_t> now_{0};
    std::atomic<int64_t> most_{0};
};

} // namespace halflight::embree
