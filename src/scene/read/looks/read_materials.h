#pragma once
// Materials and textures of a document.

#include "halflight/scene/gltf.h"
#include "scene/document/document.h"
#include "scene/settings/settings.h"

namespace halflight {

struct MaterialsRead {
    std::vector<Material> materials; ///< as many as the file's, in its order
    std::vector<Texture> textures;   ///< those that a material uses
    std::vector<std::string> warnings;
};
/// Marks the rules of `file` that matched.
Result<MaterialsRead> readMaterials(const SourceDocument& document, FileSettings& file, const ReadOptions& options);

} // namespace halflight
