#pragma once
// Authored settings: flat halflight_* keys in glTF extras, and the tables of a settings file (TOML). Both are read by
// the same tables of keys; a key of extras is "halflight_" and the settings file's key.

#include "scene/document/document.h"
#include "scene/settings/name_pattern.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

/// Key of the scene's extras that says what a bake wrote: it outlives tools that drop unknown extensions.
constexpr const char* kBakeMark = "halflight_baked";

struct ObjectSettings {
    std::optional<bool> isStatic;
    std::optional<bool> castShadows;
    std::optional<bool> receiveShadows;
    std::optional<float> lightmapScale;
    std::optional<bool> twoSided; ///< texels for both sides of sheets, or for one
    std::optional<ProbeLighting> probeLighting;
    std::optional<ivec3> probeResolution;
    std::optional<bool> reflectionProbe; ///< the node's cube [-1, 1]^3 is a reflection probe's box
    std::optional<LightType> areaLight;  ///< the node is an area light, in its XY plane
    std::optional<std::string> group;    ///< light group of its lights and emission, and of those of nodes below it
};

struct MaterialSettings {
    std::optional<bool> castShadows;
    std::optional<bool> receiveShadows;
    std::optional<bool> tinted;
    std::optional<std::string> group;
};

struct LightSettings {
    std::optional<LightMode> mode;
    std::optional<bool> castShadows;
    std::optional<float> shadowStrength;
    std::optional<float> indirectMultiplier;
    std::optional<float> radiusMeters;
    std::optional<float> angularDiameterDegrees;
    std::optional<vec2> sizeMeters; ///< of an area light, as Light::sizeMeters
    ShadowBias shadowBias;
    std::optional<float> rangeMeters;
    std::optional<float> intensity;
    std::optional<vec3> color;
    std::optional<std::string> group;
    std::optional<std::vector<vec3>> directions; ///< unit, in the file's world
};

struct SceneSettings {
    std::optional<vec3> skyZenith;
    std::optional<vec3> skyHorizon;
    std::optional<vec3> skyGround;
    std::optional<std::filesystem::path> skyImage; ///< of a file's own settings: relative to the file
    bool skyOfBake = false;                        ///< the picture that an earlier bake recorded, turned as it was
    std::optional<float> skyRotationDegrees;
    std::optional<float> skyIntensity;
    std::optional<std::string> skyGroup;
    std::optional<bool> skyChanges;
    std::optional<EmissionUnit> emissionUnit;
    std::optional<vec3> shadowColor;
    std::optional<std::vector<glm::dvec3>> probes; ///< in the file's world
};

/// "single" or "volume"; nothing for other words.
std::optional<ProbeLighting> probeLightingNamed(std::string_view name);
/// One number for all axes or three, each 1…64; false for anything else.
bool readProbeResolution(const Json& value, ivec3& resolution);

/// Key of the scene's extras that says what emission counts; bakes and the Blender extension write it too.
constexpr const char* kEmissionUnitKey = "halflight_emission_unit";

/// A settings file: rules in the file's order, later ones win.
struct FileSettings {
    template<typename Settings> struct Rule {
        std::string pattern;
        Settings settings;
        bool matched = false;
    };
    std::vector<Rule<ObjectSettings>> nodes;
    std::vector<Rule<MaterialSettings>> materials;
    std::vector<Rule<LightSettings>> lights;
    struct AddedLight {
        Light light;         ///< its pose has the direction only
        glm::dvec3 position; ///< in the file's world
    };
    std::vector<AddedLight> addedLights;
    SceneSettings scene;
};

/// Settings in an object's extras. A wrong value is an error; a halflight_ key that neither table of a node nor of a
/// light knows is a warning.
Result<ObjectSettings> objectSettingsOf(const Json& extras, const std::string& path);
Result<MaterialSettings> materialSettingsOf(const Json& extras, const std::string& path);
Result<LightSettings> lightSettingsOf(const Json& extras, const std::string& path);
Result<SceneSettings> sceneSettingsOf(const Json& extras, const std::string& path);
enum class ExtrasOwner { Node, Material, Light, Scene };
void warnUnknownExtras(const Json& extras, ExtrasOwner owner, const std::string& path,
                       std::vector<std::string>& warnings);

Result<FileSettings> readSettingsFile(const std::filesystem::path& path);
/// The same from the file's text. Errors name the line.
Result<FileSettings> parseSettings(std::string_view toml);
/// The same from the file's tables as JSON.
Result<FileSettings> settingsFromTables(const Json& root);

/// `stronger` where it says something, else `weaker`.
ObjectSettings mergeSettings(const ObjectSettings& weaker, const ObjectSettings& stronger);
SceneSettings mergeSettings(const SceneSettings& weaker, const SceneSettings& stronger);
void applySettings(const LightSettings& settings, Light& light);
void applySettings(const MaterialSettings& settings, Material& material);

} // namespace halflight
