// A mesh that is too large to be cut into charts triangle by triangle, judged by what came out.

#include "atlas_check.h"
#include "shapes.h"

#include "halflight/base/parallel.h"

#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

namespace halflight::large_test {
namespace {

using glm::dvec2;
using glm::dvec3;

/// A ball with bumps; every so often a triangle comes twice, or a third time from behind, an edge carries a fin, or
/// there is a triangle without area.
Scene spoiledBall()
{
    Mesh mesh = shapes::sphere(1.0f, 250, 420);
    MeshPart& part = mesh.parts[0];
    for (vec3& p : part.positions)
        p *= 1.0f + 0.06f * std::sin(9.0f * p.x) * std::sin(8.0f * p.y) * std::sin(7.0f * p.z);
    const std::size_t count = part.indices.size() / 3;
    for (std::size_t t = 0; t < count; ++t) {
        const uint32_t a = part.indices[3 * t], b = part.indices[3 * t + 1], c = part.indices[3 * t + 2];
        if (t % 97 == 0) part.indices.insert(part.indices.end(), {b, c, a});
        if (t % 389 == 0) part.indices.insert(part.indices.end(), {a, c, b});
        if (t % 61 == 0) part.indices.insert(part.indices.end(), {a, b, a});
        if (t % 67 == 0) part.indices.insert(part.indices.end(), {c, c, c});
        if (t % 601 == 0) { // two on one edge
            for (const float out : {1.02f, 1.04f}) {
                part.indices.insert(part.indices.end(), {a, b, uint32_t(part.positions.size())});
                part.positions.push_back(out * part.positions[c]);
                part.normals.push_back(part.normals[c]);
            }
        }
    }
    return shapes::scene(std::move(mesh));
}

struct Truth {
    double stretch = 0.0;       ///< area-weighted L2 stretch (Sander et al. 2001), where areas are kept on the whole
    std::size_t turnedOver = 0; ///< edges on whose two sides the page is seen from different sides
    std::size_t lost = 0;       ///< triangles with an area that have none on the page
};

Truth measure(const UnwrappedScene& unwrapped)
{
    Truth truth;
    const Object& object = unwrapped.scene.objects[0];
    const MeshPart& part = unwrapped.scene.meshes[std::size_t(object.mesh)].parts[0];
    const auto key = [](vec2 uv) {
        return uint64_t(std::bit_cast<uint32_t>(uv.x)) << 32 | std::bit_cast<uint32_t>(uv.y);
    };
    std::map<std::pair<uint64_t, uint64_t>, bool> sideOfEdge;
    double area = 0.0, pageArea = 0.0, sum = 0.0;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        const uint32_t* v = part.indices.data() + i;
        const dvec3 p(part.positions[v[0]]), q(part.positions[v[1]]), r(part.positions[v[2]]);
        const dvec2 a(part.lightmapUv[v[0]]), b(part.lightmapUv[v[1]]), c(part.lightmapUv[v[2]]);
        const double own = 0.5 * glm::length(glm::cross(q - p, r - p));
        const double longest = std::max({glm::distance(p, q), glm::distance(q, r), glm::distance(r, p)});
        if (!(own > 1e-4 * longest * longest)) continue;
        const double flat = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (!(std::abs(flat) > 0.0)) {
            ++truth.lost;
            continue;
        }
        const dvec3 alongU = (p * (b.y - c.y) + q * (c.y - a.y) + r * (a.y - b.y)) / flat;
        const dvec3 alongV = (p * (c.x - b.x) + q * (a.x - c.x) + r * (b.x - a.x)) / flat;
        sum += own * 0.5 * (glm::dot(alongU, alongU) + glm::dot(alongV, alongV));
        area += own;
        pageArea += 0.5 * std::abs(flat);
        for (int k = 0; k < 3; ++k) {
            const uint64_t from = key(part.lightmapUv[v[k]]), to = key(part.lightmapUv[v[(k + 1) % 3]]);
            const auto [found, inserted] = sideOfEdge.try_emplace(std::minmax(from, to), flat > 0.0);
            if (!inserted && found->second != (flat > 0.0)) ++truth.turnedOver;
        }
    }
    truth.stretch = std::sqrt(sum / area) * std::sqrt(pageArea / area);
    return truth;
}

TEST(UnwrapLarge, TwoHundredThousandTrianglesWithDuplicatesFinsAndSlivers)
{
    const Scene scene = spoiledBall();
    ASSERT_GT(scene.meshes[0].parts[0].indices.size() / 3, 200000u); // from here on a coarse copy is used
    const Result<UnwrappedScene> result = unwrap(scene, {});
    ASSERT_TRUE(result) << result.error().text();
    const AtlasCheck check = checkAtlas(*result, 2);
    EXPECT_EQ(check.fault, "");
    EXPECT_EQ(check.charts, result->chartCount);
    EXPECT_EQ(checkMeshes(scene, *result), "");
    const Truth truth = measure(*result);
    EXPECT_EQ(truth.lost, 0u);
    EXPECT_EQ(truth.turnedOver, 0u);
    EXPECT_LT(truth.stretch, 1.06);
    EXPECT_NEAR(truth.stretch, result->meshes[0].areaStretch, 0.005);

    // The same whatever the number of threads.
    const ThreadLimit limit(1);
    const Result<UnwrappedScene> again = unwrap(scene, {});
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->scene.meshes[0].parts[0].lightmapUv, result->scene.meshes[0].parts[0].lightmapUv);
}

TEST(UnwrapLarge, AMeshOfMoreChartsThanAPageHoldsIsAnError)
{
    // 3,000 triangles apart from one another; a page of 128 texels holds 43 x 43 of a texel each, padding 2 between.
    Mesh mesh;
    MeshPart& part = mesh.parts.emplace_back();
    for (uint32_t i = 0; i < 3000; ++i) {
        for (const vec3 corner : {vec3(0.0f), vec3(0.5f, 0.0f, 0.0f), vec3(0.0f, 0.5f, 0.0f)}) {
            part.indices.push_back(uint32_t(part.positions.size()));
            part.positions.push_back(vec3(float(i % 60), float(i / 60), 0.0f) + corner);
            part.normals.emplace_back(0.0f, 0.0f, 1.0f);
        }
    }
    UnwrapSettings settings;
    settings.pageSize = 128;
    const Result<UnwrappedScene> result = unwrap(shapes::scene(mesh), settings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(result.error().message.find("3000 charts"), std::string::npos) << result.error().message;
    // The page size that it names does.
    const std::size_t at = result.error().message.find("pages of about ");
    ASSERT_NE(at, std::string::npos) << result.error().message;
    settings.pageSize = std::stoi(result.error().message.substr(at + 15));
    EXPECT_LE(settings.pageSize, 512);
    const Result<UnwrappedScene> larger = unwrap(shapes::scene(mesh), settings);
    ASSERT_TRUE(larger) << larger.error().text();
    EXPECT_EQ(larger->chartCount, 3000);
}

} // namespace
} // namespace halflight::large_test
