#pragma once
// Cuts the meshes of a scene where surfaces cross (CrossingTest).

#include "unwrap/cuts/crossings.h"
#include "unwrap/pack/pages.h"

namespace halflight::charts {

struct SceneCuts {
    int count = 0;
    /// By mesh, the result of cutMesh(); empty for meshes without cuts, and beyond the last one with cuts.
    std::vector<std::vector<uint32_t>> portions;

    /// By mesh and triangle, texels of the mean density over those of the triangle, along a side; empty = all 1.
    std::vector<std::vector<float>> texelWidths;

    [[nodiscard]] std::span<const uint32_t> of(int mesh) const { return listOf(portions, mesh); }
    [[nodiscard]] std::span<const float> texelWidthsOf(int mesh) const { return listOf(texelWidths, mesh); }

private:
    template<typename T> static std::span<const T> listOf(const std::vector<std::vector<T>>& lists, int mesh)
    {
        return std::size_t(mesh) < lists.size() ? std::span<const T>(lists[std::size_t(mesh)]) : std::span<const T>();
    }
};

/// Cuts the meshes of groups that get new layouts. Objects with cuts get a mesh of their own. `texelMeters`: the size
/// of a texel to come, of objects with a lightmapScale of 1.
SceneCuts cutScene(Scene& scene, const std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces,
                   double texelMeters, const CrossingTest& test, std::vector<std::string>& warnings);

} // namespace halflight::charts
