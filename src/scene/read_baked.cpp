#include "scene/read_baked.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/text.h"
#include "halflight/scene/fingerprint.h"
#include "scene/ktx2.h"
#include "scene/limits.h"
#include "scene/nodes.h"
#include "scene/read_parts.h"
#include "scene/read_scene.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace halflight {

namespace {

const std::string kPath = "/extensions/HALFLIGHT_mixed_lighting";

Result<std::span<const std::byte>> viewBytes(const SourceDocument& document, const Json& reference,
                                             const std::string& path)
{
    const Json& index = member(reference, "bufferView");
    if (!index.is_number_unsigned() || index.get<uint64_t>() >= document.model.bufferViews.size()) {
        return invalid(path, "refers to a buffer view that does not exist");
    }
    const auto& view = document.model.bufferViews[index.get<std::size_t>()];
    const auto& data = document.model.buffers[std::size_t(view.buffer)].data;
    return std::span(reinterpret_cast<const std::byte*>(data.data()) + view.byteOffset, view.byteLength);
}

Result<int> accessorIndex(const SourceDocument& document, const Json& object, const char* key, std::size_t count,
                          const std::string& path)
{
    const Json& index = member(object, key);
    if (!index.is_number_unsigned() || index.get<uint64_t>() >= document.model.accessors.size()) {
        return invalid(path, std::string(key) + " refers to an accessor that does not exist");
    }
    if (document.model.accessors[index.get<std::size_t>()].count != count) {
        return invalid(path, std::string(key) + " does not have " + std::to_string(count) + " elements");
    }
    return index.get<int>();
}

template<typename Vec> bool readVector(const Json& json, Vec& out)
{
    if (!json.is_array() || json.size() != std::size_t(Vec::length())) return false;
    for (int c = 0; c < Vec::length(); ++c) {
        if (!json[std::size_t(c)].is_number()) return false;
        out[c] = json[std::size_t(c)].get<typename Vec::value_type>();
    }
    return true;
}

// Texels of all pages together; buffer views may overlap.
class PageTexels {
public:
    explicit PageTexels(const SourceDocument& document)
    {
        uint64_t bytes = 0;
        for (const auto& buffer : document.model.buffers) bytes += buffer.data.size();
        left_ = mostTexels(bytes);
    }
    Status take(uint64_t texels, const std::string& path)
    {
        if (texels > left_) return invalid(path, "pages have more texels in all than a file of this size may ask for");
        left_ -= texels;
        return {};
    }

private:
    uint64_t left_ = 0;
};

// Images of which there are as many as lightmap pages, or none.
Status readPngs(const SourceDocument& document, const Json& root, const char* key, std::size_t pageCount,
                PageTexels& texels, std::vector<ImageRgba8>& pages)
{
    const Json& images = member(root, key);
    for (std::size_t i = 0; i < images.size(); ++i) {
        const std::string path = kPath + "/" + key + "/" + std::to_string(i);
        const auto bytes = viewBytes(document, images[i], path);
        if (!bytes) return bytes.error();
        auto image = decodeImage(bytes->data(), bytes->size());
        if (!image) return Error{image.error().code, image.error().message, path};
        if (Status s = texels.take(image->texelCount(), path); !s) return s;
        pages.push_back(std::move(*image));
    }
    if (!pages.empty() && pages.size() != pageCount) {
        return invalid(kPath, "has " + std::to_string(pages.size()) + " " + key + " for " + std::to_string(pageCount) +
                                  " lightmaps");
    }
    return {};
}

Status readImages(const SourceDocument& document, const Json& root, BakedScene& baked)
{
    PageTexels texels(document);
    const Json& lightmaps = member(root, "lightmaps");
    for (std::size_t i = 0; i < lightmaps.size(); ++i) {
        const std::string path = kPath + "/lightmaps/" + std::to_string(i);
        const auto bytes = viewBytes(document, lightmaps[i], path);
        if (!bytes) return bytes.error();
        auto image = decodeKtx2(*bytes);
        if (!image) return Error{image.error().code, image.error().message, path};
        if (Status s = texels.take(image->texelCount(), path); !s) return s;
        baked.lightmaps.push_back(std::move(*image));
    }
    if (const Json& unit = member(root, "lightmapUnitLux"); !unit.is_null()) {
        baked.lightmapUnitLux = unit.is_number() ? unit.get<float>() : 0.0f;
        if (!(baked.lightmapUnitLux > 0.0f) || !std::isfinite(baked.lightmapUnitLux))
            return invalid(kPath, "lightmapUnitLux is not a number above 0");
    }
    const std::size_t pages = baked.lightmaps.size();
    if (Status s = readPngs(document, root, "lightmapDirections", pages, texels, baked.lightmapDirections); !s)
        return s;
    return readPngs(document, root, "shadowmasks", pages, texels, baked.shadowmasks);
}

Status readMaskChannels(const Json& json, BakedScene& baked)
{
    if (json.is_null()) return {};
    const std::string path = kPath + "/shadowmaskChannels";
    if (!json.is_array() || json.size() != baked.maskChannels.size()) return invalid(path, "is not an array of four");
    for (std::size_t i = 0; i < baked.maskChannels.size(); ++i) {
        const Json& encoding = member(json[i], "encoding");
        if (encoding == "attenuation") continue;
        const Json& range = member(json[i], "rangeTexels");
        const Json& penumbra = member(json[i], "penumbraTexels");
        if (encoding != "distance" || !range.is_number() || !penumbra.is_number())
            return invalid(path, "item " + std::to_string(i) + " is neither attenuation nor distance with its numbers");
        MaskChannel& channel = baked.maskChannels[i];
        channel = {range.get<float>(), penumbra.get<float>()};
        if (!(channel.rangeTexels > 0.0f) || !std::isfinite(channel.rangeTexels) || !(channel.penumbraTexels >= 0.0f) ||
            !std::isfinite(channel.penumbraTexels)) {
            return invalid(path,
                           "item " + std::to_string(i) + " has a range that is not above 0 or a penumbra below 0");
        }
    }
    return {};
}

// Where the bake chose the shadow colour; the author's is among the scene's settings.
Status readDefaultShadowColor(const Json& root, BakedScene& baked)
{
    if (const Json& fromBake = member(root, "shadowColorFromBake"); !fromBake.is_null() && !fromBake.is_boolean())
        return invalid(kPath, "shadowColorFromBake is not true or false");
    const Json& color = member(root, "subtractiveShadowColor");
    if (color.is_null()) return {};
    if (!readVector(color, baked.defaultShadowColor))
        return invalid(kPath, "subtractiveShadowColor is not three numbers");
    for (int c = 0; c < 3; ++c) {
        if (!std::isfinite(baked.defaultShadowColor[c]) || baked.defaultShadowColor[c] < 0.0f)
            return invalid(kPath, "subtractiveShadowColor has a value that is not a number of 0 or more");
    }
    return {};
}

// `shift` takes positions relative to the file's origin to the scene's: zero but for files that were moved.
Status readProbes(const SourceDocument& document, const Json& json, const glm::dvec3& shift, ProbeSet& set)
{
    if (json.is_null()) return {};
    const std::string path = kPath + "/probes";
    const Json& count = member(json, "count");
    if (!count.is_number_unsigned() || count.get<uint64_t>() > (1u << 28))
        return invalid(path, "count is not a number of probes");
    const auto n = count.get<std::size_t>();
    const auto positions = accessorIndex(document, json, "positions", n, path);
    const auto radiance = accessorIndex(document, json, "radiance", 9 * n, path);
    const auto occlusion = accessorIndex(document, json, "occlusion", n, path);
    const auto valid = accessorIndex(document, json, "valid", n, path);
    for (const auto* index : {&positions, &radiance, &occlusion, &valid}) {
        if (!*index) return index->error();
    }
    const auto p = readVectors<3>(document, *positions);
    const auto r = readVectors<3>(document, *radiance);
    const auto o = readVectors<4>(document, *occlusion);
    const auto v = readIntegers(document, *valid);
    if (!p) return p.error();
    if (!r) return r.error();
    if (!o) return o.error();
    if (!v) return v.error();
    set.probes.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        Probe& probe = set.probes[i];
        probe.position = vec3(glm::dvec3((*p)[i]) + shift);
        for (std::size_t k = 0; k < 9; ++k) probe.radiance[k] = (*r)[9 * i + k];
        probe.occlusion = (*o)[i];
        probe.valid = (*v)[i] != 0;
    }
    const Json& grid = member(json, "grid");
    if (grid.is_null()) return {};
    if (!readVector(member(grid, "origin"), set.origin) || !readVector(member(grid, "spacing"), set.spacingMeters) ||
        !readVector(member(grid, "size"), set.size)) {
        return invalid(path + "/grid", "origin, spacing and size are not three numbers each");
    }
    set.origin = vec3(glm::dvec3(set.origin) + shift);
    if (set.size.x < 1 || set.size.y < 1 || set.size.z < 1 || glm::any(glm::greaterThan(set.size, ivec3(1 << 20))) ||
        uint64_t(set.size.x) * uint64_t(set.size.y) * uint64_t(set.size.z) != n) {
        return invalid(path + "/grid", "its size does not multiply to the number of probes");
    }
    return {};
}

// Lightmap coordinates of a mesh from the TEXCOORD_n that its node names.
Status readLightmapUv(const SourceDocument& document, Mesh& mesh, int texCoord)
{
    // A TEXCOORD_1 that a texture reads too is the author's: the bake kept it.
    const bool isAuthors = std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        return readsTexCoord(element(document.json, "materials", part.material), texCoord);
    });
    for (MeshPart& part : mesh.parts) {
        const auto& primitive =
            document.model.meshes[std::size_t(mesh.sourceMesh)].primitives[std::size_t(part.sourcePrimitive)];
        const auto it = primitive.attributes.find("TEXCOORD_" + std::to_string(texCoord));
        const std::string path =
            pathOf("meshes", std::size_t(mesh.sourceMesh)) + "/primitives/" + std::to_string(part.sourcePrimitive);
        if (it == primitive.attributes.end()) {
            return invalid(path,
                           "has no TEXCOORD_" + std::to_string(texCoord) + ", which its node names for the lightmap");
        }
        const auto uv = readVectors<2>(document, it->second);
        if (!uv) return uv.error();
        part.lightmapUv.resize(part.positions.size());
        for (std::size_t i = 0; i < part.lightmapUv.size(); ++i) {
            part.lightmapUv[i] = (*uv)[part.sourceVertex.empty() ? i : part.sourceVertex[i]];
        }
        part.lightmapTexCoord = texCoord;
        if (texCoord == 1 && !isAuthors) part.uv[1].clear();
    }
    return {};
}

Status readBindings(const SourceDocument& document, BakedScene& baked)
{
    Scene& scene = baked.scene;
    std::map<int, int> texCoordOf; // by mesh
    struct Instances {
        std::vector<vec4> st;
        std::vector<float> page;
    };
    std::map<int, Instances> instancesOf; // by node
    for (Object& object : scene.objects) {
        const Json& node = document.json["nodes"][std::size_t(object.sourceNode)];
        const std::string path =
            pathOf("nodes", std::size_t(object.sourceNode)) + "/extensions/HALFLIGHT_node/lightmap";
        const Json& lightmap = member(extensionOf(node, "HALFLIGHT_node"), "lightmap");
        if (lightmap.is_null()) continue;
        const Json& texCoord = member(lightmap, "texCoord");
        if (!texCoord.is_number_unsigned() || texCoord.get<uint64_t>() > 16)
            return invalid(path, "texCoord is out of range");
        if (object.sourceInstance < 0) {
            const Json& page = member(lightmap, "page");
            if (!page.is_number_unsigned() || page.get<uint64_t>() >= baked.lightmaps.size()) {
                return invalid(path, "refers to a lightmap page that does not exist");
            }
            object.lightmap.page = page.get<int>();
            if (!readVector(member(lightmap, "scale"), object.lightmap.scale) ||
                !readVector(member(lightmap, "offset"), object.lightmap.offset)) {
                return invalid(path, "scale and offset are not two numbers each");
            }
        } else {
            const Json& attributes = member(extensionOf(node, "EXT_mesh_gpu_instancing"), "attributes");
            const auto [it, isNew] = instancesOf.try_emplace(object.sourceNode);
            if (isNew) {
                const Json& first = attributes.items().begin().value(); // instanceTransforms() has checked them all
                const std::size_t count = document.model.accessors[first.get<std::size_t>()].count;
                const auto stIndex = accessorIndex(document, attributes, "_HALFLIGHT_LIGHTMAP_ST", count, path);
                const auto pageIndex = accessorIndex(document, attributes, "_HALFLIGHT_LIGHTMAP_PAGE", count, path);
                if (!stIndex) return stIndex.error();
                if (!pageIndex) return pageIndex.error();
                auto st = readVectors<4>(document, *stIndex);
                if (!st) return st.error();
                const auto page = viewAccessor(document, *pageIndex);
                if (!page) return page.error();
                it->second.st = std::move(*st);
                for (std::size_t i = 0; i < count; ++i) it->second.page.push_back(page->number(i, 0));
            }
            const auto i = std::size_t(object.sourceInstance);
            const float page = it->second.page[i];
            if (!(page >= -1.0f && page < float(baked.lightmaps.size()))) {
                return invalid(path,
                               "instance " + std::to_string(i) + " refers to a lightmap page that does not exist");
            }
            object.lightmap.page = int(page);
            object.lightmap.scale = vec2(it->second.st[i]);
            object.lightmap.offset = vec2(it->second.st[i].z, it->second.st[i].w);
        }
        const auto [it, isNew] = texCoordOf.try_emplace(object.mesh, texCoord.get<int>());
        if (!isNew) continue;
        if (Status s = readLightmapUv(document, scene.meshes[std::size_t(object.mesh)], it->second); !s) return s;
    }
    return {};
}

// Warns of what was changed in the file since its bake: the light of such objects is that of what they were.
void checkFingerprints(const SourceDocument& document, const Json& root, Scene& scene)
{
    const std::size_t warningsBefore = scene.warnings.size();
    const auto sentencesOf = [](const Light& light) {
        const bool bakedShadows = light.baking.occlusionMaskChannel >= 0;
        return changesSinceBake(light, "light \"" + light.name + "\"", bakedShadows);
    };
    for (const Light& light : scene.lights) {
        for (const std::string& sentence : sentencesOf(light)) scene.warnings.push_back("is stale: " + sentence);
    }
    const Json& ofScene = member(root, "fingerprint");
    if (!ofScene.is_string()) return; // of a version that kept none
    const SceneFingerprints fingerprints(scene);
    if (!fingerprints.complete()) return;
    std::map<int, std::vector<const Object*>> objectsOf; // by node
    for (const Object& object : scene.objects) objectsOf[object.sourceNode].push_back(&object);
    std::vector<std::string> changed;
    for (const auto& [node, objects] : objectsOf) {
        const Json& stored =
            member(extensionOf(document.json["nodes"][std::size_t(node)], "HALFLIGHT_node"), "fingerprint");
        const std::string now = fingerprints.ofObjects(objects);
        if (now != (stored.is_string() ? stored.get<std::string>() : "")) changed.push_back(objects.front()->name);
    }
    std::vector<std::string> changedLights; // in what no sentence above speaks of: a size, say
    for (const Light& light : scene.lights) {
        const Json& record = extensionOf(element(document.json, "nodes", light.sourceNode), "HALFLIGHT_light");
        const Json& stored = member(member(record, "baking"), "fingerprint");
        if (!stored.is_string()) continue; // realtime, or added since: it lights at run time
        if (sentencesOf(light).empty() && fingerprints.ofLight(light) != stored.get<std::string>())
            changedLights.push_back(light.name);
    }
    if (!changed.empty()) {
        scene.warnings.push_back("is stale: changed since its bake: objects " + listOf(changed) +
                                 "; their light and shadows are those of before, bake the scene again");
    }
    if (!changedLights.empty()) {
        scene.warnings.push_back("is stale: changed since its bake: lights " + listOf(changedLights) +
                                 "; baked light and shadows are those of before, bake the scene again");
    }
    const bool noneNamed = changed.empty() && changedLights.empty() && scene.warnings.size() == warningsBefore;
    if (noneNamed && fingerprints.ofScene() != ofScene.get<std::string>()) {
        scene.warnings.emplace_back(
            "is stale: the sky changed, or static objects or lights were removed since its bake; "
            "bake the scene again");
    }
}

// Warns of settings that say something else than at the bake, where a bake alone can heed them. Extras of a baked file
// give way to its record, so what differs from the record comes from a settings file.
void checkSettingsOfBake(const SourceDocument& document, const Json& root, Scene& scene)
{
    const auto add = [&](const std::string& what, const std::vector<std::string>& names) {
        if (names.empty()) return;
        scene.warnings.push_back("settings file: " + what + " of " + listOf(names) +
                                 " has no effect on a baked file; bake the scene again with these settings");
    };
    const auto differs = [](const Json& recorded, float now) {
        return recorded.is_number() && recorded.get<float>() != now;
    };
    std::vector<std::string> mode;
    std::vector<std::string> multiplier;
    std::vector<std::string> added;
    for (const Light& light : scene.lights) {
        const Json& record = extensionOf(element(document.json, "nodes", light.sourceNode), "HALFLIGHT_light");
        if (!record.is_object()) {
            if (light.mode != LightMode::Realtime) added.push_back(light.name);
            continue;
        }
        const Json& recorded = member(record, "mode");
        if (recorded.is_string() && recorded != nameOf(light.mode)) mode.push_back(light.name);
        if (differs(member(record, "indirectMultiplier"), light.indirectMultiplier)) multiplier.push_back(light.name);
    }
    add("mode", mode);
    add("indirect_multiplier", multiplier);
    if (!added.empty()) {
        scene.warnings.push_back("lights " + listOf(added) +
                                 " are not in the bake: they light at run time, without baked shadows and bounced "
                                 "light; bake the scene again");
    }
    std::vector<std::string> density;
    for (const Object& object : scene.objects) {
        const Json& record = extensionOf(document.json["nodes"][std::size_t(object.sourceNode)], "HALFLIGHT_node");
        const Json& scale = member(record, "lightmapScale");
        if (record.is_object() && (scale.is_number() ? scale.get<float>() : 1.0f) != object.lightmapScale)
            density.push_back(object.name);
    }
    add("lightmap_scale", density);
    const Json& probes = member(root, "authoredProbes");
    if (probes.size() != scene.probePositions.size())
        scene.warnings.emplace_back(
            "settings file: probes has no effect on a baked file; bake the scene again with these settings");
}

} // namespace

Result<BakedScene> readBakedScene(const std::filesystem::path& path, const ReadOptions& options)
{
    auto loaded = loadDocument(path);
    if (!loaded) return loaded.error();
    auto baked = bakedFromDocument(std::move(*loaded), options);
    if (baked && baked->scene.name.empty()) baked->scene.name = path.stem().string();
    return baked;
}

Result<BakedScene> bakedFromDocument(std::shared_ptr<const SourceDocument> source, const ReadOptions& options)
{
    const SourceDocument& document = *source;
    auto scene = sceneFromDocument(source, options);
    if (!scene) return scene.error();
    BakedScene baked;
    baked.scene = std::move(*scene);
    const Json& root = extensionOf(document.json, "HALFLIGHT_mixed_lighting");
    if (root.is_null()) {
        for (Light& light : baked.scene.lights) light.baking = {};
        return baked;
    }
    if (member(root, "version") != 1) {
        return Error{ErrorCode::Unsupported, "was written by a newer version of this program", kPath};
    }
    const Json& mode = member(root, "mode");
    const auto named = mode.is_string() ? mixedLightingModeNamed(mode.get<std::string>()) : std::nullopt;
    if (!named) return invalid(kPath, "mode is not baked-indirect, shadowmask or subtractive");
    baked.mode = *named;
    baked.isBaked = true;
    if (Status s = readImages(document, root, baked); !s) return s.error();
    if (Status s = readMaskChannels(member(root, "shadowmaskChannels"), baked); !s) return s.error();
    const auto origin = recordedOrigin(document);
    if (!origin) return origin.error();
    const glm::dvec3 shift = *origin - baked.scene.originMeters;
    if (Status s = readDefaultShadowColor(root, baked); !s) return s.error();
    if (Status s = readProbes(document, member(root, "probes"), shift, baked.probes); !s) return s.error();
    if (Status s = readBindings(document, baked); !s) return s.error();
    if (Status s = checkFinite(baked); !s) return s.error();
    checkFingerprints(document, root, baked.scene);
    checkSettingsOfBake(document, root, baked.scene);
    return baked;
}

} // namespace halflight
