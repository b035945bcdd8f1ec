#include "transport/radiosity/patches.h"

#include "halflight/base/atomic_ref.h"
#include "halflight/base/parallel.h"

#include <cmath>

namespace halflight {
namespace {

/// Chart patches are as small as keeps their number near this.
constexpr std::size_t kFewPatches = 24576;
constexpr int kMaxPatchShift = 3;
/// Longest edge of a triangle patch, in widths of chart patches.
constexpr float kLongestEdgeInPatches = 2.0f;

/// Width of a texel, in the mean over the covered area.
float meanTexelMeters(const BakeGeometry& geometry, const TexelMap& map)
{
    struct Sums {
        double meters = 0.0;
        double texels = 0.0;
    };
    constexpr std::size_t kBlock = 65536; // fragments; sums of blocks do not depend on threads
    std::vector<Sums> sums((map.fragments.size() + kBlock - 1) / kBlock);
    parallelFor(sums.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin * kBlock; i < std::min(end * kBlock, map.fragments.size()); ++i) {
            const TexelFragment& f = map.fragments[i];
            sums[i / kBlock].meters += double(f.area) * double(geometry.texelMeters(f.triangle));
            sums[i / kBlock].texels += double(f.area);
        }
    });
    Sums all;
    for (const Sums& s : sums) all = {all.meters + s.meters, all.texels + s.texels};
    return all.texels > 0.0 ? float(all.meters / all.texels) : 0.0f;
}

} // namespace

int axisOf(vec3 normal)
{
    const vec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
}

float longestEdgeOf(const BakeGeometry& geometry, uint32_t triangle)
{
    const auto [a, b, c] = geometry.cornersOf(triangle);
    return std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
}

PatchId PatchLayout::elementAt(FaceId face, vec2 barycentric, PatchId patch) const
{
    const Elements& e = elements[patch];
    if (e.split == 0) return kNoPatch;
    const Surface& s = surface(face);
    const vec2 at = s.origin + barycentric.x * s.edgeU + barycentric.y * s.edgeV;
    const int shift = elementShift(patch);
    return e.first + (shading::elementNumberAlong(at.y, s.height, shift) << shift) +
           shading::elementNumberAlong(at.x, s.width, shift);
}

ChartPatches::ChartPatches(const BakeGeometry& geometry, const TexelMap& map)
{
    while (shift_ < kMaxPatchShift && map.texels.size() >> (2 * (shift_ + 1)) >= kFewPatches) ++shift_;
    rectangles_.assign(std::size_t(map.chartCount) * kAxes, {});
    rectangleOfTriangle_.assign(geometry.triangleCount(), ~0u);
    // Blocks of texels find their parts of the rectangles.
    constexpr std::size_t kBlock = 16384; // texels, of few charts each
    std::vector<std::unordered_map<uint32_t, Rectangle>> partsOf((map.texels.size() + kBlock - 1) / kBlock);
    parallelFor(partsOf.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin * kBlock; i < std::min(end * kBlock, map.texels.size()); ++i)
            addTexel(geometry, map, map.texels[i], partsOf[i / kBlock]);
    });
    for (const auto& parts : partsOf) {
        for (const auto& [number, part] : parts) rectangles_[number].add(part);
    }
    // Rectangles of charts whose texels are scattered over the page (possible in kept layouts) would waste memory.
    // These charts have no patches, and paths continue there.
    uint64_t count = 0;
    for (Rectangle& r : rectangles_) {
        const ivec2 size = r.size();
        const uint64_t area = uint64_t(std::max(size.x, 0)) * uint64_t(std::max(size.y, 0));
        if (area == 0 || area > 64 + 16 * (uint64_t(r.texels) >> (2 * shift_)) || count + area > kMaxPatches / 4)
            continue;
        r.firstPatch = PatchId(count);
        count += area;
    }
    patchCount_ = uint32_t(count);
}

void ChartPatches::addTexel(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel,
                            std::unordered_map<uint32_t, Rectangle>& parts)
{
    const ivec2 place(texel.x >> shift_, texel.y >> shift_);
    for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
        const uint32_t triangle = map.fragments[texel.firstFragment + f].triangle;
        if (geometry.partOf(triangle).side == SurfaceSide::Back) continue; // rays meet the front half, which has both
        // A triangle lies in one chart, so that all threads write the same number.
        const AtomicRef<uint32_t> number(rectangleOfTriangle_[triangle]);
        if (number.load(std::memory_order_relaxed) == ~0u) {
            const int axis = halflight::axisOf(geometry.geometricNormal(triangle));
            number.store(texel.chart * kAxes + uint32_t(axis), std::memory_order_relaxed);
        }
        parts[number.load(std::memory_order_relaxed)].add({place, place, 1});
    }
}

const ChartPatches::Rectangle* ChartPatches::rectangleOf(uint32_t triangle) const
{
    const uint32_t number = rectangleOfTriangle_[triangle];
    return number != ~0u && rectangles_[number].firstPatch != kNoPatch ? &rectangles_[number] : nullptr;
}

PatchId ChartPatches::patchOf(const Texel& texel, uint32_t triangle) const
{
    const Rectangle* r = rectangleOf(triangle);
    if (r == nullptr) return kNoPatch;
    const ivec2 at = ivec2(texel.x >> shift_, texel.y >> shift_) - r->min;
    return r->firstPatch + uint32_t(at.y * r->size().x + at.x);
}

PatchId ChartPatches::patchOf(const TexelMap& map, uint32_t texel) const
{
    const Texel& t = map.texels[texel];
    return patchOf(t, map.fragments[t.firstFragment].triangle);
}

Patches::Patches(const RayTracer& tracer, const TexelMap& map) : charts(tracer.geometry(), map)
{
    const BakeGeometry& geometry = tracer.geometry();
    layout.patchShift = charts.shift();
    layout.chartPatches = charts.patchCount();
    layout.surfaces.assign(tracer.hitTriangleCount(), {});
    layout.hitIndexOfTriangle.assign(geometry.triangleCount(), ~0u);
    for (uint32_t index = 0; index < tracer.hitTriangleCount(); ++index) {
        const uint32_t triangle = tracer.triangleAt(index);
        layout.hitIndexOfTriangle[triangle] = index;
        PatchLayout::Surface& s = layout.surfaces[index];
        if (const ChartPatches::Rectangle* r = charts.rectangleOf(triangle)) {
            const std::array<vec2, 3> t = geometry.texelsOf(triangle);
            const float scale = 1.0f / float(1 << charts.shift());
            s.origin = t[0] * scale - vec2(r->min);
            s.edgeU = (t[1] - t[0]) * scale;
            s.edgeV = (t[2] - t[0]) * scale;
            s.hasPatches = 1;
            s.firstPatch = r->firstPatch & kMaxPatches;
            s.width = uint16_t(r->size().x);
            s.height = uint16_t(r->size().y);
        }
        s.emissive = tracer.materials().of(triangle).emission != vec3(0.0f) ? 1 : 0;
    }
    addTriangles(tracer, map);
    state.assign(2 * std::size_t(layout.chartPatches) + 2 * triangles.size(), {});
    layout.elements.assign(state.size(), {});
}

/// Makes patches of small triangles without a lightmap (leaves, grass), of at most as many as the map has texels.
void Patches::addTriangles(const RayTracer& tracer, const TexelMap& map)
{
    const BakeGeometry& geometry = tracer.geometry();
    layout.texelMeters = meanTexelMeters(geometry, map);
    const float longest = kLongestEdgeInPatches * float(1 << layout.patchShift) * layout.texelMeters;
    const std::size_t most = map.texels.size();
    for (uint32_t index = 0; index < tracer.hitTriangleCount() && triangles.size() < most; ++index) {
        const uint32_t triangle = tracer.triangleAt(index);
        PatchLayout::Surface& s = layout.surfaces[index];
        if (s.hasPatches != 0 || charts.hasTexels(triangle)) continue;
        if (!(longestEdgeOf(geometry, triangle) <= longest)) continue;
        const PatchId patch = 2 * layout.chartPatches + 2 * uint32_t(triangles.size());
        if (patch + 1 > kMaxPatches) break;
        triangles.push_back(triangle);
        s.hasPatches = 1;
        s.firstPatch = patch & kMaxPatches;
        s.width = s.height = 1;
    }
}

/// False if there would be too many patches.
bool Patches::split(PatchId patch)
{
    const bool half = layout.patchShift == 0 || (layout.patchShift == 1 && state[patch].occluded);
    const std::size_t next = state.size() + (std::size_t(1) << (2 * (layout.patchShift + (half ? 1 : 0))));
    if (next > kMaxPatches) return false;
    layout.elements[patch] = {uint32_t(state.size()) & kMaxPatches, half ? 1u : 0u, 1};
    PatchState element;
    element.texelWide = !half;
    state.resize(next, element);
    return true;
}

float Patches::widthOf(PatchId patch, const BakeGeometry& geometry, uint32_t triangle) const
{
    if (patch >= 2 * layout.chartPatches && patch < layout.patchCount()) return longestEdgeOf(geometry, triangle);
    float texels = float(1 << layout.patchShift);
    if (patch >= layout.patchCount()) texels = state[patch].texelWide ? 1.0f : 0.5f;
    return texels * geometry.texelMeters(triangle);
}

} // namespace halflight
