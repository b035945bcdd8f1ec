#pragma once
// A bake of some objects (BakeSettings::only): its objects and texels, and what the last bake must have in common with
// it, so that the texels of all other objects can keep the light of that bake.

#include "halflight/bake/integrator.h"
#include "halflight/bake/part_folder.h"
#include "halflight/base/hash.h"
#include "halflight/base/result.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace halflight {

/// By object, 1 for those that the entries of BakeSettings::only name. An error for an entry that names none.
Result<std::vector<uint8_t>> chosenObjects(const Scene& scene, const std::vector<std::string>& only);

/// By texel, 1 for those of the objects. An error when there are none.
Result<std::vector<uint8_t>> chosenTexels(const BakeGeometry& geometry, const TexelMap& map,
                                          const std::vector<uint8_t>& objects);

/// Which texels an object has, and which lights the shadowmask's channels belong to.
class TexelOwners {
public:
    TexelOwners(const Scene& scene, const BakeGeometry& geometry, const TexelMap& map);

    void keepIn(PartFolder& folder) const;
    /// An error unless the bake that `folder` belongs to has all objects but the chosen ones at the same texels.
    /// Renamed objects are known by their shape.
    [[nodiscard]] Status compareObjects(const PartFolder& folder, const std::vector<uint8_t>& chosen) const;
    /// The first light whose channel was not its own in the bake that `folder` belongs to; empty: none.
    [[nodiscard]] std::string lightWithoutMask(const PartFolder& folder) const;

private:
    struct Owner {
        std::string name;
        Hash128 texels; ///< their places
        Hash128 shape;  ///< of the mesh
        int object = -1;
    };
    TexelOwners() = default;
    static Result<TexelOwners> readFrom(const PartFolder& folder);

    std::vector<Owner> owners_;                      ///< ascending by name and texels
    std::vector<std::pair<std::string, int>> masks_; ///< lights and their channels, ascending
};

} // namespace halflight
