#pragma once
// A bake beside its file: pictures and one JSON that binds them by node name, for tools and engines that drop
// extensions. docs/format.md documents it.

#include "halflight/base/image.h"
#include "halflight/base/result.h"
#include "halflight/scene/gltf.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

struct SidecarOptions {
    /// Empty: EXR in lux of `write.irradiance`. Else as the file holds lightmaps.
    std::optional<LightmapFormat> format;
    WriteOptions write; ///< irradiance, progress, generator
};

/// Writes DIR/bake.json and its pictures for a file that writeBakedScene() wrote of `baked`. `warnings`: names that do
/// not tell objects or lights apart.
Status writeSidecar(const std::filesystem::path& folder, const std::filesystem::path& bakedFile,
                    const BakedScene& baked, const SidecarOptions& options, std::vector<std::string>& warnings);

} // namespace halflight
