#pragma once

#include "console.h"

#include "halflight/scene/scene.h"

#include <optional>

namespace halflight::cli {

/// "--emission-unit nits|blender", of commands that read a scene.
inline void addEmissionUnit(CLI::App& app, std::optional<EmissionUnit>& unit)
{
    addChoice<std::optional<EmissionUnit>>(
        app, "--emission-unit", unit, {{"nits", EmissionUnit::Nits}, {"blender", EmissionUnit::Blender}},
        "what emission in the file counts: cd/m2, or watts as Blender's exporter writes it, 683 times as bright "
        "(default nits, or what the file says)");
}

} // namespace halflight::cli
