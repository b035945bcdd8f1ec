// Conservative rasterization and the sample points of texels (spec S6).

#include "bake/geometry/flatten.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>
#include <utility>

namespace halflight::test::texels_test {
namespace {

constexpr int kPage = 64;

/// Any point of any triangle lies in a texel of the map: nothing the renderer can sample is missing.
TEST(TexelsS6, RasterizationIsConservative)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<float> u(0.0f, 1.0f);
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    MeshPart part;
    for (int t = 0; t < 200; ++t) {
        const vec2 base(u(random) * 60.0f, u(random) * 60.0f);
        const float size = t % 2 ? 4.0f : 0.3f;
        for (int i = 0; i < 3; ++i) {
            const vec2 p = base + size * vec2(u(random), u(random));
            part.positions.push_back(vec3(p, float(t)));
            part.normals.push_back(vec3(0, 0, 1));
            part.lightmapUv.push_back(p / float(kPage));
            part.indices.push_back(uint32_t(part.indices.size()));
        }
    }
    part.material = grey;
    addObject(scene, std::move(part));
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::set<std::pair<int, int>> covered;
    for (const Texel& texel : map.texels) {
        EXPECT_TRUE(covered.emplace(texel.x, texel.y).second) << "a texel listed twice";
        float area = 0.0f;
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) area += map.fragments[texel.firstFragment + f].area;
        EXPECT_GT(area, 0.0f);
        std::array<SurfacePoint, kMaxTexelPoints> points;
        EXPECT_GE(texelPoints(geometry, map, texel, points), 1);
    }
    for (std::size_t t = 0; t < geometry.triangleCount(); ++t) {
        const uvec3 v = geometry.triangles[t];
        const vec2 a = geometry.lightmapTexel[v.x];
        const vec2 b = geometry.lightmapTexel[v.y];
        const vec2 c = geometry.lightmapTexel[v.z];
        if (std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) < 1e-4f) continue;
        for (int s = 0; s < 50; ++s) {
            float x = u(random);
            float y = u(random);
            if (x + y > 1.0f) {
                x = 1.0f - x;
                y = 1.0f - y;
            }
            const vec2 p = a + x * (b - a) + y * (c - a);
            EXPECT_TRUE(covered.count({int(p.x), int(p.y)})) << p.x << " " << p.y;
        }
    }
}

/// A texel that its surface covers in part has points enough to stand for that part: their mean is near its centroid,
/// and the points of more batches close in on it.
TEST(TexelsS6, TexelsCoveredInPartHavePointsEnough)
{
    Scene scene;
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, addMaterial(scene, vec3(0.5f)), kPage,
                 {vec2(10.3f, 10.8f), vec2(40.4f, 40.15f)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    int partly = 0;
    for (const Texel& texel : map.texels) {
        float area = 0.0f;
        vec3 centroid(0.0f);
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[texel.firstFragment + f];
            area += fragment.area;
            centroid += fragment.area * surfacePoint(geometry, fragment.triangle, fragment.barycentric).position;
        }
        if (area > 0.9f || area < 0.05f) continue;
        ++partly;
        vec3 sum(0.0f);
        int count = 0;
        for (int batch = 0; batch < 4; ++batch) {
            std::array<SurfacePoint, kMaxTexelPoints> points;
            const int some = texelPoints(geometry, map, texel, points, batch);
            EXPECT_GE(some, 9) << "of " << area << " at " << texel.x << ", " << texel.y;
            for (int i = 0; i < some; ++i) sum += points[std::size_t(i)].position;
            count += some;
        }
        const float texelMeters = 4.0f / 30.0f;
        EXPECT_LT(glm::distance(sum / float(count), centroid / area), 0.06f * texelMeters)
            << texel.x << ", " << texel.y;
    }
    EXPECT_GT(partly, 100);
}

TEST(TexelsS6, AreasOfAFullTexelSumToOneAndCentroidsLieInside)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(3.25f), vec2(20.75f)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    EXPECT_EQ(map.texels.size(), 18u * 18u);
    EXPECT_EQ(map.chartCount, 1u);
    double total = 0.0;
    for (const Texel& texel : map.texels) {
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[texel.firstFragment + f];
            total += fragment.area;
            const uvec3 v = geometry.triangles[fragment.triangle];
            const vec2 p = (1.0f - fragment.barycentric.x - fragment.barycentric.y) * geometry.lightmapTexel[v.x] +
                           fragment.barycentric.x * geometry.lightmapTexel[v.y] +
                           fragment.barycentric.y * geometry.lightmapTexel[v.z];
            EXPECT_GE(p.x, float(texel.x) - 1e-3f);
            EXPECT_LE(p.x, float(texel.x) + 1.001f);
            EXPECT_GE(p.y, float(texel.y) - 1e-3f);
            EXPECT_LE(p.y, float(texel.y) + 1.001f);
        }
    }
    EXPECT_NEAR(total, 17.5 * 17.5, 1e-2);
}

} // namespace
} // namespace halflight::test::texels_test
