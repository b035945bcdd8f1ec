#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace halflight::cli {

/// "--exposure EV|auto"; `ev` stays empty for auto, `given` tells whether the option was there.
void addExposure(CLI::App& app, std::optional<float>& ev, bool& given, const std::string& help);

} // namespace halflight::cli
