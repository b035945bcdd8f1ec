#include "transport/radiosity/patch_pass.h"

namespace halflight {

/// Element at a point that no occluder crosses, or kNoPatch.
PatchId PatchPass::openElementAt(FaceId face, vec2 barycentric, PatchId patch) const
{
    const PatchId element = layout().elementAt(face, barycentric, patch);
    return element == kNoPatch || patches_.state[element].occluded ? kNoPatch : element;
}

PatchId PatchPass::sourceOf(const TexelGroup& group, int lane, const SurfacePoint& point) const
{
    FaceId face;
    if (!layout().faceOf(point.triangle, group.onBack(lane), face) || !layout().hasPatches(face)) return kNoPatch;
    const PatchId patch = layout().patchAt(face, point.barycentric);
    const PatchState state = patches_.state[patch];
    switch (kind_) {
    case PassKind::Fronts:
        return state.occluded ? openElementAt(face, point.barycentric, patch) : patch;
    case PassKind::Elements:
    case PassKind::BackElements:
        return openElementAt(face, point.barycentric, patch);
    case PassKind::Backs:
    case PassKind::Triangles:
        return state.hit && !state.occluded ? patch : kNoPatch;
    }
    return kNoPatch;
}

PatchId PatchPass::targetOf(FaceId face, vec2 barycentric) const
{
    if (!layout().hasPatches(face)) return kNoPatch;
    const PatchId patch = layout().patchAt(face, barycentric);
    const PatchState state = patches_.state[patch];
    if (state.occluded) return openElementAt(face, barycentric, patch);
    const bool filled = patch < layout().chartPatches || kind_ == PassKind::Fronts || state.hit;
    return filled ? patch : kNoPatch;
}

} // namespace halflight
