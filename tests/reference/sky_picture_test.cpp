// The reference under a sky's picture: each way to sample the sun, and both together, give the sum over the picture
// (S6).
#include "bake/test_sky.h"
#include "reference/traced.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::sky_picture_test {
namespace {

TEST(ReferenceSkyPictureS6, AllWaysToSampleTheSunAgreeWithTheSum)
{
    const vec3 view = glm::normalize(vec3(-1, 1.2f, 0.1f));
    const Sky sky = skyOf(sunPicture(256, vec3(1, 1, 0), 0.1f, 300.0f));
    const SkyLight light(sky);
    ASSERT_TRUE(light.samples());
    for (const Finish& f : {Finish{vec3(0.8f), 0.0f, 0.9f, 1.0f}, Finish{vec3(0.9f), 1.0f, 0.3f, 1.0f}}) {
        double expected = 0.0;
        const ivec2 size(2048, 1024);
        for (int y = 0; y < size.y; ++y) {
            const double band =
                std::cos(double(y) / size.y * double(kPi)) - std::cos(double(y + 1) / size.y * double(kPi));
            for (int x = 0; x < size.x; ++x) {
                const vec3 d = shading::skyPictureDirection((vec2(x, y) + 0.5f) / vec2(size), vec2(1, 0));
                if (d.y <= 0.0f) continue;
                expected += double(reflectedBy(f, vec3(0, 1, 0), view, d, light.radiance(d)).y) * band * 2.0 *
                            double(kPi) / size.x;
            }
        }
        for (const auto way : {EmitterSampling::Both, EmitterSampling::Directions, EmitterSampling::Surfaces}) {
            Scene scene;
            addFloor(scene, addFinish(scene, f));
            scene.sky = sky;
            const Traced traced(std::move(scene), {.emitters = way});
            SCOPED_TRACE(testing::Message() << f.roughness << ' ' << int(way));
            const bool rare = way == EmitterSampling::Directions; // few directions meet the sun
            expectMean(traced.bySeeds(view, 5000), expected, {.resolved = rare ? 0.04 : 0.01});
        }
    }
}

// The camera sees the picture itself, where skyPictureUv() says.
TEST(ReferenceSkyPictureS6, CameraRaysSeeThePicture)
{
    Scene scene;
    addFloor(scene, addFinish(scene, {}));
    scene.sky = skyOf(skyPicture(512, [](vec3 d) { return 2.0f + d; }), 0.5f * kPi);
    const Traced traced(std::move(scene));
    // A quarter turn about +Y takes +X to -Z and +Z to +X.
    EXPECT_NEAR(traced.radiance(vec3(0, 1, 0), vec3(0, 0, -1), 1).x, 3.0f, 1e-3f);
    EXPECT_NEAR(traced.radiance(vec3(0, 1, 0), vec3(1, 0, 0), 1).z, 3.0f, 1e-3f);
    EXPECT_NEAR(traced.radiance(vec3(0, 1, 0), vec3(0, 1, 0), 1).y, 3.0f, 1e-3f);
}

} // namespace
} // namespace halflight::test::sky_picture_test
