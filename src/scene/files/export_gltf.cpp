#include "halflight/base/file.h"
#include "halflight/base/mathematics.h"
#include "halflight/scene/export.h"
#include "scene/document/compact.h"
#include "scene/document/erase_extension.h"
#include "scene/document/texture_coordinates.h"
#include "scene/files/export_place.h"
#include "scene/format/material_sides.h"
#include "scene/load/extensions.h"
#include "scene/load/load_document.h"
#include "scene/settings/settings.h"
#include "scene/write/make_document.h"
#include "scene/write/write_baked.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace halflight {
namespace {

constexpr int kLinear = 9729; // WebGL enums, as glTF has them
constexpr int kClampToEdge = 33071;
constexpr int kLastLineMode = 3; // points and lines have modes up to here

vec2 pairOf(const Json& json, vec2 otherwise)
{
    if (!json.is_array() || json.size() != 2) return otherwise;
    return {json[0].get<float>(), json[1].get<float>()};
}

/// An extension for whose sake materials and textures keep their numbers; empty if there is none.
std::string extensionWithNumbers(const Json& document)
{
    constexpr const char* kPointers = "KHR_animation_pointer"; // names materials by their index
    const Json& used = member(document, "extensionsUsed");
    return std::find(used.begin(), used.end(), kPointers) != used.end() ? kPointers : unknownExtension(document);
}

void collectExtensions(const Json& json, std::set<std::string>& names)
{
    if (!json.is_structured()) return;
    if (json.is_object() && json.contains("extensions")) {
        for (const auto& item : json["extensions"].items()) names.insert(item.key());
    }
    for (const Json& value : json) collectExtensions(value, names);
}

class Exporter {
public:
    Exporter(const SourceDocument& source, const Scene& scene, const ExportOptions& options, ExportReport& report)
        : source_(source), options_(options), report_(report), patcher_(source),
          factor_(math::exp2(-options.exposureEv)), unknown_(extensionWithNumbers(source.json))
    {
        for (const Material& material : scene.materials) {
            if (material.sourceMaterial >= 0) materialOf_[material.sourceMaterial] = &material;
        }
    }

    Result<FinishedDocument> run(const std::vector<ImageRgba8>& pages)
    {
        stripBake();
        scaleLight(); // before the new materials are there
        if (Status s = addPages(pages); !s) return s.error();
        const std::size_t nodes = member(source_.json, "nodes").size();
        for (std::size_t i = 0; i < nodes; ++i)
            if (Status s = exportNode(i); !s) return s.error();
        closeGaps();
        if (unknown_.empty()) {
            compactDocument(patcher_.json, false);
        } else {
            report_.warnings.push_back(
                staysForExtension("materials and textures that nothing uses any more stay in the file", unknown_));
        }
        listExtensions();
        patcher_.json["asset"]["generator"] = options_.generator;
        return patcher_.finish();
    }

private:
    // Everything of Halflight's but the nodes' records, which are read from the source.
    void stripBake()
    {
        eraseExtension(patcher_.json, "HALFLIGHT_mixed_lighting");
        for (const char* array : {"nodes", "materials", "textures"}) {
            if (!patcher_.json.contains(array)) continue;
            for (Json& object : patcher_.json[array]) {
                for (const char* name :
                     {"HALFLIGHT_node", "HALFLIGHT_light", "HALFLIGHT_material", "HALFLIGHT_texture_ktx2"})
                    eraseExtension(object, name);
            }
        }
        if (patcher_.json.contains("scenes")) {
            for (Json& scene : patcher_.json["scenes"]) {
                if (!scene.contains("extras") || !scene["extras"].is_object()) continue;
                scene["extras"].erase(kBakeMark);
                if (scene["extras"].empty()) scene.erase("extras");
            }
        }
        compactDocument(patcher_.json, true); // pictures of the bake are the last
    }

    // Objects that keep their materials are seen at the same exposure as the pictures.
    void scaleLight()
    {
        if (factor_ == 1.0f) return;
        for (const auto& [name, absent] : {std::pair("KHR_lights_punctual", 1.0), {"EXT_lights_area", 1000.0}}) {
            if (!extensionOf(patcher_.json, name).is_object()) continue;
            for (Json& light : patcher_.json["extensions"][name]["lights"])
                light["intensity"] = double(factor_) * light.value("intensity", absent);
        }
        if (!patcher_.json.contains("materials")) return;
        for (Json& material : patcher_.json["materials"]) {
            const Json& emissive = member(material, "emissiveFactor");
            const bool emits = std::any_of(emissive.begin(), emissive.end(), [](const Json& c) { return c != 0; });
            if (!emits || extensionOf(material, "KHR_materials_unlit").is_object()) continue;
            Json& strength = material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"];
            strength = double(factor_) * (strength.is_number() ? strength.get<double>() : 1.0);
        }
    }

    Status addPages(const std::vector<ImageRgba8>& pages)
    {
        const int sampler = patcher_.append(
            "samplers",
            {{"magFilter", kLinear}, {"minFilter", kLinear}, {"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}});
        for (std::size_t i = 0; i < pages.size(); ++i) {
            auto png = encodePng(pages[i]);
            if (!png) return png.error();
            report_.pictures += png->size();
            const std::string name = "surfaces " + std::to_string(i);
            const int view = patcher_.addView({std::move(*png), 0, 0});
            const int image =
                patcher_.append("images", {{"name", name}, {"mimeType", "image/png"}, {"bufferView", view}});
            textures_.push_back(patcher_.append("textures", {{"name", name}, {"sampler", sampler}, {"source", image}}));
        }
        return {};
    }

    int materialFor(int page, const Material& source, bool doubleSided)
    {
        const Material::AlphaMode mode = source.isBlended() ? Material::AlphaMode::Blend : source.alphaMode;
        const auto [it, isNew] = materials_.try_emplace({page, mode, doubleSided}, -1);
        if (!isNew) return it->second;
        const Json texture = {{"index", textures_[std::size_t(page)]}};
        Json pbr = {{"metallicFactor", 0}, {"roughnessFactor", 1}};
        Json json;
        if (options_.style == ExportStyle::Unlit) {
            pbr["baseColorTexture"] = texture;
            json["extensions"]["KHR_materials_unlit"] = Json::object();
        } else {
            pbr["baseColorFactor"] = {0, 0, 0, 1};
            if (mode != Material::AlphaMode::Opaque) pbr["baseColorTexture"] = texture; // for its alpha
            json["emissiveFactor"] = {1, 1, 1};
            json["emissiveTexture"] = texture;
            json["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", options_.strength}};
            json["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0}}; // lights leave it black
        }
        json["pbrMetallicRoughness"] = std::move(pbr);
        json["name"] = "surfaces " + std::to_string(page);
        if (doubleSided) json["doubleSided"] = true;
        if (mode == Material::AlphaMode::Blend) json["alphaMode"] = "BLEND";
        // Alpha is the share of a texel that is there, so half of it is the edge, whatever the source's cutoff.
        if (mode == Material::AlphaMode::Mask) json["alphaMode"] = "MASK";
        return it->second = patcher_.append("materials", std::move(json));
    }

    // Coordinates on the page.
    Result<int> coordinates(int accessor, const ExportPlace& place)
    {
        if (place.scale == vec2(1.0f) && place.offset == vec2(0.0f)) return accessor;
        const auto [it, isNew] = coordinates_.try_emplace({accessor, place}, -1);
        if (!isNew) return it->second;
        auto uvs = readVectors<2>(source_, accessor);
        if (!uvs) return uvs.error();
        for (vec2& uv : *uvs) uv = glm::clamp(place.scale * uv + place.offset, 0.0f, 1.0f);
        it->second = patcher_.addAccessor({{"componentType", gltf::kFloat}, {"count", uvs->size()}, {"type", "VEC2"}},
                                          {bytesOf(*uvs), 0, gltf::kVertices});
        return it->second;
    }

    // Points, lines and unlit surfaces stay as they are.
    Result<Json> primitive(const Json& source, const ExportPlace& place)
    {
        const Json& attributes = source["attributes"];
        const Json& lightmapUv = member(attributes, ("TEXCOORD_" + std::to_string(place.texCoord)).c_str());
        const int index = source.value("material", -1);
        const auto known = materialOf_.find(index);
        const Material& material = known != materialOf_.end() ? *known->second : defaultMaterial();
        if (lightmapUv.is_null() || source.value("mode", 4) <= kLastLineMode || material.unlit) return source;
        const auto uv = coordinates(lightmapUv.get<int>(), place);
        if (!uv) return uv.error();
        const bool isWhole = markedSide(element(source_.json, "materials", index)) == SurfaceSide::Both;
        const int own = materialFor(place.page, material, material.doubleSided && isWhole);
        Json result = {{"attributes", {{"TEXCOORD_0", *uv}}}, {"material", own}};
        for (const char* key : {"indices", "mode"}) {
            if (source.contains(key)) result[key] = source[key];
        }
        for (const auto& [name, accessor] : attributes.items()) {
            const bool placesVertices = name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
            if (name == "POSITION" || name == "NORMAL" || (placesVertices && place.skinned))
                result["attributes"][name] = accessor;
        }
        if (source.contains("targets")) {
            for (const Json& target : source["targets"]) {
                Json kept = Json::object();
                for (const char* name : {"POSITION", "NORMAL"}) {
                    if (target.contains(name)) kept[name] = target[name];
                }
                result["targets"].push_back(std::move(kept));
            }
        }
        return result;
    }

    Result<int> meshFor(int mesh, const ExportPlace& place)
    {
        const auto [it, isNew] = meshes_.try_emplace({mesh, place}, -1);
        if (!isNew) return it->second;
        Json json = source_.json["meshes"][std::size_t(mesh)];
        for (Json& item : json["primitives"]) {
            auto result = primitive(item, place);
            if (!result) return result.error();
            item = std::move(*result);
        }
        return it->second = patcher_.append("meshes", std::move(json));
    }

    Status exportNode(std::size_t node)
    {
        const Json& source = source_.json["nodes"][node];
        if (!source.contains("mesh")) return {};
        const Json& lightmap = member(extensionOf(source, "HALFLIGHT_node"), "lightmap");
        if (lightmap.is_null()) {
            report_.others.push_back(source.value("name", "node " + std::to_string(node)));
            return {};
        }
        ExportPlace place;
        place.texCoord = lightmap.value("texCoord", 1);
        place.skinned = source.contains("skin");
        if (lightmap.value("perInstance", false)) return exportInstances(node, place);
        place.page = lightmap.value("page", 0);
        place.scale = pairOf(member(lightmap, "scale"), vec2(1.0f));
        place.offset = pairOf(member(lightmap, "offset"), vec2(0.0f));
        const auto mesh = meshFor(source["mesh"].get<int>(), place);
        if (!mesh) return mesh.error();
        patcher_.json["nodes"][node]["mesh"] = *mesh;
        ++report_.surfaces;
        return {};
    }

    // A child for each instance: instances of one mesh cannot have texels of their own in core glTF.
    Status exportInstances(std::size_t node, const ExportPlace& shared)
    {
        const Json source = source_.json["nodes"][node];
        const Json& attributes = member(extensionOf(source, "EXT_mesh_gpu_instancing"), "attributes");
        const auto pages = viewAccessor(source_, attributes["_HALFLIGHT_LIGHTMAP_PAGE"].get<int>());
        const auto rectangles = viewAccessor(source_, attributes["_HALFLIGHT_LIGHTMAP_ST"].get<int>());
        if (!pages) return pages.error();
        if (!rectangles) return rectangles.error();
        std::map<std::string, AccessorView> pose;
        for (const auto& [attribute, key] :
             {std::pair("TRANSLATION", "translation"), {"ROTATION", "rotation"}, {"SCALE", "scale"}}) {
            if (!attributes.contains(attribute)) continue;
            auto view = viewAccessor(source_, attributes[attribute].get<int>());
            if (!view) return view.error();
            pose.emplace(key, std::move(*view));
        }
        for (std::size_t i = 0; i < pages->count; ++i) {
            ExportPlace place = shared;
            place.page = int(std::lround(pages->number(i, 0)));
            place.scale = {rectangles->number(i, 0), rectangles->number(i, 1)};
            place.offset = {rectangles->number(i, 2), rectangles->number(i, 3)};
            int mesh = source["mesh"].get<int>();
            if (place.page >= 0) {
                const auto exported = meshFor(mesh, place);
                if (!exported) return exported.error();
                mesh = *exported;
                ++report_.surfaces;
            }
            Json child = {{"mesh", mesh}};
            if (source.contains("name")) child["name"] = source["name"].get<std::string>() + " " + std::to_string(i);
            for (const auto& [key, view] : pose) {
                for (int c = 0; c < view.components; ++c) child[key].push_back(view.number(i, c));
            }
            const int index = patcher_.append("nodes", std::move(child));
            patcher_.json["nodes"][node]["children"].push_back(index);
        }
        patcher_.json["nodes"][node].erase("mesh");
        eraseExtension(patcher_.json["nodes"][node], "EXT_mesh_gpu_instancing");
        return {};
    }

    // Sets of texture coordinates are numbered without gaps: a lightmap's that nothing reads any more goes.
    void closeGaps()
    {
        if (!patcher_.json.contains("meshes")) return;
        for (Json& mesh : patcher_.json["meshes"]) {
            for (Json& primitive : mesh["primitives"]) {
                Json& attributes = primitive["attributes"];
                const Json& material = element(patcher_.json, "materials", primitive.value("material", -1));
                for (int n = 16; n > 0; --n) {
                    const std::string set = "TEXCOORD_" + std::to_string(n);
                    const std::string below = "TEXCOORD_" + std::to_string(n - 1);
                    if (!attributes.contains(set) || attributes.contains(below)) continue;
                    if (readsTexCoord(material, n))
                        attributes[below] = attributes[set];
                    else
                        attributes.erase(set);
                }
            }
        }
    }

    void listExtensions()
    {
        Json& json = patcher_.json;
        std::set<std::string> present;
        collectExtensions(json, present);
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
            std::set<std::string> names;
            for (const Json& name : member(json, list)) {
                const auto text = name.get<std::string>();
                if (present.contains(text) || text == "KHR_mesh_quantization") names.insert(text);
            }
            if (std::string_view(list) == "extensionsUsed") names.insert(present.begin(), present.end());
            json.erase(list);
            if (!names.empty()) json[list] = names;
        }
    }

    const SourceDocument& source_;
    const ExportOptions& options_;
    ExportReport& report_;
    DocumentPatcher patcher_;
    const float factor_;
    const std::string unknown_;
    std::map<int, const Material*> materialOf_; // by the source's materials
    std::vector<int> textures_;                 // by page
    std::map<std::tuple<int, Material::AlphaMode, bool>, int> materials_;
    std::map<std::pair<int, ExportPlace>, int> meshes_;
    std::map<std::pair<int, ExportPlace>, int> coordinates_;
};

} // namespace

const char* nameOf(ExportStyle style)
{
    return style == ExportStyle::Unlit ? "unlit" : "emissive";
}

Status writeExport(const std::filesystem::path& path, BakedScene baked, const std::vector<ImageRgba8>& pages,
                   const ExportOptions& options, ExportReport& report)
{
    if (!baked.scene.source) {
        if (Status s = giveSourceDocument(baked.scene); !s) return s;
    }
    // The bake's own pictures do not get into the file; one texel stands for each page.
    for (Image<uint32_t>& page : baked.lightmaps) page = Image<uint32_t>(1, 1);
    baked.lightmapDirections.clear();
    baked.shadowmasks.clear();
    baked.scene.sky.picture = nullptr;
    baked.probes = {}, baked.reflections = {};
    WrittenBytes written;
    const auto document = bakedDocument(baked, {}, {}, written);
    if (!document) return document.error();
    const auto bytes = makeGlb(document->json, document->binary);
    if (!bytes) return bytes.error();
    const auto source = parseDocument(*bytes, path.parent_path());
    if (!source) return source.error();
    const auto exported = Exporter(**source, baked.scene, options, report).run(pages);
    if (!exported) return exported.error();
    const auto glb = makeGlb(exported->json, exported->binary);
    if (!glb) return glb.error();
    report.bytes = glb->size();
    return writeFileAtomically(path, glb->data(), glb->size(), options.mayReplace);
}

} // namespace halflight
