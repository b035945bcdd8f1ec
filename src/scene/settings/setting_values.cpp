#include "scene/settings/setting_values.h"

#include "halflight/scene/light_groups.h"
#include "halflight/scene/turning_lights.h"

namespace halflight {

Expectation readBool(const Json& value, std::optional<bool>& out)
{
    if (value.is_boolean()) {
        out = value.get<bool>();
    } else if (value.is_number() && (value.get<double>() == 0.0 || value.get<double>() == 1.0)) {
        out = value.get<double>() == 1.0; // Blender writes its boolean properties as integers
    } else {
        return "true, false, 0 or 1";
    }
    return nullptr;
}

Expectation readNumber(const Json& value, double low, double high, Expectation expectation, std::optional<float>& out)
{
    if (!value.is_number()) return expectation;
    const double number = value.get<double>();
    if (!std::isfinite(float(number)) || number < low || number > high) return expectation;
    out = float(number);
    return nullptr;
}

Expectation readSize(const Json& value, std::optional<vec2>& out)
{
    constexpr Expectation kExpectation = "a size in metres, or [width, height], above 0 and at most 100000";
    const bool two = value.is_array() && value.size() == 2;
    vec2 size(0.0f);
    for (int i = 0; i < 2; ++i) {
        const Json& number = two ? value[std::size_t(i)] : value;
        if (!number.is_number()) return kExpectation;
        size[i] = number.get<float>();
        if (!(size[i] > 0.0f && size[i] <= kLargestLightMeters)) return kExpectation;
    }
    out = size;
    return nullptr;
}

Expectation readColor(const Json& value, std::optional<vec3>& out)
{
    vec3 color(0.0f);
    if (value.is_number()) {
        color = vec3(float(value.get<double>()));
    } else if (!readVec3(value, color)) {
        return "three numbers >= 0, or one";
    }
    if (!std::isfinite(color.x) || glm::any(glm::lessThan(color, vec3(0.0f)))) return "three numbers >= 0, or one";
    out = color;
    return nullptr;
}

Expectation readPoints(const Json& value, std::optional<std::vector<glm::dvec3>>& out)
{
    constexpr Expectation kExpectation = "a list of [x, y, z]";
    if (!value.is_array()) return kExpectation;
    std::vector<glm::dvec3> points;
    if (!value.empty() && value[0].is_number()) {
        if (value.size() % 3 != 0) return kExpectation;
        for (std::size_t i = 0; i < value.size(); i += 3) {
            glm::dvec3 p;
            if (!readVec3(Json::array({value[i], value[i + 1], value[i + 2]}), p)) return kExpectation;
            points.push_back(p);
        }
    } else {
        for (const Json& item : value) {
            glm::dvec3 p;
            if (!readVec3(item, p)) return kExpectation;
            points.push_back(p);
        }
    }
    out = std::move(points);
    return nullptr;
}

Expectation readDirections(const Json& value, std::optional<std::vector<vec3>>& out)
{
    constexpr Expectation kExpectation =
        "a list of at most 12 directions [x, y, z], not zero, each a degree or more from the others";
    std::optional<std::vector<glm::dvec3>> points;
    if (readPoints(value, points) != nullptr || points->size() > kMostDirections) return kExpectation;
    std::vector<vec3> directions;
    for (const glm::dvec3& point : *points) {
        const double length = glm::length(point);
        if (!(length > 1.0e-6) || !std::isfinite(length)) return kExpectation;
        const vec3 direction(point / length);
        if (!directions.empty() && angleToNearest(directions, direction) < kLeastStepRadians) return kExpectation;
        directions.push_back(direction);
    }
    out = std::move(directions);
    return nullptr;
}

Expectation readGroup(const Json& value, std::optional<std::string>& out)
{
    const std::string name = value.is_string() ? value.get<std::string>() : std::string();
    if (!isGroupName(name)) return kGroupNames;
    out = name;
    return nullptr;
}

std::optional<LightType> lightTypeNamed(std::string_view name)
{
    for (const LightType type :
         {LightType::Directional, LightType::Point, LightType::Spot, LightType::Rectangle, LightType::Disk}) {
        if (name == nameOf(type)) return type;
    }
    return std::nullopt;
}
std::optional<LightMode> lightModeNamed(std::string_view name)
{
    for (const LightMode mode : {LightMode::Realtime, LightMode::Mixed, LightMode::Baked}) {
        if (name == nameOf(mode)) return mode;
    }
    return std::nullopt;
}
std::optional<MixedLightingMode> mixedLightingModeNamed(std::string_view name)
{
    for (const auto mode :
         {MixedLightingMode::BakedIndirect, MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive}) {
        if (name == nameOf(mode)) return mode;
    }
    return std::nullopt;
}
std::optional<EmissionUnit> emissionUnitNamed(std::string_view name)
{
    for (const EmissionUnit unit : {EmissionUnit::Nits, EmissionUnit::Blender}) {
        if (name == nameOf(unit)) return unit;
    }
    return std::nullopt;
}

} // namespace halflight
