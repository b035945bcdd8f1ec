#include "scene/read_lights.h"

#include "halflight/base/text.h"
#include "scene/origin.h"
#include "scene/pose.h"

#include <cmath>
#include <limits>

namespace halflight {

namespace {

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

// The light's values at the bake; unknown unless all of them are there.
void readAtBake(const Json& json, LightAtBake& out)
{
    constexpr float kMax = std::numeric_limits<float>::max();
    LightAtBake read;
    bool good = json.is_object();
    const auto number = [&](const Json& value, float high, float& target) {
        good = good && value.is_number() && value.get<float>() >= 0.0f && value.get<float>() <= high;
        if (good) target = value.get<float>();
    };
    const Json& color = member(json, "colorIntensity");
    good = good && color.is_array() && color.size() == 3;
    for (std::size_t c = 0; good && c < 3; ++c) number(color[c], kMax, read.colorIntensity[int(c)]);
    number(member(json, "indirectMultiplier"), kMax, read.indirectMultiplier);
    number(member(json, "range"), kMax, read.rangeMeters);
    number(member(json, "innerConeAngle"), kPi, read.innerConeRadians);
    number(member(json, "shadowStrength"), 1.0f, read.shadowStrength);
    const Json& cast = member(json, "castShadows");
    good = good && cast.is_boolean();
    if (!good) return;
    const auto recorded = [&](const char* key, float high) {
        const Json& value = member(json, key);
        const bool inRange = value.is_number() && value.get<float>() >= 0.0f && value.get<float>() <= high;
        return inRange ? value.get<float>() : -1.0f;
    };
    read.radiusMeters = recorded("radius", kMax);
    read.angularRadiusRadians = recorded("angularRadius", kPi);
    read.castShadows = cast.get<bool>();
    read.known = true;
    out = read;
}

// A name of an enumeration by its inverse of nameOf(); absent: unchanged.
template<typename Enum, typename Named>
Status readName(const Json& object, const char* key, const Named& named, const std::string& path, Enum& out)
{
    const Json& value = member(object, key);
    if (value.is_null()) return {};
    const auto known = named(value.get<std::string>());
    if (!known) return invalid(path + "/" + key, "is no " + std::string(key) + " that this program knows");
    out = *known;
    return {};
}

// What an earlier bake wrote down about the light (HALFLIGHT_light): its settings and the bake's output. checkTypes()
// has seen the types.
Status readRecord(const Json& record, const std::string& path, const glm::dvec3& origin, Light& light)
{
    if (!record.is_object()) return {};
    constexpr float kMax = std::numeric_limits<float>::max();
    if (Status s = readName(record, "mode", lightModeNamed, path, light.mode); !s) return s;
    if (Status s = readNumber(record, "shadowStrength", 0.0f, 1.0f, path, light.shadowStrength); !s) return s;
    if (Status s = readNumber(record, "indirectMultiplier", 0.0f, kMax, path, light.indirectMultiplier); !s) return s;
    if (Status s = readNumber(record, "radius", 0.0f, kMax, path, light.radiusMeters); !s) return s;
    if (Status s = readNumber(record, "angularRadius", 0.0f, kPi, path, light.angularRadiusRadians); !s) return s;
    const Json& cast = member(record, "castShadows");
    if (cast.is_boolean()) light.castShadows = cast.get<bool>();

    const Json& bias = member(record, "shadowBias");
    const auto biasNumber = [&](const char* key, float high, std::optional<float>& out) {
        const Json& value = member(bias, key);
        if (value.is_number() && value.get<float>() >= 0.0f && value.get<float>() <= high) out = value.get<float>();
    };
    biasNumber("depth", kMaxShadowBias, light.shadowBias.depthTexels);
    biasNumber("slope", kMaxShadowBias, light.shadowBias.slope);
    biasNumber("normal", kMaxNormalBiasTexels, light.shadowBias.normalTexels);

    const Json& baking = member(record, "baking");
    if (!baking.is_object()) return {};
    BakingOutput& output = light.baking;
    output.isBaked = true;
    if (Status s = readName(baking, "bakeType", lightModeNamed, path + "/baking", output.bakeType); !s) return s;
    if (Status s = readName(baking, "mixedLightingMode", mixedLightingModeNamed, path + "/baking", output.mixedMode);
        !s) {
        return s;
    }
    const Json& channel = member(baking, "occlusionMaskChannel");
    if (channel.is_number_integer()) {
        if (channel.get<int64_t>() < -1 || channel.get<int64_t>() > 3 || channel > 3)
            return invalid(path + "/baking/occlusionMaskChannel", "is not -1 to 3");
        output.occlusionMaskChannel = channel.get<int>();
    }
    const Json& reason = member(baking, "reason");
    if (reason.is_string()) output.reason = reason.get<std::string>();
    if (glm::dmat4 pose(1.0); readMatrix(member(baking, "worldFromLight"), pose))
        output.worldFromLight = localFromWorld(pose, origin);
    // Lights without a range have no reach unless the bake gave them one; other lights without a record are of files
    // of earlier versions, and are taken to be as they were.
    light.baking.reachMeters = light.type == LightType::Directional ? 0.0f : light.rangeMeters;
    light.baking.outerConeRadians = light.outerConeRadians;
    const auto baked = [&](const char* key, float high, float& out) {
        const Json& value = member(baking, key);
        if (value.is_number() && value.get<float>() > 0.0f && value.get<float>() <= high) out = value.get<float>();
    };
    baked("reach", std::numeric_limits<float>::max(), light.baking.reachMeters);
    baked("outerConeAngle", kPi, light.baking.outerConeRadians);
    readAtBake(member(baking, "atBake"), light.baking.atBake);
    return {};
}

// What of a baked light an animation of its members leaves behind.
void warnAnimatedLight(const Light& light, const std::set<std::string>& members, const std::string& path,
                       std::vector<std::string>& warnings)
{
    if (light.mode == LightMode::Realtime) return;
    const std::string what = path + ": light " + light.name + " is " + nameOf(light.mode) +
                             ", but an animation changes its " +
                             listOf(std::vector<std::string>(members.begin(), members.end())) + ": ";
    if (light.mode == LightMode::Baked) {
        warnings.push_back(what + "all of its light stays as baked; halflight_mode = \"realtime\" makes it change");
        return;
    }
    const bool shape = members.count("range") != 0 || members.count("spot/outerConeAngle") != 0;
    if (!shape && light.indirectMultiplier == 0.0f) return; // the seeds' remedy: nothing of it is baked but shadows
    warnings.push_back(what + (shape
                                   ? "its baked shadows and bounced light stay; halflight_mode = \"realtime\" is right"
                                   : "its bounced light stays as baked; halflight_indirect_multiplier = 0 leaves it "
                                     "out of the bake"));
}

} // namespace

Result<std::optional<Light>> readLight(const SourceDocument& document, const NodeState& state, const glm::dvec3& origin,
                                       const AnimatedThings& animated, FileSettings& file,
                                       std::vector<std::string>& warnings)
{
    const Json& node = document.json["nodes"][std::size_t(state.node)];
    const std::string nodePath = pathOf("nodes", std::size_t(state.node));
    const Json& reference = extensionOf(node, "KHR_lights_punctual");
    if (reference.is_null()) return std::optional<Light>();
    const Json& index = member(reference, "light");
    const Json& lights = member(extensionOf(document.json, "KHR_lights_punctual"), "lights");
    if (!index.is_number_unsigned() || !lights.is_array() || index.get<uint64_t>() >= lights.size()) {
        return invalid(nodePath, "refers to a light that does not exist");
    }
    const Json& json = lights[index.get<std::size_t>()];
    const std::string path = "/extensions/KHR_lights_punctual/lights/" + std::to_string(index.get<uint64_t>());

    Light light;
    const Json& name = member(json, "name");
    light.name = name.is_string() && !name.get<std::string>().empty() ? name.get<std::string>() : state.name;
    light.sourceNode = state.node;
    light.worldFromLight = rigidPose(mat4(state.worldFromNode));
    const Json& type = member(json, "type");
    if (type == "directional") {
        light.type = LightType::Directional;
    } else if (type == "point") {
        light.type = LightType::Point;
    } else if (type == "spot") {
        light.type = LightType::Spot;
    } else {
        return invalid(path, "type is not directional, point or spot");
    }
    const Json& color = member(json, "color");
    if (!color.is_null()) {
        bool good = color.is_array() && color.size() == 3;
        for (std::size_t c = 0; good && c < 3; ++c) {
            good = color[c].is_number() && std::isfinite(color[c].get<float>()) && color[c].get<float>() >= 0.0f;
            if (good) light.color[int(c)] = color[c].get<float>();
        }
        if (!good) return invalid(path, "color is not three numbers >= 0");
    }
    constexpr float kMax = std::numeric_limits<float>::max();
    if (Status s = readNumber(json, "intensity", 0.0f, kMax, path, light.intensity); !s) return s.error();
    if (light.type != LightType::Directional) {
        if (Status s = readNumber(json, "range", 0.0f, kMax, path, light.rangeMeters); !s) return s.error();
    }
    if (light.type == LightType::Spot) {
        const Json& spot = member(json, "spot");
        if (Status s = readNumber(spot, "innerConeAngle", 0.0f, kPi, path + "/spot", light.innerConeRadians); !s)
            return s.error();
        if (Status s = readNumber(spot, "outerConeAngle", 0.0f, kPi, path + "/spot", light.outerConeRadians); !s)
            return s.error();
        if (light.outerConeRadians > kPi / 2.0f) {
            light.outerConeRadians = kPi / 2.0f;
            warnings.push_back(path + ": outerConeAngle above 90 degrees is read as 90");
        }
        if (light.innerConeRadians >= light.outerConeRadians) {
            warnings.push_back(path + ": innerConeAngle is not below outerConeAngle; read as just below");
            light.innerConeRadians = 0.999f * light.outerConeRadians;
        }
    }

    // A moving light cannot be baked; whoever knows better says so with halflight_mode.
    if (state.animated) light.mode = LightMode::Realtime;
    for (const auto& [object, owner, where] :
         {std::tuple{&json, ExtrasOwner::Light, path}, {&node, ExtrasOwner::Node, nodePath}}) {
        const Json& extras = member(*object, "extras");
        auto settings = lightSettingsOf(extras, where);
        if (!settings) return settings.error();
        if (extensionOf(node, "HALFLIGHT_light").is_object()) {
            // The bake put these into the light itself, and there they may be changed since.
            settings->intensity.reset();
            settings->rangeMeters.reset();
            settings->color.reset();
        }
        if (owner == ExtrasOwner::Light) warnUnknownExtras(extras, owner, where, warnings);
        applySettings(*settings, light);
    }
    const std::string recordPath = nodePath + "/extensions/HALFLIGHT_light";
    if (Status s = readRecord(extensionOf(node, "HALFLIGHT_light"), recordPath, origin, light); !s) return s.error();
    for (auto& rule : file.lights) {
        if (!matchesPattern(rule.pattern, light.name) && !matchesPattern(rule.pattern, state.name)) continue;
        rule.matched = true;
        applySettings(rule.settings, light);
    }
    if (state.animated && light.mode != LightMode::Realtime) {
        warnings.push_back(nodePath + ": light " + light.name + " is animated, but " + nameOf(light.mode) +
                           " by its settings");
    }
    if (const auto it = animated.lights.find(index.get<int>()); it != animated.lights.end())
        warnAnimatedLight(light, it->second, nodePath, warnings);
    return std::optional<Light>(std::move(light));
}

std::optional<Camera> readCamera(const SourceDocument& document, const NodeState& state,
                                 std::vector<std::string>& warnings)
{
    const Json& json = element(document.json, "cameras", document.model.nodes[std::size_t(state.node)].camera);
    if (json.is_null()) return std::nullopt;
    Camera camera;
    const Json& name = member(json, "name");
    camera.name = name.is_string() && !name.get<std::string>().empty() ? name.get<std::string>() : state.name;
    camera.worldFromCamera = rigidPose(mat4(state.worldFromNode));
    const bool perspective = member(json, "type") != "orthographic";
    const Json& lens = member(json, perspective ? "perspective" : "orthographic");
    const auto number = [&](const char* key, float absent) {
        const Json& value = member(lens, key);
        return value.is_number() ? value.get<float>() : value.is_null() ? absent : NAN;
    };
    const auto positive = [](float value) { return value > 0.0f && std::isfinite(value); };
    camera.orthographic = !perspective;
    camera.nearMeters = number("znear", NAN);
    camera.farMeters = number("zfar", perspective ? std::max(camera.farMeters, 10.0f * camera.nearMeters) : NAN);
    const char* wrong = nullptr;
    if (perspective) {
        camera.verticalFovRadians = number("yfov", NAN);
        if (!(camera.verticalFovRadians > 1.0e-3f && camera.verticalFovRadians < 0.999f * kPi))
            wrong = "yfov is not an angle between 0 and 180 degrees";
        if (!positive(camera.nearMeters)) wrong = "znear is not above 0";
    } else {
        camera.orthographicHeightMeters = 2.0f * std::abs(number("ymag", NAN));
        if (!positive(camera.orthographicHeightMeters)) wrong = "ymag is 0 or no number";
        if (!(camera.nearMeters >= 0.0f)) wrong = "znear is below 0 or no number";
    }
    if (wrong == nullptr && !(std::isfinite(camera.farMeters) && camera.farMeters > camera.nearMeters))
        wrong = "zfar is not beyond znear";
    if (wrong != nullptr) {
        warnings.push_back(pathOf("cameras", std::size_t(document.model.nodes[std::size_t(state.node)].camera)) +
                           ": camera " + camera.name + " is left out: " + wrong);
        return std::nullopt;
    }
    return camera;
}

} // namespace halflight
