#include "scene/read/looks/read_materials.h"
#include "halflight/scene/light_groups.h"
#include "scene/document/decode/compression.h"
#include "scene/format/material_sides.h"
#include "scene/read/looks/decode_textures.h"
#include "scene/settings/setting_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

namespace halflight {

namespace {

// Numbers of a material, checked. Missing ones keep their default.
class Fields {
public:
    Fields(const Json& object, std::string path) : object_(object), path_(std::move(path)) {}

    Status number(const char* key, float low, float high, float& value) const
    {
        const Json& v = member(object_, key);
        if (v.is_null()) return {};
        if (!v.is_number() || !std::isfinite(float(v.get<double>())))
            return invalid(path_, std::string(key) + " is not a number");
        const auto number = float(v.get<double>());
        if (number < low || number > high) return invalid(path_, std::string(key) + " is out of range");
        value = number;
        return {};
    }
    template<int N> Status vector(const char* key, glm::vec<N, float>& value) const
    {
        const Json& v = member(object_, key);
        if (v.is_null()) return {};
        bool good = v.is_array() && v.size() == N;
        for (std::size_t c = 0; good && c < N; ++c) {
            good = v[c].is_number() && std::isfinite(float(v[c].get<double>()));
            if (good) value[int(c)] = float(v[c].get<double>());
        }
        return good ? Status() : Status(invalid(path_, std::string(key) + " is not " + std::to_string(N) + " numbers"));
    }

private:
    const Json& object_;
    std::string path_;
};

Texture::Wrap wrapOf(int mode)
{
    return mode == gltf::kClampToEdge      ? Texture::Wrap::ClampToEdge
           : mode == gltf::kMirroredRepeat ? Texture::Wrap::MirroredRepeat
                                           : Texture::Wrap::Repeat;
}

// The texture without its pixels: name and sampler.
Texture textureOf(const SourceDocument& document, int index)
{
    const Json& source = element(document.json, "textures", index);
    const Json& sampler = element(document.json, "samplers", integerOf(source, "sampler"));
    Texture texture;
    texture.name = stringOf(source, "name");
    if (texture.name.empty()) texture.name = stringOf(element(document.json, "images", imageOf(source)), "name");
    texture.sourceTexture = index;
    texture.wrapU = wrapOf(integerOf(sampler, "wrapS"));
    texture.wrapV = wrapOf(integerOf(sampler, "wrapT"));
    texture.nearest = integerOf(sampler, "magFilter") == gltf::kNearest;
    return texture;
}

// A texture slot. Textures get their index in the scene as they are met; those that show the same image in the same way
// are one.
class TextureTable {
public:
    explicit TextureTable(const SourceDocument& document) : document_(document) {}

    Status read(const Json& slot, const std::string& path, TextureRef& ref, std::vector<std::string>& warnings)
    {
        if (slot.is_null()) return {};
        const Json& index = member(slot, "index");
        if (!isIndexInto(document_.json, "textures", index))
            return invalid(path, "refers to a texture that does not exist");
        const auto source = index.get<int>();
        const Json& json = element(document_.json, "textures", source);
        const Json& image = element(document_.json, "images", imageOf(json));
        if (image.is_null()) {
            std::string hint;
            for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif"}) {
                if (!extensionOf(json, name).is_null()) hint = conversionHint(name);
            }
            warnings.push_back(path + ": texture " + std::to_string(source) +
                               " has no image this program reads; left out" + hint);
            return {};
        }
        uint64_t texCoord = 0;
        const auto readTexCoord = [&](const Json& value) {
            if (value.is_number_unsigned()) texCoord = value.get<uint64_t>();
        };
        readTexCoord(member(slot, "texCoord"));
        const Json& transform = extensionOf(slot, "KHR_texture_transform");
        if (transform.is_object()) {
            const Fields fields(transform, path + "/extensions/KHR_texture_transform");
            if (Status s = fields.vector<2>("offset", ref.offset); !s) return s;
            if (Status s = fields.vector<2>("scale", ref.scale); !s) return s;
            if (Status s = fields.number("rotation", -1.0e6f, 1.0e6f, ref.rotationRadians); !s) return s;
            readTexCoord(member(transform, "texCoord"));
        }
        ref.texCoord = int(std::min(texCoord, uint64_t(std::numeric_limits<int>::max()))); // keepTwoSets() has limits
        Texture texture = textureOf(document_, source);
        const auto key = std::make_tuple(placeOf(image), texture.wrapU, texture.wrapV, texture.nearest);
        const auto [it, isNew] = indexOf_.try_emplace(key, int(used_.size()));
        if (isNew) used_.push_back(std::move(texture));
        ref.texture = it->second;
        return {};
    }

    [[nodiscard]] std::vector<Texture> take() { return std::move(used_); }

private:
    const SourceDocument& document_;
    std::map<std::tuple<ImagePlace, Texture::Wrap, Texture::Wrap, bool>, int> indexOf_;
    std::vector<Texture> used_;
};

// KHR_materials_transmission as coverage, so that light passes glass and one sees through it: what the glass reflects
// and what it lacks in transmission stays (Material::coverage()). Light goes straight on and takes the base colour
// (Material::passed()); metals let none through. Unlit materials have base colour and alpha alone
// (KHR_materials_unlit).
Status readTransmission(const Json& json, const std::string& path, TextureTable& textures, Material& material,
                        std::vector<std::string>& warnings)
{
    const Json& extension = extensionOf(json, "KHR_materials_transmission");
    const std::string where = path + "/extensions/KHR_materials_transmission";
    if (Status s = Fields(extension, where).number("transmissionFactor", 0.0f, 1.0f, material.transmission); !s)
        return s;
    if (Status s = textures.read(member(extension, "transmissionTexture"), where + "/transmissionTexture",
                                 material.transmissionTexture, warnings);
        !s) {
        return s;
    }
    if (material.unlit || material.transmission == 0.0f ||
        (material.metallic == 1.0f && !material.metallicRoughnessTexture)) {
        material.transmission = 0.0f;
        material.transmissionTexture = {};
    }
    return {};
}

// KHR_materials_volume, of materials that transmit light. An attenuation distance of 0 or less is not allowed.
Status readVolume(const Json& json, const std::string& path, TextureTable& textures, Material& material,
                  std::vector<std::string>& warnings)
{
    const Json& extension = extensionOf(json, "KHR_materials_volume");
    if (!extension.is_object() || material.transmission <= 0.0f) return {};
    const std::string where = path + "/extensions/KHR_materials_volume";
    const Fields fields(extension, where);
    constexpr float kLeastMeters = 1.0e-9f;
    if (Status s = fields.number("thicknessFactor", 0.0f, 3.0e38f, material.thickness); !s) return s;
    if (Status s = fields.number("attenuationDistance", kLeastMeters, 3.0e38f, material.attenuationMeters); !s)
        return s;
    if (Status s = fields.vector<3>("attenuationColor", material.attenuationColor); !s) return s;
    material.attenuationColor = glm::clamp(material.attenuationColor, vec3(0.0f), vec3(1.0f));
    if (!material.attenuates()) return {};
    return textures.read(member(extension, "thicknessTexture"), where + "/thicknessTexture", material.thicknessTexture,
                         warnings);
}

// KHR_materials_pbrSpecularGlossiness, where a material has no pbrMetallicRoughness beside it: diffuse is the base
// colour of a dielectric. What is lost is the colour of the specular reflection and the glossiness of its texture.
Status readSpecularGlossiness(const Json& json, const std::string& path, TextureTable& textures, Material& material,
                              std::vector<std::string>& warnings)
{
    const char* const kName = "KHR_materials_pbrSpecularGlossiness";
    const Json& extension = extensionOf(json, kName);
    if (!extension.is_object() || member(json, "pbrMetallicRoughness").is_object()) return {};
    const std::string where = path + "/extensions/" + kName;
    const Fields fields(extension, where);
    vec3 specular(1.0f);
    float glossiness = 1.0f;
    if (Status s = fields.vector<4>("diffuseFactor", material.baseColor); !s) return s;
    if (Status s = fields.vector<3>("specularFactor", specular); !s) return s;
    if (Status s = fields.number("glossinessFactor", 0.0f, 1.0f, glossiness); !s) return s;
    if (Status s = textures.read(member(extension, "diffuseTexture"), where + "/diffuseTexture",
                                 material.baseColorTexture, warnings);
        !s) {
        return s;
    }
    constexpr float kDielectric = 0.04f; // what specular = 1 stands for
    material.baseColor = glm::max(material.baseColor, vec4(0.0f));
    material.metallic = 0.0f;
    material.roughness = 1.0f - glossiness;
    material.specular = glm::clamp(std::max({specular.x, specular.y, specular.z}) / kDielectric, 0.0f, 1.0f);
    warnings.push_back(where +
                       ": read as diffuse colour and roughness; its specular colour is approximated by that of " +
                       "a dielectric (convert the file to metallic-roughness for more)");
    return {};
}

// Vertices carry two texture coordinate sets to the renderer. Textures that read a further one, or one beyond the last
// that is read, take the material's first.
void keepTwoSets(const std::string& path, Material& material, std::vector<std::string>& warnings)
{
    std::vector<int> kept;
    std::set<int> left;
    const auto take = [&](TextureRef& ref) {
        if (!ref || std::find(kept.begin(), kept.end(), ref.texCoord) != kept.end()) return;
        if (ref.texCoord < kTexCoordSets && kept.size() < 2) {
            kept.push_back(ref.texCoord);
            return;
        }
        left.insert(ref.texCoord);
        ref.texCoord = kept.empty() ? 0 : kept.front();
        if (kept.empty()) kept.push_back(0);
    };
    take(material.baseColorTexture);
    take(material.metallicRoughnessTexture);
    take(material.normalTexture);
    take(material.occlusionTexture);
    take(material.emissiveTexture);
    take(material.transmissionTexture);
    take(material.thicknessTexture);
    for (const int n : left) {
        warnings.push_back(path + ": material \"" + material.name + "\" reads TEXCOORD_" + std::to_string(n) +
                           (n < kTexCoordSets ? " as a third set of texture coordinates, where two are read"
                                              : ", which is beyond TEXCOORD_7, the last that is read") +
                           "; its textures there are read with TEXCOORD_" + std::to_string(kept.front()));
    }
}

Status readMaterial(const Json& json, const std::string& path, TextureTable& textures, Material& material,
                    std::vector<std::string>& warnings)
{
    material.name = stringOf(json, "name");
    const Json& pbr = member(json, "pbrMetallicRoughness");
    const std::string pbrPath = path + "/pbrMetallicRoughness";
    const Fields pbrFields(pbr, pbrPath);
    if (Status s = pbrFields.vector<4>("baseColorFactor", material.baseColor); !s) return s;
    if (Status s = pbrFields.number("metallicFactor", 0.0f, 1.0f, material.metallic); !s) return s;
    if (Status s = pbrFields.number("roughnessFactor", 0.0f, 1.0f, material.roughness); !s) return s;
    material.baseColor = glm::max(material.baseColor, vec4(0.0f));

    const Json& normal = member(json, "normalTexture");
    const Json& occlusion = member(json, "occlusionTexture");
    const auto slot = [&](const Json& value, const std::string& slotPath, TextureRef& ref) {
        return textures.read(value, slotPath, ref, warnings);
    };
    if (Status s = slot(member(pbr, "baseColorTexture"), pbrPath + "/baseColorTexture", material.baseColorTexture); !s)
        return s;
    if (Status s = slot(member(pbr, "metallicRoughnessTexture"), pbrPath + "/metallicRoughnessTexture",
                        material.metallicRoughnessTexture);
        !s) {
        return s;
    }
    if (Status s = readSpecularGlossiness(json, path, textures, material, warnings); !s) return s;
    if (Status s = slot(normal, path + "/normalTexture", material.normalTexture); !s) return s;
    if (Status s = slot(occlusion, path + "/occlusionTexture", material.occlusionTexture); !s) return s;
    if (Status s = slot(member(json, "emissiveTexture"), path + "/emissiveTexture", material.emissiveTexture); !s)
        return s;
    if (Status s = Fields(normal, path + "/normalTexture").number("scale", -1.0e6f, 1.0e6f, material.normalScale); !s)
        return s;
    if (Status s =
            Fields(occlusion, path + "/occlusionTexture").number("strength", 0.0f, 1.0f, material.occlusionStrength);
        !s) {
        return s;
    }

    if (Status s = Fields(extensionOf(json, "KHR_materials_specular"), path + "/extensions/KHR_materials_specular")
                       .number("specularFactor", 0.0f, 1.0f, material.specular);
        !s) {
        return s;
    }

    vec3 emissive(0.0f);
    float strength = 1.0f;
    if (Status s = Fields(json, path).vector<3>("emissiveFactor", emissive); !s) return s;
    if (Status s = Fields(extensionOf(json, "KHR_materials_emissive_strength"),
                          path + "/extensions/KHR_materials_emissive_strength")
                       .number("emissiveStrength", 0.0f, 3.0e38f, strength);
        !s) {
        return s;
    }
    material.emissiveNits = glm::max(emissive, vec3(0.0f)) * strength;
    if (!std::isfinite(material.emissiveNits.x + material.emissiveNits.y + material.emissiveNits.z)) {
        return invalid(path, "emission is not finite");
    }
    if (Status s = Fields(json, path).number("alphaCutoff", 0.0f, 3.0e38f, material.alphaCutoff); !s) return s;
    const Json& mode = member(json, "alphaMode");
    if (mode == "MASK") {
        material.alphaMode = Material::AlphaMode::Mask;
    } else if (mode == "BLEND") {
        material.alphaMode = Material::AlphaMode::Blend;
    } else if (!mode.is_null() && mode != "OPAQUE") {
        warnings.push_back(path + ": unknown alphaMode is read as OPAQUE");
    }
    const Json& doubleSided = member(json, "doubleSided");
    material.doubleSided =
        (doubleSided.is_boolean() && doubleSided.get<bool>()) || markedSide(json) != SurfaceSide::Both;
    material.unlit = extensionOf(json, "KHR_materials_unlit").is_object();
    if (Status s = readTransmission(json, path, textures, material, warnings); !s) return s;
    if (Status s = readVolume(json, path, textures, material, warnings); !s) return s;
    keepTwoSets(path, material, warnings);
    return {};
}

// Extras, what an earlier bake wrote down, and the settings file, the later the stronger, as for nodes.
Status readSwitches(const Json& json, const std::string& path, FileSettings& file, Material& material,
                    std::vector<std::string>& warnings)
{
    const Json& extras = member(json, "extras");
    const auto authored = materialSettingsOf(extras, path);
    if (!authored) return authored.error();
    warnUnknownExtras(extras, ExtrasOwner::Material, path, warnings);
    applySettings(*authored, material);
    const Json& record = extensionOf(json, "HALFLIGHT_material");
    const auto flag = [&](const char* key, bool& value) {
        if (const Json& written = member(record, key); written.is_boolean()) value = written.get<bool>();
    };
    flag("castShadows", material.castShadows);
    flag("receiveShadows", material.receiveShadows);
    flag("tinted", material.tinted);
    if (std::string group = stringOf(record, "group"); isGroupName(group)) material.group = std::move(group);
    const Json& baking = member(record, "baking");
    if (const Json& group = member(baking, "group"); group.is_number_unsigned()) {
        material.bakedGroup = group.get<int>();
        readVec3(member(baking, "white"), material.whiteNits);
    }
    for (auto& rule : file.materials) {
        if (!matchesPattern(rule.pattern, material.name)) continue;
        rule.matched = true;
        applySettings(rule.settings, material);
    }
    return {};
}

} // namespace

Result<MaterialsRead> readMaterials(const SourceDocument& document, FileSettings& file, const ReadOptions& options)
{
    MaterialsRead read;
    TextureTable table(document);
    const Json& materials = member(document.json, "materials");
    for (std::size_t i = 0; i < materials.size(); ++i) {
        Material material;
        material.sourceMaterial = int(i);
        if (Status s = readMaterial(materials[i], pathOf("materials", i), table, material, read.warnings); !s)
            return s.error();
        if (Status s = readSwitches(materials[i], pathOf("materials", i), file, material, read.warnings); !s)
            return s.error();
        read.materials.push_back(std::move(material));
    }
    read.textures = table.take();
    if (options.decodeTextures) {
        if (Status s = decodeTextures(document, read.textures, options.cancel); !s) return s.error();
    }
    return read;
}

} // namespace halflight
