#include "scene/read/looks/emission_unit.h"

#include "scene/document/patcher.h"

#include <algorithm>
#include <string>

namespace halflight {

namespace {

constexpr const char* kStrength = "KHR_materials_emissive_strength";

bool emits(const Scene& scene)
{
    return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
        const std::vector<MeshPart>& parts = scene.meshes[std::size_t(object.mesh)].parts;
        return std::any_of(parts.begin(), parts.end(),
                           [&](const MeshPart& part) { return materialOf(scene, part).emissiveNits != vec3(0.0f); });
    });
}

bool isOfBlender(const SourceDocument& document)
{
    return stringOf(member(document.json, "asset"), "generator").starts_with("Khronos glTF Blender I/O");
}

} // namespace

void applyEmissionUnit(const SourceDocument& document, std::optional<EmissionUnit> ofFile,
                       std::optional<EmissionUnit> asked, Scene& scene)
{
    EmissionUnit unit = asked.value_or(ofFile.value_or(EmissionUnit::Nits));
    if (ofFile == EmissionUnit::Nits && unit != EmissionUnit::Nits) {
        scene.warnings.push_back(std::string("the file says that its emission is in nits (") + kEmissionUnitKey +
                                 "): it stays as it is, though \"" + nameOf(unit) + "\" is asked for");
        unit = EmissionUnit::Nits;
    }
    if (!ofFile && !asked && isOfBlender(document) && emits(scene)) {
        scene.warnings.emplace_back("Blender's exporter writes emission 683 times darker than its lamps: "
                                    "--emission-unit blender, or emission_unit = \"blender\" under [scene] of a "
                                    "settings file, corrects it, and \"nits\" keeps it without this warning");
    }
    if (unit != EmissionUnit::Blender) return;
    scene.emissionScale = kLumensPerWatt;
    for (Material& material : scene.materials) material.emissiveNits *= kLumensPerWatt;
}

void writeScaledEmission(Json& document, const Scene& scene)
{
    if (scene.emissionScale == 1.0f) return;
    bool any = false;
    for (Json& material : document["materials"]) {
        const Json& factor = member(material, "emissiveFactor");
        if (!factor.is_array() || factor == Json::array({0, 0, 0})) continue;
        Json& strength = material["extensions"][kStrength]["emissiveStrength"];
        strength = scene.emissionScale * (strength.is_number() ? strength.get<float>() : 1.0f);
        any = true;
    }
    Json& used = document["extensionsUsed"];
    if (any && std::find(used.begin(), used.end(), kStrength) == used.end()) used.push_back(kStrength);
    if (used.empty()) document.erase("extensionsUsed");
    Json& active = document["scenes"][std::size_t(integerOf(document, "scene", 0))];
    if (!active.contains("extras") || active["extras"].is_object())
        active["extras"][kEmissionUnitKey] = nameOf(EmissionUnit::Nits);
}

void writeChangedEmission(Json& document, const Scene& scene, const std::vector<int>& materials)
{
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        if (materials[i] < 0) continue;
        Json& material = document["materials"][std::size_t(materials[i])];
        const Json& factor = member(material, "emissiveFactor");
        const Json& strength = member(extensionOf(material, kStrength), "emissiveStrength");
        const bool hasFactor = factor.is_array() && factor.size() == 3;
        vec3 written(0.0f);
        for (int c = 0; hasFactor && c < 3; ++c) written[c] = std::max(factor[std::size_t(c)].get<float>(), 0.0f);
        written *= strength.is_number() ? strength.get<float>() : 1.0f;
        const vec3 nits = scene.materials[i].emissiveNits;
        if (glm::all(glm::lessThanEqual(glm::abs(written - nits), 1.0e-4f * (written + nits)))) continue;
        const float most = std::max({1.0f, nits.x, nits.y, nits.z});
        material["emissiveFactor"] = numbers(nits / most);
        if (strength.is_number() || most > 1.0f) material["extensions"][kStrength]["emissiveStrength"] = most;
        Json& used = document["extensionsUsed"];
        if (most > 1.0f && std::find(used.begin(), used.end(), kStrength) == used.end()) used.push_back(kStrength);
        if (used.empty()) document.erase("extensionsUsed");
    }
}

} // namespace halflight
