#include "scene/write/write_baked.h"
#include "halflight/base/file.h"
#include "halflight/base/file_group.h"
#include "halflight/scene/gltf.h"
#include "scene/document/erase_extension.h"
#include "scene/document/uri.h"
#include "scene/format/limits.h"
#include "scene/read/looks/emission_unit.h"
#include "scene/read/read_baked.h"
#include "scene/settings/settings.h"
#include "scene/write/make_document.h"
#include "scene/write/meshes/variant_groups.h"
#include "scene/write/write_bake_pictures.h"
#include "scene/write/write_groups.h"
#include "scene/write/write_lights.h"
#include "scene/write/write_nodes.h"
#include "scene/write/write_pictures.h"
#include "scene/write/write_probes.h"
#include "scene/write/write_reflections.h"

#include <algorithm>
#include <cctype>

namespace halflight {
namespace {
constexpr const char* kRootExtension = "HALFLIGHT_mixed_lighting";

class Writer {
public:
    Writer(const BakedScene& baked, const WriteOptions& options)
        : baked_(baked), scene_(baked.scene), options_(options), source_(*baked.scene.source), patcher_(source_),
          pictures_(patcher_, source_), atBake_(baked.scene), nodes_(patcher_, source_, baked, atBake_, fileMaterials_)
    {}

    /// `imagePrefix`: see DocumentPatcher::finish().
    Result<FinishedDocument> write(const std::string& imagePrefix)
    {
        removeEarlierBake();
        if (Status s = writeBakePictures(pictures_, baked_, options_, root_, bytes_); !s) return s.error();
        writeMaterials();
        if (Status s = nodes_.write(); !s) return s.error();
        if (Status s = writeLights(patcher_, source_, scene_); !s) return s.error();
        writeRoot();
        writeExtensionsUsed();
        return patcher_.finish(imagePrefix);
    }

    [[nodiscard]] const WrittenBytes& bytes() const { return bytes_; }

private:
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

    /// The file's material of each scene material. Scene materials of one source, of different light groups, have a
    /// copy each but for the first.
    std::vector<int> copyMaterials()
    {
        std::vector<int> inFile;
        std::set<int> taken;
        for (const Material& material : scene_.materials) {
            const int source = material.sourceMaterial;
            const bool copied = source >= 0 && !taken.insert(source).second;
            inFile.push_back(copied ? patcher_.append("materials", source_.json["materials"][std::size_t(source)])
                                    : source);
        }
        return inFile;
    }

    /// A record where something is off, or the material is tinted or of a light group, and none elsewhere.
    void writeMaterials()
    {
        fileMaterials_ = copyMaterials();
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            const Material& material = scene_.materials[i];
            if (material.sourceMaterial < 0) continue;
            Json& json = patcher_.json["materials"][std::size_t(fileMaterials_[i])];
            eraseExtension(json, kMaterialExtension);
            const bool plain = material.castShadows && material.receiveShadows && !material.tinted;
            if (plain && material.group.empty() && material.bakedGroup < 0) continue;
            Json& record = json["extensions"][kMaterialExtension];
            record = {{"castShadows", material.castShadows}, {"receiveShadows", material.receiveShadows}};
            if (material.tinted) record["tinted"] = true;
            if (!material.group.empty()) record["group"] = material.group;
            if (material.bakedGroup >= 0)
                record["baking"] = {{"group", material.bakedGroup}, {"white", numbers(material.whiteNits)}};
            materialRecords_ = true;
        }
        writeScaledEmission(patcher_.json, scene_);
        writeChangedEmission(patcher_.json, scene_, fileMaterials_);
    }

    void writeRoot()
    {
        const bool layered = baked_.maskLayers > 1 || !baked_.groups.empty() || hasColoredMasks(scene_);
        root_["version"] = layered ? kLayeredVersion : kFormatVersion;
        if (baked_.maskLayers > 1) root_["shadowmaskLayers"] = baked_.maskLayers;
        root_["mode"] = nameOf(baked_.mode);
        if (scene_.originMeters != dvec3(0.0)) root_["origin"] = numbers(scene_.originMeters);
        if (baked_.isBaked) root_["atBake"].update(atBake_.sceneJson(nodes_.lightmapped()));
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
        root_["subtractiveShadowColor"] = numbers(scene_.subtractiveShadowColor.value_or(baked_.defaultShadowColor));
        root_["shadowColorFromBake"] = !scene_.subtractiveShadowColor.has_value();
        if (!scene_.probePositions.empty()) {
            for (const vec3& p : scene_.probePositions)
                root_["authoredProbes"].push_back(numbers(scene_.originMeters + dvec3(p)));
        }
        for (const mat4& box : scene_.reflectionBoxes) root_["authoredReflectionProbes"].push_back(numbersOf(box));
        writeMark();
        if (Json probes = probesJson(patcher_, baked_.probes, baked_.maskLayers, bytes_.probes); !probes.is_null())
            root_["probes"] = std::move(probes);
        writeGroupProbes(patcher_, baked_, root_, bytes_);
        if (baked_.isBaked) root_["atBake"]["members"] = membersOfBake(root_);
        patcher_.json["extensions"][kRootExtension] = std::move(root_);
    }

    /// In the scene's extras, which tools keep that drop extensions they do not know.
    void writeMark()
    {
        if (!baked_.isBaked || !patcher_.json.contains("scenes")) return;
        Json& scene = patcher_.json["scenes"][std::size_t(activeSceneIndex(source_))];
        if (scene.contains("extras") && !scene["extras"].is_object()) return;
        scene["extras"][kBakeMark] = std::string(nameOf(baked_.mode)) + ", " + std::to_string(nodes_.lightmapped()) +
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
    std::vector<int> fileMaterials_; ///< by Scene::materials
    NodeWriter nodes_;
    WrittenBytes bytes_;
    Json root_;
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
