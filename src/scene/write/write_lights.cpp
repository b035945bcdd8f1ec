#include "scene/write/write_lights.h"

#include "halflight/scene/turning_lights.h"
#include "scene/model/origin.h"
#include "scene/model/pose.h"
#include "scene/read/geometry/nodes.h"
#include "scene/read/looks/light_shapes.h"

namespace halflight {

namespace {

Json atBakeJson(const LightAtBake& atBake)
{
    Json json = {{"colorIntensity", numbers(atBake.colorIntensity)},
                 {"indirectMultiplier", atBake.indirectMultiplier},
                 {"range", atBake.rangeMeters},
                 {"innerConeAngle", atBake.innerConeRadians},
                 {"castShadows", atBake.castShadows},
                 {"shadowStrength", atBake.shadowStrength},
                 {"radius", atBake.radiusMeters},
                 {"angularRadius", atBake.angularRadiusRadians}};
    if (atBake.sizeMeters.x >= 0.0f) json["size"] = {atBake.sizeMeters.x, atBake.sizeMeters.y};
    return json;
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
            if (light.sourceNode >= 0 && std::size_t(light.sourceNode) >= member(source_.json, "nodes").size()) {
                return Error{ErrorCode::InvalidArgument, "light \"" + light.name + "\" has no node in the source file",
                             ""};
            }
            bool added = false;
            const int node = place(light, added);
            if (!added && !light.directions.empty())
                if (Status s = turn(light); !s) return s;
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

    // The light's node and the extension's light, with what settings changed. `added`: the file has neither.
    int place(const Light& light, bool& added)
    {
        const int node = light.sourceNode;
        added =
            node < 0 || member(extensionOf(source_.json["nodes"][std::size_t(node)], kLightExtension), "added") == true;
        if (node < 0) {
            Json json = {{"name", light.name}};
            addLight(light, json);
            if (light.worldFromLight != mat4(1.0f) || scene_.originMeters != dvec3(0.0))
                json["matrix"] = worldNumbers(light.worldFromLight);
            const int made = patcher_.append("nodes", std::move(json));
            addToScene(made);
            return made;
        }
        const bool inFile = extensionOf(source_.json["nodes"][std::size_t(node)], extensionNameOf(light)).is_object();
        if (added) { // its settings file is its source: it may say something else by now
            Json& extensions = nodeJson(node)["extensions"];
            if (inFile) {
                const auto index = extensions[extensionNameOf(light)]["light"].get<std::size_t>();
                lightList(light)[index] = lightJson(light);
            } else {
                for (const char* name : {"KHR_lights_punctual", "EXT_lights_area"}) extensions.erase(name);
                addLight(light, nodeJson(node));
            }
            nodeJson(node)["matrix"] = worldNumbers(light.worldFromLight);
        } else if (inFile) {
            patchLight(light);
        } else { // an area light by its node's extras alone
            addLight(light, nodeJson(node));
        }
        return node;
    }

    /// The node of a light that turns, where the light was turned since it was read.
    Status turn(const Light& light)
    {
        const Json& nodes = source_.json["nodes"];
        const std::vector<int> parents = parentsOf(nodes);
        glm::dmat4 worldFromParent(1.0);
        glm::dmat4 local(1.0);
        for (int n = light.sourceNode; n >= 0; n = parents[std::size_t(n)]) {
            const auto own = localTransform(nodes[std::size_t(n)], pathOf("nodes", std::size_t(n)));
            if (!own) return own.error();
            if (n == light.sourceNode)
                local = *own;
            else
                worldFromParent = *own * worldFromParent;
        }
        constexpr double kRounding = 1.0e-5; // radians
        const dvec3 now = -glm::normalize(dvec3((worldFromParent * local)[2]));
        if (glm::distance(now, dvec3(light.direction())) <= kRounding) return {};
        Json& node = nodeJson(light.sourceNode);
        for (const char* other : {"children", "mesh", "camera"})
            if (node.contains(other))
                return Error{ErrorCode::Unsupported,
                             "light \"" + light.name +
                                 "\" was turned, and other things are in its node or below it, "
                                 "which would turn too: give the light a node of its own",
                             pathOf("nodes", std::size_t(light.sourceNode))};
        const dvec3 along = glm::inverse(glm::dmat3(worldFromParent)) * dvec3(light.direction());
        const quat turned = glm::quat_cast(mat3(poseLookingAlong(vec3(0.0f), vec3(glm::normalize(along)))));
        for (const char* key : {"matrix", "scale", "rotation"}) node.erase(key);
        node["translation"] = numbers(vec3(local[3]));
        node["rotation"] = {turned.x, turned.y, turned.z, turned.w};
        return {};
    }

    void addLight(const Light& light, Json& node)
    {
        node["extensions"][extensionNameOf(light)] = {{"light", lightList(light).size()}};
        lightList(light).push_back(lightJson(light));
    }

    [[nodiscard]] Json record(const Light& light, bool added) const
    {
        Json record = {{"mode", nameOf(light.mode)},
                       {"shadowStrength", light.shadowStrength},
                       {"indirectMultiplier", light.indirectMultiplier},
                       {"castShadows", light.castShadows},
                       {"radius", light.radiusMeters}};
        if (light.type == LightType::Directional) record["angularRadius"] = light.angularRadiusRadians;
        if (isAreaLight(light.type) && light.rangeMeters > 0.0f) record["range"] = light.rangeMeters;
        if (const Json bias = biasJson(light.shadowBias); !bias.empty()) record["shadowBias"] = bias;
        if (!light.group.empty()) record["group"] = light.group;
        for (const vec3 direction : light.directions) record["directions"].push_back(numbers(direction));
        if (added) record["added"] = true;
        if (!light.baking.isBaked) return record;
        Json& baking = record["baking"];
        baking = {{"bakeType", nameOf(light.baking.bakeType)},
                  {"mixedLightingMode", nameOf(light.baking.mixedMode)},
                  {"occlusionMaskChannel", light.baking.occlusionMaskChannel},
                  {"worldFromLight", worldNumbers(light.baking.worldFromLight)}};
        if (light.baking.coloredMask) baking["coloredMask"] = true;
        if (light.type != LightType::Directional && light.baking.reachMeters > 0.0f)
            baking["reach"] = light.baking.reachMeters;
        if (light.type == LightType::Spot) baking["outerConeAngle"] = light.baking.outerConeRadians;
        if (light.baking.atBake.known) baking["atBake"] = atBakeJson(light.baking.atBake);
        if (light.baking.group >= 0) {
            baking["group"] = light.baking.group;
            baking["white"] = numbers(light.baking.white);
        }
        if (turns(light)) {
            baking["turns"]["group"] = light.baking.turning.group;
            for (const vec3 direction : light.baking.turning.directions)
                baking["turns"]["directions"].push_back(numbers(direction));
            baking["white"] = numbers(light.baking.white);
        }
        if (!light.baking.reason.empty()) baking["reason"] = light.baking.reason;
        return record;
    }

    static const char* extensionNameOf(const Light& light)
    {
        return isAreaLight(light.type) ? "EXT_lights_area" : "KHR_lights_punctual";
    }

    static void setSize(Json& json, const Light& light)
    {
        const glm::dvec2 size = glm::dvec2(light.sizeMeters) / double(light.sourceScale);
        json["size"] = light.type == LightType::Disk ? size.x : size.y;
        if (light.type == LightType::Rectangle) json["rect"]["aspect"] = size.x / size.y;
    }

    static Json lightJson(const Light& light)
    {
        if (isAreaLight(light.type)) {
            Json json = {{"name", light.name},
                         {"type", light.type == LightType::Disk ? "disk" : "rect"},
                         {"color", numbers(light.color)},
                         {"intensity", light.intensity}};
            setSize(json, light);
            return json;
        }
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

    Json& lightList(const Light& light)
    {
        Json& list = patcher_.json["extensions"][extensionNameOf(light)]["lights"];
        if (!list.is_array()) list = Json::array();
        return list;
    }

    // What settings changed of a light of the file: changed in the light itself, or in a copy where nodes share it.
    void patchLight(const Light& light)
    {
        const bool isArea = isAreaLight(light.type);
        Json& reference = nodeJson(light.sourceNode)["extensions"][extensionNameOf(light)]["light"];
        const auto index = reference.get<std::size_t>();
        Json json = lightList(light)[index];
        const Json before = json;
        const float intensity = json.value("intensity", isArea ? 1000.0f : 1.0f);
        if (light.intensity != intensity) json["intensity"] = light.intensity;
        if (numbers(light.color) != json.value("color", numbers(vec3(1.0f))) && !sameColor(json, light.color))
            json["color"] = numbers(light.color);
        if (isArea && !sameSize(json, light)) setSize(json, light);
        if (!isArea && light.type != LightType::Directional && light.rangeMeters != json.value("range", 0.0f)) {
            if (light.rangeMeters > 0.0f) {
                json["range"] = light.rangeMeters;
            } else {
                json.erase("range");
            }
        }
        if (json == before) return;
        std::size_t users = 0;
        for (const Json& node : patcher_.json["nodes"]) {
            const Json& other = member(extensionOf(node, extensionNameOf(light)), "light");
            users += other.is_number_integer() && other.get<std::size_t>() == index;
        }
        if (users > 1) {
            reference = lightList(light).size();
            lightList(light).push_back(std::move(json));
        } else {
            lightList(light)[index] = std::move(json);
        }
    }

    static bool sameSize(const Json& json, const Light& light)
    {
        const vec2 inFile = areaLightSize(json, light.sourceScale);
        return light.sizeMeters.x == inFile.x && (light.type == LightType::Disk || light.sizeMeters.y == inFile.y);
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
            const std::vector<int> parents = parentsOf(member(source_.json, "nodes"));
            Json nodes = Json::array();
            for (std::size_t i = 0; i < parents.size(); ++i) {
                if (parents[i] < 0) nodes.push_back(i);
            }
            scenes = Json::array({{{"nodes", nodes}}});
            patcher_.json["scene"] = 0;
        }
        const auto index = std::size_t(activeSceneIndex(source_));
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
