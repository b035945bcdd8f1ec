// Rays through coloured glass: order, hits, volumes, thickness (spec S35).
#include "transport/glass_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace halflight::test::glass_rays_test {
namespace {

using namespace glass;

/// Of rays in a scene.
vec3 transmittance(const Traced& traced, vec3 origin, vec3 direction, float end)
{
    return traced.paths->surfaces().transmittance(origin, glm::normalize(direction), 0.0f, end);
}

TEST(GlassRaysS35, PanesMultiplyInAnyOrder)
{
    const vec3 one = expectedOf(Glass::Quad, 1.0f);
    const vec3 expected = one * expectedOf(Glass::Pane, 1.0f) * expectedOf(Glass::Box, 1.0f);
    std::vector<std::pair<Glass, float>> panes = {{Glass::Quad, 1.0f}, {Glass::Pane, 2.0f}, {Glass::Box, 3.0f}};
    do {
        Scene scene;
        for (const auto& [glass, height] : panes) addGlass(scene, glass, height, 5.0f);
        const Traced traced(std::move(scene));
        expectColor(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), kInfinity), expected, 1e-4f);
        expectColor(transmittance(traced, vec3(0.1f, 9, 0.2f), vec3(0, -1, 0), 9.0f), expected, 1e-4f);
        // Up to between two panes.
        expectColor(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 1.5f), one, 1e-4f);
    } while (std::next_permutation(panes.begin(), panes.end()));
}

TEST(GlassRaysS35, FullyCoveredIsOpaque)
{
    Scene scene;
    addGlass(scene, Glass::Quad);
    scene.materials.back().baseColor.w = 1.0f;
    const Traced traced(std::move(scene));
    EXPECT_EQ(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 9.0f), vec3(0.0f));
    EXPECT_TRUE(traced.paths->surfaces().nearest(vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 0.0f, 9.0f).found());
}

/// What lies behind the hit gives no colour, in whichever order candidates come; chance and colour together give the
/// transmittance. Packets and single rays agree.
TEST(GlassRaysS35, HitsTakeTheColorOfTheGlassBefore)
{
    Scene scene;
    const int behind = addGlassMaterial(scene, Glass::Quad);
    for (int i = 0; i < 12; ++i) // slanted, in bounds that begin before the floor
        addRectangle(scene, {vec3(-5, -6.5f - 0.1f * float(i), 5), vec3(10, 10, 0), vec3(0, 0, -10)}, behind, kPage);
    addFloor(scene, addMaterial(scene, vec3(0.5f)));
    addGlass(scene, Glass::Quad, 1.0f, 5.0f);
    addGlass(scene, Glass::Box, 2.0f, 5.0f);
    const Traced traced(std::move(scene));
    const RayTracer& surfaces = traced.paths->surfaces();
    constexpr int kRays = 40000;
    std::vector<Ray> rays;
    Sampler sampler(1, 2, 3);
    for (int i = 0; i < kRays; ++i) {
        const vec2 at = sampler.next2() - 0.5f;
        rays.push_back({vec3(at.x, 4, at.y), 0.0f, vec3(0, -1, 0), kInfinity});
    }
    std::vector<RayHit> hits(rays.size());
    surfaces.nearest(rays, hits);
    glm::dvec3 arrives(0.0);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const RayHit alone = surfaces.nearest(rays[i].origin, rays[i].direction, 0.0f, kInfinity);
        EXPECT_NEAR(alone.distance, hits[i].distance, 1e-4f);
        EXPECT_NEAR(alone.tint.y, hits[i].tint.y, 1e-5f);
        if (std::abs(hits[i].distance - 4.0f) < 1e-3f) arrives += glm::dvec3(hits[i].tint) / double(kRays);
    }
    expectColor(vec3(arrives), expectedOf(Glass::Quad, 1.0f) * expectedOf(Glass::Box, 1.0f), 0.015f);
}

/// From within a solid to its outside, and from outside to within.
TEST(GlassRaysS35, WaysThatEndInAVolume)
{
    Scene scene;
    addGlass(scene, Glass::Box, 0.0f, 5.0f);
    const Traced traced(std::move(scene));
    for (int c = 0; c < 3; ++c) {
        const float expected = 0.96f * kColor[c] * std::pow(kLeft[c], 0.05f / kDistance);
        EXPECT_NEAR(transmittance(traced, vec3(0.1f, 0.15f, 0.3f), vec3(0, 1, 0), 9.0f)[c], expected, 1e-4f);
        EXPECT_NEAR(transmittance(traced, vec3(0.1f, 1.2f, 0.3f), vec3(0, -1, 0), 1.05f)[c], expected, 1e-4f);
    }
}

/// A thickness is in the mesh's space: it grows with the object along the surface's normal alone.
TEST(GlassRaysS35, ThicknessTakesTheObjectsScale)
{
    for (const vec3 scale : {vec3(3, 1, 2), vec3(1, 2, 1)}) {
        Scene scene;
        addGlass(scene, Glass::Thin, 1.0f, 5.0f);
        scene.objects.back().worldFromObject = glm::scale(mat4(1.0f), scale);
        const Traced traced(std::move(scene));
        const vec3 found = transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 9.0f);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], 0.96f * kColor[c] * std::pow(kLeft[c], kThick * scale.y / kDistance), 1e-4f);
    }
}

/// Alpha without `tinted` is coverage and stays grey, beside coloured glass too.
TEST(GlassRaysS35, GreyGlassStaysGrey)
{
    Scene scene;
    addGlass(scene, Glass::Quad, 1.0f, 5.0f);
    scene.materials.back().tinted = false;
    addGlass(scene, Glass::Pane, 2.0f, 5.0f);
    const Traced traced(std::move(scene));
    expectColor(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 9.0f), 0.75f * 0.96f * kColor, 1e-4f);
    EXPECT_EQ(transmittance(traced, vec3(0.1f, 0, 0.2f), vec3(0, 1, 0), 1.5f), vec3(0.75f));
}

} // namespace
} // namespace halflight::test::glass_rays_test
