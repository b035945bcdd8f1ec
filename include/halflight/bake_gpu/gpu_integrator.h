#pragma once
// Bakes on a GPU with Vulkan's ray-tracing pipelines.

#include "halflight/bake/integrator.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace halflight {

class BakeDevice;

struct BakeDeviceOptions {
    std::string name;        ///< part of the device's or its driver's name; empty: the best GPU, never a CPU driver
    bool validation = false; ///< Khronos validation layer with synchronization validation
    uint64_t mostBytes = 0;  ///< of the device's own memory that may be taken; 0 = no limit
    /// For tests: asked, on any thread, before memory is taken and commands are submitted. True: as if the device had
    /// no memory left, or was lost.
    std::function<bool()> fails;
};

/// Opens a device. DeviceFailed says of each device why it does not serve. It lives as long as an integrator uses it.
Result<std::shared_ptr<BakeDevice>> openBakeDevice(const BakeDeviceOptions& options);
/// "NVIDIA H200, NVIDIA 580.82.07".
std::string describe(BakeDevice& device);
struct DeviceDescription {
    std::string name;    ///< with its driver: "NVIDIA H200, NVIDIA 580.82.07"
    std::string refusal; ///< why it bakes only where it is named, or not at all: "lacks …"; empty: it bakes
};
/// All Vulkan devices, the one of an empty name first. DeviceFailed where there is no Vulkan.
Result<std::vector<DeviceDescription>> bakeDevices();
/// Whether threads still make pipelines, which a driver may compile for ten seconds. They begin with a bake, and need
/// not have ended with one that ends early. A device waits for them when it goes.
bool makesPipelines(BakeDevice& device);
/// What the validation layer said so far.
std::vector<std::string> validationMessages(BakeDevice& device);

/// Integrators that trace large batches of rays on a device, and all else on the processor. Light is the processor's
/// within its noise; the same device and driver gives the same bytes.
IntegratorFactory gpuIntegrators(const std::shared_ptr<BakeDevice>& device);

} // namespace halflight
