#pragma once
// Lightmap coordinates and bindings, from groups that have their places.

#include "halflight/unwrap/unwrap.h"
#include "unwrap/pack/pages.h"

#include <vector>

namespace halflight::charts {

/// Writes coordinates, bindings and reports. Groups that keep TEXCOORD_1 share the source mesh's coordinates; any other
/// group but the first of its mesh gets a copy of the mesh, so that no group writes over coordinates of another.
void writeGroups(UnwrappedScene& result, const std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces,
                 const Pages& pages);

} // namespace halflight::charts
