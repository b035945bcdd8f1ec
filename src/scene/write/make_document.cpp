#include "scene/write/make_document.h"

#include "scene/document/patcher.h"
#include "scene/load/load_document.h"
#include "scene/model/origin.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace halflight {

namespace {

template<typename Vec> int addVectors(DocumentPatcher& patcher, const std::vector<Vec>& values, bool withBounds)
{
    constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    Json accessor = {{"componentType", gltf::kFloat}, {"count", values.size()}, {"type", kTypes[Vec::length() - 1]}};
    if (withBounds) {
        Vec low = values[0];
        Vec high = values[0];
        for (const Vec& v : values) {
            low = glm::min(low, v);
            high = glm::max(high, v);
        }
        accessor["min"] = numbers(low);
        accessor["max"] = numbers(high);
    }
    return patcher.addAccessor(std::move(accessor), {bytesOf(values), 0, gltf::kVertices});
}

void writeSlot(Json& object, const char* key, const TextureRef& ref)
{
    if (!ref) return;
    Json slot = {{"index", ref.texture}};
    if (ref.texCoord != 0) slot["texCoord"] = ref.texCoord;
    if (ref.offset != vec2(0.0f) || ref.scale != vec2(1.0f) || ref.rotationRadians != 0.0f) {
        slot["extensions"]["KHR_texture_transform"] = {
            {"offset", numbers(ref.offset)}, {"scale", numbers(ref.scale)}, {"rotation", ref.rotationRadians}};
    }
    object[key] = std::move(slot);
}

Json materialJson(const Material& material)
{
    Json json = Json::object();
    if (!material.name.empty()) json["name"] = material.name;
    Json& pbr = json["pbrMetallicRoughness"];
    pbr = {{"baseColorFactor", numbers(glm::clamp(material.baseColor, vec4(0.0f), vec4(1.0f)))},
           {"metallicFactor", material.metallic},
           {"roughnessFactor", material.roughness}};
    writeSlot(pbr, "baseColorTexture", material.baseColorTexture);
    writeSlot(pbr, "metallicRoughnessTexture", material.metallicRoughnessTexture);
    writeSlot(json, "normalTexture", material.normalTexture);
    if (material.normalTexture && material.normalScale != 1.0f) json["normalTexture"]["scale"] = material.normalScale;
    writeSlot(json, "occlusionTexture", material.occlusionTexture);
    if (material.occlusionTexture && material.occlusionStrength != 1.0f) {
        json["occlusionTexture"]["strength"] = material.occlusionStrength;
    }
    writeSlot(json, "emissiveTexture", material.emissiveTexture);
    const float strength = std::max({1.0f, material.emissiveNits.x, material.emissiveNits.y, material.emissiveNits.z});
    if (material.emissiveNits != vec3(0.0f))
        json["emissiveFactor"] = numbers(glm::clamp(material.emissiveNits / strength, vec3(0.0f), vec3(1.0f)));
    if (strength > 1.0f) json["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
    if (material.specular != 1.0f)
        json["extensions"]["KHR_materials_specular"] = {{"specularFactor", material.specular}};
    if (material.transmission > 0.0f) {
        Json& extension = json["extensions"]["KHR_materials_transmission"];
        extension = {{"transmissionFactor", material.transmission}};
        writeSlot(extension, "transmissionTexture", material.transmissionTexture);
    }
    if (material.attenuates()) {
        Json& extension = json["extensions"]["KHR_materials_volume"];
        extension = {{"thicknessFactor", material.thickness},
                     {"attenuationDistance", material.attenuationMeters},
                     {"attenuationColor", numbers(material.attenuationColor)}};
        writeSlot(extension, "thicknessTexture", material.thicknessTexture);
    }
    if (material.unlit) json["extensions"]["KHR_materials_unlit"] = Json::object();
    if (material.alphaMode == Material::AlphaMode::Mask) {
        json["alphaMode"] = "MASK";
        json["alphaCutoff"] = material.alphaCutoff;
    } else if (material.alphaMode == Material::AlphaMode::Blend) {
        json["alphaMode"] = "BLEND";
    }
    if (material.doubleSided) json["doubleSided"] = true;
    if (!material.castShadows) json["extras"]["halflight_cast_shadows"] = false;
    if (!material.receiveShadows) json["extras"]["halflight_receive_shadows"] = false;
    if (material.tinted) json["extras"]["halflight_tinted"] = true;
    if (!material.group.empty()) json["extras"]["halflight_group"] = material.group;
    return json;
}

int wrapMode(Texture::Wrap wrap)
{
    return wrap == Texture::Wrap::ClampToEdge      ? gltf::kClampToEdge
           : wrap == Texture::Wrap::MirroredRepeat ? gltf::kMirroredRepeat
                                                   : gltf::kRepeat;
}

Status writeTextures(DocumentPatcher& patcher, Scene& scene)
{
    for (std::size_t i = 0; i < scene.textures.size(); ++i) {
        Texture& texture = scene.textures[i];
        auto png = encodePng(texture.pixels);
        if (!png) return Error{png.error().code, png.error().message, pathOf("textures", i)};
        Json image = {{"mimeType", "image/png"}, {"bufferView", patcher.addView({std::move(*png), 0, 0})}};
        if (!texture.name.empty()) image["name"] = texture.name;
        const int filter = texture.nearest ? gltf::kNearest : gltf::kLinear;
        const int sampler = patcher.append(
            "samplers",
            {{"wrapS", wrapMode(texture.wrapU)}, {"wrapT", wrapMode(texture.wrapV)}, {"magFilter", filter}});
        patcher.append("textures", {{"source", patcher.append("images", std::move(image))}, {"sampler", sampler}});
        texture.sourceTexture = int(i);
    }
    return {};
}

// glTF wants the sets numbered without gaps: zeros stand in for missing ones, where a texture would be read too. A
// TEXCOORD_1 alone is a lightmap's layout, which the bake writes itself.
void writeTextureSets(DocumentPatcher& patcher, const MeshPart& part, Json& attributes)
{
    std::size_t count = part.uv.size();
    while (count > 0 && part.uv[count - 1].empty()) --count;
    if (count == 2 && part.uv[0].empty()) return;
    std::optional<int> zeros;
    for (std::size_t n = 0; n < count; ++n) {
        Json& accessor = attributes["TEXCOORD_" + std::to_string(n)];
        if (!part.uv[n].empty()) {
            accessor = addVectors(patcher, part.uv[n], false);
        } else {
            if (!zeros) zeros = addVectors(patcher, std::vector<vec2>(part.positions.size(), vec2(0.0f)), false);
            accessor = *zeros;
        }
    }
}

void writeMeshes(DocumentPatcher& patcher, Scene& scene)
{
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        Mesh& mesh = scene.meshes[m];
        Json json = {{"primitives", Json::array()}};
        if (!mesh.name.empty()) json["name"] = mesh.name;
        for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
            MeshPart& part = mesh.parts[p];
            Json primitive = Json::object();
            Json& attributes = primitive["attributes"];
            attributes["POSITION"] = addVectors(patcher, part.positions, true);
            if (!part.normals.empty()) attributes["NORMAL"] = addVectors(patcher, part.normals, false);
            if (!part.tangents.empty()) attributes["TANGENT"] = addVectors(patcher, part.tangents, false);
            writeTextureSets(patcher, part, attributes);
            if (!part.colors.empty()) attributes["COLOR_0"] = addVectors(patcher, part.colors, false);
            primitive["indices"] = patcher.addAccessor(
                {{"componentType", gltf::kUnsignedInt}, {"count", part.indices.size()}, {"type", "SCALAR"}},
                {bytesOf(part.indices), 0, gltf::kIndices});
            if (part.material >= 0) primitive["material"] = part.material;
            json["primitives"].push_back(std::move(primitive));
            part.sourcePrimitive = int(p);
            part.sourceVertex.clear();
            part.cutVertices.clear();
        }
        mesh.sourceMesh = int(m);
        patcher.append("meshes", std::move(json));
    }
}

int addNode(DocumentPatcher& patcher, const std::string& name, const dmat4& worldFromNode)
{
    Json node = Json::object();
    if (!name.empty()) node["name"] = name;
    if (worldFromNode != dmat4(1.0)) node["matrix"] = numbers(worldFromNode);
    const int index = patcher.append("nodes", std::move(node));
    patcher.json["scenes"][0]["nodes"].push_back(index);
    return index;
}

void writeCameras(DocumentPatcher& patcher, const Scene& scene)
{
    for (const Camera& camera : scene.cameras) {
        Json json = Json::object();
        if (!camera.name.empty()) json["name"] = camera.name;
        if (camera.orthographic) {
            const float half = 0.5f * camera.orthographicHeightMeters;
            json["type"] = "orthographic";
            json["orthographic"] = {
                {"xmag", half}, {"ymag", half}, {"znear", camera.nearMeters}, {"zfar", camera.farMeters}};
        } else {
            json["type"] = "perspective";
            json["perspective"] = {{"yfov", camera.verticalFovRadians}, {"znear", camera.nearMeters}};
            if (std::isfinite(camera.farMeters)) json["perspective"]["zfar"] = camera.farMeters;
        }
        const int index = patcher.append("cameras", std::move(json));
        const int node = addNode(patcher, camera.name, worldFromLocal(camera.worldFromCamera, scene.originMeters));
        patcher.json["nodes"][std::size_t(node)]["camera"] = index;
    }
}

} // namespace

Status giveSourceDocument(Scene& scene)
{
    SourceDocument empty;
    empty.json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", Json::array({Json::object()})}};
    if (!scene.name.empty()) empty.json["scenes"][0]["name"] = scene.name;
    DocumentPatcher patcher(empty);
    if (Status s = writeTextures(patcher, scene); !s) return s;
    scene.emissionScale = 1.0f; // the materials below have the product
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        patcher.append("materials", materialJson(scene.materials[i]));
        scene.materials[i].sourceMaterial = int(i);
    }
    writeMeshes(patcher, scene);
    for (Object& object : scene.objects) {
        object.sourceNode = addNode(patcher, object.name, worldFromLocal(object.worldFromObject, scene.originMeters));
        object.sourceInstance = -1;
        if (object.mesh >= 0) patcher.json["nodes"][std::size_t(object.sourceNode)]["mesh"] = object.mesh;
    }
    writeCameras(patcher, scene);
    for (Light& light : scene.lights) light.sourceNode = -1; // the writer adds nodes for them

    std::vector<std::string> used;
    const std::string text = patcher.json.dump();
    for (const char* name : {"KHR_materials_emissive_strength", "KHR_materials_specular", "KHR_materials_unlit",
                             "KHR_texture_transform"}) {
        if (text.find(std::string("\"") + name + "\"") != std::string::npos) used.emplace_back(name);
    }
    if (!used.empty()) patcher.json["extensionsUsed"] = used;
    const FinishedDocument finished = patcher.finish();
    const auto glb = makeGlb(finished.json, finished.binary);
    if (!glb) return glb.error();
    auto document = parseDocument(*glb, {});
    if (!document) return document.error();
    scene.source = std::move(*document);
    return {};
}

} // namespace halflight
