#include "scene/read/geometry/nodes.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <cmath>

namespace halflight {

namespace {

bool readNumbers(const Json& value, std::size_t count, double* out)
{
    if (!value.is_array() || value.size() != count) return false;
    for (std::size_t i = 0; i < count; ++i) {
        if (!value[i].is_number()) return false;
        out[i] = value[i].get<double>();
        if (!std::isfinite(out[i])) return false;
    }
    return true;
}

glm::dmat4 compose(const glm::dvec3& t, glm::dquat q, const glm::dvec3& s)
{
    const double length = glm::length(q);
    q = length > 0.0 ? q / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
    glm::dmat4 m = glm::mat4_cast(q);
    for (int c = 0; c < 3; ++c) m[c] *= s[c];
    m[3] = glm::dvec4(t, 1.0);
    return m;
}

// What an earlier bake wrote down about the node (HALFLIGHT_node): stronger than extras, since it has their values and
// those of the settings file of that bake.
Result<ObjectSettings> bakedRecord(const Json& node, const std::string& nodePath)
{
    ObjectSettings settings;
    const Json& record = extensionOf(node, "HALFLIGHT_node");
    const std::string path = nodePath + "/extensions/HALFLIGHT_node";
    const auto flag = [&](const char* key, std::optional<bool>& out) {
        const Json& value = member(record, key);
        if (value.is_boolean()) out = value.get<bool>();
    };
    flag("static", settings.isStatic);
    flag("castShadows", settings.castShadows);
    flag("receiveShadows", settings.receiveShadows);
    flag("twoSided", settings.twoSided);
    if (const Json& scale = member(record, "lightmapScale"); scale.is_number()) {
        if (!(scale.get<double>() >= 0.0)) return invalid(path + "/lightmapScale", "is below 0");
        settings.lightmapScale = scale.get<float>();
    }
    if (const Json& probes = member(record, "probes"); probes.is_string()) {
        settings.probeLighting = probeLightingNamed(probes.get<std::string>());
        if (!settings.probeLighting) return invalid(path + "/probes", "is neither single nor volume");
    }
    if (const Json& texels = member(record, "probeResolution"); !texels.is_null()) {
        ivec3 resolution;
        if (!readProbeResolution(texels, resolution))
            return invalid(path + "/probeResolution", "is not three numbers from 1 to 64");
        settings.probeResolution = resolution;
    }
    return settings;
}

} // namespace

bool readMatrix(const Json& value, glm::dmat4& matrix)
{
    double numbers[16];
    if (!readNumbers(value, 16, numbers)) return false;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = numbers[i];
    return true;
}

Result<glm::dmat4> localTransform(const Json& node, const std::string& path)
{
    const Json& matrix = member(node, "matrix");
    glm::dmat4 local(1.0);
    if (!matrix.is_null()) {
        double m[16];
        if (!readNumbers(matrix, 16, m)) return invalid(path, "matrix is not 16 finite numbers");
        for (int i = 0; i < 16; ++i) local[i / 4][i % 4] = m[i];
        local = glm::dmat4(glm::dvec4(glm::dvec3(local[0]), 0), glm::dvec4(glm::dvec3(local[1]), 0),
                           glm::dvec4(glm::dvec3(local[2]), 0), glm::dvec4(glm::dvec3(local[3]), 1));
    } else {
        double t[3] = {0, 0, 0};
        double r[4] = {0, 0, 0, 1};
        double s[3] = {1, 1, 1};
        const auto read = [&](const char* key, std::size_t count, double* out) {
            const Json& value = member(node, key);
            return value.is_null() || readNumbers(value, count, out);
        };
        if (!read("translation", 3, t)) return invalid(path, "translation is not 3 finite numbers");
        if (!read("rotation", 4, r)) return invalid(path, "rotation is not 4 finite numbers");
        if (!read("scale", 3, s)) return invalid(path, "scale is not 3 finite numbers");
        local = compose({t[0], t[1], t[2]}, glm::dquat(r[3], r[0], r[1], r[2]), {s[0], s[1], s[2]});
    }
    if (!isFinite(mat4(local))) return invalid(path, "transform is not finite");
    return local;
}

Result<std::vector<glm::dmat4>> instanceTransforms(const SourceDocument& document, int node)
{
    const std::string path = pathOf("nodes", std::size_t(node)) + "/extensions/EXT_mesh_gpu_instancing";
    const Json& attributes =
        member(extensionOf(document.json["nodes"][std::size_t(node)], "EXT_mesh_gpu_instancing"), "attributes");
    if (!attributes.is_object()) return invalid(path, "has no attributes");
    std::optional<std::size_t> count;
    std::vector<vec3> translation;
    std::vector<vec4> rotation;
    std::vector<vec3> scale;
    for (const auto& [name, value] : attributes.items()) {
        if (!isIndexInto(document.json, "accessors", value))
            return invalid(path, name + " refers to an accessor that does not exist");
        const int accessor = value.get<int>();
        const std::size_t length = elementCount(document, accessor);
        if (count && *count != length) return invalid(path, "attributes differ in length");
        count = length;
        const auto fetch = [&](auto result, auto& out) -> Status {
            if (!result) return result.error();
            out = std::move(*result);
            return {};
        };
        Status status;
        if (name == "TRANSLATION") status = fetch(readVectors<3>(document, accessor), translation);
        if (name == "ROTATION") status = fetch(readVectors<4>(document, accessor), rotation);
        if (name == "SCALE") status = fetch(readVectors<3>(document, accessor), scale);
        if (!status) return status.error();
    }
    std::vector<glm::dmat4> transforms(count.value_or(0));
    for (std::size_t i = 0; i < transforms.size(); ++i) {
        const vec3 t = translation.empty() ? vec3(0) : translation[i];
        const vec4 r = rotation.empty() ? vec4(0, 0, 0, 1) : rotation[i];
        const vec3 s = scale.empty() ? vec3(1) : scale[i];
        transforms[i] = compose(glm::dvec3(t), glm::dquat(r.w, r.x, r.y, r.z), glm::dvec3(s));
        if (!isFinite(mat4(transforms[i]))) return invalid(path, "instance " + std::to_string(i) + " is not finite");
    }
    return transforms;
}

std::vector<int> parentsOf(const Json& nodes)
{
    std::vector<int> parents(nodes.size(), -1);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        for (const Json& child : member(nodes[i], "children")) parents[child.get<std::size_t>()] = int(i);
    }
    return parents;
}

const Json& activeScene(const SourceDocument& document)
{
    return element(document.json, "scenes", activeSceneIndex(document));
}

Result<std::vector<NodeState>> walkNodes(const SourceDocument& document, const AnimatedThings& animated,
                                         FileSettings& file, std::vector<std::string>& warnings)
{
    const Json& nodes = member(document.json, "nodes");
    std::vector<int> roots;
    if (const Json& scene = activeScene(document); !scene.is_null()) {
        for (const Json& root : member(scene, "nodes")) roots.push_back(root.get<int>());
    } else {
        const std::vector<int> parents = parentsOf(nodes);
        for (std::size_t i = 0; i < parents.size(); ++i) {
            if (parents[i] < 0) roots.push_back(int(i));
        }
    }

    // A stack, not recursion: hierarchies may be as deep as the file is long.
    std::vector<bool> visited(nodes.size(), false);
    std::vector<NodeState> states;
    struct Pending {
        int node;
        int parent; ///< index into states, -1 none
    };
    std::vector<Pending> stack;
    for (auto it = roots.rbegin(); it != roots.rend(); ++it) stack.push_back({*it, -1});
    while (!stack.empty()) {
        const Pending pending = stack.back();
        stack.pop_back();
        const auto index = std::size_t(pending.node);
        if (visited[index]) continue; // a root listed twice
        visited[index] = true;
        const Json& json = nodes[index];
        const std::string path = pathOf("nodes", index);
        NodeState state;
        if (pending.parent >= 0) {
            const NodeState& parent = states[std::size_t(pending.parent)];
            state.worldFromNode = parent.worldFromNode;
            state.visible = parent.visible;
            state.animated = parent.animated;
            state.isStaticExtras = parent.isStaticExtras;
            state.isStaticFile = parent.isStaticFile;
            state.settings.group = parent.settings.group;
        }
        state.node = pending.node;
        state.name = stringOf(json, "name");
        if (state.name.empty()) state.name = "node " + std::to_string(index);
        const auto local = localTransform(json, path);
        if (!local) return local.error();
        state.worldFromNode = state.worldFromNode * *local;
        if (!isFinite(mat4(state.worldFromNode))) return invalid(path, "world transform is not finite");
        const Json& visible = member(extensionOf(json, "KHR_node_visibility"), "visible");
        if (visible.is_boolean()) state.visible = state.visible && visible.get<bool>();
        state.animated = state.animated || animated.movedNodes[index];
        state.morphed = animated.morphedNodes[index];

        const Json& extras = member(json, "extras");
        const auto authored = objectSettingsOf(extras, path);
        if (!authored) return authored.error();
        warnUnknownExtras(extras, ExtrasOwner::Node, path, warnings);
        ObjectSettings fromFile;
        for (auto& rule : file.nodes) {
            if (!matchesPattern(rule.pattern, state.name)) continue;
            rule.matched = true;
            fromFile = mergeSettings(fromFile, rule.settings);
        }
        if (authored->isStatic) state.isStaticExtras = authored->isStatic;
        if (fromFile.isStatic) state.isStaticFile = fromFile.isStatic;
        const auto record = bakedRecord(json, path);
        if (!record) return record.error();
        state.settings = mergeSettings(mergeSettings(mergeSettings(state.settings, *authored), *record), fromFile);
        state.settings.isStatic = state.isStaticFile ? state.isStaticFile
                                  : record->isStatic ? record->isStatic
                                                     : state.isStaticExtras;

        states.push_back(std::move(state));
        const Json& children = member(json, "children");
        for (std::size_t c = children.size(); c-- > 0;)
            stack.push_back({children[c].get<int>(), int(states.size()) - 1});
    }
    return states;
}

} // namespace halflight
