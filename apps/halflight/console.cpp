#include "console.h"

#include "interrupt.h"
#include "terminal.h"

#include "halflight/base/file.h"
#include "halflight/base/system.h"
#include "halflight/scene/mask_values.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

namespace halflight::cli {

namespace {

void printError(const std::string& text)
{
    // Messages may quote a file's own names: nothing in them may break the line or steer the terminal.
    say(fmt::format("halflight: {}\n", printable(text)));
}

std::string shortNumber(double value)
{
    return fmt::format("{:g}", value);
}

// CLI11 shows a validator's answer after the option's name: "--cascades: must be ...".
CLI::Option* addChecked(CLI::App& app, const std::string& name, std::function<std::string(const std::string&)> check,
                        std::function<void(const std::string&)> assign, const std::string& metavar,
                        const std::string& help)
{
    return app.add_option_function<std::string>(name, assign, help)
        ->check(CLI::Validator([check](std::string& text) { return check(text); }, std::string()))
        ->type_name(metavar)
        // So that a script can put a user's options after its own.
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

std::string checkWholeNumber(const std::string& text, double min, double max)
{
    double value = 0.0;
    if (parseNumber(text, value) && value >= min && value <= max && value == std::floor(value)) return {};
    return fmt::format("must be a whole number from {:.0f} to {:.0f}, not '{}'", min, max, text);
}

std::vector<std::string> splitAtCommas(const std::string& text)
{
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == ',') {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

} // namespace

int fail(const std::filesystem::path& file, const Error& error)
{
    if (error.code == ErrorCode::Cancelled) {
        printError("interrupted");
    } else {
        printError(file.empty() ? error.text() : file.string() + ": " + error.text());
    }
    return kFailed;
}

int wrongUsage(std::string_view command, std::string_view sentence)
{
    printError(fmt::format("{} (see halflight {}{}--help)", sentence, command, command.empty() ? "" : " "));
    return kWrongUsage;
}

void warn(const std::filesystem::path& file, std::string_view sentence)
{
    printError(fmt::format("warning: {}: {}", file.string(), sentence));
}

Status checkOutput(const std::filesystem::path& output)
{
    const Result<std::filesystem::path> file = replacedFile(output);
    if (!file) return file.error();
    return tryWriting(file->parent_path());
}

std::string lowerExtension(const std::filesystem::path& path)
{
    std::string extension = path.extension().string();
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

std::string grouped(uint64_t number)
{
    std::string digits = std::to_string(number);
    for (std::ptrdiff_t i = std::ptrdiff_t(digits.size()) - 3; i > 0; i -= 3) digits.insert(std::size_t(i), " ");
    return digits;
}

std::string clockTime(double seconds)
{
    const auto whole = uint64_t(std::max(0.0, std::round(seconds)));
    if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::string withUnit(double number)
{
    if (number >= 1e9) return fmt::format("{:.2f} G", number / 1e9);
    if (number >= 1e6) return fmt::format("{:.1f} M", number / 1e6);
    if (number >= 1e3) return fmt::format("{:.1f} k", number / 1e3);
    return fmt::format("{:.0f}", number);
}

std::string megabytes(uint64_t bytes)
{
    return fmt::format("{:.0f} MB", double(bytes) / 1e6);
}

std::string channelName(int channel, bool colored)
{
    if (channel < 0) return "-";
    const int layer = channel / kLayerChannels;
    const std::string letters = colored ? "RGB" : std::string(1, "RGBA"[channel % kLayerChannels]);
    return letters + (layer > 0 ? std::to_string(layer + 1) : "");
}

bool parseNumber(const std::string& text, double& value)
{
    // strtod() takes more: spaces before the number, hexadecimal, "infinity".
    if (text.empty() || text.find_first_not_of("0123456789+-.eE") != std::string::npos) return false;
    char* end = nullptr;
    value = std::strtod(text.c_str(), &end);
    return end == text.c_str() + text.size() && std::isfinite(value);
}

CLI::Option* addInt(CLI::App& app, const std::string& name, int& value, int min, int max, const std::string& help)
{
    return addChecked(
        app, name, [min, max](const std::string& text) { return checkWholeNumber(text, min, max); },
        [&value](const std::string& text) { value = int(std::strtod(text.c_str(), nullptr)); },
        fmt::format("{}..{}", min, max), help);
}

CLI::Option* addUint(CLI::App& app, const std::string& name, uint32_t& value, const std::string& help)
{
    return addChecked(
        app, name, [](const std::string& text) { return checkWholeNumber(text, 0.0, 4294967295.0); },
        [&value](const std::string& text) { value = uint32_t(std::strtod(text.c_str(), nullptr)); }, "N", help);
}

CLI::Option* addFloat(CLI::App& app, const std::string& name, float& value, float min, float max,
                      const std::string& metavar, const std::string& help)
{
    // Compared as float, so that a limit such as 0.01 may itself be given.
    const auto check = [min, max](const std::string& text) {
        double number = 0.0;
        if (parseNumber(text, number) && float(number) >= min && float(number) <= max) return std::string();
        return fmt::format("must be a number from {} to {}, not '{}'", shortNumber(min), shortNumber(max), text);
    };
    return addChecked(
        app, name, check, [&value](const std::string& text) { value = float(std::strtod(text.c_str(), nullptr)); },
        metavar, help);
}

CLI::Option* addPercent(CLI::App& app, const std::string& name, float& value, float min, float max,
                        const std::string& help)
{
    const auto parse = [](std::string text, double& number) {
        if (text.ends_with('%')) text.pop_back();
        return parseNumber(text, number);
    };
    const auto check = [=](const std::string& text) {
        double number = 0.0;
        if (parse(text, number) && float(number) >= min && float(number) <= max) return std::string();
        return fmt::format("must be a percentage from {} to {}, such as 2%, not '{}'", shortNumber(min),
                           shortNumber(max), text);
    };
    return addChecked(
        app, name, check,
        [&value, parse](const std::string& text) {
            double number = 0.0;
            if (parse(text, number)) value = float(number) * 0.01f;
        },
        "PERCENT", help);
}

CLI::Option* addSeconds(CLI::App& app, const std::string& name, double& value, double min, double max,
                        const std::string& help)
{
    const auto parse = [](std::string text, double& seconds) {
        const char unit = text.empty() ? ' ' : text.back();
        const double factor = unit == 'h' ? 3600.0 : unit == 'm' ? 60.0 : 1.0;
        if (unit == 'h' || unit == 'm' || unit == 's') text.pop_back();
        const bool isNumber = parseNumber(text, seconds);
        seconds *= factor;
        return isNumber;
    };
    const auto check = [=](const std::string& text) {
        double seconds = 0.0;
        if (parse(text, seconds) && seconds >= min && seconds <= max) return std::string();
        return fmt::format("must be a time from {:g} seconds to {:g} hours, such as 30s, 5m or 1.5h, not '{}'", min,
                           max / 3600.0, text);
    };
    return addChecked(
        app, name, check, [&value, parse](const std::string& text) { parse(text, value); }, "TIME", help);
}

namespace {

template<typename T> CLI::Option* addThree(CLI::App& app, const std::string& name, glm::vec<3, T>& value, T min, T max,
                                           const std::string& metavar, const std::string& help)
{
    const auto parse = [min, max](const std::string& text, glm::vec<3, T>& out) {
        const std::vector<std::string> parts = splitAtCommas(text);
        if (parts.size() != 3) return false;
        for (int i = 0; i < 3; ++i) {
            double number = 0.0;
            if (!parseNumber(parts[std::size_t(i)], number) || number < double(min) || number > double(max))
                return false;
            out[i] = T(number);
        }
        return true;
    };
    const auto check = [parse, min, max](const std::string& text) {
        glm::vec<3, T> ignored;
        if (parse(text, ignored)) return std::string();
        return fmt::format("must be three numbers from {} to {} with commas between them, not '{}'", shortNumber(min),
                           shortNumber(max), text);
    };
    return addChecked(
        app, name, check, [parse, &value](const std::string& text) { parse(text, value); }, metavar, help);
}

} // namespace

CLI::Option* addVec3(CLI::App& app, const std::string& name, vec3& value, float min, float max,
                     const std::string& metavar, const std::string& help)
{
    return addThree(app, name, value, min, max, metavar, help);
}

CLI::Option* addPosition(CLI::App& app, const std::string& name, dvec3& value, const std::string& help)
{
    constexpr double kFarthestMeters = 1.0e8; // the reader takes no scene that reaches so far
    return addThree(app, name, value, -kFarthestMeters, kFarthestMeters, "X,Y,Z", help);
}

CLI::Option* addChoiceByIndex(CLI::App& app, const std::string& name, const std::vector<std::string>& names,
                              std::function<void(std::size_t)> choose, const std::string& help)
{
    const auto find = [names](const std::string& text) {
        return std::size_t(std::find(names.begin(), names.end(), text) - names.begin());
    };
    const auto check = [names, find](const std::string& text) {
        if (find(text) < names.size()) return std::string();
        return fmt::format("must be one of {}, not '{}'", fmt::join(names, ", "), text);
    };
    return addChecked(
        app, name, check, [find, choose](const std::string& text) { choose(find(text)); },
        fmt::format("{}", fmt::join(names, "|")), help);
}

// -- progress ---------------------------------------------------------------------------------------------------------

ProgressDisplay::ProgressDisplay(ProgressStyle style)
    : style_(style), terminal_(isErrorStreamTerminal()), stageStart_(Clock::now()), lastShown_(stageStart_)
{}

ProgressDisplay::~ProgressDisplay()
{
    finish();
}

Progress ProgressDisplay::progress()
{
    Progress progress;
    progress.cancel = &listenForInterrupts();
    if (style_ != ProgressStyle::Quiet)
        progress.report = [this](std::string_view stage, double fraction) { report(stage, fraction); };
    return progress;
}

void ProgressDisplay::finish()
{
    if (!stage_.empty()) endStage();
}

void ProgressDisplay::report(std::string_view stage, double fraction)
{
    using std::chrono::duration;
    const Clock::time_point now = Clock::now();
    const bool lines = style_ == ProgressStyle::Lines;
    const bool live = lines || terminal_;
    if (stage != stage_) {
        finish();
        stage_ = stage;
        stageStart_ = now;
        most_ = 0.0;
        lastShown_ = live ? Clock::time_point() : now;
        if (!live) say(fmt::format("{:<14}", stage_));
    }
    // Ten pictures or lines a second. In a log each stage is one line, which grows every ten seconds.
    if (duration<double>(now - lastShown_).count() < (live ? 0.1 : 10.0)) return;
    lastShown_ = now;
    most_ = fraction = std::clamp(fraction, most_, 1.0); // a stage of several passes begins anew
    const int percent = int(100.0 * fraction);
    if (!live) {
        say(fmt::format(" {} %", percent));
        return;
    }
    if (lines) {
        say(fmt::format("progress: {} {} %\n", stage_, percent));
        return;
    }
    const double elapsed = duration<double>(now - stageStart_).count();
    const bool known = fraction > 0.01 && elapsed > 0.5;
    const std::string left = known ? clockTime(elapsed * (1.0 - fraction) / fraction) + " left" : "";
    constexpr int kWidth = 30;
    const int full = int(kWidth * fraction);
    say(fmt::format("\r{:<14.14} [{:=<{}}{:<{}}] {:>3} %  {}\x1b[K", stage_, "", full, "", kWidth - full, percent,
                    left));
}

void ProgressDisplay::endStage()
{
    const double seconds = std::chrono::duration<double>(Clock::now() - stageStart_).count();
    if (style_ == ProgressStyle::Lines) {
        say(fmt::format("progress: {} 100 %\n", stage_));
    } else if (terminal_) {
        say(fmt::format("\r{:<14} {:.1f} s\x1b[K\n", stage_, seconds));
    } else {
        say(fmt::format(" {:.1f} s\n", seconds));
    }
    stage_.clear();
}

} // namespace halflight::cli
