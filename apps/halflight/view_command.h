#pragma once
// halflight view. The window is a program of its own, halflight-view, which halflight starts: the libraries of a
// desktop are needed by that one alone.

#include "bake_options.h"
#include "console.h"
#include "render_options.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace halflight::cli {

struct ViewCommandOptions {
    RenderOptions render;
    BakeOptions bake;
    bool bakeAtStart = false;
    std::filesystem::path screenshots = ".";
    int frames = 0;                ///< 0: until it is closed
    std::vector<int> loseDeviceAt; ///< frames, for tests
};

Command addViewCommand(CLI::App& parent, std::function<int(const ViewCommandOptions&)> run);

/// halflight-view beside this program; empty where there is none.
std::filesystem::path windowProgram();
/// Goes on as halflight-view, with the arguments of `view`.
int startWindowProgram(const ViewCommandOptions& options, const std::vector<std::string>& arguments);

} // namespace halflight::cli
