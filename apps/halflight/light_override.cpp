#include "light_override.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace halflight::cli {
namespace {

constexpr const char* kForm = "must be NAME:intensity=X,color=R,G,B,direction=X,Y,Z,position=X,Y,Z,range=X,strength=X,"
                              "inner-cone=DEGREES,outer-cone=DEGREES,depth-bias=X,slope-bias=X,normal-bias=X (any of "
                              "these)";

Error malformed(const std::string& text, std::string_view why)
{
    return {ErrorCode::InvalidArgument, fmt::format("{}, not '{}': {}", kForm, text, why), ""};
}

/// Numbers with commas between them.
std::vector<double> numbersOf(const std::string& text)
{
    std::vector<double> numbers;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        double number = 0.0;
        if (!parseNumber(text.substr(begin, end - begin), number)) return {};
        numbers.push_back(number);
        begin = end + 1;
    }
    return numbers;
}

bool assign(std::optional<float>& target, const std::vector<double>& numbers, double max)
{
    if (numbers.size() != 1 || !(numbers[0] >= 0.0 && numbers[0] <= max)) return false;
    target = float(numbers[0]);
    return true;
}

template<typename T> bool assign(std::optional<glm::vec<3, T>>& target, const std::vector<double>& numbers)
{
    if (numbers.size() != 3) return false;
    target = glm::vec<3, T>(numbers[0], numbers[1], numbers[2]);
    return true;
}

bool assignKey(LightOverride& change, const std::string& key, const std::vector<double>& numbers)
{
    constexpr double kMax = 1.0e12;
    if (key == "intensity") return assign(change.intensity, numbers, kMax);
    if (key == "range") return assign(change.rangeMeters, numbers, kMax);
    if (key == "strength") return assign(change.shadowStrength, numbers, 1.0);
    if (key == "inner-cone" || key == "outer-cone") {
        std::optional<float>& radians = key == "inner-cone" ? change.innerConeRadians : change.outerConeRadians;
        if (!assign(radians, numbers, 90.0)) return false;
        *radians = glm::radians(*radians);
        return true;
    }
    if (key == "depth-bias") return assign(change.shadowBias.depthTexels, numbers, double(kMaxShadowBias));
    if (key == "slope-bias") return assign(change.shadowBias.slope, numbers, double(kMaxShadowBias));
    if (key == "normal-bias") return assign(change.shadowBias.normalTexels, numbers, double(kMaxNormalBiasTexels));
    if (key == "position") return assign(change.position, numbers);
    if (key == "color") return assign(change.color, numbers) && glm::all(glm::greaterThanEqual(*change.color, vec3(0)));
    if (key == "direction") return assign(change.direction, numbers) && glm::length(*change.direction) > 1.0e-6f;
    return false;
}

/// A rigid pose whose -Z is `direction`.
mat4 posed(vec3 position, vec3 direction)
{
    const vec3 z = -glm::normalize(direction);
    const vec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0), z));
    return mat4(vec4(x, 0), vec4(glm::cross(z, x), 0), vec4(z, 0), vec4(position, 1));
}

} // namespace

Result<LightOverride> parseLightOverride(const std::string& text)
{
    // Names may hold colons, values cannot.
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0) return malformed(text, "no name");
    LightOverride change;
    change.name = text.substr(0, colon);
    const std::string rest = text.substr(colon + 1);
    for (std::size_t begin = 0; begin < rest.size();) {
        const std::size_t equals = rest.find('=', begin);
        if (equals == std::string::npos) return malformed(text, "a value without a name");
        // A value ends at the comma before the next name.
        const std::size_t next = rest.find('=', equals + 1);
        const std::size_t end = next == std::string::npos ? rest.size() : rest.rfind(',', next);
        const std::string key = rest.substr(begin, equals - begin);
        if (end <= equals || !assignKey(change, key, numbersOf(rest.substr(equals + 1, end - equals - 1))))
            return malformed(text, fmt::format("'{}' is unknown, or its value is out of bounds", key));
        begin = end + 1;
    }
    if (rest.empty()) return malformed(text, "nothing to change");
    return change;
}

void addLights(CLI::App& app, std::vector<LightOverride>& lights, const std::string& description)
{
    const auto check = [](std::string& text) {
        const Result<LightOverride> change = parseLightOverride(text);
        return change ? std::string() : change.error().message;
    };
    app.add_option_function<std::vector<std::string>>(
           "--light",
           [&lights](const std::vector<std::string>& texts) {
               for (const std::string& text : texts) lights.push_back(*parseLightOverride(text));
           },
           description)
        ->check(CLI::Validator(check, std::string()))
        ->type_size(1)
        ->allow_extra_args(false)
        ->type_name("NAME:KEY=VALUE,…");
}

Light overridden(Light light, const LightOverride& change, const dvec3& originMeters)
{
    light.intensity = change.intensity.value_or(light.intensity);
    light.color = change.color.value_or(light.color);
    light.rangeMeters = change.rangeMeters.value_or(light.rangeMeters);
    light.shadowStrength = change.shadowStrength.value_or(light.shadowStrength);
    light.innerConeRadians = change.innerConeRadians.value_or(light.innerConeRadians);
    light.outerConeRadians = change.outerConeRadians.value_or(light.outerConeRadians);
    const auto assign = [](const std::optional<float>& from, std::optional<float>& to) {
        if (from) to = from;
    };
    assign(change.shadowBias.depthTexels, light.shadowBias.depthTexels);
    assign(change.shadowBias.slope, light.shadowBias.slope);
    assign(change.shadowBias.normalTexels, light.shadowBias.normalTexels);
    if (change.direction) light.worldFromLight = posed(light.position(), *change.direction);
    if (change.position) light.worldFromLight[3] = vec4(vec3(*change.position - originMeters), 1.0f);
    return light;
}

Result<std::vector<std::pair<int, Light>>> changedLights(const Scene& scene, const std::vector<LightOverride>& changes)
{
    std::map<int, Light> changed;
    for (const LightOverride& change : changes) {
        bool found = false;
        for (std::size_t i = 0; i < scene.lights.size(); ++i) {
            if (scene.lights[i].name != change.name) continue;
            found = true;
            Light& light = changed.try_emplace(int(i), scene.lights[i]).first->second;
            light = overridden(light, change, scene.originMeters);
        }
        if (found) continue;
        std::string names;
        for (const Light& light : scene.lights) names += (names.empty() ? "" : ", ") + light.name;
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("no light is named '{}'; there are: {}", change.name, names.empty() ? "none" : names),
                     ""};
    }
    return std::vector<std::pair<int, Light>>(changed.begin(), changed.end());
}

} // namespace halflight::cli
