#include "group_option.h"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <optional>

namespace halflight::cli {
namespace {

/// "lamps=0.2" or "lamps=1,0.5,0"; nothing for other texts.
std::optional<GroupWeight> parseWeight(const std::string& text)
{
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0) return std::nullopt;
    std::vector<float> numbers;
    for (std::size_t begin = equals + 1; begin <= text.size() && numbers.size() < 4;) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        double number = 0.0;
        if (!parseNumber(text.substr(begin, end - begin), number) || !(number >= 0.0 && number <= 1.0e12))
            return std::nullopt;
        numbers.push_back(float(number));
        begin = end + 1;
    }
    if (numbers.size() != 1 && numbers.size() != 3) return std::nullopt;
    const vec3 weight = numbers.size() == 1 ? vec3(numbers[0]) : vec3(numbers[0], numbers[1], numbers[2]);
    return GroupWeight{text.substr(0, equals), weight};
}

} // namespace

CLI::Option* addGroups(CLI::App& app, std::vector<GroupWeight>& weights, const std::string& description)
{
    const auto check = [](std::string& text) {
        if (parseWeight(text)) return std::string();
        return fmt::format("must be a light group and one number of 0 or more, or three, such as lamps=0.5 or "
                           "lamps=1,0.5,0, not '{}'",
                           text);
    };
    return app
        .add_option_function<std::vector<std::string>>(
            "--group",
            [&weights](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) weights.push_back(*parseWeight(text));
            },
            description)
        ->check(CLI::Validator(check, std::string()))
        ->type_size(1)
        ->allow_extra_args(false)
        ->type_name("NAME=WEIGHT");
}

void addSky(CLI::App& app, std::vector<GroupWeight>& weights)
{
    struct Part {
        const char* option;
        const char* group;
        const char* description;
    };
    constexpr std::array<Part, 4> kParts = {{
        {"--sky", "sky", "radiance of a sky that changes, cd/m2, or what its picture is multiplied by"},
        {"--sky-zenith", "sky.zenith", "the same of a gradient's zenith alone"},
        {"--sky-horizon", "sky.horizon", "the same of its horizon"},
        {"--sky-ground", "sky.ground", "the same of its ground"},
    }};
    for (const Part& part : kParts) {
        const auto weightOf = [part](const std::string& text) {
            return parseWeight(std::string(part.group) + "=" + text);
        };
        const auto check = [weightOf](std::string& text) {
            return weightOf(text) ? std::string()
                                  : fmt::format("must be one number of 0 or more, or three, not '{}'", text);
        };
        app.add_option_function<std::string>(
               part.option, [&weights, weightOf](const std::string& text) { weights.push_back(*weightOf(text)); },
               part.description)
            ->check(CLI::Validator(check, std::string()))
            ->type_name("R,G,B");
    }
}

} // namespace halflight::cli
