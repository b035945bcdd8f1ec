#include "scene/read/looks/read_lights.h"

#include "halflight/base/text.h"
#include "halflight/scene/light_groups.h"
#include "halflight/scene/mask_values.h"
#include "halflight/scene/turning_lights.h"
#include "scene/model/origin.h"
#include "scene/model/pose.h"
#include "scene/read/looks/light_shapes.h"
#include "scene/settings/setting_values.h"

#include <cmath>
#include <limits>

namespace halflight {

namespace {

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
    if (const Json& size = member(json, "size"); size.is_array() && size.size() == 2) {
        for (int i = 0; i < 2; ++i) number(size[std::size_t(i)], kMax, read.sizeMeters[i]);
        if (!good) return;
    }
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

Status readUnitVectors(const Json& list, const std::string& path, std::vector<vec3>& out)
{
    constexpr float kTolerance = 1.0e-3f;
    out.clear();
    for (const Json& json : list) {
        vec3 direction(0.0f);
        const bool isUnit = readVec3(json, direction) && std::abs(glm::length(direction) - 1.0f) <= kTolerance;
        if (!isUnit || out.size() == kMostDirections) return invalid(path, "is no list of at most 12 unit vectors");
        out.push_back(direction);
    }
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
    if (std::string group = stringOf(record, "group"); isGroupName(group)) light.group = std::move(group);
    if (const Json& list = member(record, "directions"); list.is_array())
        if (Status s = readUnitVectors(list, path + "/directions", light.directions); !s) return s;
    const Json& cast = member(record, "castShadows");
    if (cast.is_boolean()) light.castShadows = cast.get<bool>();
    if (isAreaLight(light.type)) { // EXT_lights_area has no range
        if (Status s = readNumber(record, "range", 0.0f, kMax, path, light.rangeMeters); !s) return s;
    }

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
        constexpr int kLast = kMostMaskLayers * kLayerChannels - 1;
        if (channel.get<int64_t>() < -1 || channel.get<int64_t>() > kLast || channel > kLast)
            return invalid(path + "/baking/occlusionMaskChannel", "is not -1 to " + std::to_string(kLast));
        output.occlusionMaskChannel = channel.get<int>();
    }
    output.coloredMask = member(baking, "coloredMask") == true;
    output.reason = stringOf(baking, "reason");
    if (const Json& group = member(baking, "group"); group.is_number_unsigned()) {
        output.group = group.get<int>();
        readVec3(member(baking, "white"), output.white);
    }
    if (const Json& turns = member(baking, "turns"); turns.is_object()) {
        output.turning.group = turns.value("group", -1);
        const std::string place = path + "/baking/turns/directions";
        if (Status s = readUnitVectors(member(turns, "directions"), place, output.turning.directions); !s) return s;
        readVec3(member(baking, "white"), output.white);
    }
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

// Sizes that do not belong to the light's kind.
void warnWithoutEffect(const LightSettings& settings, const Light& light, const std::string& where,
                       std::vector<std::string>& warnings)
{
    if (settings.sizeMeters && !isAreaLight(light.type))
        warnings.push_back(where + ": light " + light.name + " is no area light, so its size has no effect");
    if (settings.radiusMeters && isAreaLight(light.type))
        warnings.push_back(where + ": light " + light.name + " is an area light, so its radius has no effect");
    if (settings.directions && !settings.directions->empty() && light.type != LightType::Directional)
        warnings.push_back(where + ": light " + light.name + " is no directional light, so its directions have no " +
                           "effect");
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
    const bool shape = members.count("range") != 0 || members.count("spot/outerConeAngle") != 0 ||
                       members.count("size") != 0 || members.count("rect/aspect") != 0;
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
    auto found = lightOfNode(document, state, warnings);
    if (!found) return found.error();
    if (!*found) return std::optional<Light>();
    Light& light = (*found)->light;
    const bool isBaked = extensionOf(node, "HALFLIGHT_light").is_object();

    // A moving light cannot be baked; whoever knows better says so with halflight_mode.
    if (state.animated) light.mode = LightMode::Realtime;
    for (const auto& [object, owner, where] :
         {std::tuple{(*found)->json, ExtrasOwner::Light, (*found)->path}, {&node, ExtrasOwner::Node, nodePath}}) {
        if (object == nullptr) continue;
        const Json& extras = member(*object, "extras");
        auto settings = lightSettingsOf(extras, where);
        if (!settings) return settings.error();
        if (owner == ExtrasOwner::Light) warnUnknownExtras(extras, owner, where, warnings);
        warnWithoutEffect(*settings, light, where, warnings);
        if (isBaked) {
            // The bake put these into the light itself, and there they may be changed since.
            settings->intensity.reset();
            settings->rangeMeters.reset();
            settings->color.reset();
            settings->sizeMeters.reset();
        }
        applySettings(*settings, light);
    }
    light.group = state.settings.group.value_or(light.group);
    const std::string recordPath = nodePath + "/extensions/HALFLIGHT_light";
    if (Status s = readRecord(extensionOf(node, "HALFLIGHT_light"), recordPath, origin, light); !s) return s.error();
    for (auto& rule : file.lights) {
        if (!matchesPattern(rule.pattern, light.name) && !matchesPattern(rule.pattern, state.name)) continue;
        rule.matched = true;
        warnWithoutEffect(rule.settings, light, "settings file", warnings);
        applySettings(rule.settings, light);
    }
    if (light.type != LightType::Directional) light.directions.clear();
    if (state.animated && light.mode != LightMode::Realtime && light.directions.empty()) {
        warnings.push_back(nodePath + ": light " + light.name + " is animated, but " + nameOf(light.mode) +
                           " by its settings");
    }
    const auto& animatedLights = isAreaLight(light.type) ? animated.areaLights : animated.lights;
    if (const auto it = animatedLights.find((*found)->index); it != animatedLights.end())
        warnAnimatedLight(light, it->second, nodePath, warnings);
    return std::optional<Light>(std::move(light));
}

std::optional<Camera> readCamera(const SourceDocument& document, const NodeState& state,
                                 std::vector<std::string>& warnings)
{
    const int index = integerOf(element(document.json, "nodes", state.node), "camera");
    const Json& json = element(document.json, "cameras", index);
    if (json.is_null()) return std::nullopt;
    Camera camera;
    camera.name = stringOf(json, "name");
    if (camera.name.empty()) camera.name = state.name;
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
    camera.farMeters = number("zfar", perspective ? kInfinity : NAN); // glTF 2.0, section 5.13.3: an infinite one
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
    if (wrong == nullptr && !(camera.farMeters > camera.nearMeters && (perspective || positive(camera.farMeters))))
        wrong = "zfar is not beyond znear";
    if (wrong != nullptr) {
        warnings.push_back(pathOf("cameras", std::size_t(index)) + ": camera " + camera.name +
                           " is left out: " + wrong);
        return std::nullopt;
    }
    return camera;
}

} // namespace halflight
