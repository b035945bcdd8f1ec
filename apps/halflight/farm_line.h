#pragma once
// What the parts of `halflight farm` share.

#include "bake_options.h"
#include "console.h"

#include <string>
#include <vector>

namespace halflight::cli {

/// A `halflight bake` command line that a plan holds, parsed.
struct BakeLine {
    CLI::App program{"", "halflight"};
    BakeOptions options;
    CLI::App* app = nullptr;

    explicit BakeLine(const std::vector<std::string>& arguments)
    {
        program.allow_windows_style_options(false);
        app = &addBakeApp(program, options);
        program.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
        // All machines of a farm have a processor.
        if (options.device.device == "auto") options.device.device = "cpu";
    }
};

/// The scene of a command line, with its options applied.
inline Result<Scene> sceneOf(BakeLine& line)
{
    Result<Scene> scene = readBakeScene(line.options);
    if (scene) applyOptions(line.options, *scene);
    return scene;
}

/// What keeps words from being the options of a planned bake, as a sentence; empty when nothing does. Options that name
/// files are none: the plan names them.
std::string wrongPlanOptions(const std::vector<std::string>& words);

Command addFarmPlan(CLI::App& parent);

} // namespace halflight::cli
