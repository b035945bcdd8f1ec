// Sheets are connected pieces of double-sided surfaces that bound no solid. A lightmap stores light for one side. A
// sheet gets texels for the other side too where both can be seen and their light differs. A side can be seen if random
// walks from it leave the scene, meet emission, or come in sight of a light or a camera.
#include "bake/sides/sheet_sides.h"

#include "bake/geometry/solids.h"

#include "bake/geometry/components.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

namespace halflight {
namespace {

constexpr int kPoints = 128;    ///< of a sheet, spread evenly over its area
constexpr int kFewPoints = 8;   ///< of a sheet too small for texels of its own
constexpr int kPaths = 4;       ///< of an estimate of a point's irradiance, of two on each side
constexpr int kWalks = 4;       ///< of a point and side
constexpr float kOpen = 0.05f;  ///< least share of a visible side's walks that get out; gaps in walls let a few through
constexpr float kDiffer = 0.1f; ///< difference of both sides' light, over the brighter one, that shows
constexpr float kEven = 0.02f;  ///< most deviation of an even side's estimates, over the brighter side's light
constexpr float kLeastTexels = 4.0f; ///< area of a sheet with texels for both sides; smaller ones are leaves
constexpr double kSigmas = 3.0;      ///< standard errors beyond which a result of few points is no chance
constexpr uint32_t kSheetSeed = 0x5eed0061u;

struct Sheet {
    int mesh = -1;
    TwoSided twoSided = TwoSided::Automatic;
    std::vector<uint32_t> triangles;
    float areaTexels = 0.0f;
    int points = 0; ///< on each side
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

/// Bits of a number in reverse order, behind the binary point (van der Corput 1935).
double radicalInverse(uint32_t i)
{
    double inverse = 0.0;
    for (double digit = 0.5; i != 0; i >>= 1, digit *= 0.5) inverse += (i & 1u) != 0 ? digit : 0.0;
    return inverse;
}

/// Points of a sheet, evenly spread over its area, as the first ones of a power of two are too; the first half on the
/// front, the others the same on the back.
std::vector<SurfacePoint> pointsOf(const BakeGeometry& geometry, const Sheet& sheet)
{
    std::vector<double> sums;
    double area = 0.0;
    for (const uint32_t t : sheet.triangles) sums.push_back(area += double(areaOf(geometry, t)));
    std::vector<SurfacePoint> points;
    for (int i = 0; i < sheet.points; ++i) {
        const double at = (radicalInverse(uint32_t(i)) + 0.5 / double(sheet.points)) * area;
        const auto found = std::upper_bound(sums.begin(), sums.end(), at) - sums.begin();
        const auto triangle = std::min(std::size_t(found), sums.size() - 1);
        const vec2 u = r2Point(int(hashCombine(kSheetSeed, uint32_t(i)) >> 8));
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

/// Which sides of a sheet can be seen, from random walks.
class VisibleSides {
public:
    /// Walks of further points: on the front, then on the back.
    void add(std::span<const SideEstimate> estimates)
    {
        for (std::size_t i = 0; i < estimates.size(); ++i) open_[2 * i / estimates.size()] += estimates[i].open;
        points_ += float(estimates.size() / 2);
    }
    [[nodiscard]] bool isVisible(std::size_t side) const { return open_[side] >= kOpen * points_; }
    /// Whether both results would be the same with more walks.
    [[nodiscard]] bool isClear() const
    {
        const float walks = points_ * float(kWalks);
        return std::ranges::all_of(open_, [&](float open) {
            const float share = open / points_;
            const float variance = share * (1.0f - share) + kOpen * (1.0f - kOpen); // 0 of few walks proves little
            return std::abs(share - kOpen) > float(kSigmas) * std::sqrt(variance / walks);
        });
    }

private:
    std::array<float, 2> open_{}; ///< sum by side
    float points_ = 0.0f;
};

/// What both sides of a sheet receive, from two independent estimates of each point: their product is free of noise in
/// the mean.
class SideLight {
public:
    /// Estimates of further points: on the front, then on the back.
    void add(std::span<const SideEstimate> first, std::span<const SideEstimate> second)
    {
        for (std::size_t i = 0; i < first.size(); ++i) {
            const std::size_t side = i < first.size() / 2 ? 0 : 1;
            first_[side].push_back(double(luminance(first[i].irradiance)));
            second_[side].push_back(double(luminance(second[i].irradiance)));
            isLit_[side] = isLit_[side] || first[i].direct != vec3(0.0f);
        }
        for (std::size_t side = 0; side < 2; ++side) mean_[side] = 0.5 * (meanOf(first_[side]) + meanOf(second_[side]));
    }
    /// Whether the sides differ by more than kDiffer of the brighter, in the root mean square, which is no less than
    /// the mean. Unless `isLast`, nothing while the noise of few points leaves it open.
    [[nodiscard]] std::optional<bool> differs(bool isLast) const
    {
        constexpr double kClear = 1.5; // ratio to the limit, which is estimated itself
        std::vector<double> differences;
        std::vector<double> squares;
        for (std::size_t i = 0; i < first_[0].size(); ++i) {
            const double first = first_[0][i] - first_[1][i];
            const double second = second_[0][i] - second_[1][i];
            differences.push_back(0.5 * (first + second));
            squares.push_back(first * second);
        }
        const double limit = kDiffer * brighter();
        const double square = meanOf(squares);
        if (isLast) return square > limit * limit;
        if (std::abs(meanOf(differences)) - noiseOf(differences) > kClear * limit) return true;
        if (square + noiseOf(squares) < limit * limit / kClear) return false;
        return std::nullopt;
    }
    /// Whether the light of a side is the same everywhere, so that few texels hold it.
    [[nodiscard]] bool isEven(std::size_t side) const
    {
        if (isLit_[side]) return false; // a mask may need all texels
        const double most = double(kEven) * brighter();
        const auto isNear = [&](double light) { return std::abs(light - mean_[side]) <= most; };
        return std::ranges::all_of(first_[side], isNear) && std::ranges::all_of(second_[side], isNear);
    }

private:
    static double meanOf(std::span<const double> values)
    {
        return std::reduce(values.begin(), values.end()) / double(values.size());
    }
    /// Largest error of a mean by chance.
    static double noiseOf(std::span<const double> values)
    {
        const double mean = meanOf(values);
        double sum = 0.0;
        for (const double value : values) sum += (value - mean) * (value - mean);
        return kSigmas * std::sqrt(sum) / double(values.size());
    }
    [[nodiscard]] double brighter() const { return std::max(mean_[0], mean_[1]); }

    std::array<std::vector<double>, 2> first_; ///< luminance by side (front, back) and point
    std::array<std::vector<double>, 2> second_;
    std::array<double, 2> mean_{};
    std::array<bool, 2> isLit_{};
};

/// The texels of a sheet of which both sides are visible. Unless `isLast`, nothing while more points may show others.
std::optional<SheetTexels> texelsOf(const Sheet& sheet, const SideLight& light, bool isLast)
{
    if (sheet.twoSided != TwoSided::On) {
        const std::optional<bool> differs = light.differs(isLast);
        if (!differs) return std::nullopt;
        if (!*differs) return SheetTexels::Mean;
        if (sheet.twoSided == TwoSided::Off) return SheetTexels::FrontOfBoth;
    }
    if (!light.isEven(0) && !light.isEven(1)) return SheetTexels::Both;
    if (!isLast) return std::nullopt;
    return light.isEven(1) ? SheetTexels::BothWithEvenBack : SheetTexels::BothWithEvenFront;
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

/// Decides on all sheets, on most from few of their points.
class SheetSides {
public:
    SheetSides(Integrator& integrator, const BakeGeometry& geometry, std::span<const Sheet> sheets,
               std::span<const vec3> eyes, const Progress& progress)
        : integrator_(integrator), sheets_(sheets), eyes_(eyes), progress_(progress)
    {
        for (const Sheet& sheet : sheets) points_.push_back(pointsOf(geometry, sheet));
    }

    /// The texels by sheet.
    Result<std::vector<SheetTexels>> decide()
    {
        std::vector<SheetTexels> texels(sheets_.size(), SheetTexels::Front);
        std::vector<VisibleSides> visible(sheets_.size());
        std::vector<std::size_t> open(sheets_.size());
        std::iota(open.begin(), open.end(), std::size_t(0));
        const auto isSettled = [&](std::size_t i, std::span<const SideEstimate> walks, bool isLast) {
            visible[i].add(walks);
            return isLast || visible[i].isClear();
        };
        if (Status status = inRounds(open, {0, kWalks, 1}, isSettled); !status) return status.error();
        for (std::size_t i = 0; i < sheets_.size(); ++i) {
            const bool isLeaf = sheets_[i].areaTexels < kLeastTexels && sheets_[i].twoSided != TwoSided::On;
            const bool back = visible[i].isVisible(1);
            if (back && visible[i].isVisible(0) && !isLeaf)
                open.push_back(i);
            else if (back)
                texels[i] = visible[i].isVisible(0) ? SheetTexels::Mean : SheetTexels::Back;
        }
        std::vector<SideLight> light(sheets_.size());
        const auto isDecided = [&](std::size_t i, std::span<const SideEstimate> estimates, bool isLast) {
            light[i].add(estimates.first(estimates.size() / 2), estimates.last(estimates.size() / 2));
            const std::optional<SheetTexels> found = texelsOf(sheets_[i], light[i], isLast);
            if (found) texels[i] = *found;
            return found.has_value();
        };
        if (Status status = inRounds(open, {kPaths, 0, 2}, isDecided); !status) return status.error();
        return texels;
    }

private:
    static constexpr int kFirstPoints = 16;
    /// What is traced from a point.
    struct Effort {
        int paths = 0;
        int walks = 0;
        int estimates = 1; ///< independent ones
    };

    /// Estimates of more and more points of the open sheets, until isDone(sheet, estimates, isLast) has closed all:
    /// all further points of the sheet in a row, of each estimate.
    template<typename IsDone>
    Status inRounds(std::vector<std::size_t>& open, const Effort& effort, const IsDone& isDone)
    {
        for (int first = 0, end = kFirstPoints; !open.empty(); first = end, end *= 2) {
            std::vector<SurfacePoint> points;
            for (const std::size_t i : open) {
                for (int estimate = 0; estimate < effort.estimates; ++estimate) addPoints(i, first, end, points);
            }
            std::vector<SideEstimate> estimates(points.size());
            Status status = integrator_.sides(points, eyes_, effort.paths, effort.walks, estimates, progress_);
            if (!status) return status;
            std::size_t next = 0;
            std::erase_if(open, [&](std::size_t i) {
                const int most = sheets_[i].points;
                const auto count = std::size_t(2 * effort.estimates * (std::min(end, most) - first));
                next += count;
                return isDone(i, std::span(estimates).subspan(next - count, count), end >= most);
            });
        }
        return {};
    }
    void addPoints(std::size_t sheet, int first, int end, std::vector<SurfacePoint>& points) const
    {
        const std::vector<SurfacePoint>& own = points_[sheet];
        const int count = sheets_[sheet].points;
        for (const int side : {0, count})
            points.insert(points.end(), own.begin() + side + first, own.begin() + side + std::min(end, count));
    }

    Integrator& integrator_;
    std::span<const Sheet> sheets_;
    std::span<const vec3> eyes_;
    const Progress& progress_;
    std::vector<std::vector<SurfacePoint>> points_; ///< by sheet
};

} // namespace

SheetTest sheetSidesTest(SourceTree& tree, TwoSided mode, const Progress& progress)
{
    return [&tree, mode, &progress](const Scene& scene, double texelMeters) {
        std::vector<std::vector<SheetTexels>> none(scene.meshes.size());
        const BakeGeometry& geometry = tree.geometryOf(scene);
        std::vector<Sheet> sheets = findSheets(scene, geometry, mode, texelMeters);
        if (sheets.empty()) return none;
        for (Sheet& sheet : sheets) sheet.points = sheet.areaTexels < kLeastTexels ? kFewPoints : kPoints;
        Integrator* integrator = tree.integratorOf(scene);
        if (integrator == nullptr) return none;
        const std::vector<vec3> eyes = lightAndViewPoints(scene);
        const Result<std::vector<SheetTexels>> texels =
            SheetSides(*integrator, geometry, sheets, eyes, progress).decide();
        if (!texels) {
            tree.fail(texels.error());
            return none;
        }
        MeshTexels meshes(scene, geometry);
        for (std::size_t i = 0; i < sheets.size(); ++i) meshes.add(sheets[i], (*texels)[i]);
        return meshes.take();
    };
}

} // namespace halflight
