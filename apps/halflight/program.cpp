#include "program.h"

#include "bake_device.h"

#include "console.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/system.h"
#include "halflight/scene/compression.h"
#include "terminal.h"
#if HALFLIGHT_GPU
#include "view_command.h"
#endif

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

namespace halflight::cli {

namespace {

int reportParseError(const CLI::App& app, const std::vector<Command>& commands, const CLI::ParseError& error,
                     const std::vector<std::string>& arguments)
{
    if (error.get_exit_code() == 0) return app.exit(error); // --help, --version
    const CLI::App* named = nullptr;
    for (const Command& command : commands) {
        if (command.app->parsed()) named = command.app;
    }
    std::string name = named != nullptr ? named->get_name() : "";
    while (named != nullptr && !named->get_subcommands().empty()) {
        named = named->get_subcommands().front(); // the one that was given
        name += " " + named->get_name();
    }
    std::string sentence = error.what();
    if (named == nullptr && !arguments.empty() && !arguments[0].starts_with('-')) {
        std::string names;
        for (const Command& command : commands) names += (names.empty() ? "" : ", ") + command.app->get_name();
        sentence = "there is no command '" + arguments[0] + "'; there are " + names;
#if !HALFLIGHT_GPU
        if (arguments[0] == "render" || arguments[0] == "view" || arguments[0] == "farm")
            return wrongUsage(arguments[0],
                              "this program bakes and has no renderer, window or farm; Halflight's other packages have "
                              "them (Install in its README)");
#endif
    }
    if (const std::string option = unknownOption(named); !option.empty()) {
        sentence = "there is no option '" + option + "'";
    }
    const std::string hint = usageHint(app, named, arguments);
    if (!hint.empty()) sentence += "; " + hint;
    return wrongUsage(name, sentence);
}

// The first argument of the command that was named: the file, or the farm's folder.
std::filesystem::path fileOf(const std::vector<Command>& commands)
{
    for (const Command& command : commands) {
        const CLI::App* named = command.app->parsed() ? command.app : nullptr;
        while (named != nullptr && !named->get_subcommands().empty()) named = named->get_subcommands().front();
        if (named == nullptr) continue;
        for (const CLI::Option* option : named->get_options()) {
            if (option->get_positional() && option->count() > 0) return option->results().front();
        }
    }
    return {};
}

// `halflight help COMMAND` is `halflight COMMAND --help`; no arguments are --help.
std::vector<std::string> withHelpWords(std::vector<std::string> arguments)
{
    if (arguments.empty()) return {"--help"};
    if (arguments[0] != "help") return arguments;
    arguments.erase(arguments.begin());
    arguments.emplace_back("--help");
    return arguments;
}

std::string versionText()
{
    std::string version = std::string("halflight ") + HALFLIGHT_VERSION;
    const std::vector<std::string> compression = readableCompression();
    for (const std::string& name : compression) version += (&name == &compression[0] ? "\nreads " : ", ") + name;
#if HALFLIGHT_GPU
    version += windowProgram().empty() ? "\nno window: there is no halflight-view beside this program"
                                       : "\nwindow by SDL2 and Dear ImGui";
#else
    version += "\nno renderer, window or farm";
#endif
    const Result<std::string> identity = embreeIntegrators().identity(InstructionSet::Automatic);
    version += "\n" + (identity ? "bakes as " + *identity : identity.error().message);
    return version + "\n" + bakeDeviceText();
}

std::vector<Command> addCommands(CLI::App& app, [[maybe_unused]] const std::vector<std::string>& arguments,
                                 [[maybe_unused]] OpenWindow openWindow)
{
#if !HALFLIGHT_GPU
    return {addBakeCommand(app), addInfoCommand(app), addOptimizeCommand(app), addComposeCommand(app)};
#else
    const auto view = [&arguments, openWindow](const ViewCommandOptions& options) {
        if (openWindow != nullptr) return openWindow(options);
        return startWindowProgram(options,
                                  {std::find(arguments.begin(), arguments.end(), "view") + 1, arguments.end()});
    };
    return {addBakeCommand(app), addFarmCommand(app),     addRenderCommand(app), addViewCommand(app, view),
            addInfoCommand(app), addOptimizeCommand(app), addComposeCommand(app)};
#endif
}

int runCommand(const std::vector<std::string>& arguments, OpenWindow openWindow)
{
    CLI::App app("Halflight: mixed lighting for any engine. glTF in, baked glTF out, baked and realtime shadows mixed.",
                 "halflight");
    app.allow_windows_style_options(false); // /a/b.glb is a file
    app.set_version_flag("-V,--version", versionText);
    bool describes = false; // asked for below, before a command is required
    app.add_flag("--describe", describes, "Print all commands and options as JSON and exit");
    app.require_subcommand(1);
    const std::vector<Command> commands = addCommands(app, arguments, openWindow);
    app.footer("halflight COMMAND --help, or halflight help COMMAND, tells more. Exit codes: 0 done, 1 failed, 2 wrong "
               "usage.");
    if (arguments == std::vector<std::string>{"--describe"}) {
        printJson(describeCommandLine(app, HALFLIGHT_VERSION));
        return kOk;
    }
    const auto isCommand = [&](const std::string& word) {
        return std::any_of(commands.begin(), commands.end(),
                           [&](const Command& command) { return command.app->get_name() == word; });
    };
    try {
        const bool helps = !arguments.empty() && arguments.back() == "--help";
        if (helps && !arguments[0].starts_with('-') && !isCommand(arguments[0])) {
            throw CLI::ExtrasError({arguments[0]});
        }
        // CLI11 takes the arguments from the back of the list.
        app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
        for (const Command& command : commands) {
            if (!command.app->parsed()) continue;
            if (const std::string sentence = emptyValue(*command.app); !sentence.empty())
                return wrongUsage(command.app->get_name(), sentence);
            return command.run();
        }
        return kWrongUsage;
    } catch (const CLI::ParseError& error) {
        return reportParseError(app, commands, error, arguments);
    } catch (const std::bad_alloc&) {
        return fail(fileOf(commands), Error{ErrorCode::Unsupported, "out of memory"});
    } catch (const std::exception&) {
        // What a library says of itself helps nobody who reads it here; a debugger shows where it comes from.
        return fail(fileOf(commands), Error{ErrorCode::Unsupported, "internal error, please report it with this file"});
    }
}

} // namespace

int runProgram(int argc, char** argv, OpenWindow openWindow)
{
    prepareStandardStreams();
    std::vector<std::string> arguments(argv + 1, argv + argc);
    if (openWindow != nullptr) arguments.insert(arguments.begin(), "view");
    const int code = runCommand(withHelpWords(std::move(arguments)), openWindow);
    if (Status status = finishResults(); !status && code == kOk) return fail({}, status.error());
    return code;
}

} // namespace halflight::cli
