#pragma once
// Variants (KHR_materials_variants) of primitives whose emission is of a light group.

#include "scene/document/document.h"
#include "scene/document/patcher.h"

#include "halflight/scene/baked_scene.h"

#include <map>
#include <set>
#include <utility>
#include <vector>

namespace halflight {

/// Of materials.
inline constexpr const char* kMaterialExtension = "HALFLIGHT_material";

/// A variant takes the place of a material that shines by a group's weight, so it shines by that weight too. The light
/// that was baked is that of the primitive's own material.
class VariantGroups {
public:
    /// `inFile`: the file's material of each scene material. All outlive this.
    VariantGroups(DocumentPatcher& patcher, const SourceDocument& source, const BakedScene& baked,
                  const std::vector<int>& inFile);
    /// Gives the variants of a primitive with this scene material copies that are members of its group.
    void setIn(Json& primitive, int sceneMaterial);

private:
    int memberOf(int material, int group);
    /// Whether primitives of one group alone have the material, all of them as a variant: no copy is needed.
    [[nodiscard]] bool isOfOne(int material) const;

    DocumentPatcher& patcher_;
    const BakedScene& baked_;
    const std::vector<int>& inFile_;
    std::map<int, std::set<int>> groupsOf_;   ///< by material of a variant: groups of the primitives, -1 = none
    std::set<int> own_;                       ///< materials that parts have without a variant
    std::map<std::pair<int, int>, int> made_; ///< by material and group
};

} // namespace halflight
