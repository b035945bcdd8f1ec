#include "scene/write/write_nodes.h"

#include "halflight/base/parallel.h"

#include <algorithm>

namespace halflight {
namespace {

/// What authors and settings said of a node's objects.
Json recordOf(const Object& object)
{
    Json record = {
        {"static", object.isStatic}, {"castShadows", object.castShadows}, {"receiveShadows", object.receiveShadows}};
    if (object.lightmapScale != 1.0f) record["lightmapScale"] = object.lightmapScale;
    if (object.twoSided != TwoSided::Automatic) record["twoSided"] = object.twoSided == TwoSided::On;
    if (object.probeLighting != ProbeLighting::Automatic)
        record["probes"] = object.probeLighting == ProbeLighting::Volume ? "volume" : "single";
    if (const ivec3 texels = object.probeResolution; texels != ivec3(0))
        record["probeResolution"] = {texels.x, texels.y, texels.z};
    return record;
}

} // namespace

NodeWriter::NodeWriter(DocumentPatcher& patcher, const SourceDocument& source, const BakedScene& baked,
                       const AtBake& atBake, const std::vector<int>& materials)
    : patcher_(patcher), source_(source), baked_(baked), scene_(baked.scene), atBake_(atBake),
      layouts_(fileLayouts(scene_, source_)), meshes_(patcher_, source_, baked, layouts_, materials)
{}

Status NodeWriter::write()
{
    std::map<int, Objects> objectsOf; // by node
    for (const Object& object : scene_.objects) {
        if (object.sourceNode < 0 || std::size_t(object.sourceNode) >= member(source_.json, "nodes").size()) {
            return Error{ErrorCode::InvalidArgument, "object \"" + object.name + "\" has no node in the source file",
                         ""};
        }
        objectsOf[object.sourceNode].push_back(&object);
    }
    const std::vector<std::pair<int, Objects>> nodes(objectsOf.begin(), objectsOf.end());
    std::vector<std::optional<SurfaceAtBake>> surfaces(nodes.size());
    parallelFor(baked_.isBaked ? nodes.size() : 0, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) surfaces[i] = atBake_.ofObjects(nodes[i].second);
    });
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (Status s = writeNode(nodes[i].first, nodes[i].second, surfaces[i]); !s) return s;
    }
    meshes_.finish();
    return {};
}

Status NodeWriter::check(const Objects& objects, bool lightmapped, const std::string& path) const
{
    const auto wrong = [&](const std::string& what) { return Error{ErrorCode::InvalidArgument, what, path}; };
    const Mesh& mesh = scene_.meshes[std::size_t(objects[0]->mesh)];
    if (mesh.sourceMesh < 0 || std::size_t(mesh.sourceMesh) >= member(source_.json, "meshes").size())
        return wrong("the node's mesh does not come from the source file");
    const std::size_t pages = baked_.lightmaps.size();
    for (const Object* object : objects) {
        if (object->mesh != objects[0]->mesh) return wrong("instances of one node have different meshes");
        const int page = object->lightmap.page;
        if (page >= int(pages))
            return wrong("refers to lightmap page " + std::to_string(page) + " of " + std::to_string(pages));
    }
    if (!lightmapped) return {};
    for (const MeshPart& part : mesh.parts) {
        if (part.lightmapUv.size() != part.positions.size())
            return wrong("has a lightmap but its mesh no lightmap coordinates");
        if (part.lightmapTexCoord != mesh.parts[0].lightmapTexCoord)
            return wrong("the parts of its mesh have their lightmap coordinates in different TEXCOORD_n");
    }
    return {};
}

Status NodeWriter::writeNode(int node, const Objects& objects, const std::optional<SurfaceAtBake>& surface)
{
    const Object& first = *objects[0];
    if (first.mesh < 0) return {};
    const bool lightmapped =
        std::any_of(objects.begin(), objects.end(), [](const Object* object) { return object->lightmap.page >= 0; });
    if (Status s = check(objects, lightmapped, pathOf("nodes", std::size_t(node))); !s) return s;
    Json record = recordOf(first);
    if (surface) record["atBake"] = surface->json();
    if (lightmapped) {
        record["lightmap"] = lightmapJson(node, objects);
        ++lightmapped_;
    }
    extensionsOf(node)[kNodeExtension] = std::move(record);

    // A mesh without lightmap coordinates stays as the source has it, with its skin, whatever its shape in the scene.
    const Mesh& mesh = scene_.meshes[std::size_t(first.mesh)];
    const bool isPatched = std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        return !part.lightmapUv.empty() || meshes_.isCopied(part);
    });
    return isPatched ? meshes_.setNodeMesh(node, first.mesh) : Status();
}

Json NodeWriter::lightmapJson(int node, const Objects& objects)
{
    const Object& first = *objects[0];
    const Mesh& mesh = scene_.meshes[std::size_t(first.mesh)];
    const int texCoord = mesh.parts.empty() ? 1 : mesh.parts[0].lightmapTexCoord;
    if (first.sourceInstance >= 0) {
        writeInstances(node, objects);
        return {{"perInstance", true}, {"texCoord", texCoord}};
    }
    const LightmapBinding binding = layouts_[std::size_t(first.mesh)].binding(first.lightmap);
    return {{"page", binding.page},
            {"scale", numbers(binding.scale)},
            {"offset", numbers(binding.offset)},
            {"texCoord", texCoord}};
}

void NodeWriter::writeInstances(int node, const Objects& objects)
{
    std::size_t count = 0;
    for (const Object* object : objects) count = std::max(count, std::size_t(object->sourceInstance) + 1);
    std::vector<vec4> st(count, vec4(0.0f));
    std::vector<float> page(count, -1.0f);
    for (const Object* object : objects) {
        const auto i = std::size_t(object->sourceInstance);
        const LightmapBinding binding = layouts_[std::size_t(object->mesh)].binding(object->lightmap);
        st[i] = vec4(binding.scale, binding.offset);
        page[i] = float(object->lightmap.page);
    }
    Json& attributes = extensionsOf(node)["EXT_mesh_gpu_instancing"]["attributes"];
    attributes["_HALFLIGHT_LIGHTMAP_ST"] = patcher_.addAccessor(
        {{"componentType", gltf::kFloat}, {"count", count}, {"type", "VEC4"}}, NewView{bytesOf(st)});
    attributes["_HALFLIGHT_LIGHTMAP_PAGE"] = patcher_.addAccessor(
        {{"componentType", gltf::kFloat}, {"count", count}, {"type", "SCALAR"}}, NewView{bytesOf(page)});
}

} // namespace halflight
