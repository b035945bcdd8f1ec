#include "scene/read/read_scene.h"

#include "halflight/base/parallel.h"
#include "halflight/base/text.h"
#include "halflight/scene/light_groups.h"
#include "scene/format/limits.h"
#include "scene/format/recorded_origin.h"
#include "scene/load/extensions.h"
#include "scene/load/load_document.h"
#include "scene/model/origin.h"
#include "scene/read/advice.h"
#include "scene/read/geometry/nodes.h"
#include "scene/read/geometry/read_mesh.h"
#include "scene/read/geometry/skin.h"
#include "scene/read/looks/emission_unit.h"
#include "scene/read/looks/read_lights.h"
#include "scene/read/looks/read_materials.h"
#include "scene/read/looks/read_sky.h"
#include "scene/read/read_reflections.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace halflight {

namespace {
// What makes the shape of a node's mesh: nodes that agree in all of it share a scene mesh.
struct MeshKey {
    int mesh = -1;
    std::vector<double> weights; // of morph targets; LLVM's vectors have no <=> before 17
    int skinnedNode = -1;        // joints place its vertices: a mesh of its own
    bool operator<(const MeshKey& o) const
    {
        return std::tie(mesh, weights, skinnedNode) < std::tie(o.mesh, o.weights, o.skinnedNode);
    }
};

MeshKey meshKey(const SourceDocument& document, int nodeIndex)
{
    const Json& node = element(document.json, "nodes", nodeIndex);
    const int mesh = integerOf(node, "mesh");
    const Json& own = member(node, "weights");
    const Json& weights = own.empty() ? member(element(document.json, "meshes", mesh), "weights") : own;
    return {mesh, {weights.begin(), weights.end()}, isSkinned(document, nodeIndex) ? nodeIndex : -1};
}

/// A node's shape in the scene.
struct NodeMesh {
    int mesh = -1;                             // in the scene; -1 = nothing to be lit
    std::optional<glm::dmat4> worldFromObject; // of skinned ones; others are where their node is
};

/// Where the parts of a scene go while its local origin is not known yet.
struct Placement {
    std::vector<glm::dvec3> meshOffset; ///< by Scene::meshes: what centreMesh() took off the positions
    std::vector<Bounds> meshBounds;     ///< by Scene::meshes
    std::vector<glm::dmat4> fromObject; ///< by Scene::objects: transform to the file's world
};

// Meshes that shown nodes use, in the file's order, all cores at work. Returns the mesh of each state.
Result<std::vector<NodeMesh>> readMeshes(const SourceDocument& document, const std::vector<NodeState>& nodes,
                                         const std::atomic<bool>* cancel, Scene& scene, Placement& placement)
{
    std::map<MeshKey, NodeMesh> meshes;
    bool anySkin = false;
    std::vector<std::pair<const MeshKey, NodeMesh>*> ofNode(nodes.size(), nullptr); // by state, in `meshes`
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].visible || !element(document.json, "nodes", nodes[i].node).contains("mesh")) continue;
        ofNode[i] = &*meshes.try_emplace(meshKey(document, nodes[i].node)).first;
        anySkin = anySkin || ofNode[i]->first.skinnedNode >= 0;
    }
    std::vector<glm::dmat4> worldFromNode;
    if (anySkin) {
        auto transforms = worldTransforms(document);
        if (!transforms) return transforms.error();
        worldFromNode = std::move(*transforms);
    }
    std::vector<std::pair<const MeshKey, NodeMesh>*> used;
    for (auto& item : meshes) used.push_back(&item);
    std::vector<std::optional<Result<MeshRead>>> reads(used.size());
    parallelFor(used.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (cancel != nullptr && *cancel) {
                reads[i] = cancelledError();
                continue;
            }
            const MeshKey& key = used[i]->first;
            reads[i] = readMesh(document, key.mesh, key.weights, scene.materials);
            if (key.skinnedNode < 0 || !*reads[i] || (*reads[i])->mesh.parts.empty()) continue;
            auto placed = skinMesh(document, key.skinnedNode, worldFromNode, (*reads[i])->mesh, (*reads[i])->warnings);
            if (placed) {
                used[i]->second.worldFromObject = *placed;
            } else {
                reads[i] = placed.error();
            }
        }
    });
    std::size_t flatParts = 0;
    std::size_t tangentParts = 0;
    std::set<std::string> said; // shapes of one mesh warn of the same
    for (std::size_t i = 0; i < used.size(); ++i) {
        Result<MeshRead>& read = *reads[i];
        if (!read) return read.error();
        for (std::string& warning : read->warnings) {
            if (said.insert(warning).second) scene.warnings.push_back(std::move(warning));
        }
        flatParts += read->flatParts;
        tangentParts += read->tangentParts;
        if (read->mesh.parts.empty()) continue;
        used[i]->second.mesh = int(scene.meshes.size());
        placement.meshOffset.push_back(centreMesh(read->mesh));
        if (auto coarse = coarseVerticesWarning(read->mesh, placement.meshOffset.back()); !coarse.empty())
            scene.warnings.push_back(std::move(coarse));
        placement.meshBounds.push_back(boundsOf(read->mesh));
        scene.meshes.push_back(std::move(read->mesh));
    }
    if (flatParts > 0)
        scene.warnings.push_back(std::to_string(flatParts) + " primitives without normals got flat ones");
    if (tangentParts > 0)
        scene.warnings.push_back(std::to_string(tangentParts) + " normal-mapped primitives got generated tangents");
    std::vector<NodeMesh> ofState(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (ofNode[i] != nullptr) ofState[i] = ofNode[i]->second;
    }
    return ofState;
}

// The corners of its bounds tell for nearly every object; vertices are looked at where a corner is too far.
bool reachesTooFar(const Mesh& mesh, const Bounds& bounds, const glm::dmat4& fromObject, double limit)
{
    const WideBounds box = transformedBounds(bounds, fromObject);
    if (box.empty() || !(tooFar(box.min, limit) || tooFar(box.max, limit))) return false;
    const auto far = [&](vec3 p) { return tooFar(glm::dvec3(fromObject * glm::dvec4(glm::dvec3(p), 1.0)), limit); };
    return std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        return std::any_of(part.positions.begin(), part.positions.end(), far);
    });
}

// Finds the scene's local origin (a baked file brings its own) and makes objects and nodes relative to it.
Status placeScene(const SourceDocument& document, std::vector<NodeState>& nodes, const Placement& placement,
                  Scene& scene)
{
    const auto reaches = [&](std::size_t i, double limit) {
        const auto mesh = std::size_t(scene.objects[i].mesh);
        return reachesTooFar(scene.meshes[mesh], placement.meshBounds[mesh], placement.fromObject[i], limit);
    };
    const auto refused = [&](std::size_t i, const std::string& where) {
        const Object& object = scene.objects[i];
        return invalid(pathOf("nodes", std::size_t(object.sourceNode)),
                       "\"" + object.name + "\" reaches farther than " + where);
    };
    std::vector<WideBounds> boxes;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        if (reaches(i, kFarthestFromWorldMeters)) return refused(i, "16777 km from the world's origin");
        boxes.push_back(
            transformedBounds(placement.meshBounds[std::size_t(scene.objects[i].mesh)], placement.fromObject[i]));
    }
    const auto recorded = recordedOrigin(document);
    if (!recorded) return recorded.error();
    scene.originMeters = localOrigin(boxes, *recorded);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        glm::dmat4 local = placement.fromObject[i];
        local[3] -= glm::dvec4(scene.originMeters, 0.0);
        const auto mesh = std::size_t(scene.objects[i].mesh);
        if (reachesTooFar(scene.meshes[mesh], placement.meshBounds[mesh], local, kFarthestMeters))
            return refused(i, "10000 km from the scene's middle");
        scene.objects[i].worldFromObject = mat4(local);
    }
    for (NodeState& state : nodes) state.worldFromNode[3] -= glm::dvec4(scene.originMeters, 0.0);
    if (std::string warning = coarseObjectsWarning(scene); !warning.empty())
        scene.warnings.push_back(std::move(warning));
    return {};
}

Status addObjects(const SourceDocument& document, const NodeState& state, const NodeMesh& placed, Scene& scene,
                  Placement& placement)
{
    const Json& json = element(document.json, "nodes", state.node);
    const bool hasSkin = json.contains("skin");
    const std::string path = pathOf("nodes", std::size_t(state.node));
    Object object;
    object.name = state.name;
    object.mesh = placed.mesh;
    const glm::dmat4 worldFromShape = placed.worldFromObject.value_or(state.worldFromNode);
    const bool moves = state.animated || state.morphed || hasSkin;
    object.isStatic = state.settings.isStatic.value_or(!moves);
    if (object.isStatic && moves)
        scene.warnings.push_back(path + ": " + state.name + " moves, but is static by its settings");
    if (hasSkin && !placed.worldFromObject) {
        scene.warnings.push_back(path + ": " + state.name +
                                 " has a skin, but instances or no joints and weights: it is where its node is");
    }
    object.castShadows = state.settings.castShadows.value_or(true);
    object.receiveShadows = state.settings.receiveShadows.value_or(true);
    object.lightmapScale = state.settings.lightmapScale.value_or(1.0f);
    if (state.settings.twoSided) object.twoSided = *state.settings.twoSided ? TwoSided::On : TwoSided::Off;
    object.probeLighting = state.settings.probeLighting.value_or(ProbeLighting::Automatic);
    object.probeResolution = state.settings.probeResolution.value_or(ivec3(0));
    object.sourceNode = state.node;
    const glm::dmat4 fromCentred = glm::translate(glm::dmat4(1.0), placement.meshOffset[std::size_t(placed.mesh)]);
    if (extensionOf(json, "EXT_mesh_gpu_instancing").is_null()) {
        placement.fromObject.push_back(worldFromShape * fromCentred);
        scene.objects.push_back(std::move(object));
        return {};
    }
    const auto instances = instanceTransforms(document, state.node);
    if (!instances) return instances.error();
    for (std::size_t i = 0; i < instances->size(); ++i) {
        Object instance = object;
        instance.name += " #" + std::to_string(i);
        placement.fromObject.push_back(state.worldFromNode * (*instances)[i] * fromCentred);
        instance.sourceInstance = int(i);
        instance.probeGroup = state.node;
        scene.objects.push_back(std::move(instance));
    }
    return {};
}

Status applySceneSettings(const SourceDocument& document, const FileSettings& file, const ReadOptions& options,
                          Scene& scene)
{
    const Json& json = activeScene(document);
    const std::string path = pathOf("scenes", std::size_t(activeSceneIndex(document)));
    auto authored = sceneSettingsOf(member(json, "extras"), path);
    if (!authored) return authored.error();
    if (authored->skyImage) authored->skyImage = document.directory / *authored->skyImage;
    warnUnknownExtras(member(json, "extras"), ExtrasOwner::Scene, path, scene.warnings);
    applyEmissionUnit(document, authored->emissionUnit,
                      options.emissionUnit ? options.emissionUnit : file.scene.emissionUnit, scene);

    // An earlier bake's record stands between extras and the settings file, as for nodes and lights.
    SceneSettings record = recordedSky(document);
    const Json& root = extensionOf(document.json, "HALFLIGHT_mixed_lighting");
    // Not the author's: what a bake chose, and black in files that do not say whose it is.
    const Json& shadow = member(root, "subtractiveShadowColor");
    const Json& fromBake = member(root, "shadowColorFromBake");
    const bool authoredShadow = fromBake.is_boolean() ? !fromBake.get<bool>() : shadow != Json::array({0, 0, 0});
    if (shadow.is_array() && authoredShadow) {
        const auto settings =
            sceneSettingsOf(Json{{"halflight_shadow_color", shadow}}, "/extensions/HALFLIGHT_mixed_lighting");
        if (!settings) return settings.error();
        record.shadowColor = settings->shadowColor;
    }
    if (const Json& probes = member(root, "authoredProbes"); probes.is_array()) {
        const auto settings =
            sceneSettingsOf(Json{{"halflight_probes", probes}}, "/extensions/HALFLIGHT_mixed_lighting");
        if (!settings) return settings.error();
        record.probes = settings->probes;
    }

    const SceneSettings settings = mergeSettings(mergeSettings(*authored, record), file.scene);
    auto sky = readSky(document, settings, scene.warnings);
    if (!sky) return sky.error();
    scene.sky = std::move(*sky);
    scene.sky.group = settings.skyGroup.value_or(std::string());
    scene.sky.changes = settings.skyChanges.value_or(false);
    scene.subtractiveShadowColor = settings.shadowColor;
    for (const glm::dvec3& p : settings.probes.value_or(std::vector<glm::dvec3>())) {
        if (tooFar(p - scene.originMeters))
            return invalid(path, "a light probe lies farther than 10000 km from the scene's middle");
        scene.probePositions.emplace_back(p - scene.originMeters);
    }

    // A plain model with nothing that shines would bake to black.
    const bool skyAuthored = scene.sky.picture || settings.skyZenith || settings.skyHorizon || settings.skyGround;
    const std::vector<std::string> advice = adviceFor(scene, document.json, skyAuthored);
    scene.warnings.insert(scene.warnings.end(), advice.begin(), advice.end());
    bool emits = false;
    for (const Object& object : scene.objects) {
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            emits = emits || materialOf(scene, part).emissiveNits != vec3(0.0f);
        }
    }
    if (!skyAuthored && scene.lights.empty() && !emits) {
        scene.sky.zenith = scene.sky.horizon = vec3(1.0f);
        scene.sky.ground = vec3(0.5f);
        scene.warnings.push_back(
            "the file has no light, no emissive material and no sky: it gets a white sky of 1 cd/m2");
    }
    return {};
}

// [[add_light]] of the settings file. A light that an earlier bake with the same file added is replaced, not doubled.
void addLights(const SourceDocument& document, const FileSettings& file, Scene& scene)
{
    for (const auto& [authored, position] : file.addedLights) {
        Light added = authored;
        added.worldFromLight[3] = vec4(vec3(position - scene.originMeters), 1.0f);
        const auto isSame = [&](const Light& light) {
            const Json& node = element(document.json, "nodes", light.sourceNode);
            const Json& flag = member(extensionOf(node, "HALFLIGHT_light"), "added");
            return light.name == added.name && flag.is_boolean() && flag.get<bool>();
        };
        const auto earlier = std::find_if(scene.lights.begin(), scene.lights.end(), isSame);
        if (earlier != scene.lights.end()) {
            const int node = earlier->sourceNode;
            const BakingOutput baking = earlier->baking; // what the bake made of it stays, whatever the file says now
            *earlier = added;
            earlier->sourceNode = node;
            earlier->baking = baking;
        } else {
            scene.lights.push_back(added);
        }
    }
}

} // namespace

Result<Scene> sceneFromDocument(std::shared_ptr<const SourceDocument> document, const ReadOptions& options)
{
    FileSettings file;
    if (!options.settingsFile.empty()) {
        auto settings = readSettingsFile(options.settingsFile);
        if (!settings) return settings.error();
        file = std::move(*settings);
    }
    Scene scene;
    scene.source = document;
    scene.name = stringOf(activeScene(*document), "name");

    auto materials = readMaterials(*document, file, options);
    if (!materials) return materials.error();
    scene.materials = std::move(materials->materials);
    scene.textures = std::move(materials->textures);
    scene.warnings = document->warnings;
    scene.warnings.insert(scene.warnings.end(), materials->warnings.begin(), materials->warnings.end());

    const std::vector<std::string> ofExtensions = extensionWarnings(document->json);
    scene.warnings.insert(scene.warnings.end(), ofExtensions.begin(), ofExtensions.end());

    const AnimatedThings animated = animatedThings(*document);
    auto nodes = walkNodes(*document, animated, file, scene.warnings);
    if (!nodes) return nodes.error();
    Placement placement;
    const auto nodeMeshes = readMeshes(*document, *nodes, options.cancel, scene, placement);
    if (!nodeMeshes) return nodeMeshes.error();
    std::vector<std::string> groups; // light groups, by object
    for (std::size_t i = 0; i < nodes->size(); ++i) {
        if ((*nodeMeshes)[i].mesh < 0) continue;
        if (Status s = addObjects(*document, (*nodes)[i], (*nodeMeshes)[i], scene, placement); !s) return s.error();
        groups.resize(scene.objects.size(), (*nodes)[i].settings.group.value_or(std::string()));
    }
    if (Status s = placeScene(*document, *nodes, placement, scene); !s) return s.error();
    groupEmission(scene, groups);
    for (const NodeState& state : *nodes) {
        if (state.visible) {
            auto light = readLight(*document, state, scene.originMeters, animated, file, scene.warnings);
            if (!light) return light.error();
            if (*light) scene.lights.push_back(std::move(**light));
        }
        if (auto camera = readCamera(*document, state, scene.warnings)) scene.cameras.push_back(std::move(*camera));
    }
    if (Status s = readReflectionBoxes(*document, *nodes, scene); !s) return s.error();
    addLights(*document, file, scene);
    warnAnimatedMaterials(animated, scene);
    if (Status s = applySceneSettings(*document, file, options, scene); !s) return s.error();
    if (Status s = checkBrightness(scene); !s) return s.error();

    const auto warnUnmatched = [&](const auto& rules, const char* table) {
        for (const auto& rule : rules) {
            if (!rule.matched) {
                scene.warnings.push_back("settings file: the pattern \"" + rule.pattern + "\" of [[" + table +
                                         "]] matches nothing");
            }
        }
    };
    warnUnmatched(file.nodes, "node");
    warnUnmatched(file.materials, "material");
    warnUnmatched(file.lights, "light");
    return scene;
}

Result<Scene> readScene(const std::filesystem::path& path, const ReadOptions& options)
{
    auto document = loadDocument(path);
    if (!document) return document.error();
    auto scene = sceneFromDocument(std::move(*document), options);
    if (!scene) return scene;
    // readBakedScene() reads what an earlier bake found out; here only settings count.
    for (Light& light : scene->lights) light.baking = {};
    if (scene->name.empty()) scene->name = path.stem().string();
    return scene;
}

} // namespace halflight
