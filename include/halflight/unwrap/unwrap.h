#pragma once
// Lightmap coordinates: charts, parameterization, packing.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/scene.h"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// More pages than this are an error. At the default size they are a gigabyte of lightmaps.
constexpr int kMaxPages = 256;

enum class UvMode {
    Auto,   ///< keep a mesh's TEXCOORD_1 when it is valid (in [0,1], charts not overlapping), else unwrap it
    Keep,   ///< keep it, and fail with the reason where it isn't valid; meshes without one are unwrapped
    Unwrap, ///< always unwrap
};

struct UnwrapSettings {
    UvMode uvMode = UvMode::Auto;
    float texelsPerMeter = 0.0f;     ///< 0 = what fits one page of pageSize, but at most mostTexelsPerMeter
    float mostTexelsPerMeter = 0.0f; ///< limits a density of 0, such as sceneDensity(); 0 = no limit
    int pageSize = 1024;             ///< width and height of a page in texels, 64…8192
    bool cutPage = false;  ///< where one page is enough, it is cut to the smallest square that is: a multiple of 4
    int paddingTexels = 2; ///< empty texels between charts, >= 1 (2: bilinear filtering and one ring of dilation)
};

/// What decided the density.
enum class DensityFrom {
    Asked, ///< UnwrapSettings::texelsPerMeter
    Page,  ///< what fits one page
    Scene, ///< UnwrapSettings::mostTexelsPerMeter
};

/// Texels per metre beyond which a scene gains little. With a page of 2048 texels: 40 per metre, or 256 along the
/// diagonal of what is lightmapped where that is more (scenes below 6.4 m); in proportion for other pages. 0 for a
/// scene without size.
float sceneDensity(const Scene& scene, int pageSize);

/// How one mesh got its coordinates, for the report.
struct MeshUnwrapReport {
    int mesh = -1;      ///< index into the returned scene's meshes
    bool kept = false;  ///< the file's TEXCOORD_1
    std::string reason; ///< why TEXCOORD_1 was not kept, e.g. "TEXCOORD_1 leaves [0,1] (part 0, triangle 17)"
    int charts = 0;
    float areaStretch = 1.0f; ///< texel-area-weighted L2 stretch (Sander et al. 2001), 1 = isometric
};

/// A point where an object's surface goes on behind another surface that stands on it.
struct CrossingPoint {
    int object = -1;       ///< index into Scene::objects
    uint32_t triangle = 0; ///< of the object's mesh, counted through its parts
    vec3 position{0.0f};   ///< world space, metres
    vec3 normal{0.0f};     ///< unit, towards the front of the triangle
    vec3 across{0.0f};     ///< unit, in the triangle's plane, at a right angle to the crossing
    vec3 rise{0.0f};       ///< unit, in the other surface's plane, at a right angle to the crossing
    float texelMeters = 0; ///< width of the object's texels to come
};

/// By point, 1 where both sides of the crossing lie open within a texel or so, and neither is visible from the other:
/// a texel across the crossing would hold the light of two spaces.
using CrossingTest = std::function<std::vector<uint8_t>(const Scene&, std::span<const CrossingPoint>)>;

/// What texels of a triangle hold: as TexelSide, or Both…: each side has texels of its own. An even side has the same
/// light everywhere, mostly none: its texels are kEvenTexels times as wide.
enum class SheetTexels : uint8_t { Front, FrontOfBoth, Mean, Back, Both, BothWithEvenFront, BothWithEvenBack };
constexpr float kEvenTexels = 8.0f;
constexpr bool isDoubled(SheetTexels texels)
{
    return texels >= SheetTexels::Both;
}

/// By mesh of the scene, by triangle (counted through the mesh's parts); an empty list stands for all Front. The scene
/// has no halves of sheets. `texelMeters`: width of a texel to come, of objects with a lightmapScale of 1.
using SheetTest = std::function<std::vector<std::vector<SheetTexels>>(const Scene&, double texelMeters)>;

struct UnwrappedScene {
    /// The scene with lightmapUv in the parts of static meshes, vertices split along chart borders
    /// (MeshPart::sourceVertex), meshes duplicated where objects need layouts of their own, and each static object's
    /// LightmapBinding set.
    Scene scene;
    int pageSize = 0; ///< of every page; UnwrapSettings::pageSize, or less where pages may be cut
    int pageCount = 0;
    float texelsPerMeter = 0.0f; ///< the density reached
    DensityFrom densityFrom = DensityFrom::Page;
    int chartCount = 0;               ///< over all objects
    int cuts = 0;                     ///< planes along which surfaces were cut, over all objects
    float coverage = 0.0f;            ///< texels that triangles touch / all texels of all pages
    float coverageWithPadding = 0.0f; ///< the same, each chart with its half of the padding around it
    std::vector<MeshUnwrapReport> meshes;
    std::vector<std::string> warnings;
};

/// Gives every static object (Object::isStatic, lightmapScale > 0) texels of its own. A chart's texels are all those
/// that one of its triangles touches, borders included; between the texels of any two charts, of one object or of two,
/// lie at least paddingTexels others in x or in y. Bilinear filtering reads at most one texel beyond a chart's own, so
/// with a padding of 2 no texel is ever read by two charts. Within a chart, triangles do not overlap. Triangles without
/// area shrink to a point of a chart.
///
/// Objects that share a mesh at (within 5 %) the same scale share its layout and get a rectangle each; where scales
/// differ the mesh is duplicated, so that padding counts texels for all of them. Only the instances of one
/// EXT_mesh_gpu_instancing node share a layout at any scale, with the texels that the largest needs; their node has one
/// mesh. A mesh with one object has
/// lightmapUv in page coordinates (scale 1, offset 0). Density is measured in the world: texelsPerMeter times the
/// object's lightmapScale.
///
/// With UvMode::Keep, charts of one kept layout may come closer than the padding (a warning); two objects never touch
/// one texel, in any mix of kept and new layouts. The result is rasterized to check that.
///
/// With a CrossingTest, meshes that get new layouts are cut in two where another surface that casts shadows crosses
/// theirs and the test says that each side has light of its own: a smooth piece of surface is cut along the plane of
/// the crossing triangles, and no chart lies on both sides. Objects with a cut have a mesh of their own then. Left
/// uncut are instances of EXT_mesh_gpu_instancing nodes, meshes of many triangles with many objects, crossings shorter
/// than a few texels, and the least gainful ones where cuts would add more than a few per cent of texels (a warning).
///
/// With a SheetTest, triangles of double-sided sheets are written twice where it says so (SurfaceSide), and both halves
/// have charts of their own. Meshes that keep their TEXCOORD_1 have no second side (a warning). Halves of an earlier
/// bake are joined first.
///
/// Errors: InvalidArgument (settings; a density that needs more than kMaxPages pages), FileInvalid (UvMode::Keep, with
/// the reason), Unsupported (the check failed, with the objects' names), Cancelled.
Result<UnwrappedScene> unwrap(Scene scene, const UnwrapSettings& settings, const Progress& progress = {},
                              const CrossingTest& crossingTest = {}, const SheetTest& sheetTest = {});

} // namespace halflight
