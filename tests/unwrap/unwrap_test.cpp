#include "atlas_check.h"
#include "shapes.h"

#include "halflight/base/parallel.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace halflight {
namespace {

UnwrappedScene unwrapAndCheck(const Scene& scene, const UnwrapSettings& settings = {})
{
    Result<UnwrappedScene> result = unwrap(scene, settings);
    EXPECT_TRUE(result) << (result ? "" : result.error().text());
    if (!result) return {};
    const AtlasCheck check = checkAtlas(*result, settings.paddingTexels);
    EXPECT_EQ(check.fault, "");
    EXPECT_EQ(checkMeshes(scene, *result), "");
    return std::move(*result);
}

TEST(UnwrapShapes, PlaneIsOneChartWithoutStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::plane(3.0f, 2.0f, 20)));
    EXPECT_EQ(result.chartCount, 1);
    EXPECT_NEAR(result.meshes[0].areaStretch, 1.0f, 1e-4f);
}

TEST(UnwrapShapes, BoxIsSixChartsWithoutStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::box({1.0f, 2.0f, 3.0f})));
    EXPECT_LE(result.chartCount, 6);
    EXPECT_NEAR(result.meshes[0].areaStretch, 1.0f, 1e-4f);
}

TEST(UnwrapShapes, CylinderIsFourChartsWithoutStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::cylinder(1.0f, 3.0f, 32)));
    EXPECT_LE(result.chartCount, 4);
    EXPECT_NEAR(result.meshes[0].areaStretch, 1.0f, 1e-3f);
}

TEST(UnwrapShapes, SphereIsAHandfulOfChartsWithLittleStretch)
{
    const UnwrappedScene result = unwrapAndCheck(shapes::scene(shapes::sphere(1.0f, 32, 64)));
    EXPECT_LE(result.chartCount, 6);
    EXPECT_LT(result.meshes[0].areaStretch, 1.08f);
}

} // namespace
} // namespace halflight
