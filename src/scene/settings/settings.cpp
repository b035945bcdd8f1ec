#include "scene/settings/settings.h"

#include "scene/format/material_sides.h"
#include "scene/model/pose.h"
#include "scene/settings/setting_values.h"

#include <functional>

namespace halflight {

namespace {

template<typename Settings> struct Key {
    const char* name;
    std::function<Expectation(const Json&, Settings&)> set;
};

const std::vector<Key<ObjectSettings>>& objectKeys()
{
    static const std::vector<Key<ObjectSettings>> keys = {
        {"static", [](const Json& v, ObjectSettings& s) { return readBool(v, s.isStatic); }},
        {"cast_shadows", [](const Json& v, ObjectSettings& s) { return readBool(v, s.castShadows); }},
        {"receive_shadows", [](const Json& v, ObjectSettings& s) { return readBool(v, s.receiveShadows); }},
        {"lightmap_scale",
         [](const Json& v, ObjectSettings& s) {
             return readNumber(v, 0.0, 1000.0, "a number from 0 to 1000", s.lightmapScale);
         }},
        {"two_sided", [](const Json& v, ObjectSettings& s) { return readBool(v, s.twoSided); }},
        {"probes",
         [](const Json& v, ObjectSettings& s) -> Expectation {
             if (v.is_string()) s.probeLighting = probeLightingNamed(v.get<std::string>());
             return s.probeLighting ? nullptr : "\"single\" or \"volume\"";
         }},
        {"probe_resolution",
         [](const Json& v, ObjectSettings& s) -> Expectation {
             ivec3 resolution;
             if (!readProbeResolution(v, resolution)) return "a whole number from 1 to 64, or three";
             s.probeResolution = resolution;
             return nullptr;
         }},
        {"reflection_probe", [](const Json& v, ObjectSettings& s) { return readBool(v, s.reflectionProbe); }},
        {"area_light",
         [](const Json& v, ObjectSettings& s) -> Expectation {
             if (v.is_string()) s.areaLight = lightTypeNamed(v.get<std::string>());
             return s.areaLight && isAreaLight(*s.areaLight) ? nullptr : "\"rectangle\" or \"disk\"";
         }},
        {"group", [](const Json& v, ObjectSettings& s) { return readGroup(v, s.group); }},
    };
    return keys;
}

const std::vector<Key<MaterialSettings>>& materialKeys()
{
    static const std::vector<Key<MaterialSettings>> keys = {
        {"cast_shadows", [](const Json& v, MaterialSettings& s) { return readBool(v, s.castShadows); }},
        {"receive_shadows", [](const Json& v, MaterialSettings& s) { return readBool(v, s.receiveShadows); }},
        {"tinted", [](const Json& v, MaterialSettings& s) { return readBool(v, s.tinted); }},
        {"group", [](const Json& v, MaterialSettings& s) { return readGroup(v, s.group); }},
    };
    return keys;
}

const std::vector<Key<LightSettings>>& lightKeys()
{
    static const std::vector<Key<LightSettings>> keys = {
        {"mode",
         [](const Json& v, LightSettings& s) -> Expectation {
             if (v.is_string()) s.mode = lightModeNamed(v.get<std::string>());
             return s.mode ? nullptr : "\"realtime\", \"mixed\" or \"baked\"";
         }},
        {"cast_shadows", [](const Json& v, LightSettings& s) { return readBool(v, s.castShadows); }},
        {"shadow_strength",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, 1.0, "a number from 0 to 1", s.shadowStrength);
         }},
        {"indirect_multiplier",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, 1.0e6, "a number from 0 to 1000000", s.indirectMultiplier);
         }},
        {"radius",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, 1.0e7, "a number of metres from 0 to 10000000", s.radiusMeters);
         }},
        {"angular_diameter",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, 180.0, "a number of degrees from 0 to 180", s.angularDiameterDegrees);
         }},
        {"size", [](const Json& v, LightSettings& s) { return readSize(v, s.sizeMeters); }},
        {"depth_bias",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, kMaxShadowBias, "a number from 0 to 100", s.shadowBias.depthTexels);
         }},
        {"slope_bias",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, kMaxShadowBias, "a number from 0 to 100", s.shadowBias.slope);
         }},
        {"normal_bias",
         [](const Json& v, LightSettings& s) {
             return readNumber(v, 0.0, kMaxNormalBiasTexels, "a number from 0 to 8", s.shadowBias.normalTexels);
         }},
        {"range",
         [](const Json& v, LightSettings& s) { return readNumber(v, 0.0, kHuge, kNotNegative, s.rangeMeters); }},
        {"intensity",
         [](const Json& v, LightSettings& s) { return readNumber(v, 0.0, kHuge, kNotNegative, s.intensity); }},
        {"color", [](const Json& v, LightSettings& s) { return readColor(v, s.color); }},
        {"group", [](const Json& v, LightSettings& s) { return readGroup(v, s.group); }},
        {"directions", [](const Json& v, LightSettings& s) { return readDirections(v, s.directions); }},
    };
    return keys;
}

const std::vector<Key<SceneSettings>>& sceneKeys()
{
    static const std::vector<Key<SceneSettings>> keys = {
        // The shorthand first: the parts below override it, whatever their order in the file.
        {"sky",
         [](const Json& v, SceneSettings& s) {
             const Expectation wrong = readColor(v, s.skyZenith);
             s.skyHorizon = s.skyGround = s.skyZenith;
             return wrong;
         }},
        {"sky_zenith", [](const Json& v, SceneSettings& s) { return readColor(v, s.skyZenith); }},
        {"sky_horizon", [](const Json& v, SceneSettings& s) { return readColor(v, s.skyHorizon); }},
        {"sky_ground", [](const Json& v, SceneSettings& s) { return readColor(v, s.skyGround); }},
        {"sky_image",
         [](const Json& v, SceneSettings& s) -> Expectation {
             const std::string name = v.is_string() ? v.get<std::string>() : std::string();
             if (name.empty() || name.find('\0') != std::string::npos) return "the name of a .hdr or .exr file";
             s.skyImage = name;
             return nullptr;
         }},
        {"sky_rotation",
         [](const Json& v, SceneSettings& s) {
             return readNumber(v, -3600.0, 3600.0, "a number of degrees", s.skyRotationDegrees);
         }},
        {"sky_intensity",
         [](const Json& v, SceneSettings& s) { return readNumber(v, 0.0, kHuge, kNotNegative, s.skyIntensity); }},
        {"sky_group", [](const Json& v, SceneSettings& s) { return readGroup(v, s.skyGroup); }},
        {"sky_changes", [](const Json& v, SceneSettings& s) { return readBool(v, s.skyChanges); }},
        {"emission_unit",
         [](const Json& v, SceneSettings& s) -> Expectation {
             s.emissionUnit = emissionUnitNamed(v.is_string() ? v.get<std::string>() : std::string());
             return s.emissionUnit ? nullptr : "\"nits\" or \"blender\"";
         }},
        {"shadow_color", [](const Json& v, SceneSettings& s) { return readColor(v, s.shadowColor); }},
        {"probes", [](const Json& v, SceneSettings& s) { return readPoints(v, s.probes); }},
    };
    return keys;
}

constexpr Expectation kLightTypes = "\"directional\", \"point\", \"spot\", \"rectangle\" or \"disk\"";

// A light of [[add_light]], before its pose is known.
struct AddedLight {
    Light light;
    LightSettings settings;
    glm::dvec3 position{0.0};
    vec3 direction{0.0f, -1.0f, 0.0f};
    bool hasType = false;
};

const std::vector<Key<AddedLight>>& addedLightKeys()
{
    static const std::vector<Key<AddedLight>> keys = [] {
        std::vector<Key<AddedLight>> list = {
            {"type",
             [](const Json& v, AddedLight& s) -> Expectation {
                 const auto type = lightTypeNamed(v.is_string() ? v.get<std::string>() : "");
                 s.hasType = type.has_value();
                 s.light.type = type.value_or(s.light.type);
                 return s.hasType ? nullptr : kLightTypes;
             }},
            {"name",
             [](const Json& v, AddedLight& s) -> Expectation {
                 if (!v.is_string() || v.get<std::string>().empty()) return "a text";
                 s.light.name = v.get<std::string>();
                 return nullptr;
             }},
            {"position",
             [](const Json& v, AddedLight& s) -> Expectation {
                 return readVec3(v, s.position) ? nullptr : "[x, y, z]";
             }},
            {"direction",
             [](const Json& v, AddedLight& s) -> Expectation {
                 return readVec3(v, s.direction) && glm::length(s.direction) > 1.0e-6f ? nullptr
                                                                                       : "[x, y, z], not zero";
             }},
            {"inner_cone_degrees",
             [](const Json& v, AddedLight& s) -> Expectation {
                 std::optional<float> degrees;
                 const Expectation wrong = readNumber(v, 0.0, 90.0, "a half angle from 0 to 90 degrees", degrees);
                 if (degrees) s.light.innerConeRadians = glm::radians(*degrees);
                 return wrong;
             }},
            {"outer_cone_degrees",
             [](const Json& v, AddedLight& s) -> Expectation {
                 std::optional<float> degrees;
                 const Expectation wrong = readNumber(v, 0.01, 90.0, "a half angle from 0.01 to 90 degrees", degrees);
                 if (degrees) s.light.outerConeRadians = glm::radians(*degrees);
                 return wrong;
             }},
        };
        for (const auto& key : lightKeys()) {
            list.push_back({key.name, [set = key.set](const Json& v, AddedLight& s) { return set(v, s.settings); }});
        }
        return list;
    }();
    return keys;
}

Error wrongValue(const std::string& path, const std::string& key, Expectation expectation)
{
    return Error{ErrorCode::FileInvalid, key + " must be " + expectation, path};
}

constexpr std::string_view kPrefix = "halflight_";

template<typename Settings>
Result<Settings> fromExtras(const Json& extras, const std::vector<Key<Settings>>& keys, const std::string& path)
{
    Settings settings;
    for (const auto& key : keys) {
        const std::string name = std::string(kPrefix) + key.name;
        if (!extras.is_object() || !extras.contains(name)) continue;
        if (const Expectation wrong = key.set(extras[name], settings)) return wrongValue(path + "/extras", name, wrong);
    }
    return settings;
}

// One table of a settings file: every key must be known.
template<typename Settings> Status fromTable(const Json& table, const std::vector<Key<Settings>>& keys,
                                             const std::string& path, const char* skip, Settings& settings)
{
    for (const auto& [name, value] : table.items()) {
        if (name == skip) continue;
        bool known = false;
        for (const auto& key : keys) known = known || name == key.name;
        if (!known) return Error{ErrorCode::FileInvalid, "unknown key \"" + name + "\"", path};
    }
    for (const auto& key : keys) { // in the table's order, so that shorthands come first
        const Json& value = member(table, key.name);
        if (value.is_null()) continue;
        if (const Expectation wrong = key.set(value, settings)) return wrongValue(path, key.name, wrong);
    }
    return {};
}

template<typename Settings> Status readRules(const Json& tables, const char* name,
                                             const std::vector<Key<Settings>>& keys,
                                             std::vector<FileSettings::Rule<Settings>>& rules)
{
    if (!tables.is_array())
        return Error{ErrorCode::FileInvalid, std::string("must be written as [[") + name + "]]", name};
    for (std::size_t i = 0; i < tables.size(); ++i) {
        const std::string path = std::string(name) + "[" + std::to_string(i) + "]";
        const Json& pattern = member(tables[i], "pattern");
        if (!pattern.is_string()) return wrongValue(path, "pattern", "a text such as \"Lamp*\"");
        FileSettings::Rule<Settings> rule;
        rule.pattern = pattern.get<std::string>();
        if (Status s = fromTable(tables[i], keys, path, "pattern", rule.settings); !s) return s;
        rules.push_back(std::move(rule));
    }
    return {};
}

Status readAddedLights(const Json& tables, std::vector<FileSettings::AddedLight>& lights)
{
    if (!tables.is_array()) return Error{ErrorCode::FileInvalid, "must be written as [[add_light]]", "add_light"};
    for (std::size_t i = 0; i < tables.size(); ++i) {
        const std::string path = "add_light[" + std::to_string(i) + "]";
        AddedLight added;
        if (Status s = fromTable(tables[i], addedLightKeys(), path, "", added); !s) return s;
        if (!added.hasType) return wrongValue(path, "type", kLightTypes);
        if (added.light.innerConeRadians >= added.light.outerConeRadians && added.light.type == LightType::Spot) {
            return wrongValue(path, "inner_cone_degrees", "below outer_cone_degrees");
        }
        if (added.light.name.empty()) added.light.name = "added light " + std::to_string(i);
        applySettings(added.settings, added.light);
        added.light.worldFromLight = poseLookingAlong(vec3(0.0f), added.direction);
        lights.push_back({std::move(added.light), added.position});
    }
    return {};
}

Status checkSky(const SceneSettings& settings, const std::string& path)
{
    if (!settings.skyImage || !(settings.skyZenith || settings.skyHorizon || settings.skyGround)) return {};
    return Error{ErrorCode::FileInvalid, "the sky has an image and colours; it is one or the other", path};
}

// sky.* keys are those of sceneKeys() without "sky_"; "color" is the shorthand for all three.
Status readSky(const Json& table, SceneSettings& settings)
{
    std::vector<Key<SceneSettings>> keys;
    for (const auto& key : sceneKeys()) {
        const std::string_view name = key.name;
        if (name == "sky") keys.push_back({"color", key.set});
        if (name.starts_with("sky_")) keys.push_back({key.name + 4, key.set});
    }
    if (Status s = fromTable(table, keys, "sky", "", settings); !s) return s;
    return checkSky(settings, "sky");
}

} // namespace

Result<FileSettings> settingsFromTables(const Json& root)
{
    FileSettings settings;
    for (const auto& [name, value] : root.items()) {
        Status status;
        if (name == "sky" || name == "scene") {
            if (!value.is_object()) return Error{ErrorCode::FileInvalid, "must be a table", name};
            if (name == "sky") {
                status = readSky(value, settings.scene);
            } else {
                std::vector<Key<SceneSettings>> keys;
                for (const auto& key : sceneKeys()) {
                    if (std::string_view(key.name).substr(0, 3) != "sky") keys.push_back(key);
                }
                status = fromTable(value, keys, "scene", "", settings.scene);
            }
        } else if (name == "node") {
            status = readRules(value, "node", objectKeys(), settings.nodes);
        } else if (name == "material") {
            status = readRules(value, "material", materialKeys(), settings.materials);
        } else if (name == "light") {
            status = readRules(value, "light", lightKeys(), settings.lights);
        } else if (name == "add_light") {
            status = readAddedLights(value, settings.addedLights);
        } else {
            return Error{ErrorCode::FileInvalid, "unknown table \"" + name + "\"", ""};
        }
        if (!status) return status.error();
    }
    return settings;
}

Result<ObjectSettings> objectSettingsOf(const Json& extras, const std::string& path)
{
    return fromExtras(extras, objectKeys(), path);
}
Result<MaterialSettings> materialSettingsOf(const Json& extras, const std::string& path)
{
    return fromExtras(extras, materialKeys(), path);
}
Result<LightSettings> lightSettingsOf(const Json& extras, const std::string& path)
{
    return fromExtras(extras, lightKeys(), path);
}
Result<SceneSettings> sceneSettingsOf(const Json& extras, const std::string& path)
{
    auto settings = fromExtras(extras, sceneKeys(), path);
    if (!settings) return settings;
    if (Status s = checkSky(*settings, path + "/extras"); !s) return s.error();
    return settings;
}

void warnUnknownExtras(const Json& extras, ExtrasOwner owner, const std::string& path,
                       std::vector<std::string>& warnings)
{
    if (!extras.is_object()) return;
    for (const auto& item : extras.items()) {
        const std::string_view name = item.key();
        if (name.substr(0, kPrefix.size()) != kPrefix || name == kBakeMark || name == kSideMark) continue;
        const auto knows = [&](const auto& keys) {
            for (const auto& key : keys) {
                if (name.substr(kPrefix.size()) == key.name) return true;
            }
            return false;
        };
        const bool known = owner == ExtrasOwner::Scene      ? knows(sceneKeys())
                           : owner == ExtrasOwner::Light    ? knows(lightKeys())
                           : owner == ExtrasOwner::Material ? knows(materialKeys())
                                                            : knows(objectKeys()) || knows(lightKeys());
        if (!known) warnings.push_back(path + "/extras: unknown key " + item.key() + " is ignored");
    }
}

std::optional<ProbeLighting> probeLightingNamed(std::string_view name)
{
    if (name == "single") return ProbeLighting::Single;
    if (name == "volume") return ProbeLighting::Volume;
    return std::nullopt;
}

bool readProbeResolution(const Json& value, ivec3& resolution)
{
    const bool three = value.is_array() && value.size() == 3;
    for (int axis = 0; axis < 3; ++axis) {
        const Json& number = three ? value[std::size_t(axis)] : value;
        if (!number.is_number()) return false;
        const double texels = number.get<double>(); // Blender writes some integers as 8.0
        if (!(texels >= 1.0 && texels <= 64.0) || texels != std::floor(texels)) return false;
        resolution[axis] = int(texels);
    }
    return true;
}

} // namespace halflight
