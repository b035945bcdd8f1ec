#include "scene/read/read_baked.h"

#include "halflight/base/text.h"
#include "scene/document/texture_coordinates.h"
#include "scene/format/bake_members.h"
#include "scene/format/limits.h"
#include "scene/format/recorded_origin.h"
#include "scene/load/load_document.h"
#include "scene/model/origin.h"
#include "scene/read/check_bake.h"
#include "scene/read/looks/read_pictures.h"
#include "scene/read/read_groups.h"
#include "scene/read/read_probes.h"
#include "scene/read/read_reflections.h"
#include "scene/read/read_scene.h"
#include "scene/settings/setting_values.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace halflight {

namespace {

/// Of version 2, or a light that has lost its layer: one.
Status readMaskLayers(const Json& root, BakedScene& baked)
{
    const Json& layers = member(root, "shadowmaskLayers");
    if (!layers.is_null() && (member(root, "version") != kLayeredVersion || !layers.is_number_unsigned() ||
                              layers < 1 || layers > kMostMaskLayers))
        return invalid(kBakePath, "shadowmaskLayers is not 1 to " + std::to_string(kMostMaskLayers) +
                                      ", or the version has no layers");
    baked.maskLayers = layers.is_null() ? 1 : layers.get<int>();
    for (const Light& light : baked.scene.lights) {
        if (light.baking.occlusionMaskChannel >= baked.maskLayers * kLayerChannels)
            return invalid(kBakePath, "light \"" + light.name + "\" has a mask channel of a layer that the file lacks");
    }
    return {};
}

/// Those that say so have a layer's first three channels, which hold attenuation.
Status checkColoredMasks(const Json& root, const BakedScene& baked)
{
    for (const Light& light : baked.scene.lights) {
        if (!light.baking.coloredMask) continue;
        const int channel = light.baking.occlusionMaskChannel;
        const std::string name = "light \"" + light.name + "\" has a coloured mask, and ";
        if (member(root, "version") != kLayeredVersion) return invalid(kBakePath, name + "the version has none");
        if (channel < 0 || channel % kLayerChannels != 0)
            return invalid(kBakePath, name + "its channel is not the first of a mask layer");
        for (int c = channel; c < channel + 3; ++c)
            if (baked.maskChannels[std::size_t(c)].rangeTexels > 0.0f)
                return invalid(kBakePath, name + "shadowmaskChannels says that it holds distances");
    }
    return {};
}

Status readMaskChannels(const Json& json, BakedScene& baked)
{
    if (json.is_null()) return {};
    const std::string path = kBakePath + "/shadowmaskChannels";
    const auto channels = std::size_t(baked.maskLayers * kLayerChannels);
    if (!json.is_array() || json.size() != channels)
        return invalid(path, "is not an array of " + std::to_string(channels));
    for (std::size_t i = 0; i < channels; ++i) {
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
        return invalid(kBakePath, "shadowColorFromBake is not true or false");
    const Json& color = member(root, "subtractiveShadowColor");
    if (color.is_null()) return {};
    if (!readVector(color, baked.defaultShadowColor))
        return invalid(kBakePath, "subtractiveShadowColor is not three numbers");
    for (int c = 0; c < 3; ++c) {
        if (!std::isfinite(baked.defaultShadowColor[c]) || baked.defaultShadowColor[c] < 0.0f)
            return invalid(kBakePath, "subtractiveShadowColor has a value that is not a number of 0 or more");
    }
    return {};
}

bool hasSet(const SourceDocument& document, const Mesh& mesh, int texCoord)
{
    const std::string name = "TEXCOORD_" + std::to_string(texCoord);
    return std::all_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        return attributeOf(primitiveOf(document, mesh.sourceMesh, part.sourcePrimitive), name) >= 0;
    });
}

// Lightmap coordinates of a mesh from the TEXCOORD_n that its node names.
Status readLightmapUv(const SourceDocument& document, const Scene& scene, Mesh& mesh, int texCoord)
{
    // A TEXCOORD_1 that a texture reads too is the author's: the bake kept it.
    const bool isAuthors = std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        return readsTexCoord(element(document.json, "materials", sourceMaterialOf(scene, part)), texCoord);
    });
    for (MeshPart& part : mesh.parts) {
        const Json& primitive = primitiveOf(document, mesh.sourceMesh, part.sourcePrimitive);
        const auto uv = readVectors<2>(document, attributeOf(primitive, "TEXCOORD_" + std::to_string(texCoord)));
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
    std::vector<std::string> withoutSet;
    for (Object& object : scene.objects) {
        const Json& node = document.json["nodes"][std::size_t(object.sourceNode)];
        const std::string path =
            pathOf("nodes", std::size_t(object.sourceNode)) + "/extensions/HALFLIGHT_node/lightmap";
        const Json& lightmap = member(extensionOf(node, "HALFLIGHT_node"), "lightmap");
        if (lightmap.is_null()) continue;
        const Json& texCoord = member(lightmap, "texCoord");
        if (!texCoord.is_number_unsigned() || texCoord.get<uint64_t>() > 16)
            return invalid(path, "texCoord is out of range");
        if (!hasSet(document, scene.meshes[std::size_t(object.mesh)], texCoord.get<int>())) {
            withoutSet.push_back(object.name);
            continue;
        }
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
                const std::size_t count = elementCount(document, first.get<int>());
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
        if (Status s = readLightmapUv(document, scene, scene.meshes[std::size_t(object.mesh)], it->second); !s)
            return s;
    }
    if (!withoutSet.empty())
        baked.lost.push_back("the lightmap coordinates of objects " + listOf(withoutSet) + ": probes light them");
    return {};
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
        checkLostBake(document, baked);
        return baked;
    }
    const Json& version = member(root, "version");
    if (version.is_number_integer() && version < kFormatVersion)
        return Error{ErrorCode::Unsupported, "was written by an old version of this program: bake again", kBakePath};
    if (!isFormatVersion(version))
        return Error{ErrorCode::Unsupported, "was written by a newer version of this program", kBakePath};
    const Json& mode = member(root, "mode");
    const auto named = mode.is_string() ? mixedLightingModeNamed(mode.get<std::string>()) : std::nullopt;
    if (!named) return invalid(kBakePath, "mode is not baked-indirect, shadowmask or subtractive");
    baked.mode = *named;
    baked.isBaked = true;
    if (Status s = readMaskLayers(root, baked); !s) return s.error();
    if (Status s = readGroups(root, baked); !s) return s.error();
    if (Status s = readPictures(document, root, baked); !s) return s.error();
    if (Status s = readMaskChannels(member(root, "shadowmaskChannels"), baked); !s) return s.error();
    if (Status s = checkColoredMasks(root, baked); !s) return s.error();
    const auto origin = recordedOrigin(document);
    if (!origin) return origin.error();
    const glm::dvec3 shift = *origin - baked.scene.originMeters;
    if (Status s = readDefaultShadowColor(root, baked); !s) return s.error();
    if (Status s = readProbes(document, member(root, "probes"), shift, baked.probes); !s) return s.error();
    if (Status s = readGroupProbes(document, root, baked); !s) return s.error();
    auto reflections = readReflections(document, member(root, "reflectionProbes"), shift);
    if (!reflections) return reflections.error();
    baked.reflections = std::move(*reflections);
    if (Status s = readGroupReflections(document, root, baked); !s) return s.error();
    if (Status s = readBindings(document, baked); !s) return s.error();
    if (Status s = checkBakedValues(baked); !s) return s.error();
    for (Probe& probe : baked.probes.probes) probe.occlusion = saturate(probe.occlusion);
    checkAgainstBake(document, root, shift, baked);
    checkSettingsOfBake(document, root, baked.scene);
    return baked;
}

} // namespace halflight
