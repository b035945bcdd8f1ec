// halflight: bake mixed lighting into a glTF file, render it, look into it.

#include "console.h"

#include <spdlog/fmt/fmt.h>

#include <cstdio>
#include <exception>
#include <new>

using namespace halflight;
using namespace halflight::cli;

namespace {

int reportParseError(const CLI::App& app, const std::vector<Command>& commands, const CLI::ParseError& error,
                     const std::string& firstArgument)
{
    if (error.get_exit_code() == 0) return app.exit(error); // --help, --version
    std::string name;
    for (const Command& command : commands) {
        if (command.app->parsed()) name = command.app->get_name();
    }
    if (name.empty() && !firstArgument.empty() && firstArgument.front() != '-') {
        return wrongUsage(name, "there is no command '" + firstArgument + "'; there are bake, render and info");
    }
    return wrongUsage(name, error.what());
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Halflight: mixed lighting for any engine. glTF in, baked glTF out, baked and realtime shadows mixed.",
                 "halflight");
    app.set_version_flag("--version", std::string("halflight ") + HALFLIGHT_VERSION);
    app.require_subcommand(1);
    const std::vector<Command> commands = {addBakeCommand(app), addRenderCommand(app), addInfoCommand(app)};
    app.footer("halflight COMMAND --help tells more. Exit codes: 0 done, 1 failed, 2 wrong usage.");

    try {
        app.parse(argc, argv);
        for (const Command& command : commands) {
            if (command.app->parsed()) return command.run();
        }
        return kWrongUsage;
    } catch (const CLI::ParseError& error) {
        return reportParseError(app, commands, error, argc > 1 ? argv[1] : "");
    } catch (const std::bad_alloc&) {
        return fail({}, Error{ErrorCode::Unsupported, "out of memory"});
    } catch (const std::exception& error) {
        return fail({}, Error{ErrorCode::Unsupported, error.what()});
    }
}
