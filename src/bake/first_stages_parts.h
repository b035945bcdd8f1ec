#pragma once
// Results of the first stages as parts of a cache, so that a worker or a re-bake does not compute them again.

#include "bake/geometry/source_tree.h"

#include "halflight/bake/bake.h"
#include "halflight/bake/part_folder.h"
#include "halflight/unwrap/unwrap.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace halflight {

/// The folder of parts that follow from a scene and the settings of its layout alone. `cache`: folderOfIdentity();
/// nothing where it is empty.
std::optional<PartFolder> frontFolder(const Scene& scene, const BakeSettings& settings,
                                      const std::filesystem::path& cache);

/// Gives folders that are in the places of parts another name, NAME.broken, with what is in them, so that the parts can
/// be written. Returns a sentence on each.
std::vector<std::string> moveFoldersAway(const PartFolder& parts);

/// What unwrap() made of `scene`, whose other members move into it. False, and `scene` unchanged, if it is not kept.
bool takeUnwrapped(const PartFolder& folder, Scene& scene, UnwrappedScene& unwrapped);
/// The test that finds what the last bake of the same surfaces found, if the cache has it. Lights and the sky may have
/// changed: the charts stay, and with them tiles that the change does not affect.
SheetTest keptSheetTest(const Scene& scene, const BakeSettings& settings, const std::filesystem::path& cache,
                        SheetTest test, const SourceTree& tree, const Progress& progress);

void keepUnwrapped(PartFolder& folder, const UnwrappedScene& unwrapped);

bool takeGeometry(const PartFolder& folder, BakeGeometry& geometry);
void keepGeometry(PartFolder& folder, const BakeGeometry& geometry);

/// Texels, before validity.
bool takeTexels(const PartFolder& folder, TexelMap& map);
void keepTexels(PartFolder& folder, const TexelMap& map);

} // namespace halflight
