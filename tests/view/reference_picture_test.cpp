// The reference beside the raster: it is that of the view that rests, and gets better.
#include "view/reference_picture.h"

#include "bake/test_room.h"
#include "halflight/bake_cpu/embree_integrator.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

namespace halflight::view {
namespace {

constexpr ivec2 kSize{48, 32};

Camera lookingAt(vec3 eye, vec3 target)
{
    Camera camera;
    camera.worldFromCamera = glm::inverse(glm::lookAt(eye, target, vec3(0, 1, 0)));
    return camera;
}

/// Root mean square difference over the mean of `truth`.
template<typename Picture> double errorOf(const Picture& picture, const ImageRgb32f& truth)
{
    double squares = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.texelCount(); ++i) {
        const vec3 difference = vec3(picture.texels()[i]) - truth.texels()[i];
        squares += double(glm::dot(difference, difference)) / 3.0;
        sum += double(luminance(truth.texels()[i]));
    }
    return std::sqrt(squares * double(truth.texelCount())) / sum;
}

TEST(ReferencePicture, IsOfTheViewThatRestsAndGetsBetter)
{
    const auto scene = std::make_shared<const Scene>(test::room(true, false, true));
    ReferencePicture reference;
    for (int i = 0; i < 20; ++i) { // the camera moves: nothing of this is shown
        EXPECT_TRUE(reference.follow(scene, lookingAt(vec3(0.1f * float(i), 1, 4), vec3(0, 1, 0)), kSize));
        EXPECT_FALSE(reference.take());
        std::this_thread::sleep_for(std::chrono::milliseconds(i < 10 ? 1 : 30));
    }
    const Camera camera = lookingAt(vec3(0.3f, 1, 3), vec3(0, 1, 0));
    EXPECT_TRUE(reference.follow(scene, camera, kSize));
    EXPECT_FALSE(reference.follow(scene, camera, kSize));
    ReferenceSettings settings;
    settings.samplesPerPixel = 512;
    settings.seed = 77;
    const Result<ImageRgb32f> truth = renderReference(*scene, camera, kSize, settings);
    ASSERT_TRUE(truth);
    settings.samplesPerPixel = 1;
    const Result<ImageRgb32f> rough = renderReference(*scene, camera, kSize, settings);
    ASSERT_TRUE(rough);
    double last = double(kInfinity);
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    for (int samples = 0; samples < 64 && std::chrono::steady_clock::now() < limit;) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        const std::optional<ReferencePicture::Picture> picture = reference.take();
        if (!picture || picture->radiance.size() != kSize) continue;
        EXPECT_GE(picture->samples, samples);
        samples = picture->samples;
        last = errorOf(picture->radiance, *truth);
    }
    EXPECT_LT(last, 0.3 * errorOf(*rough, *truth)) << "of at least 64 samples against one";
    reference.stop();
}

} // namespace
} // namespace halflight::view
