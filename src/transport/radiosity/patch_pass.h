#pragma once
// One pass over texels or triangles that fills patches.

#include "bake/cache/store.h"
#include "transport/radiosity/patches.h"
#include "transport/texels/texel_group.h"

#include <span>

namespace halflight {

/// Inputs of all passes.
struct RadiosityInput {
    const PathTracer& paths;
    const TexelMap& map;
    const StratifiedPattern& pattern;
    const IntegrationSettings& settings;
    Store store = {}; ///< where other processes share the work
};

/// Patches that a pass fills, in order of the passes: rays of the first one hit the backs and triangles of later ones.
enum class PassKind : uint32_t {
    Fronts,       ///< items are texels
    Elements,     ///< texels of split patches
    Backs,        ///< texels of patches whose backs were hit
    BackElements, ///< texels of patches whose backs are split
    Triangles     ///< items are triangle patches, from the first
};

/// Items that are computed together, in their order.
constexpr std::size_t kRangeItems = 256;

class PatchPass {
public:
    PatchPass(PassKind kind, const Patches& patches, const RadiosityInput& input)
        : kind_(kind), patches_(patches), input_(input)
    {}

    [[nodiscard]] PassKind kind() const { return kind_; }
    [[nodiscard]] bool ofElements() const { return kind_ == PassKind::Elements || kind_ == PassKind::BackElements; }
    [[nodiscard]] const Patches& patches() const { return patches_; }
    [[nodiscard]] const PatchLayout& layout() const { return patches_.layout; }
    [[nodiscard]] const RadiosityInput& input() const { return input_; }

    /// Calls body(group) for all items, eight at a time.
    template<typename Body> void forGroups(std::span<const uint32_t> items, const Body& body) const
    {
        std::array<TexelGroup::Side, kLanes> sides;
        for (std::size_t i = 0; i < items.size(); i += kLanes) {
            const auto some = items.subspan(i, std::min(items.size() - i, std::size_t(kLanes)));
            if (kind_ == PassKind::Triangles) {
                for (std::size_t k = 0; k < some.size(); ++k) sides[k] = sideOf(some[k]);
                body(TexelGroup::triangles(input_.paths, std::span(sides.data(), some.size())));
            } else if (kind_ == PassKind::Backs || kind_ == PassKind::BackElements) {
                body(TexelGroup::backs(input_.paths, input_.map, some));
            } else {
                body(TexelGroup(input_.paths, input_.map, some));
            }
        }
    }

    /// Of triangle patches, an item.
    [[nodiscard]] TexelGroup::Side sideOf(uint32_t item) const { return {patches_.triangles[item / 2], item % 2 != 0}; }
    /// Patch or element that the pass fills from a point, or kNoPatch.
    [[nodiscard]] PatchId sourceOf(const TexelGroup& group, int lane, const SurfacePoint& point) const;
    /// Patch or element whose radiance a hit will have, or kNoPatch. During the first pass that may be any back or
    /// triangle.
    [[nodiscard]] PatchId targetOf(FaceId face, vec2 barycentric) const;
    [[nodiscard]] float widthOf(PatchId patch, uint32_t triangle) const
    {
        return patches_.widthOf(patch, input_.paths.surfaces().geometry(), triangle);
    }

private:
    [[nodiscard]] PatchId openElementAt(FaceId face, vec2 barycentric, PatchId patch) const;

    PassKind kind_;
    const Patches& patches_;
    const RadiosityInput& input_;
};

} // namespace halflight
