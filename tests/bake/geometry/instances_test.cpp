// Objects that share a mesh are instances of one tree (spec S6): the same scene with a mesh for each object, which is
// stored in world space, is the truth.

#include "bake/geometry/balls.h"
#include "bake/geometry/flatten.h"
#include "bake/seams/seams.h"
#include "bake/test_scene.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "transport/trace/ray_tracer.h"

#include "halflight/shading/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace halflight::test::instances_test {
namespace {

using namespace balls;

/// A scene with its tree.
struct Traceable {
    Scene scene;
    BakeGeometry geometry;
    RayTracer tracer;

    explicit Traceable(Scene s)
        : scene(std::move(s)), geometry(flattenGeometry(scene, kPage, GeometryFilter::All)),
          tracer(scene, geometry, embreeKernels())
    {}
};

float farApart(const std::array<vec3, 3>& a, const std::array<vec3, 3>& b)
{
    return std::max({glm::distance(a[0], b[0]), glm::distance(a[1], b[1]), glm::distance(a[2], b[2])});
}

TEST(InstancesS6, AMeshIsInTheTreesOnce)
{
    const Traceable shared(ballsOnFloor());
    const Traceable flat(unshared(ballsOnFloor()));
    EXPECT_EQ(flat.geometry.instances.size(), 0u);
    EXPECT_EQ(flat.tracer.treeTriangleCount(), kBalls * kBallTriangles + 2);
    EXPECT_EQ(shared.geometry.instances.size(), std::size_t(kBalls));
    EXPECT_EQ(shared.geometry.triangleCount(), kBalls * kBallTriangles + 2);
    EXPECT_EQ(shared.geometry.triangles.size(), kBallTriangles + 2);
    // The ball without a shadow has a tree of its own.
    EXPECT_EQ(shared.tracer.treeTriangleCount(), 2 * kBallTriangles + 2);
    EXPECT_EQ(shared.tracer.hitTriangleCount(), flat.tracer.hitTriangleCount());
    std::vector<uint8_t> seen(shared.geometry.triangleCount(), 0);
    for (uint32_t hit = 0; hit < shared.tracer.hitTriangleCount(); ++hit) ++seen[shared.tracer.triangleAt(hit)];
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](uint8_t n) { return n == 1; }));
}

TEST(InstancesS6, SmallMeshesAreStoredInWorldSpace)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {}, 4);
    for (int i = 0; i < 100; ++i) scene.objects.push_back(scene.objects[0]);
    EXPECT_TRUE(flattenGeometry(scene, kPage, GeometryFilter::Static).instances.empty());
}

TEST(InstancesS6, TrianglesAreWhereTheyAreInWorldSpace)
{
    const Traceable shared(ballsOnFloor());
    const Traceable flat(unshared(ballsOnFloor()));
    ASSERT_EQ(shared.geometry.triangleCount(), flat.geometry.triangleCount());
    for (uint32_t t = 0; t < flat.geometry.triangleCount(); ++t) {
        ASSERT_EQ(shared.geometry.partNumberOf(t), flat.geometry.partNumberOf(t));
        ASSERT_LT(farApart(shared.geometry.cornersOf(t), flat.geometry.cornersOf(t)), 3.0e-6f);
        ASSERT_LT(farApart(shared.geometry.normalsOf(t), flat.geometry.normalsOf(t)), 1.0e-5f);
        ASSERT_LT(glm::distance(shared.geometry.geometricNormal(t), flat.geometry.geometricNormal(t)), 1.0e-3f) << t;
        ASSERT_NEAR(shared.geometry.texelMeters(t), flat.geometry.texelMeters(t), 1.0e-4f);
        ASSERT_EQ(shared.geometry.isSolid(t), flat.geometry.isSolid(t));
        for (std::size_t k = 0; k < 3; ++k)
            ASSERT_LT(glm::distance(shared.geometry.texelsOf(t)[k], flat.geometry.texelsOf(t)[k]), 1.0e-3f);
    }
    EXPECT_TRUE(shared.geometry.isSolid(shared.geometry.triangleCount() - 1));
}

/// Where rays hit: 100,000 of them, for each kind of surface.
TEST(InstancesS6, RaysHitWhatTheyHitInWorldSpace)
{
    constexpr uint32_t kRays = 100000;
    for (const auto alpha : {Material::AlphaMode::Opaque, Material::AlphaMode::Mask}) {
        const Traceable shared(ballsOnFloor(alpha));
        const Traceable flat(unshared(ballsOnFloor(alpha)));
        uint32_t onBalls = 0;
        uint32_t mirrored = 0;
        uint32_t backs = 0;
        uint32_t otherHits = 0;
        uint32_t otherShadows = 0;
        uint32_t coarse = 0;
        for (uint32_t i = 0; i < kRays; ++i) {
            const Ray ray = randomRay(i);
            const RayUse use = i % 2 == 0 ? RayUse::Camera : RayUse::Light;
            const RayHit a = shared.tracer.nearest(ray.origin, ray.direction, 0.0f, kInfinity, use);
            const RayHit b = flat.tracer.nearest(ray.origin, ray.direction, 0.0f, kInfinity, use);
            otherShadows += shared.tracer.occluded(ray.origin, ray.direction, 0.0f, 3.0f) !=
                                    flat.tracer.occluded(ray.origin, ray.direction, 0.0f, 3.0f)
                                ? 1
                                : 0;
            const auto triangleOf = [](const RayTracer& tracer, const RayHit& hit) {
                return hit.found() ? tracer.triangleAt(hit.face.hitIndex) : ~0u;
            };
            const uint32_t triangle = triangleOf(shared.tracer, a);
            // A ray through an edge may hit either triangle.
            if (triangle != triangleOf(flat.tracer, b)) {
                ++otherHits;
                continue;
            }
            if (!a.found()) continue;
            ASSERT_NEAR(a.distance, b.distance, 1.0e-4f);
            coarse += glm::distance(a.barycentric, b.barycentric) > 1.0e-4f ? 1 : 0; // of slivers, and grazing rays
            ASSERT_EQ(a.face.back, b.face.back);
            const SurfacePoint point = shared.tracer.surfaceAt(a).point;
            ASSERT_LT(glm::distance(point.position, ray.origin + a.distance * ray.direction), 1.0e-4f);
            ASSERT_LT(glm::distance(point.position, flat.tracer.surfaceAt(b).point.position), 1.0e-3f); // grazing rays
            ASSERT_LT(glm::dot(point.geometricNormal, ray.direction), 0.0f);
            const uint32_t object = uint32_t(shared.geometry.partOf(triangle).object);
            onBalls += object > 0 ? 1 : 0;
            mirrored += object == 4 || object == 8 ? 1 : 0;
            backs += a.face.back != 0 ? 1 : 0;
        }
        EXPECT_GT(onBalls, kRays / 5);
        EXPECT_GT(mirrored, kRays / 50);
        EXPECT_GT(backs, kRays / 100);
        EXPECT_LT(otherHits, kRays / 1000);
        EXPECT_LT(otherShadows, kRays / 1000);
        EXPECT_LT(coarse, kRays / 100);
    }
}

/// Rays from inside balls leave one solid, also where the ball is mirrored.
TEST(InstancesS6, SolidsAreLeftOnce)
{
    constexpr std::size_t kRays = 20000;
    const Traceable shared(ballsOnFloor());
    const Traceable flat(unshared(ballsOnFloor()));
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < kRays; ++i) rays.push_back(randomRay(uint32_t(i)));
    std::vector<int> a(kRays);
    std::vector<int> b(kRays);
    shared.tracer.crossings(rays, a);
    flat.tracer.crossings(rays, b);
    EXPECT_GT(std::count(b.begin(), b.end(), 1), std::ptrdiff_t(kRays / 200));
    std::size_t other = 0;
    for (std::size_t i = 0; i < kRays; ++i) other += a[i] != b[i];
    EXPECT_LT(other, kRays / 1000);
}

/// Volumes of turned, mirrored and stretched instances let the same colours pass as those of objects in world space.
TEST(InstancesS6, GlassWithVolumesS35)
{
    const auto glassBalls = [] {
        Scene scene = ballsOnFloor();
        Material& glass = scene.materials.back();
        glass.transmission = 1.0f;
        glass.thickness = 1.0f;
        glass.attenuationColor = vec3(0.2f, 0.9f, 0.5f);
        glass.attenuationMeters = 0.5f;
        return scene;
    };
    const Traceable shared(glassBalls());
    const Traceable flat(unshared(glassBalls()));
    constexpr uint32_t kRays = 10000;
    int colored = 0;
    int other = 0;
    for (uint32_t i = 0; i < kRays; ++i) {
        const Ray ray = randomRay(i);
        const vec3 a = shared.tracer.transmittance(ray.origin, ray.direction, 0.0f, 3.0f);
        const vec3 b = flat.tracer.transmittance(ray.origin, ray.direction, 0.0f, 3.0f);
        colored += a.y > 1.5f * a.x ? 1 : 0;
        other += glm::distance(a, b) > 0.01f ? 1 : 0;
    }
    EXPECT_GT(colored, int(kRays / 20));
    EXPECT_LT(other, int(kRays / 500));
}

/// Packets find what single rays find, and blended surfaces let the same light pass.
TEST(InstancesS6, PacketsAndBlendedSurfaces)
{
    const Traceable shared(ballsOnFloor(Material::AlphaMode::Blend));
    const Traceable flat(unshared(ballsOnFloor(Material::AlphaMode::Blend)));
    const Traceable opaque(ballsOnFloor());
    constexpr int kBundles = 2000;
    int partly = 0;
    int other = 0;
    int otherLight = 0;
    for (uint32_t i = 0; i < kBundles; ++i) {
        std::array<Ray, 8> rays;
        std::array<RayHit, 8> hits;
        for (uint32_t lane = 0; lane < 8; ++lane) {
            const Ray ray = rays[lane] = randomRay(8 * i + lane);
            const float light = shared.tracer.transmittance(ray.origin, ray.direction, 0.0f, 3.0f).x;
            otherLight +=
                std::abs(light - flat.tracer.transmittance(ray.origin, ray.direction, 0.0f, 3.0f).x) > 0.01f ? 1 : 0;
            partly += light > 0.0f && light < 1.0f ? 1 : 0;
        }
        ASSERT_TRUE(opaque.tracer.kernels().nearest(rays, hits));
        for (std::size_t lane = 0; lane < 8; ++lane) {
            const Ray& ray = rays[lane];
            const RayHit hit = opaque.tracer.nearest(ray.origin, ray.direction, 0.0f, kInfinity);
            ASSERT_EQ(hits[lane].found(), hit.found());
            if (!hit.found()) continue;
            const bool same = hit.face.hitIndex == hits[lane].face.hitIndex;
            other += same ? 0 : 1;
            if (!same) continue;
            ASSERT_EQ(hits[lane].face.back, hit.face.back);
            ASSERT_LT(glm::distance(hits[lane].barycentric, hit.barycentric), 1.0e-3f);
        }
    }
    EXPECT_GT(partly, 500);
    EXPECT_LT(other, kBundles * 8 / 1000);
    // Rays along the edge of a texel, and rays through more than four surfaces.
    EXPECT_LT(otherLight, kBundles * 8 / 200);
}

double meanOf(const std::vector<IrradianceEstimate>& estimates)
{
    double sum = 0.0;
    for (const IrradianceEstimate& e : estimates) sum += double(luminance(e.irradiance));
    return sum / double(estimates.size());
}

/// Lightmaps, masks and seams are those of the scene without instances. The same seed has the same rays, so that there
/// is no noise between the two; a few rays along edges end elsewhere.
TEST(InstancesS6, BakesAgree)
{
    IntegrationSettings settings;
    settings.samples = 16;
    Bench shared(ballsOnFloor(), MixedLightingMode::Shadowmask, kPage, settings);
    Bench flat(unshared(ballsOnFloor()), MixedLightingMode::Shadowmask, kPage, settings);
    ASSERT_EQ(shared.geometry.instances.size(), std::size_t(kBalls));
    EXPECT_EQ(shared.map.chartCount, flat.map.chartCount);
    ASSERT_EQ(shared.map.texels.size(), flat.map.texels.size());
    const auto a = shared.irradiance();
    const auto b = flat.irradiance();
    EXPECT_NEAR(meanOf(a) / meanOf(b), 1.0, 1.0e-4);
    double squares = 0.0;
    std::size_t otherValid = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(shared.map.texels[i].x, flat.map.texels[i].x);
        ASSERT_EQ(shared.map.texels[i].y, flat.map.texels[i].y);
        ASSERT_EQ(shared.map.texels[i].chart, flat.map.texels[i].chart);
        ASSERT_LT(glm::distance(shared.positionOf(shared.map.texels[i]), flat.positionOf(flat.map.texels[i])), 1.0e-3f);
        otherValid += a[i].valid != b[i].valid ? 1 : 0;
        if (!a[i].valid || !b[i].valid) continue;
        const double difference = double(luminance(a[i].irradiance)) - double(luminance(b[i].irradiance));
        squares += difference * difference;
    }
    EXPECT_LT(std::sqrt(squares / double(a.size())), 0.002 * meanOf(b));
    EXPECT_LT(otherValid, a.size() / 500);

    const auto maskA = shared.shadowmask();
    const auto maskB = flat.shadowmask();
    double difference = 0.0;
    for (std::size_t i = 0; i < maskA.size(); ++i) difference += double(std::abs(maskA[i].x - maskB[i].x));
    EXPECT_LT(difference / double(maskA.size()), 0.002);

    EXPECT_EQ(findSeams(shared.geometry, kPage).size(), findSeams(flat.geometry, kPage).size());
    EXPECT_GT(findSeams(flat.geometry, kPage).size(), 100u);
}

/// Balls whose front is inside are inverted where they are empty. One is a room with a lamp in it; that object alone
/// has another orientation than its mesh has elsewhere.
TEST(InstancesS6, OrientationIsThatOfEachInstance)
{
    Scene scene = ballsOnFloor(Material::AlphaMode::Opaque, true);
    const vec3 inside(scene.objects[3].worldFromObject * vec4(3, 1, 2, 1));
    scene.lights.push_back(pointAt("lamp", inside, 1.0f));
    const BakeGeometry shared = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const BakeGeometry flat = flattenGeometry(unshared(scene), kPage, GeometryFilter::Static);
    ASSERT_EQ(shared.triangleCount(), flat.triangleCount());
    std::size_t kept = 0;
    for (uint32_t t = 0; t < flat.triangleCount(); ++t) {
        ASSERT_EQ(shared.isSolid(t), flat.isSolid(t));
        ASSERT_GT(glm::dot(shared.geometricNormal(t), flat.geometricNormal(t)), 0.99f);
        kept += shared.isSolid(t) ? 0 : 1;
    }
    EXPECT_EQ(kept, kBallTriangles + 2); // the room and the floor
}

} // namespace
} // namespace halflight::test::instances_test
