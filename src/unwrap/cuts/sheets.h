#pragma once
// Double-sided sheets whose sides have texels of their own (SheetTest).

#include "unwrap/cuts/cut_scene.h"

namespace halflight::charts {

/// Undoes doubleSheets(): drops the back halves of sheets, and makes the front halves double-sided again.
void joinSheets(Scene& scene);

/// Writes the triangles of sheets twice, as a front half and a back half (SurfaceSide), and notes what texels of the
/// other triangles hold. Each half is a part of its own; the back half follows its front half, with the same triangles
/// in the same order. `texels`: by mesh, as SheetTest says. `kept`: by mesh, 1 where it keeps the file's TEXCOORD_1,
/// which has no room for a second side. `cuts.portions` gets different numbers for both halves. Returns whether
/// anything changed.
bool doubleSheets(Scene& scene, const std::vector<std::vector<SheetTexels>>& texels, std::span<const uint8_t> kept,
                  SceneCuts& cuts, std::vector<std::string>& warnings);

} // namespace halflight::charts
