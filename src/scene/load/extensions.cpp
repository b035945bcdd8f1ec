#include "scene/load/extensions.h"

#include "halflight/base/text.h"
#include "scene/document/decode/compression.h"

#include <algorithm>
#include <set>

namespace halflight {

namespace {

constexpr std::string_view kSupported[] = {"KHR_lights_punctual",
                                           "EXT_lights_area",
                                           "KHR_materials_emissive_strength",
                                           "KHR_texture_transform",
                                           "KHR_mesh_quantization",
                                           "EXT_mesh_gpu_instancing",
                                           "KHR_node_visibility",
                                           "KHR_materials_unlit",
                                           "KHR_materials_variants",
                                           "KHR_materials_specular",
                                           "KHR_materials_transmission",
                                           "KHR_materials_volume",
                                           "KHR_materials_pbrSpecularGlossiness",
                                           "KHR_animation_pointer",
                                           "HALFLIGHT_mixed_lighting",
                                           "HALFLIGHT_node",
                                           "HALFLIGHT_material",
                                           "HALFLIGHT_light",
                                           "HALFLIGHT_texture_ktx2"};

// The first group refines how a surface reflects or transmits, beyond the diffuse and the specular lobe that bakes and
// pictures have; the second holds no surface at all.
constexpr std::string_view kHarmless[] = {"KHR_materials_ior",
                                          "KHR_materials_clearcoat",
                                          "KHR_materials_sheen",
                                          "KHR_materials_iridescence",
                                          "KHR_materials_anisotropy",
                                          "KHR_materials_dispersion",
                                          "KHR_materials_diffuse_transmission",
                                          "ADOBE_materials_clearcoat_specular",
                                          "ADOBE_materials_clearcoat_tint",
                                          "MSFT_packing_normalRoughnessMetallic",
                                          "MSFT_packing_occlusionRoughnessMetallic",

                                          "KHR_audio_emitter",
                                          "KHR_interactivity",
                                          "KHR_node_hoverability",
                                          "KHR_node_selectability",
                                          "KHR_physics_rigid_bodies",
                                          "KHR_implicit_shapes",
                                          "KHR_xmp",
                                          "KHR_xmp_json_ld",
                                          "EXT_mesh_features",
                                          "EXT_instance_features",
                                          "EXT_structural_metadata",
                                          "EXT_mesh_manifold",
                                          "EXT_mesh_primitive_edge_visibility",
                                          "CESIUM_primitive_outline",
                                          "AGI_articulations",
                                          "AGI_stk_metadata",
                                          "MSFT_lod",
                                          "VRM",
                                          "VRMC_vrm",
                                          "VRMC_springBone",
                                          "VRMC_node_constraint",
                                          "VRMC_materials_mtoon",
                                          "VRMC_materials_hdr_emissiveMultiplier",
                                          "OMI_physics_body",
                                          "OMI_physics_shape",
                                          "OMI_spawn_point",
                                          "MOZ_lightmap",
                                          "MOZ_texture_rgbe"};

std::set<std::string> names(const Json& document)
{
    std::set<std::string> names;
    for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
        for (const Json& name : member(document, key)) {
            if (name.is_string()) names.insert(name.get<std::string>());
        }
    }
    return names;
}

/// Of meshes and pictures: the reader of such data says itself what it cannot read.
bool isCompression(const std::string& name)
{
    return name.ends_with("_compression") || name.starts_with("EXT_texture_") || name.starts_with("KHR_texture_");
}

} // namespace

bool isSupportedExtension(std::string_view name)
{
    return readsCompression(name) ||
           std::find(std::begin(kSupported), std::end(kSupported), name) != std::end(kSupported);
}

std::string unknownExtension(const Json& document)
{
    for (const Json& name : member(document, "extensionsUsed")) {
        const auto text = name.get<std::string>();
        if (!isSupportedExtension(text) && !text.starts_with("HALFLIGHT_") && !text.starts_with("KHR_materials_") &&
            !text.starts_with("KHR_texture_"))
            return text;
    }
    return {};
}

std::string staysForExtension(const std::string& what, const std::string& extension)
{
    return what + ": the extension " + extension + ", which this program does not know, may refer to it";
}

bool isHarmlessExtension(std::string_view name)
{
    return std::find(std::begin(kHarmless), std::end(kHarmless), name) != std::end(kHarmless);
}

std::vector<std::string> extensionWarnings(const Json& document)
{
    std::vector<std::string> harmless;
    std::vector<std::string> unknown;
    for (const std::string& name : names(document)) {
        if (isHarmlessExtension(name)) {
            harmless.push_back(name);
        } else if (!isSupportedExtension(name) && !isCompression(name)) {
            unknown.push_back(name);
        }
    }
    std::vector<std::string> warnings;
    if (!harmless.empty())
        warnings.push_back("kept in the file but not read, as baked light does not need them: " + listOf(harmless));
    if (!unknown.empty())
        warnings.push_back("kept in the file but not read, as this program does not know them: " + listOf(unknown));
    return warnings;
}

} // namespace halflight
