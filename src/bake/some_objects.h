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
    /// An error unless the bake that `folder` belongs to has the same objects at the same texels, and at least the
    /// lights of this one in the same channels.
    [[nodiscard]] Status compareWith(const PartFolder& folder) const;

private:
    TexelOwners() = default;
    static Result<TexelOwners> readFrom(const PartFolder& folder);

    std::vector<std::pair<std::string, Hash128>> owners_; ///< objects and a hash of their texels' places, ascending
    std::vector<std::pair<std::string, int>> masks_;      ///< lights and their channels, ascending
};

} // namespace halflight
