#pragma once
// --group NAME=WEIGHT and --sky of commands that show or write a state of a bake.

#include "console.h"

#include "halflight/render/compose.h"

#include <vector>

namespace halflight::cli {

/// Adds the option; each use appends to `weights`.
CLI::Option* addGroups(CLI::App& app, std::vector<GroupWeight>& weights, const std::string& description);

/// Adds --sky, --sky-zenith, --sky-horizon and --sky-ground: the weights of the sky's parts.
void addSky(CLI::App& app, std::vector<GroupWeight>& weights);

} // namespace halflight::cli
