// Orientation repair of double-sided faces by ray casting, patch by patch (Takayama et al. 2014, "A Simple Method for
// Correcting Facet Orientations in Polygon Meshes Based on Ray Casting"). A lightmap stores light for the front side. A
// face whose front bounds a narrow, closed cavity would be black there, and is seen from its back alone.
#include "bake/geometry/facet_orientation.h"
#include "bake/geometry/flatten.h"
#include "bake/geometry/solids.h"
#include "bake/geometry/surfaces_along.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace halflight {
namespace {

constexpr float kWidestMeters = 1.0f; ///< a cavity is narrower than rooms,
constexpr float kWidestShare = 0.1f;  ///< and than this share of the scene's diagonal
constexpr float kLift = 1.0e-5f;      ///< start of rays above the surface, over the diagonal: skips coincident faces
constexpr int kRaysOfSide = 256;      ///< on each side: at most 15 of them may leave a cavity
/// Some front rays may leave the cavity, where faces are missing or do not quite meet. So many times as many back rays
/// have to be longer than a cavity is wide.
constexpr int kMoreOpen = 16;
constexpr uint32_t kSeed = 0x5eed0021u;
constexpr int kRaysAtOnce = 32;             ///< of a patch; most are known then to face no cavity
constexpr std::size_t kBlockPatches = 4096; ///< patches that are tested at a time, which bounds memory

using Patch = std::span<const uint32_t>; ///< triangles

Bounds boundsOf(const BakeGeometry& geometry)
{
    Bounds bounds;
    for (const BakeGeometry::Part& part : geometry.parts) {
        for (uint32_t v = part.firstVertex; v < part.firstVertex + part.vertexCount; ++v)
            bounds.extend(geometry.positionOf(part, v));
    }
    return bounds;
}

/// A patch that may face a cavity, with the numbers of its rays that are longer than a cavity is wide.
struct FacetSide {
    Patch patch;
    int front = 0;
    int back = 0;
    /// One more front ray is assumed, so that a few back rays between surfaces prove nothing.
    [[nodiscard]] int enoughBack() const { return kMoreOpen * (front + 1); }
};

class CavityTest {
public:
    CavityTest(const Scene& scene, const BakeGeometry& geometry, const Integrator& integrator)
        : geometry_(geometry), integrator_(integrator), points_(lightAndViewPoints(scene))
    {
        const Bounds bounds = boundsOf(geometry);
        const float diagonal = bounds.empty() ? 0.0f : glm::length(bounds.size());
        widest_ = std::min(kWidestMeters, kWidestShare * diagonal);
        lift_ = kLift * diagonal;
    }

    /// The patches whose front faces a narrow, empty, nearly closed cavity and whose back faces open space.
    [[nodiscard]] Result<std::vector<Patch>> facingCavities(std::span<const Patch> patches) const
    {
        std::vector<Patch> found;
        for (std::size_t first = 0; first < patches.size(); first += kBlockPatches) {
            std::vector<FacetSide> candidates;
            for (const Patch patch : patches.subspan(first, std::min(kBlockPatches, patches.size() - first)))
                candidates.push_back({patch});
            for (int ray = 0; ray < kRaysOfSide && !candidates.empty(); ray += kRaysAtOnce) {
                if (Status s = cast(candidates, ray, false); !s) return s.error();
                std::erase_if(candidates, [](const FacetSide& c) { return c.enoughBack() > kRaysOfSide; });
            }
            for (int ray = 0; ray < kRaysOfSide; ray += kRaysAtOnce)
                if (Status s = cast(candidates, ray, true); !s) return s.error();
            for (const FacetSide& c : candidates) {
                if (c.back < c.enoughBack()) continue;
                const Result<bool> empty = isEmpty(c.patch);
                if (!empty) return empty.error();
                if (*empty) found.push_back(c.patch);
            }
        }
        return found;
    }

private:
    struct Start {
        vec3 position;
        vec3 normal;
        vec3 direction; ///< cosine-distributed
    };
    /// Ray `ray` of kRaysOfSide. All patches use the same random numbers, so that results do not depend on other
    /// patches.
    [[nodiscard]] Start startOf(Patch patch, int ray) const
    {
        const uint32_t triangle = patch[std::size_t(ray) * patch.size() / kRaysOfSide];
        const vec2 b = shading::sampleTriangle(r2Point(int(hashCombine(kSeed, uint32_t(ray)) >> 8)));
        const SurfacePoint point = surfacePoint(geometry_, triangle, b);
        Start s;
        s.position = point.position;
        s.normal = point.geometricNormal;
        vec3 tangent;
        vec3 bitangent;
        shading::orthonormalBasis(s.normal, tangent, bitangent);
        const vec3 local = shading::sampleCosineHemisphere(r2Point(ray));
        s.direction = local.x * tangent + local.y * bitangent + local.z * s.normal;
        return s;
    }
    /// Casts kRaysAtOnce rays of all candidates, from ray `begin` on.
    Status cast(std::vector<FacetSide>& candidates, int begin, bool back) const
    {
        std::vector<Segment> segments(candidates.size() * kRaysAtOnce);
        parallelFor(candidates.size(), 16, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first * kRaysAtOnce; i < last * kRaysAtOnce; ++i) {
                const Start s = startOf(candidates[i / kRaysAtOnce].patch, begin + int(i % kRaysAtOnce));
                const float side = back ? -1.0f : 1.0f;
                const vec3 from = s.position + side * lift_ * s.normal;
                segments[i] = {from, from + widest_ * (side * s.direction)};
            }
        });
        const Result<SurfacesAlong> surfaces = surfacesAlong(integrator_, segments);
        if (!surfaces) return surfaces.error();
        for (std::size_t i = 0; i < segments.size(); ++i) {
            FacetSide& c = candidates[i / kRaysAtOnce];
            (back ? c.back : c.front) += (*surfaces)[i] ? 0 : 1;
        }
        return {};
    }
    /// Whether no light, camera or dynamic object is visible close by in front of a patch.
    [[nodiscard]] Result<bool> isEmpty(Patch patch) const
    {
        std::vector<Segment> segments;
        for (const vec3 point : points_) {
            for (int ray = 0; ray < kRaysOfSide; ++ray) {
                const Start s = startOf(patch, ray);
                const vec3 from = s.position + lift_ * s.normal;
                if (glm::dot(point - from, s.normal) <= 0.0f || glm::distance(from, point) > widest_) continue;
                segments.push_back({from, point});
            }
        }
        const Result<SurfacesAlong> surfaces = surfacesAlong(integrator_, segments);
        if (!surfaces) return surfaces.error();
        return std::all_of(surfaces->begin(), surfaces->end(), [](const auto& s) { return s.has_value(); });
    }

    const BakeGeometry& geometry_;
    const Integrator& integrator_;
    std::vector<vec3> points_;
    float widest_ = 0.0f;
    float lift_ = 0.0f;
};

/// Whether triangles of a part can be flipped: they are double-sided, not emissive, and have texels.
bool isFlippable(const Scene& scene, const BakeGeometry::Part& part)
{
    if (part.material < 0 || part.page < 0 || part.side != SurfaceSide::Both) return false;
    const Material& m = scene.materials[std::size_t(part.material)];
    return m.doubleSided && m.emissiveNits == vec3(0.0f);
}

/// Triangles that can be flipped, by object, from the part `next` on, which moves on: of as few objects as have
/// `enough` triangles.
std::vector<std::vector<uint32_t>> flippableTriangles(const Scene& scene, const BakeGeometry& geometry,
                                                      std::size_t enough, std::size_t& next)
{
    std::vector<std::vector<uint32_t>> objects;
    int last = -1; // parts of an object are adjacent
    std::size_t count = 0;
    for (; next < geometry.parts.size(); ++next) {
        const BakeGeometry::Part& part = geometry.parts[next];
        if (!isFlippable(scene, part)) continue;
        if (part.object != last && count >= enough) break;
        if (part.object != last) objects.emplace_back();
        last = part.object;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            if (!geometry.isSolid(t) && geometry.geometricNormal(t) != vec3(0.0f)) objects.back().push_back(t);
        }
        count += objects.back().size();
    }
    return objects;
}

/// Flips the patches that face cavities. Whether there are any.
Result<bool> flipCavityFaces(const Scene& scene, BakeGeometry& geometry, const Integrator& integrator)
{
    constexpr std::size_t kEnough = 262144; // triangles at a time, which bounds memory
    const CavityTest test(scene, geometry, integrator);
    std::vector<uint32_t> wrong;
    for (std::size_t next = 0; next < geometry.parts.size();) {
        const std::vector<std::vector<uint32_t>> objects = flippableTriangles(scene, geometry, kEnough, next);
        std::vector<std::vector<std::vector<uint32_t>>> patchesOf(objects.size());
        parallelFor(objects.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t o = begin; o < end; ++o) patchesOf[o] = facetPatches(geometry, objects[o]);
        });
        std::vector<Patch> patches;
        for (const auto& ofObject : patchesOf) patches.insert(patches.end(), ofObject.begin(), ofObject.end());
        const Result<std::vector<Patch>> facing = test.facingCavities(patches);
        if (!facing) return facing.error();
        for (const Patch patch : *facing) wrong.insert(wrong.end(), patch.begin(), patch.end());
    }
    flipTriangles(geometry, wrong);
    return !wrong.empty();
}

} // namespace

Result<std::unique_ptr<Integrator>> repairOrientation(const IntegratorFactory& factory, const Scene& scene,
                                                      BakeGeometry& geometry, const IntegrationSettings& settings,
                                                      const Integrator* tree)
{
    if (tree != nullptr) {
        if (Result<bool> flipped = flipCavityFaces(scene, geometry, *tree); !flipped) return flipped.error();
        return factory.make(scene, geometry, settings);
    }
    Result<std::unique_ptr<Integrator>> integrator = factory.make(scene, geometry, settings);
    if (!integrator) return integrator;
    const Result<bool> flipped = flipCavityFaces(scene, geometry, **integrator);
    if (!flipped) return flipped.error();
    if (!*flipped) return integrator;
    return factory.make(scene, geometry, settings);
}

} // namespace halflight
