#pragma once
// What traces a bake's rays: --device and --device-memory.

#include "halflight/bake/bake.h"

#include <CLI/CLI.hpp>

#include <string>

namespace halflight::cli {

struct DeviceChoice {
    std::string device = "auto"; ///< "auto", "cpu", "gpu", or "gpu:" and part of a device's name
    int memoryMegabytes = 0;     ///< the most of a GPU's memory that may be taken, MiB; 0 = no limit
};

/// Adds `name` (--device, where that is not the device that draws) and --device-memory.
void addDeviceOptions(CLI::App& app, const char* name, DeviceChoice& choice);

/// The integrators that a user chose. "auto" takes a GPU that is expected to make the bake quicker; where none can be
/// had, the processor. Else an error where the GPU that is asked for cannot be had.
Result<IntegratorFactory> integratorsOn(const DeviceChoice& choice, const Scene& scene, const BakeSettings& settings);

/// Of each device here a line that says whether it bakes, and else why it does not.
std::string bakeDeviceText();

} // namespace halflight::cli
