// World-space geometry of the bake, its solids, and determinism (spec S6).

#include "bake/geometry/flatten.h"
#include "bake/report/bake_report.h"
#include "bake/test_scene.h"

#include "halflight/base/parallel.h"
#include "halflight/shading/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace halflight::test::geometry_test {
namespace {

constexpr int kPage = 64;

/// A point in the unit cube, by number.
vec3 randomPoint(uint32_t i)
{
    const vec2 xy = r2Point(int(i));
    return {xy.x, xy.y, r2Point(int(hashCombine(i, 1u) >> 8)).x};
}

TEST(DeterminismS6, ThreadCountChangesNoBit)
{
    std::vector<IrradianceEstimate> reference;
    std::vector<vec4> referenceMask;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        Scene scene;
        scene.sky = {vec3(1), vec3(0.5f), vec3(0.1f)};
        addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f), vec3(0.1f)), true, kPage);
        addBox(scene, vec3(-0.3f), vec3(0.3f), addMaterial(scene, vec3(0.5f)), false);
        scene.lights.push_back(pointAt("p", vec3(0.7f), 5.0f));
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
        const auto estimates = bench.irradiance();
        const auto mask = bench.shadowmask();
        if (reference.empty()) {
            reference = estimates;
            referenceMask = mask;
        }
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            ASSERT_EQ(estimates[i].irradiance, reference[i].irradiance);
            ASSERT_EQ(mask[i], referenceMask[i]);
        }
    }
}

/// Closed outward boxes are solids, rooms (inward) and boxes without a lid are not.
TEST(GeometryS6, SolidsAreClosedAndFaceOutward)
{
    const auto solids = [](bool inward, bool lid) {
        Scene scene;
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), addMaterial(scene, vec3(0.5f), vec3(0), true), inward);
        // One mesh of all faces, as a modeller would have it.
        for (std::size_t i = 1; i < scene.meshes.size(); ++i) {
            if (i == 3 && !lid) continue;
            scene.meshes[0].parts.push_back(scene.meshes[i].parts[0]);
        }
        scene.objects.resize(1);
        return flattenGeometry(scene, kPage, GeometryFilter::Static).solid;
    };
    EXPECT_EQ(solids(false, true), std::vector<uint8_t>(12, 1));
    EXPECT_EQ(solids(true, true), std::vector<uint8_t>(12, 0));
    EXPECT_EQ(solids(false, false), std::vector<uint8_t>(10, 0));

    // A box whose six faces are objects of their own is closed all the same.
    Scene scene;
    addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), addMaterial(scene, vec3(0.5f), vec3(0), true), false);
    EXPECT_EQ(flattenGeometry(scene, kPage, GeometryFilter::Static).solid, std::vector<uint8_t>(12, 1));
}

/// A triangle with two corners at one place has no edge to a neighbour, and rounding gives it a volume. It is no solid,
/// and is not flipped.
TEST(GeometryS6, DegenerateTrianglesEncloseNothing)
{
    constexpr uint32_t kTriangles = 64;
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f), vec3(0), true);
    addBox(scene, vec3(-9), vec3(-8), grey, false); // the scene is more than the triangles
    addBox(scene, vec3(0), vec3(1), grey, false);
    MeshPart& part = scene.meshes.back().parts.front();
    part.indices.clear();
    part.positions.clear();
    for (uint32_t i = 0; i < kTriangles; ++i) {
        part.positions.emplace_back(randomPoint(2 * i));
        part.positions.emplace_back(randomPoint(2 * i + 1));
        part.indices.insert(part.indices.end(), {2 * i, 2 * i, 2 * i + 1});
    }
    part.normals.assign(part.positions.size(), vec3(0, 0, 1));
    for (auto& uv : part.uv) uv.clear();
    part.lightmapUv.assign(part.positions.size(), vec2(0.0f));
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    for (uint32_t t = 0; t < kTriangles; ++t) {
        const uint32_t last = uint32_t(geometry.solid.size()) - kTriangles + t;
        EXPECT_FALSE(geometry.solid[last]) << t;
        EXPECT_FALSE(geometry.flipped[last]) << t;
    }
}

// A hollow body is two closed surfaces; the inner one belongs to the solid, a room that faces inward in no solid does
// not.
TEST(GeometryS6, CavitiesBelongToTheirSolid)
{
    const auto solids = [](vec3 innerCenter) {
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        addBox(scene, vec3(-3), vec3(3), grey, false);
        addBox(scene, innerCenter - vec3(2), innerCenter + vec3(2), grey, true);
        joinObjects(scene, 0);
        return flattenGeometry(scene, kPage, GeometryFilter::Static).solid;
    };
    EXPECT_EQ(solids(vec3(0)), std::vector<uint8_t>(24, 1));
    std::vector<uint8_t> beside(24, 0);
    std::fill(beside.begin(), beside.begin() + 12, uint8_t(1));
    EXPECT_EQ(solids(vec3(20, 0, 0)), beside);
    EXPECT_EQ(solids(vec3(2, 2, 2)), beside) << "reaches out of the solid";
}

/// A closed box whose faces look inward, with nothing and no light inside, is a modeller's slip where its material has
/// two sides: it has its light where it is seen from. A room is not.
TEST(GeometryS6, InvertedSurfacesAreFlipped)
{
    struct Case {
        const char* what;
        bool doubleSided = true;
        bool alone = false;
        bool boxInside = false;
        bool onePart = false;
        bool lightInside = false;
        bool cameraInside = false;
        bool glows = false;
        bool flipped = false;
    };
    const Case cases[] = {
        {.what = "empty", .flipped = true},
        {.what = "one-sided", .doubleSided = false},
        {.what = "the whole scene", .alone = true},
        {.what = "furnished", .boxInside = true},
        {.what = "lit", .lightInside = true},
        {.what = "looked at from inside", .cameraInside = true},
        {.what = "glowing", .glows = true},
        {.what = "furnished, of one part", .boxInside = true, .onePart = true},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.what);
        Scene scene;
        scene.sky = {vec3(1), vec3(1), vec3(1)};
        const int grey = addMaterial(scene, vec3(0.0f), vec3(c.glows ? 1.0f : 0.0f), c.doubleSided);
        addBox(scene, vec3(-1), vec3(1), grey, true, kPage);
        if (!c.alone) addBox(scene, vec3(50, -1, -1), vec3(52, 1, 1), grey, false);
        if (c.boxInside) addBox(scene, vec3(-0.5f), vec3(0.5f), grey, false);
        // The box is one mesh, as a modeller would have it; of one part with what is inside, or of one for each face.
        const std::size_t joined = c.onePart ? scene.meshes.size() : 6;
        for (std::size_t i = 1; i < joined; ++i) {
            const MeshPart& from = scene.meshes[i].parts[0];
            MeshPart& to = scene.meshes[0].parts[0];
            if (!c.onePart) {
                scene.meshes[0].parts.push_back(from);
                continue;
            }
            const auto first = uint32_t(to.positions.size());
            for (const uint32_t index : from.indices) to.indices.push_back(first + index);
            to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
            to.normals.insert(to.normals.end(), from.normals.begin(), from.normals.end());
            to.uv[0].insert(to.uv[0].end(), from.uv[0].begin(), from.uv[0].end());
            to.lightmapUv.insert(to.lightmapUv.end(), from.lightmapUv.begin(), from.lightmapUv.end());
            to.lightmapUv.resize(to.positions.size()); // none where it has none
        }
        scene.objects.erase(scene.objects.begin() + 1, scene.objects.begin() + std::ptrdiff_t(joined));
        if (c.lightInside) scene.lights.push_back(pointAt("p", vec3(0.5f), 1.0f));
        if (c.cameraInside) scene.cameras.push_back({.name = "c"});
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {.samples = 16, .bounces = 0});
        const std::vector<uint8_t>& flipped = bench.geometry.flipped;
        EXPECT_EQ(std::count(flipped.begin(), flipped.end(), 1), c.flipped ? 12 : 0);
        EXPECT_EQ(bench.geometry.solid[0] != 0, c.flipped);
        EXPECT_GT(glm::dot(bench.geometry.normals[0], bench.geometry.geometricNormal(0)), 0.99f);
        EXPECT_EQ(glm::dot(bench.geometry.geometricNormal(0), bench.geometry.centroid(0)) > 0.0f, c.flipped);
        if (c.lightInside || c.glows) continue;
        const std::vector<IrradianceEstimate> estimates = bench.irradiance();
        EXPECT_TRUE(std::any_of(estimates.begin(), estimates.end(), [](const auto& e) { return e.valid; }));
        for (const IrradianceEstimate& e : estimates) {
            if (e.valid) EXPECT_NEAR(e.irradiance.x, c.flipped ? kPi : 0.0f, 0.1f);
        }
    }
}

// A house that is one object: the warning names the primitive that was flipped, and not the house alone.
TEST(GeometryS6, FlippedFacesAreNamedByTheirPrimitive)
{
    Scene scene;
    const int plaster = addMaterial(scene, vec3(0.5f));
    const int rail = addMaterial(scene, vec3(0.5f));
    scene.materials[std::size_t(rail)].name = "rail";
    addRectangle(scene, {}, plaster, kPage);
    addRectangle(scene, {vec3(0, 0, 2), vec3(1, 0, 0), vec3(0, 0, -1)}, rail, kPage);
    joinObjects(scene, 0);
    addRectangle(scene, {}, rail, kPage);
    scene.objects[0].name = "house";
    scene.objects[1].name = "plank";
    BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    geometry.flipped = {0, 0, 1, 0, 0, 1};
    BakeReport report;
    reportFlipped(scene, geometry, report);
    ASSERT_EQ(report.warnings.size(), 1u);
    EXPECT_EQ(report.warnings[0].find("\"house, primitive 1 (rail)\", \"plank\": "), 0u) << report.warnings[0];
}

TEST(GeometryS6, MirroredAndShearedObjectsKeepOutwardNormals)
{
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f)), false);
    mat4 transform(1.0f);
    transform[0] = vec4(-2, 0, 0.5f, 0);
    transform[1] = vec4(0.3f, 1, 0, 0);
    transform[2] = vec4(0, 0.2f, 0.5f, 0);
    for (Object& object : scene.objects) object.worldFromObject = transform;
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    for (uint32_t t = 0; t < geometry.triangleCount(); ++t) {
        const SurfacePoint p = surfacePoint(geometry, t, vec2(1.0f / 3.0f));
        EXPECT_GT(glm::dot(p.geometricNormal, p.position), 0.0f);
        EXPECT_NEAR(glm::dot(p.geometricNormal, p.normal), 1.0f, 1e-5f);
    }
}

} // namespace
} // namespace halflight::test::geometry_test
