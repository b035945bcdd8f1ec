#pragma once
// Tiling of the scene's surfaces by radiosity patches, while form factors are computed.

#include "transport/radiosity/patch_layout.h"

#include "halflight/base/parallel.h"

#include <unordered_map>

namespace halflight {

/// Index of the axis that a normal is closest to: 2 * axis, plus 1 for the negative direction.
int axisOf(vec3 normal);
float longestEdgeOf(const BakeGeometry& geometry, uint32_t triangle);

/// Chart patches by texel: a rectangle of patches for each chart and axis.
class ChartPatches {
public:
    static constexpr int kAxes = 6;
    struct Rectangle {
        ivec2 min{0};
        ivec2 max{-1};
        uint32_t texels = 0;
        PatchId firstPatch = kNoPatch;

        [[nodiscard]] ivec2 size() const { return max - min + 1; }
        /// Joins texels of another part of the same chart and axis.
        void add(const Rectangle& part)
        {
            min = texels == 0 ? part.min : glm::min(min, part.min);
            max = glm::max(max, part.max);
            texels += part.texels;
        }
    };

    ChartPatches() = default;
    ChartPatches(const BakeGeometry& geometry, const TexelMap& map);

    /// A patch is 2^shift texels wide.
    [[nodiscard]] int shift() const { return shift_; }
    [[nodiscard]] uint32_t patchCount() const { return patchCount_; }
    [[nodiscard]] bool hasTexels(uint32_t triangle) const { return rectangleOfTriangle_[triangle] != ~0u; }
    /// Rectangle of a triangle; null if it has no texels or its chart has no patches.
    [[nodiscard]] const Rectangle* rectangleOf(uint32_t triangle) const;
    /// The axis that a triangle with texels faces.
    [[nodiscard]] int axisOf(uint32_t triangle) const { return int(rectangleOfTriangle_[triangle] % kAxes); }
    /// Front patch of a texel on a triangle, or kNoPatch.
    [[nodiscard]] PatchId patchOf(const Texel& texel, uint32_t triangle) const;
    /// Front patch of a texel's largest fragment, or kNoPatch.
    [[nodiscard]] PatchId patchOf(const TexelMap& map, uint32_t texel) const;

private:
    /// Joins a texel to the rectangles of its fragments' triangles. Threads may add texels to different `parts`.
    void addTexel(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel,
                  std::unordered_map<uint32_t, Rectangle>& parts);

    int shift_ = 0;
    uint32_t patchCount_ = 0;
    std::vector<Rectangle> rectangles_;         ///< by chart and axis
    std::vector<uint32_t> rectangleOfTriangle_; ///< or ~0
};

/// Results of the passes for one patch or element.
struct PatchState {
    bool occluded : 1 = false;  ///< an occluder crosses it, so its two parts may receive different light
    bool hitNear : 1 = false;   ///< rays hit it from less than half its width
    bool hit : 1 = false;       ///< rays hit it; other backs and triangles are not gathered
    bool texelWide : 1 = false; ///< of elements: one texel wide, else half a texel
};

struct Patches {
    Patches(const RayTracer& tracer, const TexelMap& map);

    ChartPatches charts;
    PatchLayout layout;
    std::vector<PatchState> state;   ///< by patch and element
    std::vector<uint32_t> triangles; ///< of triangle patches

    /// Width of a patch or element on a triangle, in metres; of a triangle patch, its longest edge.
    [[nodiscard]] float widthOf(PatchId patch, const BakeGeometry& geometry, uint32_t triangle) const;

    /// Texels of chart patches whose state fulfils a predicate. `firstPatch`: 0 for fronts, chartPatches for backs.
    template<typename Predicate>
    [[nodiscard]] std::vector<uint32_t> texelsIn(const TexelMap& map, PatchId firstPatch, const Predicate& wanted) const
    {
        return indicesWhere(map.texels.size(), [&](std::size_t i) {
            const Texel& texel = map.texels[i];
            for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
                const PatchId patch = charts.patchOf(texel, map.fragments[texel.firstFragment + f].triangle);
                if (patch != kNoPatch && wanted(state[firstPatch + patch])) return true;
            }
            return false;
        });
    }
    /// Splits the chart patches whose state fulfils a predicate. Elements are half a texel wide in patches of one texel
    /// and in occluded patches of four texels, else a texel.
    template<typename Predicate> void split(PatchId firstPatch, const Predicate& wanted)
    {
        for (PatchId patch = firstPatch; patch < firstPatch + layout.chartPatches; ++patch) {
            if (wanted(state[patch]) && layout.elements[patch].split == 0 && !split(patch)) return;
        }
    }

private:
    bool split(PatchId patch);
    void addTriangles(const RayTracer& tracer, const TexelMap& map);
};

} // namespace halflight
