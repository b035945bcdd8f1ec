// The reference beside the raster: it is that of the view that rests, and gets better.
#include "view/scene/reference_picture.h"

#include "bake/test_room.h"
#include "halflight/bake_cpu/embree_integrator.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

namespace halflight::view::reference_picture_test {
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
    ReferencePicture moving(std::chrono::hours(1)); // to a view that does not rest
    for (int i = 0; i < 20; ++i) {
        EXPECT_TRUE(moving.follow(scene, lookingAt(vec3(0.1f * float(i), 1, 4), vec3(0, 1, 0)), kSize, true));
        std::this_thread::sleep_for(std::chrono::milliseconds(i < 10 ? 1 : 30));
        EXPECT_FALSE(moving.take());
    }
    ReferencePicture reference(std::chrono::milliseconds(1));
    const Camera camera = lookingAt(vec3(0.3f, 1, 3), vec3(0, 1, 0));
    EXPECT_TRUE(reference.follow(scene, camera, kSize, true));
    EXPECT_FALSE(reference.follow(scene, camera, kSize, true));
    ReferenceSettings settings;
    settings.samplesPerPixel = 512;
    settings.seed = 77;
    const Result<ImageRgb32f> truth = renderReference(*scene, camera, kSize, settings);
    ASSERT_TRUE(truth);
    settings.samplesPerPixel = 1;
    const Result<ImageRgb32f> rough = renderReference(*scene, camera, kSize, settings);
    ASSERT_TRUE(rough);
    double last = double(kInfinity);
    for (int samples = 0; samples < 64;) { // or for ever, as ctest notices
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

/// As `halflight render --reference` with --specular off has it; the picture begins anew.
TEST(ReferencePicture, HasNoSpecularLightWhereTheViewHasNone)
{
    Scene room = test::room(true, false, true);
    for (Material& material : room.materials) {
        material.metallic = 1.0f;
        material.roughness = 0.2f;
    }
    const auto scene = std::make_shared<const Scene>(room);
    const Camera camera = lookingAt(vec3(0.3f, 1, 3), vec3(0, 1, 0));
    ReferenceSettings settings;
    settings.samplesPerPixel = 256;
    settings.seed = 77;
    const Result<ImageRgb32f> shiny = renderReference(*scene, camera, kSize, settings);
    settings.surfaces = ReferenceSurfaces::DiffuseView;
    const Result<ImageRgb32f> dull = renderReference(*scene, camera, kSize, settings);
    ASSERT_TRUE(shiny && dull);
    ReferencePicture reference(std::chrono::milliseconds(1));
    for (const bool specular : {true, false}) {
        EXPECT_TRUE(reference.follow(scene, camera, kSize, specular));
        EXPECT_FALSE(reference.take()) << "of the other switch";
        std::optional<ReferencePicture::Picture> picture;
        while (!picture || picture->samples < 64) { // or for ever, as ctest notices
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            if (auto next = reference.take()) picture = std::move(next);
        }
        ASSERT_TRUE(picture && picture->radiance.size() == kSize);
        EXPECT_LT(errorOf(picture->radiance, specular ? *shiny : *dull),
                  0.3 * errorOf(picture->radiance, specular ? *dull : *shiny))
            << specular;
    }
}

/// A square of 2 * side * side triangles.
Scene heavyScene(int side)
{
    Scene scene;
    MeshPart part;
    for (int y = 0; y <= side; ++y) {
        for (int x = 0; x <= side; ++x) {
            part.positions.push_back(vec3(x, 0.2f * std::sin(0.1f * float(x * y)), y) / float(side));
            part.normals.push_back(vec3(0, 1, 0));
        }
    }
    const auto at = [&](int x, int y) { return uint32_t(y * (side + 1) + x); };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            for (const uint32_t i :
                 {at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)})
                part.indices.push_back(i);
    scene.meshes.push_back(Mesh{.parts = {part}});
    Object object;
    object.mesh = 0;
    scene.objects.push_back(object);
    return scene;
}

/// Another view, or none, is said at once: also while Embree builds a scene, which cannot be interrupted. A call that
/// waited would return when that is over. Where it ends by chance during the call, another scene is tried.
TEST(ReferencePicture, NeverLetsTheWindowWait)
{
    bool returnedMeanwhile = false;
    for (int attempt = 0; attempt < 20 && !returnedMeanwhile; ++attempt) {
        const auto scene = std::make_shared<const Scene>(heavyScene(150 + 50 * attempt));
        ReferencePicture reference(std::chrono::milliseconds(1));
        const Camera camera = lookingAt(vec3(0.5f, 1, 2), vec3(0.5f, 0, 0.5f));
        EXPECT_FALSE(reference.works());
        reference.follow(scene, camera, ivec2(640, 400), true);
        EXPECT_TRUE(reference.works());
        while (!reference.prepares() && !reference.take()) std::this_thread::yield();
        if (!reference.prepares()) continue; // too late
        EXPECT_TRUE(reference.follow(scene, lookingAt(vec3(0.4f, 1, 2), vec3(0.5f, 0, 0.5f)), ivec2(640, 400), true));
        EXPECT_FALSE(reference.take());
        reference.pause();
        EXPECT_FALSE(reference.works());
        returnedMeanwhile = reference.prepares();
        while (reference.prepares()) std::this_thread::yield();
        EXPECT_FALSE(reference.take()) << "of a view that is not wanted any more";
    }
    EXPECT_TRUE(returnedMeanwhile);
}

} // namespace
} // namespace halflight::view::reference_picture_test
