// Sheets are connected pieces of double-sided surfaces that bound no solid. A lightmap stores light for one side. A
// sheet gets texels for the other side too where both can be seen and their light differs. A side can be seen if random
// walks from it leave the scene, meet emission, or come in sight of a light or a camera.
#include "bake/sides/sheet_sides.h"

#include "bake/geometry/solids.h"

#include "bake/geometry/components.h"

#include "halflight/base/parallel.h"
#include "halflight/base/random.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <span>
#include <utility>

namespace halflight {
namespace {

constexpr int kPoints = 128;    ///< of a sheet, spread evenly over its area
constexpr int kFewPoints = 8;   ///< of a sheet too small for texels of its own
constexpr int kPaths = 4;       ///< of a point and side, for its irradiance
constexpr int kWalks = 2;       ///< of a point and side, twice as many in all
constexpr float kOpen = 0.05f;  ///< least share of a visible side's walks that get out; gaps in walls let a few through
constexpr float kDiffer = 0.1f; ///< difference of both sides' light, over the brighter one, that shows
constexpr float kEven = 0.02f;  ///< most deviation of an even side's estimates, over the brighter side's light
constexpr float kLeastTexels = 4.0f; ///< area of a sheet with texels for both sides; smaller ones are leaves
constexpr uint32_t kSeed = 0x5eed0061u;

struct Sheet {
    int mesh = -1;
    TwoSided twoSided = TwoSided::Automatic;
    std::vector<uint32_t> triangles;
    float areaTexels = 0.0f;
    std::size_t firstPoint = 0; ///< on its front; those on its back follow
    int points = 0;
};

float areaOf(const BakeGeometry& geometry, uint32_t triangle)
{
    const auto [a, b, c] = geometry.cornersOf(triangle);
    return 0.5f * glm::length(glm::cross(b - a, c - a));
}

/// Triangles of an object that may belong to sheets.
std::vector<uint32_t> sheetTriangles(const Scene& scene, const BakeGeometry& geometry, std::size_t firstPart)
{
    std::vector<uint32_t> triangles;
    const int object = geometry.parts[firstPart].object;
    for (std::size_t p = firstPart; p < geometry.parts.size() && geometry.parts[p].object == object; ++p) {
        const BakeGeometry::Part& part = geometry.parts[p];
        if (part.material < 0 || !scene.materials[std::size_t(part.material)].doubleSided) continue;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t)
            if (!geometry.isSolid(t) && geometry.geometricNormal(t) != vec3(0.0f)) triangles.push_back(t);
    }
    return triangles;
}

std::vector<Sheet> findSheets(const Scene& scene, const BakeGeometry& geometry, TwoSided mode, double texelMeters)
{
    constexpr std::size_t kMostObjects = 8; // of a mesh, which are representative
    std::map<int, std::size_t> objectsOfMesh;
    std::vector<std::size_t> firstParts;
    for (std::size_t p = 0; p < geometry.parts.size(); ++p) {
        const BakeGeometry::Part& part = geometry.parts[p];
        if (p > 0 && geometry.parts[p - 1].object == part.object) continue;
        if (!(scene.objects[std::size_t(part.object)].lightmapScale > 0.0f)) continue;
        if (objectsOfMesh[part.mesh]++ < kMostObjects) firstParts.push_back(p);
    }
    std::vector<std::vector<Sheet>> ofObject(firstParts.size());
    parallelFor(firstParts.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::vector<uint32_t> triangles = sheetTriangles(scene, geometry, firstParts[i]);
            if (triangles.empty()) continue;
            const Object& object = scene.objects[std::size_t(geometry.parts[firstParts[i]].object)];
            for (std::vector<uint32_t>& piece : connectedPieces(geometry, triangles)) {
                Sheet& sheet = ofObject[i].emplace_back();
                sheet.mesh = object.mesh;
                sheet.twoSided = object.twoSided == TwoSided::Automatic ? mode : object.twoSided;
                double area = 0.0;
                for (const uint32_t t : piece) area += double(areaOf(geometry, t));
                const double texel = texelMeters / double(object.lightmapScale);
                sheet.areaTexels = float(area / (texel * texel));
                sheet.triangles = std::move(piece);
            }
        }
    });
    std::vector<Sheet> sheets;
    for (std::vector<Sheet>& list : ofObject) std::move(list.begin(), list.end(), std::back_inserter(sheets));
    return sheets;
}

/// Points of a sheet, evenly spread over its area; the first half on the front, the others the same on the back.
std::vector<SurfacePoint> pointsOf(const BakeGeometry& geometry, const Sheet& sheet)
{
    std::vector<double> sums;
    double area = 0.0;
    for (const uint32_t t : sheet.triangles) sums.push_back(area += double(areaOf(geometry, t)));
    std::vector<SurfacePoint> points;
    for (int i = 0; i < sheet.points; ++i) {
        const double at = (double(i) + 0.5) / double(sheet.points) * area;
        const auto found = std::upper_bound(sums.begin(), sums.end(), at) - sums.begin();
        const auto triangle = std::min(std::size_t(found), sums.size() - 1);
        const vec2 u = r2Point(int(hashCombine(kSeed, uint32_t(i)) >> 8));
        points.push_back(surfacePoint(geometry, sheet.triangles[triangle], shading::sampleTriangle(u)));
    }
    for (int i = 0; i < sheet.points; ++i) {
        SurfacePoint back = points[std::size_t(i)];
        back.normal = -back.normal;
        back.geometricNormal = -back.geometricNormal;
        points.push_back(back);
    }
    return points;
}

/// What both sides of a sheet receive, from two independent estimates of each point: their product is free of noise in
/// the mean.
class SideLight {
public:
    SideLight(std::span<const SideEstimate> first, std::span<const SideEstimate> second)
        : first_(first), second_(second)
    {
        for (std::size_t i = 0; i < count(); ++i) {
            for (std::size_t side = 0; side < 2; ++side) {
                mean_[side] += at(first_, side, i) + at(second_, side, i);
                open_[side] += 0.5f * (first_[side * count() + i].open + second_[side * count() + i].open);
                isLit_[side] = isLit_[side] || first_[side * count() + i].direct != vec3(0.0f);
            }
        }
        for (std::size_t side = 0; side < 2; ++side) {
            mean_[side] /= 2.0 * double(count());
            open_[side] /= float(count());
        }
    }

    [[nodiscard]] bool isVisible(std::size_t side) const { return open_[side] >= kOpen; }
    /// Whether the sides differ by more than kDiffer of the brighter, in the root mean square.
    [[nodiscard]] bool differs() const
    {
        double square = 0.0;
        for (std::size_t i = 0; i < count(); ++i)
            square += (at(first_, 0, i) - at(first_, 1, i)) * (at(second_, 0, i) - at(second_, 1, i));
        return square / double(count()) > kDiffer * kDiffer * brighter() * brighter();
    }
    /// Whether the light of a side is the same everywhere, so that few texels hold it.
    [[nodiscard]] bool isEven(std::size_t side) const
    {
        if (isLit_[side]) return false; // a mask may need all texels
        const double most = double(kEven) * brighter();
        for (std::size_t i = 0; i < count(); ++i)
            if (std::abs(at(first_, side, i) - mean_[side]) > most ||
                std::abs(at(second_, side, i) - mean_[side]) > most)
                return false;
        return true;
    }

private:
    using Estimates = std::span<const SideEstimate>;
    [[nodiscard]] std::size_t count() const { return first_.size() / 2; }
    [[nodiscard]] double at(Estimates estimates, std::size_t side, std::size_t i) const
    {
        return double(luminance(estimates[side * count() + i].irradiance));
    }
    [[nodiscard]] double brighter() const { return std::max(mean_[0], mean_[1]); }

    Estimates first_;
    Estimates second_;
    std::array<double, 2> mean_{}; ///< front, back
    std::array<float, 2> open_{};
    std::array<bool, 2> isLit_{};
};

SheetTexels texelsOf(const Sheet& sheet, const SideLight& light)
{
    const bool front = light.isVisible(0);
    const bool back = light.isVisible(1);
    if (!front && back) return SheetTexels::Back;
    if (!back) return SheetTexels::Front;
    const bool isLeaf = sheet.areaTexels < kLeastTexels;
    if (sheet.twoSided != TwoSided::On && (isLeaf || !light.differs())) return SheetTexels::Mean;
    if (sheet.twoSided == TwoSided::Off) return SheetTexels::FrontOfBoth;
    if (light.isEven(1)) return SheetTexels::BothWithEvenBack;
    return light.isEven(0) ? SheetTexels::BothWithEvenFront : SheetTexels::Both;
}

/// Of two objects with one mesh, what serves both.
SheetTexels forBoth(SheetTexels a, SheetTexels b)
{
    if (a == b) return a;
    if (isDoubled(a) && isDoubled(b)) return SheetTexels::Both;
    if (isDoubled(a) || isDoubled(b)) return isDoubled(a) ? a : b;
    return SheetTexels::Mean;
}

/// The results by mesh and triangle.
class MeshTexels {
public:
    MeshTexels(const Scene& scene, const BakeGeometry& geometry)
        : geometry_(geometry), first_(scene.objects.size(), ~0u), count_(scene.objects.size(), 0),
          texels_(scene.meshes.size()), known_(scene.meshes.size())
    {
        for (const BakeGeometry::Part& part : geometry.parts) {
            first_[std::size_t(part.object)] = std::min(first_[std::size_t(part.object)], part.firstTriangle);
            count_[std::size_t(part.object)] += part.triangleCount;
        }
    }
    void add(const Sheet& sheet, SheetTexels texels)
    {
        const auto object = std::size_t(geometry_.partOf(sheet.triangles.front()).object);
        std::vector<SheetTexels>& ofMesh = texels_[std::size_t(sheet.mesh)];
        std::vector<uint8_t>& known = known_[std::size_t(sheet.mesh)];
        ofMesh.resize(count_[object], SheetTexels::Front);
        known.resize(count_[object], 0);
        for (const uint32_t t : sheet.triangles) {
            const std::size_t own = t - first_[object];
            ofMesh[own] = known[own] != 0 ? forBoth(ofMesh[own], texels) : texels;
            known[own] = 1;
        }
    }
    std::vector<std::vector<SheetTexels>> take() { return std::move(texels_); }

private:
    const BakeGeometry& geometry_;
    std::vector<uint32_t> first_; ///< triangle of each object
    std::vector<uint32_t> count_; ///< of triangles, by object
    std::vector<std::vector<SheetTexels>> texels_;
    std::vector<std::vector<uint8_t>> known_;
};

} // namespace

SheetTest sheetSidesTest(SourceTree& tree, TwoSided mode, const Progress& progress)
{
    return [&tree, mode, &progress](const Scene& scene, double texelMeters) {
        std::vector<std::vector<SheetTexels>> texels(scene.meshes.size());
        const BakeGeometry& geometry = tree.geometryOf(scene);
        std::vector<Sheet> sheets = findSheets(scene, geometry, mode, texelMeters);
        if (sheets.empty()) return texels;
        std::vector<SurfacePoint> points;
        for (Sheet& sheet : sheets) {
            sheet.points = sheet.areaTexels < kLeastTexels ? kFewPoints : kPoints;
            sheet.firstPoint = points.size();
            const std::vector<SurfacePoint> own = pointsOf(geometry, sheet);
            points.insert(points.end(), own.begin(), own.end());
        }
        Integrator* integrator = tree.integratorOf(scene);
        if (integrator == nullptr) return texels;
        const std::vector<vec3> eyes = lightAndViewPoints(scene);
        const std::size_t count = points.size();
        points.insert(points.end(), points.begin(), points.begin() + std::ptrdiff_t(count)); // estimated twice
        std::vector<SideEstimate> estimates(points.size());
        if (Status s = integrator->sides(points, eyes, kPaths, kWalks, estimates, progress); !s) {
            tree.fail(s.error());
            return texels;
        }
        MeshTexels meshes(scene, geometry);
        for (const Sheet& sheet : sheets) {
            const auto own = std::size_t(2 * sheet.points);
            const auto all = std::span<const SideEstimate>(estimates);
            const SideLight light(all.subspan(sheet.firstPoint, own), all.subspan(count + sheet.firstPoint, own));
            meshes.add(sheet, texelsOf(sheet, light));
        }
        return meshes.take();
    };
}

} // namespace halflight
