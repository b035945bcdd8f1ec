// halflight view: its options, and the program that has the window.

#include "terminal.h"
#include "view_command.h"

#include "halflight/base/system.h"

#include <memory>
#include <utility>

namespace halflight::cli {

std::filesystem::path windowProgram()
{
    const std::filesystem::path here = programPath();
    const std::filesystem::path program = here.parent_path() / ("halflight-view" + here.extension().string());
    std::error_code error;
    return !here.empty() && std::filesystem::is_regular_file(program, error) ? program : std::filesystem::path();
}

#ifdef _WIN32
constexpr const char* kNoWindow = "there is no window on Windows yet; halflight render draws pictures without one";
#else
constexpr const char* kNoWindow =
    "the window is in the package halflight-view, or in a build from source with SDL2 and "
    "Dear ImGui (libsdl2-dev, libimgui-dev); halflight render draws pictures without one";
#endif

int startWindowProgram(const ViewCommandOptions& options, const std::vector<std::string>& arguments)
{
    const std::filesystem::path program = windowProgram();
    const std::string reason =
        program.empty() ? std::string(kNoWindow) : fmt::format("{} cannot be started", program.string());
    if (program.empty()) return fail(options.render.file, Error{ErrorCode::Unsupported, reason});
    const int code = runInstead(program, arguments);
    return code >= 0 ? code : fail(options.render.file, Error{ErrorCode::Unsupported, reason});
}

Command addViewCommand(CLI::App& parent, std::function<int(const ViewCommandOptions&)> run)
{
    auto options = std::make_shared<ViewCommandOptions>();
    CLI::App& app = *parent.add_subcommand("view", "Open a window onto a baked or plain glTF file, and bake it there");
    if (windowProgram().empty()) app.group(""); // not in --help
    addViewOptions(app, options->render);
    app.option_defaults()->group("Bake");
    app.add_flag("--bake", options->bakeAtStart, "bake at once, and show the light as it comes");
    addChoice<Quality>(app, "--quality", options->bake.bake.quality,
                       choicesOf({Quality::Preview, Quality::Medium, Quality::High, Quality::Ultra}),
                       "of the bake (default medium)");
    addInt(app, "--lightmap-size", options->bake.bake.lightmapSize, 64, 8192,
           "texels along a side of a lightmap page (default: by the quality)");
    app.add_option("--cache", options->bake.bake.cacheDirectory,
                   "folder of finished tiles: later bakes compute only what a change reaches")
        ->type_name("DIR");
    addDeviceOptions(app, "--bake-device", options->bake.device);
    app.option_defaults()->group("Run");
    app.add_option("--screenshots", options->screenshots, "folder of screenshots (default: the current one)")
        ->type_name("DIR");
    addInt(app, "--frames", options->frames, 1, 1 << 30, "end after so many frames");
    app.add_option("--lose-device", options->loseDeviceAt, "for tests: fail after so many frames")
        ->delimiter(',')
        ->check(CLI::Validator(
            [](std::string& text) {
                const bool isWhole = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
                return isWhole ? std::string() : fmt::format("must be whole numbers, not '{}'", text);
            },
            std::string()))
        ->group("");
    app.footer("Example: halflight view scene.glb --bake --quality preview");
    return {&app, [options, run = std::move(run)] { return run(*options); }};
}

} // namespace halflight::cli
