#include "scene/write/write_baked.h"
#include "halflight/base/file.h"
#include "halflight/base/file_group.h"
#include "halflight/base/parallel.h"
#include "halflight/scene/gltf.h"
#include "scene/document/erase_extension.h"
#include "scene/document/uri.h"
#include "scene/format/at_bake.h"
#include "scene/format/lightmap_layout.h"
#include "scene/format/limits.h"
#include "scene/read/looks/emission_unit.h"
#include "scene/read/read_baked.h"
#include "scene/settings/settings.h"
#include "scene/write/make_document.h"
#include "scene/write/write_bake_pictures.h"
#include "scene/write/write_lights.h"
#include "scene/write/write_meshes.h"
#include "scene/write/write_pictures.h"
#include "scene/write/write_probes.h"
#include "scene/write/write_reflections.h"

#include <algorithm>
#include <cctype>

namespace halflight {
namespace {
constexpr const char* kRootExtension = "HALFLIGHT_mixed_lighting";
constexpr const char* kNodeExtension = "HALFLIGHT_node";
constexpr const char* kMaterialExtension = "HALFLIGHT_material";

class Writer {
public:
    Writer(const BakedScene& baked, const WriteOptions& options)
        : baked_(baked), scene_(baked.scene), options_(options), source_(*baked.scene.source), patcher_(source_),
          pictures_(patcher_, source_), atBake_(baked.scene), layouts_(fileLayouts(scene_, source_)),
          meshes_(patcher_, source_, scene_, layouts_)
    {}

    /// `imagePrefix`: see DocumentPatcher::finish().
    Result<FinishedDocument> write(const std::string& imagePrefix)
    {
        removeEarlierBake();
        if (Status s = writeBakePictures(pictures_, baked_, options_, root_, bytes_); !s) return s.error();
        writeMaterials();
        if (Status s = writeObjects(); !s) return s.error();
        meshes_.finish();
        if (Status s = writeLights(patcher_, source_, scene_); !s) return s.error();
        writeRoot();
        writeExtensionsUsed();
        return patcher_.finish(imagePrefix);
    }

    [[nodiscard]] const WrittenBytes& bytes() const { return bytes_; }

private:
    Json& nodeJson(int node) { return patcher_.json["nodes"][std::size_t(node)]; }

    void removeEarlierBake()
    {
        eraseExtension(patcher_.json, kRootExtension);
        if (!patcher_.json.contains("nodes")) return;
        for (Json& node : patcher_.json["nodes"]) {
            eraseExtension(node, kNodeExtension);
            eraseExtension(node, kLightExtension);
            if (!node.contains("extensions") || !node["extensions"].contains("EXT_mesh_gpu_instancing")) continue;
            Json& attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
            attributes.erase("_HALFLIGHT_LIGHTMAP_ST");
            attributes.erase("_HALFLIGHT_LIGHTMAP_PAGE");
        }
    }

    /// A record where something is off, and none elsewhere.
    void writeMaterials()
    {
        for (const Material& material : scene_.materials) {
            if (material.sourceMaterial < 0) continue;
            Json& json = patcher_.json["materials"][std::size_t(material.sourceMaterial)];
            eraseExtension(json, kMaterialExtension);
            if (material.castShadows && material.receiveShadows) continue;
            json["extensions"][kMaterialExtension] = {{"castShadows", material.castShadows},
                                                      {"receiveShadows", material.receiveShadows}};
            materialRecords_ = true;
        }
        writeScaledEmission(patcher_.json, scene_);
    }

    Status writeObjects()
    {
        std::map<int, std::vector<const Object*>> objectsOf; // by node
        for (const Object& object : scene_.objects) {
            if (object.sourceNode < 0 || std::size_t(object.sourceNode) >= source_.model.nodes.size()) {
                return Error{ErrorCode::InvalidArgument,
                             "object \"" + object.name + "\" has no node in the source file", ""};
            }
            objectsOf[object.sourceNode].push_back(&object);
        }
        const std::vector<std::pair<int, std::vector<const Object*>>> nodes(objectsOf.begin(), objectsOf.end());
        std::vector<std::optional<SurfaceAtBake>> surfaces(nodes.size());
        parallelFor(baked_.isBaked ? nodes.size() : 0, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) surfaces[i] = atBake_.ofObjects(nodes[i].second);
        });
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (Status s = writeNode(nodes[i].first, nodes[i].second, surfaces[i]); !s) return s;
        }
        return {};
    }

    /// `surface`: at the bake, of static objects.
    Status writeNode(int node, const std::vector<const Object*>& objects, const std::optional<SurfaceAtBake>& surface)
    {
        const Object& first = *objects[0];
        const std::string path = pathOf("nodes", std::size_t(node));
        if (first.mesh < 0) return {};
        const Mesh& mesh = scene_.meshes[std::size_t(first.mesh)];
        if (mesh.sourceMesh < 0 || std::size_t(mesh.sourceMesh) >= source_.model.meshes.size()) {
            return Error{ErrorCode::InvalidArgument, "the node's mesh does not come from the source file", path};
        }
        bool lightmapped = false;
        for (const Object* object : objects) {
            if (object->mesh != first.mesh) {
                return Error{ErrorCode::InvalidArgument, "instances of one node have different meshes", path};
            }
            lightmapped = lightmapped || object->lightmap.page >= 0;
            if (object->lightmap.page >= int(baked_.lightmaps.size())) {
                return Error{ErrorCode::InvalidArgument,
                             "refers to lightmap page " + std::to_string(object->lightmap.page) + " of " +
                                 std::to_string(baked_.lightmaps.size()),
                             path};
            }
        }
        for (const MeshPart& part : mesh.parts) {
            if (lightmapped && part.lightmapUv.size() != part.positions.size()) {
                return Error{ErrorCode::InvalidArgument, "has a lightmap but its mesh no lightmap coordinates", path};
            }
            if (lightmapped && part.lightmapTexCoord != mesh.parts[0].lightmapTexCoord) {
                return Error{ErrorCode::InvalidArgument,
                             "the parts of its mesh have their lightmap coordinates in different TEXCOORD_n", path};
            }
        }
        Json record = {
            {"static", first.isStatic}, {"castShadows", first.castShadows}, {"receiveShadows", first.receiveShadows}};
        if (first.lightmapScale != 1.0f) record["lightmapScale"] = first.lightmapScale;
        if (first.twoSided != TwoSided::Automatic) record["twoSided"] = first.twoSided == TwoSided::On;
        if (first.probeLighting != ProbeLighting::Automatic)
            record["probes"] = first.probeLighting == ProbeLighting::Volume ? "volume" : "single";
        if (const ivec3 texels = first.probeResolution; texels != ivec3(0))
            record["probeResolution"] = {texels.x, texels.y, texels.z};
        if (surface) record["atBake"] = surface->json();
        const bool instanced = first.sourceInstance >= 0;
        const int texCoord = mesh.parts.empty() ? 1 : mesh.parts[0].lightmapTexCoord;
        const LightmapBinding binding = layouts_[std::size_t(first.mesh)].binding(first.lightmap);
        if (lightmapped && !instanced) {
            record["lightmap"] = {{"page", binding.page},
                                  {"scale", numbers(binding.scale)},
                                  {"offset", numbers(binding.offset)},
                                  {"texCoord", texCoord}};
            ++lightmappedNodes_;
        } else if (lightmapped) {
            record["lightmap"] = {{"perInstance", true}, {"texCoord", texCoord}};
            ++lightmappedNodes_;
            writeInstances(node, objects);
        }
        nodeJson(node)["extensions"][kNodeExtension] = std::move(record);

        // A mesh without lightmap coordinates stays as the source has it, with its skin, whatever its shape in the
        // scene.
        const bool isPatched = std::any_of(mesh.parts.begin(), mesh.parts.end(),
                                           [](const MeshPart& part) { return !part.lightmapUv.empty(); });
        return isPatched ? meshes_.setNodeMesh(node, first.mesh) : Status();
    }

    void writeInstances(int node, const std::vector<const Object*>& objects)
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
        Json& attributes = nodeJson(node)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        attributes["_HALFLIGHT_LIGHTMAP_ST"] =
            patcher_.addAccessor({{"componentType", TINYGLTF_COMPONENT_TYPE_FLOAT}, {"count", count}, {"type", "VEC4"}},
                                 NewView{bytesOf(st)});
        attributes["_HALFLIGHT_LIGHTMAP_PAGE"] = patcher_.addAccessor(
            {{"componentType", TINYGLTF_COMPONENT_TYPE_FLOAT}, {"count", count}, {"type", "SCALAR"}},
            NewView{bytesOf(page)});
    }

    void writeRoot()
    {
        root_["version"] = baked_.maskLayers > 1 ? kLayeredVersion : kFormatVersion;
        if (baked_.maskLayers > 1) root_["shadowmaskLayers"] = baked_.maskLayers;
        root_["mode"] = nameOf(baked_.mode);
        if (scene_.originMeters != dvec3(0.0)) root_["origin"] = numbers(scene_.originMeters);
        if (baked_.isBaked) root_["atBake"].update(atBake_.sceneJson(lightmappedNodes_));
        if (std::any_of(baked_.maskChannels.begin(), baked_.maskChannels.end(),
                        [](const MaskChannel& c) { return c.rangeTexels > 0.0f; })) {
            for (int c = 0; c < baked_.maskLayers * kLayerChannels; ++c) {
                const MaskChannel& channel = baked_.maskChannels[std::size_t(c)];
                Json json = {{"encoding", channel.rangeTexels > 0.0f ? "distance" : "attenuation"}};
                if (channel.rangeTexels > 0.0f) {
                    json["rangeTexels"] = channel.rangeTexels;
                    json["penumbraTexels"] = channel.penumbraTexels;
                }
                root_["shadowmaskChannels"].push_back(std::move(json));
            }
        }
        if (baked_.lightmapUnitLux != 1.0f) root_["lightmapUnitLux"] = baked_.lightmapUnitLux;
        root_["subtractiveShadowColor"] = numbers(subtractiveShadowColor(baked_));
        root_["shadowColorFromBake"] = !scene_.subtractiveShadowColor.has_value();
        if (!scene_.probePositions.empty()) {
            for (const vec3& p : scene_.probePositions)
                root_["authoredProbes"].push_back(numbers(scene_.originMeters + dvec3(p)));
        }
        for (const mat4& box : scene_.reflectionBoxes) root_["authoredReflectionProbes"].push_back(numbersOf(box));
        writeMark();
        if (Json probes = probesJson(patcher_, baked_.probes, baked_.maskLayers, bytes_.probes); !probes.is_null())
            root_["probes"] = std::move(probes);
        if (baked_.isBaked) root_["atBake"]["members"] = membersOfBake(root_);
        patcher_.json["extensions"][kRootExtension] = std::move(root_);
    }

    /// In the scene's extras, which tools keep that drop extensions they do not know.
    void writeMark()
    {
        if (!baked_.isBaked || !patcher_.json.contains("scenes")) return;
        Json& scene = patcher_.json["scenes"][std::size_t(std::max(0, source_.model.defaultScene))];
        if (scene.contains("extras") && !scene["extras"].is_object()) return;
        scene["extras"][kBakeMark] = std::string(nameOf(baked_.mode)) + ", " + std::to_string(lightmappedNodes_) +
                                     " lightmapped objects, " + std::to_string(baked_.lightmaps.size()) +
                                     " lightmap pages, " + std::to_string(baked_.probes.probes.size()) + " probes";
    }

    void writeExtensionsUsed()
    {
        std::set<std::string> used;
        for (const Json& name : member(patcher_.json, "extensionsUsed"))
            if (name.is_string() && !name.get<std::string>().starts_with("HALFLIGHT_"))
                used.insert(name.get<std::string>());
        used.insert(kRootExtension);
        if (!scene_.objects.empty()) used.insert(kNodeExtension);
        if (materialRecords_) used.insert(kMaterialExtension);
        for (const Light& light : scene_.lights)
            used.insert({kLightExtension, isAreaLight(light.type) ? "EXT_lights_area" : "KHR_lights_punctual"});
        used.insert(pictures_.extensions().begin(), pictures_.extensions().end());
        patcher_.json["extensionsUsed"] = used;
        patcher_.json["asset"]["generator"] = options_.generator;
    }

    const BakedScene& baked_;
    const Scene& scene_;
    const WriteOptions& options_;
    const SourceDocument& source_;
    DocumentPatcher patcher_;
    PictureWriter pictures_;
    AtBake atBake_;
    std::vector<FileLayout> layouts_; // by scene mesh
    MeshWriter meshes_;
    WrittenBytes bytes_;
    Json root_;
    std::size_t lightmappedNodes_ = 0;
    bool materialRecords_ = false; // any material got one
};

} // namespace

bool isSeparate(const std::filesystem::path& output)
{
    std::string extension = output.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return extension == ".gltf";
}

Result<FinishedDocument> bakedDocument(const BakedScene& baked, const WriteOptions& options,
                                       const std::string& imagePrefix, WrittenBytes& written)
{
    if (Status status = checkBakedValues(baked); !status)
        return Error{ErrorCode::InvalidArgument, status.error().message + " and is not written", status.error().object};
    BakedScene withSource;
    if (!baked.scene.source) {
        withSource = baked;
        if (Status s = giveSourceDocument(withSource.scene); !s) return s.error();
    }
    Writer writer(baked.scene.source ? baked : withSource, options);
    Result<FinishedDocument> document = writer.write(imagePrefix);
    written = writer.bytes();
    return document;
}

Status writeBakedScene(const std::filesystem::path& path, const BakedScene& baked, const WriteOptions& options)
{
    const bool separate = isSeparate(path);
    const std::string stem = path.stem().string();
    WrittenBytes written;
    Result<FinishedDocument> document =
        bakedDocument(baked, options, separate ? stem + kImageInfix : std::string(), written);
    if (!document) return document.error();
    if (!separate) {
        const auto glb = makeGlb(document->json, document->binary);
        if (!glb) return glb.error();
        written.file = glb->size();
        if (options.written != nullptr) *options.written = written;
        return writeFileAtomically(path, glb->data(), glb->size(), options.mayReplace);
    }
    if (options.mayReplace && !options.mayReplace()) return writingCancelled();
    FileGroup files; // the document comes last, when all that it names is there
    for (const FinishedDocument::File& image : document->images) {
        written.file += image.bytes.size();
        if (Status s = files.add(path.parent_path() / image.name, image.bytes.data(), image.bytes.size()); !s) return s;
    }
    if (!document->binary.empty()) {
        document->json["buffers"][0]["uri"] = percentEncoded(stem + ".bin");
        written.file += document->binary.size();
        const std::vector<std::byte>& binary = document->binary;
        if (Status s = files.add(path.parent_path() / (stem + ".bin"), binary.data(), binary.size()); !s) return s;
    }
    const std::string text = textOf(document->json);
    written.file += text.size();
    if (options.written != nullptr) *options.written = written;
    if (Status s = files.add(path, text); !s) return s;
    return files.commit();
}

} // namespace halflight
