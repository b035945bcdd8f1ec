#pragma once
// Core glTF of a bake, for viewers that read no extension of Halflight's: pictures of lit surfaces on unlit or emissive
// materials.

#include "halflight/base/image.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace halflight {

/// Unlit: KHR_materials_unlit, the picture as base colour. Emissive: black, the picture as emission with
/// KHR_materials_emissive_strength.
enum class ExportStyle { Unlit, Emissive };
/// "unlit", "emissive".
const char* nameOf(ExportStyle style);

struct ExportOptions {
    ExportStyle style = ExportStyle::Unlit;
    float strength = 1.0f;   ///< Emissive: what a texel of 1 stands for
    float exposureEv = 0.0f; ///< of the pictures: lights, and emission of other materials, are multiplied by 2^-ev too
    std::string generator = "Halflight";
    std::function<bool()> mayReplace; ///< as WriteOptions::mayReplace
};

struct ExportReport {
    uint64_t bytes = 0;              ///< of the file
    uint64_t pictures = 0;           ///< bytes of the surfaces' pictures
    std::size_t surfaces = 0;        ///< objects with a picture
    std::vector<std::string> others; ///< names of objects without lightmap texels, which keep their materials
    std::vector<std::string> warnings;
};

/// Writes a GLB: the source document without any HALFLIGHT_* extension, where the parts of lightmapped objects have
/// their place on the pictures as TEXCOORD_0 and one of few new materials. `pages`: sRGB and opacity in the lightmaps'
/// layout, one per lightmap page, of any size. Alpha modes and double-sidedness stay. Unlit materials of the source
/// stay. Instances become nodes. Materials and textures that nothing uses any more are left out.
Status writeExport(const std::filesystem::path& path, BakedScene baked, const std::vector<ImageRgba8>& pages,
                   const ExportOptions& options, ExportReport& report);

} // namespace halflight
