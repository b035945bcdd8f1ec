#pragma once
// What the subcommands share: exit codes, one-sentence errors, option types with limits, progress, Ctrl-C.

#include "halflight/base/math.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/scene.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace halflight::cli {

enum ExitCode : int { kOk = 0, kFailed = 1, kWrongUsage = 2 };

/// A subcommand: main() calls `run` when it was named and its options parsed.
struct Command {
    CLI::App* app = nullptr;
    std::function<int()> run;
};
Command addBakeCommand(CLI::App& parent);
Command addFarmCommand(CLI::App& parent);
Command addRenderCommand(CLI::App& parent);
Command addInfoCommand(CLI::App& parent);
Command addOptimizeCommand(CLI::App& parent);
Command addComposeCommand(CLI::App& parent);

/// All commands and options, with what --help says of them, as JSON.
std::string describeCommandLine(const CLI::App& program, std::string_view version);

/// The option that a command was given and does not have, as it was typed; empty when there is none.
std::string unknownOption(const CLI::App* command);
/// What is wrong with a command line in which an option or argument was given and is empty, as a sentence; else empty.
std::string emptyValue(const CLI::App& command);
/// What a command line that does not parse most likely meant: "did you mean --samples?", or that the output needs -o.
/// Empty when there is no good guess. `command` is the subcommand that was named, or null.
std::string usageHint(const CLI::App& program, const CLI::App* command, const std::vector<std::string>& arguments);
/// The word of `candidates` that `word` is a slip of: the nearest by edit distance, at most a third of its letters
/// away. Empty when none is that near.
std::string nearestWord(const std::string& word, const std::vector<std::string>& candidates);

/// Prints "halflight: FILE: object: reason" to standard error, on one line, and returns kFailed. A cancelled run prints
/// "halflight: interrupted".
int fail(const std::filesystem::path& file, const Error& error);
/// Prints "halflight: sentence (see halflight COMMAND --help)" and returns kWrongUsage.
int wrongUsage(std::string_view command, std::string_view sentence);
/// Prints "halflight: warning: FILE: sentence" to standard error.
void warn(const std::filesystem::path& file, std::string_view sentence);

/// Error when `output` cannot become a file: its folder is missing or closed, or something other than a file is there.
Status checkOutput(const std::filesystem::path& output);
/// The extension in lower case, with its dot.
std::string lowerExtension(const std::filesystem::path& path);

/// "12 345 678", "0:42" (minutes and seconds), "31.2 M", "412 MB": numbers for people.
std::string grouped(uint64_t number);
std::string clockTime(double seconds);
std::string withUnit(double number);
std::string megabytes(uint64_t bytes);

/// "R", "G", "B", "A", or "-" for none.
std::string channelName(int channel, bool colored = false);

/// Options whose value is checked while parsing; the message of a bad value names the option and its limits.
/// `metavar` is what --help shows for the value.
CLI::Option* addInt(CLI::App& app, const std::string& name, int& value, int min, int max, const std::string& help);
CLI::Option* addUint(CLI::App& app, const std::string& name, uint32_t& value, const std::string& help);
CLI::Option* addFloat(CLI::App& app, const std::string& name, float& value, float min, float max,
                      const std::string& metavar, const std::string& help);
/// "2%" or "2"; limits in percent, the value as a share.
CLI::Option* addPercent(CLI::App& app, const std::string& name, float& value, float min, float max,
                        const std::string& help);
/// "90", "90s", "1.5m" or "2h"; limits and value in seconds.
CLI::Option* addSeconds(CLI::App& app, const std::string& name, double& value, double min, double max,
                        const std::string& help);
/// "x,y,z".
CLI::Option* addVec3(CLI::App& app, const std::string& name, vec3& value, float min, float max,
                     const std::string& metavar, const std::string& help);
/// A place in the world, in double precision.
CLI::Option* addPosition(CLI::App& app, const std::string& name, dvec3& value, const std::string& help);

template<typename T> using Choices = std::vector<std::pair<std::string, T>>;
/// Values by their names: nameOf() of each.
template<typename T> Choices<T> choicesOf(std::initializer_list<T> values)
{
    Choices<T> choices;
    for (const T value : values) choices.emplace_back(nameOf(value), value);
    return choices;
}
CLI::Option* addChoiceByIndex(CLI::App& app, const std::string& name, const std::vector<std::string>& names,
                              std::function<void(std::size_t)> choose, const std::string& help);
/// One of a list of words.
template<typename T> CLI::Option* addChoice(CLI::App& app, const std::string& name, T& value, const Choices<T>& choices,
                                            const std::string& help)
{
    std::vector<std::string> names;
    for (const auto& choice : choices) names.push_back(choice.first);
    return addChoiceByIndex(
        app, name, names, [&value, choices](std::size_t i) { value = choices[i].second; }, help);
}

/// A finite decimal number, the whole of `text`; false when it is anything else.
bool parseNumber(const std::string& text, double& value);

/// How progress is written to standard error.
enum class ProgressStyle {
    Auto,  ///< a bar with percent and time left on a terminal, one line a stage elsewhere
    Lines, ///< "progress: STAGE PERCENT %" lines, for programs that show it themselves
    Quiet, ///< nothing; progress() still carries the cancel flag
};

/// --progress auto|lines.
CLI::Option* addProgress(CLI::App& app, ProgressStyle& style);

class ProgressDisplay {
public:
    explicit ProgressDisplay(ProgressStyle style);
    /// Ends the last stage's line.
    ~ProgressDisplay();
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;

    /// Valid while the display lives. The first call makes Ctrl-C set the cancel flag (interrupt.h).
    Progress progress();
    void finish();

private:
    using Clock = std::chrono::steady_clock;
    void report(std::string_view stage, double fraction);
    void endStage();

    ProgressStyle style_;
    bool terminal_;
    std::string stage_;
    double most_ = 0.0; // fraction of the stage, shown so far
    Clock::time_point stageStart_;
    Clock::time_point lastShown_;
};

} // namespace halflight::cli
