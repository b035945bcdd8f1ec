// Rays on a device hit what they hit on the processor (spec S6): Embree is the truth.

#include "bake_gpu/kernel_pair.h"
#include "bake_gpu/test_device.h"

#include <cmath>
#include <cstring>

namespace halflight::test::kernels_test {
namespace {

using namespace balls;

using KernelsS6 = BakeDeviceTest;

/// Turned, stretched and mirrored instances, with fronts inside and outside.
TEST_F(KernelsS6, NearestHitsAreTheProcessors)
{
    for (const bool inward : {false, true}) {
        for (const bool shared : {true, false}) {
            const Scene scene = ballsOnFloor(Material::AlphaMode::Opaque, inward);
            const Pair pair(shared ? scene : unshared(scene), device);
            const std::vector<Ray> rays = randomRays(kInfinity);
            std::vector<RayHit> a(kRays);
            std::vector<RayHit> b(kRays);
            ASSERT_TRUE(pair.cpu.kernels().nearest(rays, a, RayUse::Light));
            ASSERT_TRUE(pair.gpu.kernels().nearest(rays, b, RayUse::Light));
            std::size_t other = 0;
            std::size_t far = 0;
            std::size_t backs = 0;
            for (std::size_t i = 0; i < kRays; ++i) {
                if (a[i].found() != b[i].found()) {
                    ++other;
                    continue;
                }
                if (!a[i].found()) continue;
                backs += b[i].face.back;
                if (a[i].face.hitIndex != b[i].face.hitIndex || a[i].face.back != b[i].face.back)
                    ++other;
                else if (glm::distance(a[i].barycentric, b[i].barycentric) > 1.0e-3f)
                    ++far;
                if (std::abs(a[i].distance - b[i].distance) > 1.0e-5f * std::max(1.0f, a[i].distance)) ++far;
            }
            EXPECT_GT(backs, kRays / 100);
            EXPECT_LT(other, kRays / 1000) << "shared " << shared << ", inward " << inward;
            EXPECT_LT(far, kRays / 1000) << "shared " << shared << ", inward " << inward;
            EXPECT_FALSE(b[7].found());
        }
    }
}

/// A leaf's holes, at the same places.
TEST_F(KernelsS6, HolesOfMasksAreTheProcessors)
{
    const Pair pair(ballsOnFloor(Material::AlphaMode::Mask), device);
    const std::vector<Ray> rays = randomRays(3.0f);
    std::vector<RayHit> a(kRays);
    std::vector<RayHit> b(kRays);
    ASSERT_TRUE(pair.cpu.kernels().nearest(rays, a, RayUse::Light));
    ASSERT_TRUE(pair.gpu.kernels().nearest(rays, b, RayUse::Light));
    const auto stopped = std::make_unique<bool[]>(2 * kRays);
    ASSERT_TRUE(pair.cpu.kernels().occluded(rays, {stopped.get(), kRays}));
    ASSERT_TRUE(pair.gpu.kernels().occluded(rays, {stopped.get() + kRays, kRays}));
    std::size_t other = 0;
    std::size_t otherShadows = 0;
    std::size_t found = 0;
    for (std::size_t i = 0; i < kRays; ++i) {
        found += a[i].found();
        other += a[i].found() != b[i].found() || (a[i].found() && a[i].face.hitIndex != b[i].face.hitIndex);
        otherShadows += stopped[i] != stopped[kRays + i];
    }
    EXPECT_GT(found, kRays / 4);
    EXPECT_LT(other, kRays / 500);
    EXPECT_LT(otherShadows, kRays / 500);
}

/// What blended surfaces let through, multiplied; and the same share of rays where chance decides.
TEST_F(KernelsS6, BlendedSurfacesLetTheSameLightThrough)
{
    const Pair pair(ballsOnFloor(Material::AlphaMode::Blend), device);
    const std::vector<Ray> rays = randomRays(3.0f);
    std::vector<vec3> a(kRays);
    std::vector<vec3> b(kRays);
    ASSERT_TRUE(pair.cpu.kernels().transmittance(rays, a));
    ASSERT_TRUE(pair.gpu.kernels().transmittance(rays, b));
    std::size_t partial = 0;
    std::size_t other = 0;
    double expected = 0.0;
    for (std::size_t i = 0; i < kRays; ++i) {
        partial += a[i].x > 0.0f && a[i].x < 1.0f;
        other += std::abs(a[i].x - b[i].x) > 1.0e-3f;
        expected += double(b[i].x);
    }
    EXPECT_GT(partial, kRays / 20);
    EXPECT_LT(other, kRays / 500);
    const auto stopped = std::make_unique<bool[]>(kRays);
    ASSERT_TRUE(pair.gpu.kernels().occluded(rays, {stopped.get(), kRays}));
    const auto passed = double(std::count(stopped.get(), stopped.get() + kRays, false));
    EXPECT_NEAR(passed, expected, 4.0 * std::sqrt(double(kRays)));
}

TEST_F(KernelsS6, SolidsCrossedAreTheProcessors)
{
    expectSameCrossings(ballsOnFloor(), device, 1000);
    expectSameCrossings(unshared(ballsOnFloor()), device, 1000);
}

/// Two sheets back to back: the front is hit, not the hidden back that lies at the same distance.
TEST_F(KernelsS6, FrontsArePreferredToHiddenBacks)
{
    Scene scene;
    const int gray = addMaterial(scene, vec3(0.6f));
    addRectangle(scene, {vec3(-4, 0, 2), vec3(8, 0, 0), vec3(0, 0, -4)}, gray, kPage, {});
    addRectangle(scene, {vec3(-4, 0, -2), vec3(8, 0, 0), vec3(0, 0, 4)}, gray, kPage, {}); // faces down
    const Pair pair(std::move(scene), device);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < kRays; ++i) {
        Ray ray = randomRay(uint32_t(i));
        ray.origin.y = i % 2 == 0 ? 1.0f : -1.0f;
        const vec3 to = vec3(-3.9f + 7.8f * unitFloat(hashPcg(uint32_t(i))), 0, 1.5f * ray.direction.z);
        ray.direction = glm::normalize(to - ray.origin);
        rays.push_back(ray);
    }
    std::vector<RayHit> hits(kRays);
    ASSERT_TRUE(pair.gpu.kernels().nearest(rays, hits, RayUse::Light));
    std::size_t backs = 0;
    std::size_t found = 0;
    for (const RayHit& hit : hits) {
        found += hit.found();
        backs += hit.found() && hit.face.back != 0;
    }
    EXPECT_GT(found, kRays / 2);
    EXPECT_EQ(backs, 0u);
}

/// The same bits again, whatever else the device did in between.
TEST_F(KernelsS6, RaysRepeatTheirBits)
{
    const Pair pair(ballsOnFloor(Material::AlphaMode::Mask), device);
    const std::vector<Ray> rays = randomRays(kInfinity);
    std::vector<RayHit> a(kRays);
    std::vector<RayHit> b(kRays / 2);
    ASSERT_TRUE(pair.gpu.kernels().nearest(rays, a, RayUse::Light));
    ASSERT_TRUE(pair.gpu.kernels().nearest(std::span(rays).last(kRays / 2), b, RayUse::Light));
    EXPECT_EQ(std::memcmp(a.data() + kRays / 2, b.data(), b.size() * sizeof(RayHit)), 0);
}

} // namespace
} // namespace halflight::test::kernels_test
