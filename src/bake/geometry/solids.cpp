// Solids: closed surfaces that face outward, found by connectivity alone. Inward-facing ones that are no rooms are
// flipped.
#include "bake/geometry/solids.h"
#include "bake/geometry/components.h"
#include "bake/geometry/flatten.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <span>

namespace halflight {
namespace {

/// Winding number of a closed component around a point, the sum of its triangles' solid angles over 4 pi. It is 1
/// inside an outward-facing component, -1 inside an inward-facing one, 0 outside (Van Oosterom and Strackee 1983, "The
/// Solid Angle of a Plane Triangle", eq. 8).
double windingNumber(const BakeGeometry& geometry, const Component& component, vec3 point)
{
    double sum = 0.0;
    for (const uint32_t t : component.triangles) {
        const std::array<vec3, 3> v = geometry.cornersOf(t);
        const glm::dvec3 a(v[0] - point);
        const glm::dvec3 b(v[1] - point);
        const glm::dvec3 c(v[2] - point);
        const double la = glm::length(a);
        const double lb = glm::length(b);
        const double lc = glm::length(c);
        sum += math::atan(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return sum / (2.0 * double(kPi));
}

bool within(const Bounds& inner, const Bounds& outer)
{
    return glm::all(glm::lessThanEqual(outer.min, inner.min)) && glm::all(glm::greaterThanEqual(outer.max, inner.max));
}

/// A cavity is an inward-facing component within a solid. It counts as part of the solid, so that a ray from within the
/// cavity enters the solid before it leaves it. An inward-facing room within no solid is none: objects in the room
/// would lie inside it.
bool isCavity(const BakeGeometry& geometry, const Component& component, std::span<const Component> solids)
{
    const vec3 point = geometry.centroid(component.triangles.front());
    return std::any_of(solids.begin(), solids.end(), [&](const Component& solid) {
        return within(component.bounds, solid.bounds) && windingNumber(geometry, solid, point) > 0.5;
    });
}

/// Finds inverted components: inward-facing ones that are double-sided, not emissive, empty, and not the whole scene. A
/// room has objects, a light or a camera in it, or is the whole scene.
class InversionTest {
public:
    InversionTest(const Scene& scene, const BakeGeometry& geometry)
        : scene_(scene), geometry_(geometry), points_(lightAndViewPoints(scene))
    {
        for (const BakeGeometry::Part& part : geometry.parts) {
            Bounds& bounds = boundsOfPart_.emplace_back();
            for (uint32_t v = part.firstVertex; v < part.firstVertex + part.vertexCount; ++v)
                bounds.extend(geometry.positionOf(part, v));
            bounds_.extend(bounds);
            const bool emits = part.material >= 0 && part.triangleCount > 0 &&
                               scene.materials[std::size_t(part.material)].emissiveNits != vec3(0.0f);
            if (emits) emissive_.push_back(part.firstTriangle);
        }
        for (const Light& light : scene.lights)
            if (light.type != LightType::Directional) roomPoints_.push_back(light.position());
        for (const Camera& camera : scene.cameras) roomPoints_.emplace_back(camera.worldFromCamera[3]);
    }

    /// Whether a component is double-sided, not emissive, and not the whole scene.
    [[nodiscard]] bool canBeInverted(const Component& component) const
    {
        return !within(bounds_, component.bounds) &&
               std::all_of(component.triangles.begin(), component.triangles.end(), [&](uint32_t t) {
                   const int material = geometry_.partOf(t).material;
                   if (material < 0) return false;
                   const Material& m = scene_.materials[std::size_t(material)];
                   return m.doubleSided && m.emissiveNits == vec3(0.0f);
               });
    }
    /// Whether an outward-facing component is a room: double-sided, with a light, a camera or an emissive surface in
    /// it. One sees its inside.
    [[nodiscard]] bool isRoom(const Component& component) const
    {
        const auto inside = [&](vec3 point) {
            return within({point, point}, component.bounds) && windingNumber(geometry_, component, point) > 0.5;
        };
        const auto emitsInside = [&](uint32_t triangle) {
            return !std::binary_search(component.triangles.begin(), component.triangles.end(), triangle) &&
                   inside(geometry_.centroid(triangle));
        };
        const bool occupied = std::any_of(roomPoints_.begin(), roomPoints_.end(), inside) ||
                              std::any_of(emissive_.begin(), emissive_.end(), emitsInside);
        return occupied && std::all_of(component.triangles.begin(), component.triangles.end(), [&](uint32_t t) {
                   const int material = geometry_.partOf(t).material;
                   return material >= 0 && scene_.materials[std::size_t(material)].doubleSided;
               });
    }
    /// Whether a component contains nothing as a whole: no component of `among` (sorted by their bounds' least x), no
    /// part without triangles in it, no point of lightAndViewPoints(). Objects that cross its surface do not count,
    /// such as plants in a pond.
    [[nodiscard]] bool isEmpty(const Component& component, std::span<const Components::Any> among) const
    {
        auto other = std::lower_bound(among.begin(), among.end(), component.bounds.min.x,
                                      [](const Components::Any& c, float x) { return c.bounds.min.x < x; });
        for (; other != among.end() && other->bounds.min.x <= component.bounds.max.x; ++other) {
            const bool own =
                std::binary_search(component.triangles.begin(), component.triangles.end(), other->triangle);
            if (!own && within(other->bounds, component.bounds) &&
                holds(component, geometry_.centroid(other->triangle)))
                return false;
        }
        for (uint32_t i = 0; i < boundsOfPart_.size(); ++i) {
            const BakeGeometry::Part& part = geometry_.parts[i];
            const bool inside = !boundsOfPart_[i].empty() && within(boundsOfPart_[i], component.bounds);
            if (inside && !hasTriangleOf(component, part) &&
                holds(component, geometry_.positionOf(part, part.firstVertex)))
                return false;
        }
        return std::none_of(points_.begin(), points_.end(), [&](vec3 point) { return holds(component, point); });
    }

private:
    [[nodiscard]] bool holds(const Component& component, vec3 point) const
    {
        return within({point, point}, component.bounds) && windingNumber(geometry_, component, point) < -0.5;
    }
    static bool hasTriangleOf(const Component& component, const BakeGeometry::Part& part)
    {
        const auto next = std::lower_bound(component.triangles.begin(), component.triangles.end(), part.firstTriangle);
        return next != component.triangles.end() && *next < part.firstTriangle + part.triangleCount;
    }

    const Scene& scene_;
    const BakeGeometry& geometry_;
    std::vector<vec3> points_;
    std::vector<vec3> roomPoints_;   ///< local lights and cameras: what is around them is a room
    std::vector<uint32_t> emissive_; ///< a triangle of each emissive part: likewise
    std::vector<Bounds> boundsOfPart_;
    Bounds bounds_;
};

bool ofOneObject(const BakeGeometry& geometry, const Component& component)
{
    const auto objectOf = [&](uint32_t t) { return geometry.partOf(t).object; };
    return objectOf(component.triangles.front()) ==
           objectOf(component.triangles.back()); // triangles are sorted by object
}

/// Marks the solids among the listed triangles, and flips inverted components. `together`: the triangles are of several
/// objects, each of which has been tested by itself. False: components of shared triangles may be inverted, which only
/// the place of each instance decides; nothing is flipped then.
bool markSolids(BakeGeometry& geometry, std::span<const uint32_t> triangles, const InversionTest& inversion,
                bool together)
{
    Components components = componentsOf(geometry, triangles);
    const auto mark = [&](const Component& component) {
        if (together) storeInWorldSpace(geometry, component.triangles);
        for (const uint32_t t : component.triangles) geometry.solid[geometry.storedOf(t).index] = 1;
    };
    const bool shared = !together && geometry.storedOf(triangles.front()).instance != nullptr;
    for (const Component& component : components.solids)
        if (shared || !inversion.isRoom(component)) mark(component);
    if (components.inward.empty()) return true;
    std::sort(components.all.begin(), components.all.end(),
              [](const auto& a, const auto& b) { return a.bounds.min.x < b.bounds.min.x; });
    for (const Component& component : components.inward) {
        if (isCavity(geometry, component, components.solids)) {
            mark(component);
        } else if (shared) {
            if (inversion.canBeInverted(component)) return false;
        } else if (inversion.canBeInverted(component) && !(together && ofOneObject(geometry, component)) &&
                   inversion.isEmpty(component, components.all)) {
            flipTriangles(geometry, component.triangles);
            mark(component);
        }
    }
    return true;
}

/// Marks solids object by object: objects that touch must not be connected. `parts`: of the objects,
/// in their order.
void markSolidsOfObjects(BakeGeometry& geometry, const InversionTest& inversion, std::span<const uint32_t> parts)
{
    std::vector<uint32_t> firstParts;
    for (const uint32_t i : parts) {
        if (firstParts.empty() || geometry.parts[firstParts.back()].object != geometry.parts[i].object)
            firstParts.push_back(i);
    }
    std::vector<uint8_t> undecided(firstParts.size(), 0);
    parallelFor(firstParts.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t o = begin; o < end; ++o) {
            const int object = geometry.parts[firstParts[o]].object;
            std::vector<uint32_t> list;
            for (std::size_t i = firstParts[o]; i < geometry.parts.size() && geometry.parts[i].object == object; ++i) {
                const BakeGeometry::Part& part = geometry.parts[i];
                if (part.side == SurfaceSide::Back) continue;
                for (uint32_t t = 0; t < part.triangleCount; ++t) list.push_back(part.firstTriangle + t);
            }
            if (!list.empty()) undecided[o] = markSolids(geometry, list, inversion, false) ? 0 : 1;
        }
    });
    // Each object with such a mesh is tested by itself.
    std::vector<uint32_t> again;
    for (std::size_t o = 0; o < firstParts.size(); ++o) {
        if (undecided[o] == 0) continue;
        const BakeGeometry::Part first = geometry.parts[firstParts[o]];
        for (uint32_t i = 0; i < geometry.parts.size(); ++i) {
            const BakeGeometry::Part& part = geometry.parts[i];
            if (part.instance == BakeGeometry::kOwn || part.mesh != first.mesh || part.part != first.part) continue;
            geometry.storeInWorldSpace(i);
            again.push_back(i);
        }
    }
    if (!again.empty()) markSolidsOfObjects(geometry, inversion, again);
}

/// Marks solids that several objects form together: buildings are often one closed surface cut into several objects.
void markSolidsTogether(BakeGeometry& geometry, const InversionTest& inversion)
{
    constexpr std::size_t kMaxTogether = 4'000'000;       // triangles: some 200 bytes each for a while
    constexpr std::size_t kMaxShared = kMaxTogether / 16; // of instances: more are a forest, not a building
    const auto forOpen = [&](const BakeGeometry::Part& part, const auto& body) {
        if (part.side == SurfaceSide::Back) return;
        for (uint32_t t = 0; t < part.triangleCount; ++t) {
            if (geometry.solid[part.firstStored + t] == 0) body(part.firstTriangle + t);
        }
    };
    std::size_t shared = 0;
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.instance != BakeGeometry::kOwn) forOpen(part, [&](uint32_t) { ++shared; });
    }
    std::vector<uint32_t> rest;
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.instance != BakeGeometry::kOwn && shared > kMaxShared) continue;
        forOpen(part, [&](uint32_t t) { rest.push_back(t); });
    }
    if (!rest.empty() && rest.size() <= kMaxTogether) markSolids(geometry, rest, inversion, true);
}

} // namespace

std::vector<vec3> lightAndViewPoints(const Scene& scene)
{
    std::vector<vec3> points;
    for (const Light& light : scene.lights) {
        if (light.type != LightType::Directional) points.push_back(light.position());
    }
    for (const Camera& camera : scene.cameras) points.emplace_back(camera.worldFromCamera[3]);
    for (const Object& object : scene.objects) {
        if (!object.isStatic) points.emplace_back(object.worldFromObject[3]);
    }
    return points;
}

void storeInWorldSpace(BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    if (geometry.instances.empty()) return;
    for (const uint32_t t : triangles) geometry.storeInWorldSpace(geometry.partNumberOf(t));
}

void flipTriangles(BakeGeometry& geometry, std::span<const uint32_t> triangles)
{
    storeInWorldSpace(geometry, triangles);
    for (const uint32_t t : triangles) {
        const uint32_t stored = geometry.storedOf(t).index;
        geometry.flipped[stored] = 1;
        uvec3& v = geometry.triangles[stored];
        std::swap(v.y, v.z);
        geometry.frames[stored].normal = -geometry.frames[stored].normal;
        for (int corner = 0; corner < 3; ++corner) {
            vec3& normal = geometry.normals[v[corner]];
            if (glm::dot(normal, geometry.frames[stored].normal) < 0.0f) normal = -normal;
        }
    }
}

void findSolids(const Scene& scene, BakeGeometry& geometry)
{
    geometry.solid.assign(geometry.triangles.size(), 0);
    geometry.flipped.assign(geometry.triangles.size(), 0);
    const InversionTest inversion(scene, geometry);
    markSolidsOfObjects(geometry, inversion, partsOnce(geometry));
    markSolidsTogether(geometry, inversion);
}

} // namespace halflight
