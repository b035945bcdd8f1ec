#pragma once
// --device of bakes: what traces rays.

#include "halflight/bake/integrator.h"

#include <string>

namespace halflight::cli {

/// What is wrong with a value of --device, as a sentence; empty when nothing is.
std::string wrongBakeDevice(const std::string& device);

/// The integrators of a value of --device: "auto", "cpu", "gpu", or "gpu:" and part of a device's name. An error where
/// the GPU that is asked for cannot be had.
Result<IntegratorFactory> integratorsOn(const std::string& device);

/// "bakes on NVIDIA H200, NVIDIA 580.159.04 with --device gpu", or why no GPU bakes here.
std::string bakeDeviceText();

} // namespace halflight::cli
