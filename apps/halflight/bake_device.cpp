#include "bake_device.h"

#include "halflight/bake_cpu/embree_integrator.h"
#if HALFLIGHT_GPU
#include "halflight/bake_gpu/gpu_integrator.h"
#endif

#include <map>
#include <memory>

namespace halflight::cli {
namespace {

constexpr std::string_view kNamed = "gpu:";

#if HALFLIGHT_GPU
/// Devices stay open as long as the program, and are never closed: a farm's worker bakes more than one scene, and
/// drivers are torn down before the program's own objects.
Result<std::shared_ptr<BakeDevice>> opened(const std::string& name)
{
    static auto& devices = *new std::map<std::string, std::shared_ptr<BakeDevice>>;
    std::shared_ptr<BakeDevice>& device = devices[name];
    if (device == nullptr) {
        auto made = openBakeDevice({.name = name});
        if (!made) return made.error();
        device = std::move(*made);
    }
    return device;
}
#endif

} // namespace

std::string wrongBakeDevice(const std::string& device)
{
    if (device == "auto" || device == "cpu" || device == "gpu") return {};
    if (device.starts_with(kNamed) && device.size() > kNamed.size()) return {};
    return "is auto, cpu, gpu, or gpu: and part of a device's name";
}

Result<IntegratorFactory> integratorsOn(const std::string& device)
{
    if (!device.starts_with("gpu")) return embreeIntegrators();
#if HALFLIGHT_GPU
    auto made = opened(device == "gpu" ? std::string() : device.substr(kNamed.size()));
    if (!made) return made.error();
    return gpuIntegrators(*made);
#else
    return Error{ErrorCode::Unsupported, "this program was built without Vulkan: it bakes with --device cpu"};
#endif
}

std::string bakeDeviceText()
{
#if HALFLIGHT_GPU
    auto device = opened({});
    if (!device) return "bakes on the processor alone: " + device.error().message;
    return "bakes on " + describe(**device) + " with --device gpu";
#else
    return "bakes on the processor alone";
#endif
}

} // namespace halflight::cli
