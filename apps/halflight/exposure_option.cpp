#include "exposure_option.h"

#include "console.h"

#include <spdlog/fmt/fmt.h>

namespace halflight::cli {

void addExposure(CLI::App& app, std::optional<float>& ev, bool& given, const std::string& help)
{
    const auto check = [](std::string& text) {
        double value = 0.0;
        if (text == "auto" || (parseNumber(text, value) && value >= -40.0 && value <= 40.0)) return std::string();
        return fmt::format("must be auto or a number from -40 to 40, not '{}'", text);
    };
    app.add_option_function<std::string>(
           "--exposure",
           [&ev, &given](const std::string& text) {
               double value = 0.0;
               ev = parseNumber(text, value) ? std::optional(float(value)) : std::nullopt;
               given = true;
           },
           help)
        ->check(CLI::Validator(check, std::string()))
        ->type_name("EV|auto");
}

} // namespace halflight::cli
