#pragma once
// Values of settings: each function sets a value, or returns what it should have been ("a number from 0 to 1").

#include "scene/document/document.h"

#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

namespace halflight {

using Expectation = const char*;

constexpr double kHuge = 3.0e38;
constexpr Expectation kNotNegative = "a number >= 0";
constexpr float kLargestLightMeters = 1.0e5f; ///< of an area light's sizes

Expectation readBool(const Json& value, std::optional<bool>& out);
Expectation readNumber(const Json& value, double low, double high, Expectation expectation, std::optional<float>& out);
/// Width and height, or one number for both, in metres.
Expectation readSize(const Json& value, std::optional<vec2>& out);
/// Three numbers, or one for all.
Expectation readColor(const Json& value, std::optional<vec3>& out);
/// The name of a light group.
Expectation readGroup(const Json& value, std::optional<std::string>& out);
/// [[x, y, z], …], or one flat list, since some tools (Blender) know no lists of lists.
Expectation readPoints(const Json& value, std::optional<std::vector<glm::dvec3>>& out);
/// The same of up to kMostDirections directions of any length, which become unit vectors.
Expectation readDirections(const Json& value, std::optional<std::vector<vec3>>& out);

/// The inverse of nameOf() in scene.h.
std::optional<LightType> lightTypeNamed(std::string_view name);
std::optional<LightMode> lightModeNamed(std::string_view name);
std::optional<MixedLightingMode> mixedLightingModeNamed(std::string_view name);
std::optional<EmissionUnit> emissionUnitNamed(std::string_view name);

template<typename T> bool readVec3(const Json& value, glm::vec<3, T>& out)
{
    if (!value.is_array() || value.size() != 3) return false;
    for (int c = 0; c < 3; ++c) {
        if (!value[std::size_t(c)].is_number()) return false;
        out[c] = T(value[std::size_t(c)].get<double>());
        if (!std::isfinite(float(out[c]))) return false;
    }
    return true;
}

} // namespace halflight
