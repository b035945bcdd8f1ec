#include "scene/read/looks/light_shapes.h"

#include "scene/model/pose.h"
#include "scene/settings/setting_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace halflight {

Status readNumber(const Json& object, const char* key, float low, float high, const std::string& path, float& out)
{
    const Json& value = member(object, key);
    if (value.is_null()) return {};
    const float number = value.is_number() ? value.get<float>() : NAN;
    if (!std::isfinite(number) || number < low || number > high) {
        return invalid(path, std::string(key) + " is not a number in its range");
    }
    out = number;
    return {};
}

namespace {

constexpr float kMax = std::numeric_limits<float>::max();

// The light that a node refers to by an extension's list; none where it has no such extension.
Result<std::optional<FileLight>> referredLight(const SourceDocument& document, const NodeState& state,
                                               const char* extension)
{
    const Json& node = document.json["nodes"][std::size_t(state.node)];
    const Json& reference = extensionOf(node, extension);
    if (reference.is_null()) return std::optional<FileLight>();
    const Json& index = member(reference, "light");
    const Json& lights = member(extensionOf(document.json, extension), "lights");
    if (!index.is_number_unsigned() || !lights.is_array() || index.get<uint64_t>() >= lights.size())
        return invalid(pathOf("nodes", std::size_t(state.node)), "refers to a light that does not exist");
    FileLight found;
    found.index = index.get<int>();
    found.json = &lights[index.get<std::size_t>()];
    found.path = "/extensions/" + std::string(extension) + "/lights/" + std::to_string(found.index);
    if (std::string name = stringOf(*found.json, "name"); !name.empty()) found.light.name = std::move(name);

    const Json& color = member(*found.json, "color");
    if (!color.is_null()) {
        bool good = color.is_array() && color.size() == 3;
        for (std::size_t c = 0; good && c < 3; ++c) {
            good = color[c].is_number() && std::isfinite(color[c].get<float>()) && color[c].get<float>() >= 0.0f;
            if (good) found.light.color[int(c)] = color[c].get<float>();
        }
        if (!good) return invalid(found.path, "color is not three numbers >= 0");
    }
    return std::optional<FileLight>(std::move(found));
}

Status readSpot(const Json& json, const std::string& path, Light& light, std::vector<std::string>& warnings)
{
    const Json& spot = member(json, "spot");
    if (Status s = readNumber(spot, "innerConeAngle", 0.0f, kPi, path + "/spot", light.innerConeRadians); !s) return s;
    if (Status s = readNumber(spot, "outerConeAngle", 0.0f, kPi, path + "/spot", light.outerConeRadians); !s) return s;
    if (light.outerConeRadians > kPi / 2.0f) {
        light.outerConeRadians = kPi / 2.0f;
        warnings.push_back(path + ": outerConeAngle above 90 degrees is read as 90");
    }
    if (light.innerConeRadians >= light.outerConeRadians) {
        warnings.push_back(path + ": innerConeAngle is not below outerConeAngle; read as just below");
        light.innerConeRadians = 0.999f * light.outerConeRadians;
    }
    return {};
}

Status readPunctual(const FileLight& found, Light& light, std::vector<std::string>& warnings)
{
    const Json& json = *found.json;
    const Json& type = member(json, "type");
    if (type == "directional") {
        light.type = LightType::Directional;
    } else if (type == "point") {
        light.type = LightType::Point;
    } else if (type == "spot") {
        light.type = LightType::Spot;
    } else {
        return invalid(found.path, "type is not directional, point or spot");
    }
    if (Status s = readNumber(json, "intensity", 0.0f, kMax, found.path, light.intensity); !s) return s;
    if (light.type != LightType::Directional) {
        if (Status s = readNumber(json, "range", 0.0f, kMax, found.path, light.rangeMeters); !s) return s;
    }
    return light.type == LightType::Spot ? readSpot(json, found.path, light, warnings) : Status();
}

// Draft of EXT_lights_area (Bond 2025, KhronosGroup/glTF pull request 2525): sizes are multiplied by the largest
// component of the node's world scale.
Status readArea(const FileLight& found, Light& light)
{
    const Json& json = *found.json;
    const Json& type = member(json, "type");
    if (type != "rect" && type != "disk") return invalid(found.path, "type is not rect or disk");
    light.type = type == "rect" ? LightType::Rectangle : LightType::Disk;
    if (Status s = readNumber(json, "intensity", 0.0f, kMax, found.path, light.intensity); !s) return s;
    float size = 1.0f;
    float aspect = 1.0f;
    if (Status s = readNumber(json, "size", 0.0f, kLargestLightMeters, found.path, size); !s) return s;
    if (light.type == LightType::Rectangle) {
        const std::string path = found.path + "/rect";
        if (Status s = readNumber(member(json, "rect"), "aspect", 0.0f, kLargestLightMeters, path, aspect); !s)
            return s;
    }
    light.sizeMeters = areaLightSize(json, light.sourceScale);
    return {};
}

float largestScale(const glm::dmat4& worldFromNode)
{
    double scale = 0.0;
    for (int axis = 0; axis < 3; ++axis) scale = std::max(scale, glm::length(glm::dvec3(worldFromNode[axis])));
    return float(scale);
}

bool hasSize(const Light& light)
{
    const float least = std::min(light.sizeMeters.x, light.sizeMeters.y);
    return least > 0.0f && std::max(light.sizeMeters.x, light.sizeMeters.y) <= kLargestLightMeters;
}

} // namespace

vec2 areaLightSize(const Json& light, float sourceScale)
{
    // In double precision, so that the writer's quotients give back the same floats.
    const Json& aspect = member(member(light, "rect"), "aspect");
    const bool hasAspect = member(light, "type") == "rect" && aspect.is_number();
    const double height = light.value("size", 1.0) * double(sourceScale);
    return {float(height * (hasAspect ? aspect.get<double>() : 1.0)), float(height)};
}

Result<std::optional<FileLight>> lightOfNode(const SourceDocument& document, const NodeState& state,
                                             std::vector<std::string>& warnings)
{
    const std::string nodePath = pathOf("nodes", std::size_t(state.node));
    auto found = referredLight(document, state, "KHR_lights_punctual");
    auto area = referredLight(document, state, "EXT_lights_area");
    if (!found || !area) return found ? area.error() : found.error();
    const std::optional<LightType>& asked = state.settings.areaLight;
    if (*found && asked)
        return invalid(nodePath, "area_light is set on a node with a light of KHR_lights_punctual; give the area light "
                                 "a node of its own");
    if (*found && *area) warnings.push_back(nodePath + ": has two lights; the one of EXT_lights_area is left out");
    const bool isArea = !*found && (*area || asked);
    if (!*found && !isArea) return std::optional<FileLight>();
    if (isArea) *found = *area ? **area : FileLight();

    Light& light = (*found)->light;
    light.sourceNode = state.node;
    light.worldFromLight = rigidPose(mat4(state.worldFromNode));
    if (light.name.empty()) light.name = state.name;
    if (!isArea) {
        if (Status s = readPunctual(**found, light, warnings); !s) return s.error();
        return found;
    }
    light.sourceScale = largestScale(state.worldFromNode);
    light.intensity = 1000.0f; // the extension's default
    light.type = asked.value_or(LightType::Rectangle);
    if (*area) {
        if (Status s = readArea(**found, light); !s) return s.error();
        if (asked && *asked != light.type)
            warnings.push_back(nodePath + ": area_light is left out, as EXT_lights_area says what the light is");
    }
    if (!(light.sourceScale > 0.0f) || !hasSize(light)) {
        warnings.push_back(nodePath + ": light " + light.name + " is left out, as its size is not above 0 m and at " +
                           "most 100 km");
        return std::optional<FileLight>();
    }
    return found;
}

} // namespace halflight
