#include "scene/write_lights.h"

#include "scene/origin.h"

namespace halflight {

namespace {

Json atBakeJson(const LightAtBake& atBake)
{
    return {{"colorIntensity", numbers(atBake.colorIntensity)},
            {"indirectMultiplier", atBake.indirectMultiplier},
            {"range", atBake.rangeMeters},
            {"innerConeAngle", atBake.innerConeRadians},
            {"castShadows", atBake.castShadows},
            {"shadowStrength", atBake.shadowStrength},
            {"radius", atBake.radiusMeters},
            {"angularRadius", atBake.angularRadiusRadians}};
}

/// The biases that the light has of its own.
Json biasJson(const ShadowBias& bias)
{
    Json json = Json::object();
    if (bias.depthTexels) json["depth"] = *bias.depthTexels;
    if (bias.slope) json["slope"] = *bias.slope;
    if (bias.normalTexels) json["normal"] = *bias.normalTexels;
    return json;
}

class LightWriter {
public:
    LightWriter(DocumentPatcher& patcher, const SourceDocument& source, const Scene& scene)
        : patcher_(patcher), source_(source), scene_(scene)
    {}

    Status write()
    {
        for (const Light& light : scene_.lights) {
            if (light.sourceNode >= 0 && std::size_t(light.sourceNode) >= source_.model.nodes.size()) {
                return Error{ErrorCode::InvalidArgument, "light \"" + light.name + "\" has no node in the source file",
                             ""};
            }
            bool added = false;
            const int node = place(light, added);
            nodeJson(node)["extensions"][kLightExtension] = record(light, added);
        }
        return {};
    }

private:
    Json& nodeJson(int node) { return patcher_.json["nodes"][std::size_t(node)]; }
    /// A pose in the world's coordinates, in double precision.
    [[nodiscard]] Json worldNumbers(const mat4& pose) const
    {
        return numbers(worldFromLocal(pose, scene_.originMeters));
    }

    // The light's node and KHR_lights_punctual light, with what settings changed. `added`: the file has neither.
    int place(const Light& light, bool& added)
    {
        const int node = light.sourceNode;
        added =
            node < 0 || member(extensionOf(source_.json["nodes"][std::size_t(node)], kLightExtension), "added") == true;
        if (node < 0) {
            const std::size_t index = lightList().size();
            lightList().push_back(lightJson(light));
            Json json = {{"name", light.name}, {"extensions", {{"KHR_lights_punctual", {{"light", index}}}}}};
            if (light.worldFromLight != mat4(1.0f) || scene_.originMeters != dvec3(0.0))
                json["matrix"] = worldNumbers(light.worldFromLight);
            const int made = patcher_.append("nodes", std::move(json));
            addToScene(made);
            return made;
        }
        if (added) { // its settings file is its source: it may say something else by now
            const auto index = nodeJson(node)["extensions"]["KHR_lights_punctual"]["light"].get<std::size_t>();
            lightList()[index] = lightJson(light);
            nodeJson(node)["matrix"] = worldNumbers(light.worldFromLight);
        } else {
            patchLight(light);
        }
        return node;
    }

    [[nodiscard]] Json record(const Light& light, bool added) const
    {
        Json record = {{"mode", nameOf(light.mode)},
                       {"shadowStrength", light.shadowStrength},
                       {"indirectMultiplier", light.indirectMultiplier},
                       {"castShadows", light.castShadows},
                       {"radius", light.radiusMeters}};
        if (light.type == LightType::Directional) record["angularRadius"] = light.angularRadiusRadians;
        if (const Json bias = biasJson(light.shadowBias); !bias.empty()) record["shadowBias"] = bias;
        if (added) record["added"] = true;
        if (!light.baking.isBaked) return record;
        Json& baking = record["baking"];
        baking = {{"bakeType", nameOf(light.baking.bakeType)},
                  {"mixedLightingMode", nameOf(light.baking.mixedMode)},
                  {"occlusionMaskChannel", light.baking.occlusionMaskChannel},
                  {"worldFromLight", worldNumbers(light.baking.worldFromLight)}};
        if (light.type != LightType::Directional && light.baking.reachMeters > 0.0f)
            baking["reach"] = light.baking.reachMeters;
        if (light.type == LightType::Spot) baking["outerConeAngle"] = light.baking.outerConeRadians;
        if (light.baking.atBake.known) baking["atBake"] = atBakeJson(light.baking.atBake);
        if (!light.baking.reason.empty()) baking["reason"] = light.baking.reason;
        return record;
    }

    static Json lightJson(const Light& light)
    {
        constexpr const char* kTypes[] = {"directional", "point", "spot"};
        Json json = {{"name", light.name},
                     {"type", kTypes[int(light.type)]},
                     {"color", numbers(light.color)},
                     {"intensity", light.intensity}};
        if (light.type != LightType::Directional && light.rangeMeters > 0.0f) json["range"] = light.rangeMeters;
        if (light.type == LightType::Spot) {
            json["spot"] = {{"innerConeAngle", light.innerConeRadians}, {"outerConeAngle", light.outerConeRadians}};
        }
        return json;
    }

    Json& lightList()
    {
        Json& list = patcher_.json["extensions"]["KHR_lights_punctual"]["lights"];
        if (!list.is_array()) list = Json::array();
        return list;
    }

    // What settings changed of a light of the file: changed in the light itself, or in a copy where nodes share it.
    void patchLight(const Light& light)
    {
        Json& reference = nodeJson(light.sourceNode)["extensions"]["KHR_lights_punctual"]["light"];
        const auto index = reference.get<std::size_t>();
        Json json = lightList()[index];
        const Json before = json;
        const float defaultIntensity = json.value("intensity", 1.0f);
        if (light.intensity != defaultIntensity) json["intensity"] = light.intensity;
        if (numbers(light.color) != json.value("color", numbers(vec3(1.0f))) && !sameColor(json, light.color))
            json["color"] = numbers(light.color);
        if (light.type != LightType::Directional && light.rangeMeters != json.value("range", 0.0f)) {
            if (light.rangeMeters > 0.0f) {
                json["range"] = light.rangeMeters;
            } else {
                json.erase("range");
            }
        }
        if (json == before) return;
        std::size_t users = 0;
        for (const Json& node : patcher_.json["nodes"]) {
            const Json& other = member(extensionOf(node, "KHR_lights_punctual"), "light");
            users += other.is_number_integer() && other.get<std::size_t>() == index;
        }
        if (users > 1) {
            reference = lightList().size();
            lightList().push_back(std::move(json));
        } else {
            lightList()[index] = std::move(json);
        }
    }

    static bool sameColor(const Json& json, vec3 color)
    {
        const Json& list = member(json, "color");
        for (std::size_t c = 0; c < 3; ++c) {
            if ((list.is_array() && list.size() == 3 ? list[c].get<float>() : 1.0f) != color[int(c)]) return false;
        }
        return true;
    }

    void addToScene(int node)
    {
        Json& scenes = patcher_.json["scenes"];
        if (!scenes.is_array() || scenes.empty()) {
            // Without scenes all root nodes are shown: a scene that lists them, and the new node, shows the same.
            std::set<int> children;
            for (const auto& n : source_.model.nodes) children.insert(n.children.begin(), n.children.end());
            Json nodes = Json::array();
            for (std::size_t i = 0; i < source_.model.nodes.size(); ++i) {
                if (children.count(int(i)) == 0) nodes.push_back(i);
            }
            scenes = Json::array({{{"nodes", nodes}}});
            patcher_.json["scene"] = 0;
        }
        const auto index = std::size_t(std::max(0, source_.model.defaultScene));
        scenes[index]["nodes"].push_back(node);
    }

    DocumentPatcher& patcher_;
    const SourceDocument& source_;
    const Scene& scene_;
};

} // namespace

Status writeLights(DocumentPatcher& patcher, const SourceDocument& source, const Scene& scene)
{
    return LightWriter(patcher, source, scene).write();
}

} // namespace halflight
