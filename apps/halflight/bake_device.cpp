#include "bake_device.h"

#include "console.h"
#include "program.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/parallel.h"
#if HALFLIGHT_GPU
#include "halflight/bake_gpu/gpu_integrator.h"
#endif

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <utility>

namespace halflight::cli {
namespace {

constexpr std::string_view kNamed = "gpu:";

/// What is wrong with a value of --device, as a sentence; empty when nothing is.
std::string wrongBakeDevice(const std::string& device)
{
    if (device == "auto" || device == "cpu" || device == "gpu") return {};
    if (device.starts_with(kNamed) && device.size() > kNamed.size()) return {};
    return "is auto, cpu, gpu, or gpu: and part of a device's name";
}

#if HALFLIGHT_GPU
/// Devices stay open as long as the program, and are never closed: a farm's worker bakes more than one scene, and
/// drivers are torn down before the program's own objects.
auto& openDevices()
{
    static auto& devices = *new std::map<std::pair<std::string, int>, std::shared_ptr<BakeDevice>>;
    return devices;
}

Result<std::shared_ptr<BakeDevice>> opened(const std::string& name, int memoryMegabytes)
{
    std::shared_ptr<BakeDevice>& device = openDevices()[{name, memoryMegabytes}];
    if (device == nullptr) {
        auto made = openBakeDevice({.name = name, .mostBytes = uint64_t(memoryMegabytes) << 20});
        if (!made) return made.error();
        device = std::move(*made);
    }
    return device;
}

/// Whether a GPU saves more than it costs to open it, to upload the scene and to copy results: so many samples of the
/// lightmap for each thread of the processor, or so many whole paths (docs/lab/gpu.md, "Where a GPU pays").
bool isWorthAGpu(const Scene& scene, const BakeSettings& settings)
{
    constexpr double kSamplesOfAThread = 2.0e6;
    constexpr double kPathsOfAThread = 0.1e6;
    const ThreadLimit limit(settings.threads);
    const double ofAThread = settings.integrator == IntegratorKind::Path ? kPathsOfAThread : kSamplesOfAThread;
    return expectedSamples(scene, settings) > ofAThread * double(threadCount());
}

#endif

} // namespace

void addDeviceOptions(CLI::App& app, const char* name, DeviceChoice& choice)
{
    app.add_option(name, choice.device,
                   "what traces the bake's rays: cpu, gpu, or gpu:NAME by part of its name (default auto: a GPU where "
                   "it is expected to be quicker). A GPU gathers the lightmap's light and denoises it, and the "
                   "processor does the rest; light differs within its noise")
        ->type_name("auto|cpu|gpu[:NAME]")
        ->check(CLI::Validator([](const std::string& device) { return wrongBakeDevice(device); }, ""));
    addInt(app, "--device-memory", choice.memoryMegabytes, 0, 1 << 20,
           "the most of the GPU's memory that the bake takes, MiB; what does not fit is the processor's (default 0: no "
           "limit)");
}

Result<IntegratorFactory> integratorsOn(const DeviceChoice& choice, [[maybe_unused]] const Scene& scene,
                                        [[maybe_unused]] const BakeSettings& settings)
{
    const bool isAsked = choice.device.starts_with("gpu");
#if HALFLIGHT_GPU
    if (!isAsked && (choice.device == "cpu" || !isWorthAGpu(scene, settings))) return embreeIntegrators();
    const bool isNamed = choice.device.starts_with(kNamed);
    auto made = opened(isNamed ? choice.device.substr(kNamed.size()) : std::string(), choice.memoryMegabytes);
    if (made) return gpuIntegrators(*made);
    if (isAsked) return made.error();
#else
    if (isAsked)
        return Error{ErrorCode::Unsupported, "this program was built without Vulkan: it bakes with --device cpu"};
#endif
    return embreeIntegrators();
}

int leavingWith(int code)
{
#if HALFLIGHT_GPU
    for (const auto& [key, device] : openDevices()) {
        if (device == nullptr || !makesPipelines(*device)) continue;
        std::fflush(nullptr);
        std::_Exit(code);
    }
#endif
    return code;
}

std::string bakeDeviceText()
{
#if HALFLIGHT_GPU
    const Result<std::vector<DeviceDescription>> devices = bakeDevices();
    if (!devices) return "bakes on the processor alone: " + devices.error().message;
    std::string text = "bakes on the processor";
    for (const DeviceDescription& device : *devices)
        text += device.refusal.empty() ? "\nbakes on " + device.name
                                       : "\ndoes not bake on " + device.name + ": it " + device.refusal;
    return text;
#else
    return "bakes on the processor alone";
#endif
}

} // namespace halflight::cli
