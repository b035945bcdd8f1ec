// Orientation repair of double-sided faces that bound cavities (spec S6).

#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight::test::facet_orientation_test {
namespace {

constexpr int kPage = 64;
constexpr vec3 kSize(0.2f, 0.6f, 0.2f);

struct Beam {
    const char* what;
    bool doubleSided = true;
    float times = 1.0f;  ///< as wide as it is
    float height = 2.0f; ///< above the floor
    float open = 0.0f;   ///< share of the upper end that is missing
    bool lightInside = false;
    bool cameraInside = false;
    bool emissive = false;
    bool flipped = false;
};

/// A hollow beam on a wide black floor under a white sky; one of its six faces is inverted.
Scene beamScene(const Beam& beam)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int black = addMaterial(scene, vec3(0.0f), vec3(beam.emissive ? 1.0f : 0.0f), beam.doubleSided);
    const vec3 size = beam.times * kSize;
    addBox(scene, -0.5f * size, 0.5f * size, black, false, kPage);
    MeshPart& inward = scene.meshes[2].parts[0];
    for (std::size_t i = 0; i < inward.indices.size(); i += 3) std::swap(inward.indices[i + 1], inward.indices[i + 2]);
    for (vec3& normal : inward.normals) normal = -normal;
    joinObjects(scene, 0);
    // The last face is the upper end.
    MeshPart& end = scene.meshes[0].parts.back();
    for (vec3& position : end.positions) position.z -= beam.open * std::max(position.z + 0.5f * size.z, 0.0f);
    const float floor = -0.5f * size.y - beam.height;
    addRectangle(scene, {vec3(-200, floor, -200), vec3(0, 0, 400), vec3(400, 0, 0)}, black, kPage);
    if (beam.lightInside)
        scene.lights.push_back(
            makeLight(LightType::Point, vec3(0.05f, 0.1f, 0.0f), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    if (beam.cameraInside) scene.cameras.push_back({.name = "c"});
    return scene;
}

/// The inverted face of a hollow beam is flipped, and no other face: its front would be black.
TEST(FacetOrientationS6, FacesOfCavitiesAreFlipped)
{
    const Beam beams[] = {
        {.what = "a beam", .flipped = true},
        {.what = "a beam on the floor", .height = 0.01f, .flipped = true},
        {.what = "a beam with a slit", .open = 0.3f, .flipped = true},
        {.what = "one-sided", .doubleSided = false},
        {.what = "a chamber", .times = 4.0f},
        {.what = "open at one end", .open = 0.99f},
        {.what = "half open at one end", .open = 0.7f},
        {.what = "a light inside", .lightInside = true},
        {.what = "a camera inside", .cameraInside = true},
        {.what = "emissive", .emissive = true},
    };
    for (const Beam& beam : beams) {
        SCOPED_TRACE(beam.what);
        Bench bench(beamScene(beam), MixedLightingMode::Shadowmask, kPage, {.samples = 64, .bounces = 0});
        const std::vector<uint8_t>& flipped = bench.geometry.flipped;
        EXPECT_EQ(std::count(flipped.begin(), flipped.end(), 1), beam.flipped ? 2 : 0);
        int inward = 0;
        for (uint32_t t = 0; t < 10; ++t) {
            const float out = glm::dot(bench.geometry.geometricNormal(t), bench.geometry.centroid(t));
            inward += out < 0.0f ? 1 : 0;
            EXPECT_GT(
                glm::dot(bench.geometry.normals[bench.geometry.triangles[t].x], bench.geometry.geometricNormal(t)),
                0.99f);
        }
        EXPECT_EQ(inward, beam.flipped ? 0 : 2);
    }
}

TEST(FacetOrientationS6, FlippedFacesHaveTheLightOfTheirNeighbours)
{
    Bench bench(beamScene({.what = "a beam"}), MixedLightingMode::Shadowmask, kPage, {.samples = 64, .bounces = 0});
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    std::array<double, 6> sum{};
    std::array<int, 6> texels{};
    for (std::size_t i = 0; i < bench.map.texels.size(); ++i) {
        const uint32_t triangle = bench.map.fragments[bench.map.texels[i].firstFragment].triangle;
        if (triangle >= 12 || !estimates[i].valid) continue;
        sum[triangle / 2] += double(estimates[i].irradiance.x);
        ++texels[triangle / 2];
    }
    for (uint32_t face = 0; face < 6; ++face) {
        // Upright faces see half of the sky.
        if (std::abs(bench.geometry.geometricNormal(2 * face).y) > 0.5f) continue;
        ASSERT_GT(texels[face], 100);
        EXPECT_NEAR(sum[face] / texels[face], kPi / 2.0f, 0.05f) << face;
    }
}

} // namespace
} // namespace halflight::test::facet_orientation_test
