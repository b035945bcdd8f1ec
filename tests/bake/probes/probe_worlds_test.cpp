// Probes in worlds that are large beside their rooms (spec S14): light of moving objects in every room, against that of
// paths traced at their places.
#include "bake/cache/cached_integrator.h"
#include "bake/geometry/indices.h"
#include "bake/probes/probes.h"
#include "bake/test_scene.h"

#include "halflight/render/probes.h"
#include "halflight/scene/gltf.h"
#include "halflight/scene/probe_cells.h"
#include "halflight/shading/color.h"
#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace halflight::test::probe_worlds_test {
namespace {

constexpr int kPage = 64;

/// Houses of 8 x 8 x 3 m on a ground, each with a doorway of 1.7 m in its +Z wall, or without one.
struct World {
    float width = 400.0f; ///< metres
    std::vector<vec3> houses;
    bool isOpen = true;

    [[nodiscard]] Scene scene() const
    {
        Scene s;
        const int grey = addMaterial(s, vec3(0.5f));
        const int brick = addMaterial(s, vec3(0.6f, 0.35f, 0.25f));
        addRectangle(s, {vec3(-0.5f * width, 0, 0.5f * width), vec3(width, 0, 0), vec3(0, 0, -width)}, grey, kPage,
                     {vec2(1), vec2(40)});
        for (const vec3 at : houses) {
            const auto box = [&](vec3 low, vec3 high) { addBox(s, at + low, at + high, brick, false); };
            box({-4, 0, -4.15f}, {4, 3, -3.85f});
            box({-4.15f, 0, -4}, {-3.85f, 3, 4});
            box({3.85f, 0, -4}, {4.15f, 3, 4});
            box({-4.15f, 0, 3.85f}, {isOpen ? -0.85f : 0.0f, 3, 4.15f});
            box({isOpen ? 0.85f : 0.0f, 0, 3.85f}, {4.15f, 3, 4.15f});
            box({-4.3f, 3, -4.3f}, {4.3f, 3.3f, 4.3f});
        }
        s.lights = {makeLight(LightType::Directional, vec3(0), vec3(-0.4f, -0.9f, -0.6f), 20.0f, LightMode::Mixed)};
        s.sky = {vec3(1.0f), vec3(1.0f), vec3(0.2f)};
        return s;
    }
};

/// Sum of the irradiance (lux) on six sides.
double lightOf(const SphericalHarmonicsL2& radiance)
{
    double sum = 0.0;
    for (int side = 0; side < 6; ++side) {
        vec3 n(0.0f);
        n[side / 2] = side % 2 == 0 ? 1.0f : -1.0f;
        for (int i = 0; i < 9; ++i)
            sum += double(luminance(radiance[std::size_t(i)]) * shading::shIrradianceWeight(i, n));
    }
    return sum;
}

/// A scene with its probes at the default density.
struct BakedWorld {
    Bench bench;
    std::vector<std::string> warnings;
    BakedScene baked;
    ProbeCheck check;
    std::vector<vec3> checkedAt; ///< outside geometry

    explicit BakedWorld(Scene scene, float spacing = 0.0f)
        : bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings())
    {
        const CachedIntegrator cached{*bench.integrator, bench.geometry, bench.map, settings()};
        BakedProbes probes = *bakeProbes(bench.scene, spacing, ProbeLayout::Refined, true, cached, warnings, {});
        baked.scene = bench.scene;
        baked.probes = std::move(probes.set);
        baked.probes.sight = *findProbeSight(baked.probes, *bench.integrator, {});
        check = checkProbes(baked, probes, warnings);
        for (std::size_t i = 0; i < probes.checks.size(); ++i)
            if (probes.checks[i].valid) checkedAt.push_back(probes.checkedAt[i]);
    }
    static IntegrationSettings settings()
    {
        IntegrationSettings s;
        s.samples = 16;
        s.probeSamples = 256;
        s.bounces = 8;
        return s;
    }
    /// Of paths traced there.
    [[nodiscard]] std::vector<double> truth(const std::vector<vec3>& places) const
    {
        std::vector<ProbeEstimate> estimates(places.size());
        EXPECT_TRUE(bench.integrator->probes(places, allIndices(places.size()), 16384, estimates, {}));
        std::vector<double> light;
        for (const ProbeEstimate& e : estimates) light.push_back(lightOf(e.radiance));
        return light;
    }
    /// Of the probes.
    [[nodiscard]] std::vector<double> found(const std::vector<vec3>& places) const
    {
        const ProbeInterpolator probes(baked);
        std::vector<double> light;
        for (const vec3 place : places) light.push_back(lightOf(probes.sample(place).radiance));
        return light;
    }
};

std::vector<vec3> onGrid(int side, float pitch)
{
    std::vector<vec3> places;
    for (int i = 0; i < side * side; ++i)
        places.push_back(pitch *
                         (vec3(i % side, 0, i / side) - vec3(0.5f * float(side - 1), 0, 0.5f * float(side - 1))));
    return places;
}

std::vector<vec3> offset(std::vector<vec3> places, vec3 by)
{
    for (vec3& place : places) place += by;
    return places;
}

double largestError(const BakedWorld& world, const std::vector<vec3>& places)
{
    const std::vector<double> right = world.truth(places);
    const std::vector<double> found = world.found(places);
    double most = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) most = std::max(most, std::abs(found[i] / right[i] - 1.0));
    return most;
}

class HousesS14 : public testing::TestWithParam<float> {};

/// Houses far apart, in a world whose grid has a probe every 12 to 60 m: light in each, which is a small part of that
/// outside, and fewer probes than a grid of the same density would have.
TEST_P(HousesS14, LightIsRightInEveryHouse)
{
    const float width = GetParam();
    const World world{width, onGrid(3, width / 3.0f)};
    const BakedWorld baked(world.scene());
    EXPECT_LT(largestError(baked, offset(world.houses, vec3(-2, 1, -2))), 0.25);
    EXPECT_LT(largestError(baked, offset(world.houses, vec3(0, 1, 0))), 0.25);
    EXPECT_LT(baked.baked.probes.probes.size(), 10000u);
}

INSTANTIATE_TEST_SUITE_P(Worlds, HousesS14, testing::Values(100.0f, 400.0f),
                         [](const auto& info) { return std::to_string(int(info.param)) + "m"; });

/// Into a house, along the middle of its doorway: light changes in small steps.
TEST(ProbeWorldsS14, NoStepOnAPathThroughADoorway)
{
    const World world{400.0f, {vec3(30, 0, -70)}};
    const BakedWorld baked(world.scene());
    std::vector<vec3> path;
    for (float z = 8.0f; z > -3.0f; z -= 0.05f) path.push_back(world.houses[0] + vec3(0.1f, 1, z));
    const std::vector<double> light = baked.found(path);
    const double brighter = *std::max_element(light.begin(), light.end());
    EXPECT_GT(brighter, 5.0 * light.back()) << "the room is dark";
    for (std::size_t i = 1; i < path.size(); ++i)
        EXPECT_LT(std::abs(light[i] - light[i - 1]), 0.05 * brighter) << path[i].z - world.houses[0].z;
}

/// A closed room with a lamp, and one without: no corner of a large cell sees into either.
TEST(ProbeWorldsS14, ClosedRoomsAreFound)
{
    const World world{400.0f, {vec3(-20, 0, 10), vec3(20, 0, 10)}, false};
    Scene scene = world.scene();
    scene.lights.push_back(
        makeLight(LightType::Point, world.houses[0] + vec3(0, 2.5f, 0), vec3(0, -1, 0), 3.0f, LightMode::Baked));
    const BakedWorld baked(std::move(scene));
    for (const vec3 place : {vec3(-2, 1, -2), vec3(2, 1, 0), vec3(0, 1, 3)}) {
        EXPECT_LT(largestError(baked, {world.houses[0] + place}), 0.25) << place.x;
        const double outside = baked.found({vec3(0, 1, -30)})[0];
        EXPECT_LT(baked.found({world.houses[1] + place})[0], 0.01 * outside) << place.x;
    }
}

/// A budget that no world exceeds, and that follows surfaces: the same house in a world of four times the width needs
/// few probes more.
TEST(ProbeWorldsS14, ProbesFollowSurfacesAndNotTheWorld)
{
    const auto count = [](float width) {
        const BakedWorld baked(World{width, {vec3(0)}}.scene());
        return baked.baked.probes.probes.size();
    };
    const std::size_t small = count(250.0f);
    EXPECT_LT(double(count(1000.0f)), 1.3 * double(small));
    EXPECT_LE(BakedWorld(World{300.0f, onGrid(12, 25.0f)}.scene()).baked.probes.probes.size(), 20000u);
}

/// Two probes outside are all that the author asked for: the warning names the rooms that they are wrong in.
TEST(ProbeWorldsS14, PlacesWhereLightIsOffAreNamed)
{
    const World world{60.0f, {vec3(0)}};
    Scene scene = world.scene();
    for (Object& object : scene.objects) object.name = "house";
    for (int i = 0; i < 2048; ++i)
        scene.probePositions.push_back({float(i % 32) - 15.5f, i % 2 == 0 ? 4.0f : 6.0f, float(i / 32) * 0.5f - 16.0f});
    const BakedWorld baked(std::move(scene));
    ASSERT_EQ(baked.warnings.size(), 1u);
    EXPECT_NE(baked.warnings[0].find("off by more than 25 %"), std::string::npos) << baked.warnings[0];
    EXPECT_NE(baked.warnings[0].find("near 'house'"), std::string::npos) << baked.warnings[0];
    EXPECT_GT(baked.check.off, 0);
    EXPECT_GT(baked.check.mostError, ProbeCheck::kOff);
}

/// Under an even sky, without anything else, light is the same everywhere, and check probes say so.
TEST(ProbeWorldsS14, EvenLightIsNowhereOff)
{
    Scene scene;
    addRectangle(scene, {vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18)}, addMaterial(scene, vec3(0)), kPage);
    addRectangle(scene, {vec3(-9, 9, 9), vec3(0.1f, 0, 0), vec3(0, 0, -0.1f)}, addMaterial(scene, vec3(0)), kPage);
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const BakedWorld baked(std::move(scene));
    EXPECT_TRUE(baked.warnings.empty());
    EXPECT_GT(baked.check.places, 5);
    EXPECT_LT(baked.check.mostError, 0.1f);
}

/// A Cornell box of 550 m under no sky, open in front. Its -X wall leans out by 6 m, so that the box around the scene
/// holds a wedge of darkness behind it, and its panel hangs 0.9 m under the ceiling.
Scene hall()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.4f));
    scene.materials[std::size_t(grey)].doubleSided = true;
    const auto sheet = [&](vec3 corner, vec3 u, vec3 v, int material) {
        addRectangle(scene, {corner, u, v}, material, kPage, {vec2(1), vec2(4)});
    };
    const vec3 along(0, 0, 560);
    sheet({0, 0, 0}, along, {550, 0, 0}, grey);        // floor
    sheet({-6, 550, 0}, {556, 0, 0}, along, grey);     // ceiling
    sheet({-6, 0, 0}, {556, 0, 0}, {0, 550, 0}, grey); // back
    sheet({0, 0, 560}, -along, {-6, 550, 0}, grey);    // the leaning wall
    sheet({550, 0, 0}, along, {0, 550, 0}, grey);      // +X wall
    const int lamp = addMaterial(scene, vec3(0.8f));
    scene.materials[std::size_t(lamp)].emissiveNits = vec3(100.0f);
    scene.materials[std::size_t(lamp)].doubleSided = true;
    sheet({210, 549.1f, 230}, {130, 0, 0}, {0, 0, 105}, lamp);
    addBox(scene, {100, 0, 120}, {265, 330, 290}, grey, false);
    addBox(scene, {320, 0, 310}, {480, 165, 470}, grey, false);
    scene.sky = {vec3(0), vec3(0), vec3(0)};
    return scene;
}

/// Nobody sees the wedge: it gets no probes of its own, and no warning. What else light needs follows the room, which
/// is 200 times as long as the finest cells. Balls in the room are right.
TEST(ProbeWorldsS14, DarknessAroundARoomNeedsNoProbes)
{
    const BakedWorld baked(hall());
    EXPECT_LT(baked.baked.probes.probes.size(), 12000u);
    EXPECT_GT(baked.checkedAt.size(), 50u);
    const auto isBehindWall = [](vec3 p) { return p.x < -6.0f * p.y / 550.0f; };
    for (const vec3 place : baked.checkedAt) EXPECT_FALSE(isBehindWall(place)) << place.x << ' ' << place.y;
    for (const Probe& probe : baked.baked.probes.probes) EXPECT_FALSE(isBehindWall(probe.position));
    EXPECT_LT(double(baked.check.off), 0.15 * double(baked.check.places));
    std::vector<vec3> balls;
    for (int i = 0; i < 27; ++i) balls.emplace_back(30 + 245 * (i % 3), 60 + 190 * (i / 3 % 3), 60 + 220 * (i / 9));
    std::erase_if(balls, [](vec3 p) { return p.y < 330 && p.x > 100 && p.x < 480 && p.z > 120 && p.z < 470; });
    // In shade, what an eye sees that is used to the room: a share of its median light.
    const std::vector<double> right = baked.truth(balls);
    const std::vector<double> found = baked.found(balls);
    std::vector<double> sorted = right;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < balls.size(); ++i)
        EXPECT_NEAR(found[i], right[i], 0.25 * std::max(right[i], sorted[sorted.size() / 2])) << balls[i].x;
}

/// Cells as a reader of the file has them: corners at the positions in floats.
struct FileCells {
    explicit FileCells(const ProbeSet& set) : probes(set.probes), cells(fileTetrahedra(probeCells(set))) {}

    /// Six volumes, each with `point` in the place of one corner.
    [[nodiscard]] std::array<double, 4> volumesAt(const Tetrahedron& cell, glm::dvec3 point) const
    {
        std::array<double, 4> volumes{};
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<glm::dvec3, 4> v;
            for (std::size_t k = 0; k < 4; ++k) v[k] = k == i ? point : glm::dvec3(probes[cell.vertex[k]].position);
            volumes[i] = glm::dot(v[1] - v[0], glm::cross(v[2] - v[0], v[3] - v[0]));
        }
        return volumes;
    }
    /// The walk of docs/format.md from the first cell. Its end, or nothing where it leaves the hull.
    [[nodiscard]] std::optional<uint32_t> walk(glm::dvec3 point) const
    {
        uint32_t current = 0;
        for (std::size_t step = 0; step < cells.size(); ++step) {
            const std::array<double, 4> volumes = volumesAt(cells[current], point);
            const auto least = std::size_t(std::min_element(volumes.begin(), volumes.end()) - volumes.begin());
            if (volumes[least] >= 0.0) return current;
            current = cells[current].neighbor[least];
            if (current == kOutside) return std::nullopt;
        }
        return std::nullopt;
    }

    const std::vector<Probe>& probes;
    std::vector<Tetrahedron> cells;
};

/// No cell is flat or inside out in floats, and a walk finds every point between the probes: here the middle of each
/// pair of probes that follow one another in the list.
TEST(ProbeWorldsS14, CellsAreSolidInFloatsAndEveryPointIsFound)
{
    for (const char* name : {"five_lights", "bumpy_wall", "sphere_on_floor", "two_rooms"}) {
        SCOPED_TRACE(name);
        Result<Scene> scene =
            readScene(std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests" / (std::string(name) + ".glb"));
        ASSERT_TRUE(scene) << scene.error().message;
        const BakedWorld world(std::move(*scene));
        const FileCells file(world.baked.probes);
        ASSERT_GT(file.cells.size(), 1000u);
        for (const Tetrahedron& cell : file.cells)
            ASSERT_GT(file.volumesAt(cell, glm::dvec3(file.probes[cell.vertex[0]].position))[0], 0.0);
        for (std::size_t i = 1; i < file.probes.size(); ++i)
            ASSERT_TRUE(
                file.walk(0.5 * (glm::dvec3(file.probes[i - 1].position) + glm::dvec3(file.probes[i].position))));
    }
}

/// The case's village: a ball in each of its 49 houses.
TEST(ProbeWorldsS14, Village)
{
    const std::filesystem::path file = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "cases/village/village.glb";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    Result<Scene> scene = readScene(file);
    ASSERT_TRUE(scene) << scene.error().message;
    std::vector<vec3> balls;
    for (const Object& object : scene->objects)
        if (!object.isStatic && object.mesh >= 0) balls.emplace_back(object.worldFromObject[3]);
    ASSERT_EQ(balls.size(), 49u);
    const BakedWorld baked(std::move(*scene));
    EXPECT_LT(largestError(baked, balls), 0.25);
    EXPECT_LE(baked.baked.probes.probes.size(), 20000u);
}

} // namespace
} // namespace halflight::test::probe_worlds_test
