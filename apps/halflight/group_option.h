#pragma once
// --group NAME=WEIGHT of commands that show or write a state of a bake.

#include "console.h"

#include "halflight/render/compose.h"

#include <vector>

namespace halflight::cli {

/// Adds the option; each use appends to `weights`.
CLI::Option* addGroups(CLI::App& app, std::vector<GroupWeight>& weights, const std::string& description);

} // namespace halflight::cli
