// Pictures that record() shows in more pixels than they have, once more, and while another scene is uploaded.
#include "render/passes/record_caller.h"

#include <array>
#include <future>
#include <set>
#include <vector>

namespace halflight::test::shown_pictures_test {
namespace {

class ShownPictures : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, ShownPictures, kBothPaths, pathNameOf);

/// A picture in more pixels than it has: in the middle of an enlarged pixel it is the pixel's, and between the values
/// of its neighbours elsewhere.
TEST_P(ShownPictures, AreEnlarged)
{
    ASSERT_TRUE(renderer->load(yard()));
    RenderSettings settings = settingsOf(GetParam());
    Caller caller(*renderer);
    constexpr int kTimes = 3;
    const gpu::Image image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, kSize * kTimes);
    caller.clear(image);
    caller.device().execute([&](VkCommandBuffer commands) {
        VulkanTarget target = targetOf(image);
        target.size = kSize * kTimes;
        target.begin = ivec2(1, 0);
        ASSERT_TRUE(renderer->record(commands, target, kCamera, settings, kExposure));
    });
    const ImageRgba8 drawn = caller.read(image);
    const ImageRgba8 small = displayedPicture(renderer->render(kCamera, settings)->radiance, kExposure);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(drawn(0, 5)[c], Caller::kGrey[c]) << "left of the rectangle";
    for (int y = 1; y + 1 < kSize.y; ++y) {
        for (int x = 1; x + 1 < kSize.x; ++x) {
            for (int c = 0; c < 4; ++c) {
                ASSERT_NEAR(drawn(kTimes * x + 1, kTimes * y + 1)[c], small(x, y)[c], 1) << x << " " << y;
                const int left = small(x, y)[c];
                const int right = small(x + 1, y)[c];
                ASSERT_GE(drawn(kTimes * x + 2, kTimes * y + 1)[c], std::min(left, right) - 1) << x << " " << y;
                ASSERT_LE(drawn(kTimes * x + 2, kTimes * y + 1)[c], std::max(left, right) + 1) << x << " " << y;
            }
        }
    }
}

/// RenderSettings::keepsPicture: nothing is drawn while nothing changes, and exposure still counts.
TEST_P(ShownPictures, KeepThePictureUntilSomethingChanges)
{
    ASSERT_TRUE(renderer->load(yard()));
    Caller caller(*renderer);
    RenderSettings settings = settingsOf(GetParam());
    settings.keepsPicture = true;
    const gpu::Image image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, kSize);
    std::vector<std::vector<PassReport>> passes;
    std::vector<bool> kept;
    const auto show = [&](const Camera& camera, float exposure) {
        caller.clear(image);
        caller.device().execute([&](VkCommandBuffer commands) {
            const auto frame = renderer->record(commands, targetOf(image), camera, settings, exposure);
            ASSERT_TRUE(frame) << frame.error().text();
            EXPECT_EQ(frame->plan.lights.size(), 1u);
            passes.push_back(frame->passes);
            kept.push_back(frame->isKept);
        });
        return caller.read(image);
    };
    const auto expectShows = [&](const Camera& camera, float exposure, const char* what) {
        const ImageRgba8 drawn = show(camera, exposure);
        const auto expected = renderer->render(camera, settings);
        ASSERT_TRUE(expected);
        EXPECT_LE(mostDifference(drawn, displayedPicture(expected->radiance, exposure)), 1) << what;
        EXPECT_EQ(mostDifference(show(camera, exposure), drawn), 0) << what << ", as render() drew it";
        EXPECT_TRUE(kept.back()) << what;
    };
    const ImageRgba8 first = show(kCamera, kExposure);
    EXPECT_EQ(mostDifference(show(kCamera, kExposure), first), 0);
    EXPECT_GT(mostDifference(show(kCamera, kExposure + 1.0f), first), 10) << "exposure";
    expectShows(kCamera, kExposure + 2.0f, "the fourth frame");
    EXPECT_EQ(kept, (std::vector<bool>{false, true, true, true, true}));
    for (std::size_t i = 2; i < 4; ++i) // passes of two calls before
        EXPECT_EQ(passes[i].size() == 1, i > 2) << "only the display is drawn again";
    const auto again = [&] { (void)show(kCamera, kExposure); };
    again();
    expectShows(lookAt(vec3(1, 2, 6), vec3(0, 0.5f, 0)), kExposure, "another camera");
    again();
    Light sun = renderer->scene().lights[0];
    sun.intensity *= 3.0f;
    ASSERT_TRUE(renderer->setLight(0, sun));
    expectShows(kCamera, kExposure, "a light");
    again();
    ASSERT_TRUE(renderer->setObjectTransform(1, glm::translate(mat4(1.0f), vec3(1, 1.5f, 0))));
    expectShows(kCamera, kExposure, "an object");
    again();
    ASSERT_TRUE(renderer->setObjectShadows(1, false, false));
    expectShows(kCamera, kExposure, "its shadow");
    again();
    BakedScene other = yard();
    other.scene.sky = Sky{vec3(1.0f, 0.0f, 0.0f), vec3(0.1f), vec3(0.1f)};
    ASSERT_TRUE(renderer->load(other));
    expectShows(kCamera, kExposure, "another scene");
}

/// upload() on another thread while frames of the scene before are recorded; show() replaces it once.
TEST_P(ShownPictures, GoOnDuringAnUpload)
{
    ASSERT_TRUE(renderer->load(yard()));
    Caller caller(*renderer);
    const RenderSettings settings = settingsOf(GetParam());
    const gpu::Image image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, kSize);
    const auto show = [&] {
        caller.clear(image);
        caller.device().execute([&](VkCommandBuffer commands) {
            ASSERT_TRUE(renderer->record(commands, targetOf(image), kCamera, settings, kExposure));
        });
        return caller.read(image);
    };
    const ImageRgba8 before = show();
    BakedScene other = yard();
    other.scene.sky = Sky{vec3(1.0f, 0.0f, 0.0f), vec3(0.1f), vec3(0.1f)};
    auto upload = std::async(std::launch::async, [&] { return renderer->upload(other); });
    for (int i = 0; i < 5; ++i) EXPECT_EQ(mostDifference(show(), before), 0);
    const auto uploaded = upload.get();
    ASSERT_TRUE(uploaded) << uploaded.error().text();
    EXPECT_EQ(mostDifference(show(), before), 0) << "not shown yet";
    ASSERT_TRUE(renderer->show(*uploaded));
    const ImageRgba8 after = show();
    EXPECT_FALSE(renderer->show(*uploaded)) << "it was shown";
    ASSERT_TRUE(renderer->load(other));
    EXPECT_EQ(mostDifference(show(), after), 0);
    EXPECT_GT(mostDifference(after, before), 10);
}

/// Coarse textures have the large ones' mean, and none of them is left after an upload of all texels.
TEST_P(ShownPictures, BeginWithCoarseTextures)
{
    BakedScene baked = yard();
    baked.scene.lights.clear();
    Texture stripes;
    stripes.nearest = true;
    stripes.pixels.edit() = ImageRgba8(512, 512, u8vec4(200, 100, 50, 255));
    for (int y = 0; y < 512; ++y)
        for (int x = 0; x < 512; ++x)
            if (x % 4 < 2) stripes.pixels.edit()(x, y) = u8vec4(100, 200, 150, 255);
    baked.scene.textures.push_back(stripes);
    Material& floor = baked.scene.materials[0];
    floor.baseColor = vec4(1.0f);
    floor.baseColorTexture.texture = 0;
    floor.unlit = true;
    RenderSettings settings = settingsOf(GetParam());
    settings.supersampling = 1;
    const auto colors = [&](TextureDetail detail) {
        const auto uploaded = renderer->upload(baked, detail);
        EXPECT_TRUE(uploaded) << uploaded.error().text();
        EXPECT_TRUE(renderer->show(*uploaded));
        const auto frame = renderer->render(lookAt(vec3(0, 0.5f, 2.5f), vec3(0, 0, 2.4f)), settings);
        EXPECT_TRUE(frame);
        const ImageRgba8 picture = displayedPicture(frame->radiance, 0.0f);
        std::set<std::array<int, 3>> colors;
        for (const u8vec4& texel : picture.texels()) colors.insert({texel.x, texel.y, texel.z});
        return colors.size();
    };
    EXPECT_EQ(colors(TextureDetail::Coarse), 1u) << "one mean of the stripes";
    EXPECT_GT(colors(TextureDetail::Full), 1u);
    EXPECT_EQ(colors(TextureDetail::Coarse), 1u);
}

} // namespace
} // namespace halflight::test::shown_pictures_test
