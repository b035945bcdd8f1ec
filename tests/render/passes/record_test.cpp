// Frames recorded into images of the caller (Renderer::record()): the displayed picture, parts of it, frames in flight,
// a device of the caller.
#include "render/passes/record_caller.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

namespace halflight::test::record_test {
namespace {

class RecordedFrames : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, RecordedFrames, kBothPaths, pathNameOf);

/// The picture in the caller's image is displayedPicture() of render()'s, to a rounding: forward and deferred, in
/// formats that encode sRGB and in others, in views of light and of values.
TEST_P(RecordedFrames, ShowTheDisplayedPicture)
{
    ASSERT_TRUE(renderer->load(yard()));
    RenderSettings settings = settingsOf(GetParam());
    Caller caller(*renderer);
    for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB}) {
        for (const DebugView view : {DebugView::Lit, DebugView::Cascades}) {
            settings.view = view;
            const auto expected = renderer->render(kCamera, settings);
            ASSERT_TRUE(expected) << expected.error().text();
            const gpu::Image image = caller.makeTarget(format, kSize);
            caller.clear(image);
            caller.device().execute([&](VkCommandBuffer commands) {
                const auto frame = renderer->record(commands, targetOf(image), kCamera, settings, kExposure);
                ASSERT_TRUE(frame) << frame.error().text();
                EXPECT_TRUE(frame->radiance.empty());
                EXPECT_EQ(frame->plan.lights.size(), 1u);
            });
            ImageRgba8 shown = displayedPicture(expected->radiance, kExposure);
            if (!showsLight(view))
                for (std::size_t i = 0; i < shown.texelCount(); ++i)
                    shown.texels()[i] = u8vec4(glm::clamp(expected->radiance.texels()[i], 0.0f, 1.0f) * 255.0f + 0.5f);
            const ImageRgba8 drawn = caller.read(image);
            EXPECT_LE(mostDifference(drawn, shown), 1) << int(format) << " " << int(view);
            EXPECT_GT(mostDifference(drawn, ImageRgba8(kSize.x, kSize.y, drawn(0, 0))), 40) << "it shows something";
        }
    }
}

TEST_P(RecordedFrames, HaveTheToneMapperThatIsAskedFor)
{
    ASSERT_TRUE(renderer->load(yard()));
    const RenderSettings settings = settingsOf(GetParam());
    const auto expected = renderer->render(kCamera, settings);
    ASSERT_TRUE(expected) << expected.error().text();
    Caller caller(*renderer);
    const ImageRgba8 neutral = displayedPicture(expected->radiance, kExposure);
    for (const ToneMapping mapper : {ToneMapping::Aces, ToneMapping::Agx, ToneMapping::None}) {
        const gpu::Image image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, kSize);
        caller.clear(image);
        caller.device().execute([&](VkCommandBuffer commands) {
            ASSERT_TRUE(renderer->record(commands, targetOf(image), kCamera, settings, kExposure, mapper));
        });
        const ImageRgba8 drawn = caller.read(image);
        EXPECT_LE(mostDifference(drawn, displayedPicture(expected->radiance, kExposure, mapper)), 1) << int(mapper);
        EXPECT_GT(mostDifference(drawn, neutral), 5) << int(mapper);
    }
}

TEST_P(RecordedFrames, FillCracksLikeTheHost)
{
    // A floor of two parts, between them a slit that is narrower than a sample.
    BakedScene baked;
    Scene& scene = baked.scene;
    scene.sky = Sky{vec3(40.0f), vec3(40.0f), vec3(40.0f)};
    const int material = addMaterial(scene, vec4(0.5f, 0.5f, 0.5f, 1.0f));
    scene.materials[std::size_t(material)].emissiveNits = vec3(1.0f);
    for (const float side : {-1.0f, 1.0f})
        addObject(scene, makeRectangle(4, 4, material),
                  glm::rotate(mat4(1.0f), 0.4f, vec3(0, 1, 0)) * glm::translate(mat4(1.0f), vec3(2.0015f * side, 0, 0)),
                  true);
    ASSERT_TRUE(renderer->load(baked));
    RenderSettings settings = settingsOf(GetParam());
    settings.supersampling = 1;
    const Camera above = lookAt(vec3(0.3f, 2.0f, 0.2f), vec3(0));
    const auto expected = renderer->render(above, settings);
    ASSERT_TRUE(expected);
    Caller caller(*renderer);
    const gpu::Image image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, kSize);
    caller.clear(image);
    caller.device().execute([&](VkCommandBuffer commands) {
        ASSERT_TRUE(renderer->record(commands, targetOf(image), above, settings, kExposure));
    });
    EXPECT_LE(mostDifference(caller.read(image), displayedPicture(expected->radiance, kExposure)), 1);
}

TEST_P(RecordedFrames, DrawOnlyTheirRectangle)
{
    ASSERT_TRUE(renderer->load(yard()));
    const RenderSettings settings = settingsOf(GetParam());
    Caller caller(*renderer);
    const gpu::Image image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, kSize);
    caller.clear(image);
    caller.device().execute([&](VkCommandBuffer commands) {
        VulkanTarget target = targetOf(image);
        target.begin = ivec2(10, 20);
        target.end = ivec2(50, 64);
        ASSERT_TRUE(renderer->record(commands, target, kCamera, settings, kExposure));
    });
    const ImageRgba8 drawn = caller.read(image);
    const ImageRgba8 whole = displayedPicture(renderer->render(kCamera, settings)->radiance, kExposure);
    for (int y = 0; y < kSize.y; ++y) {
        for (int x = 0; x < kSize.x; ++x) {
            const bool inside = x >= 10 && x < 50 && y >= 20;
            const u8vec4 expected = inside ? whole(x, y) : Caller::kGrey;
            for (int c = 0; c < 4; ++c) ASSERT_NEAR(drawn(x, y)[c], expected[c], 1) << x << " " << y;
        }
    }
}

/// Frames one after the other without waiting for more than record() asks, while a light, an object and the picture's
/// size change: each shows what was set when it was recorded.
TEST_P(RecordedFrames, InFlightKeepTheirValues)
{
    ASSERT_TRUE(renderer->load(yard()));
    Caller caller(*renderer);
    gpu::Device& device = caller.device();
    const gpu::Functions& vk = device.vk;
    constexpr int kFrames = 6;
    struct Frame {
        gpu::Image image;
        VkCommandPool pool = VK_NULL_HANDLE;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        VkFence fence = VK_NULL_HANDLE;
        ImageRgba8 expected;
    };
    std::vector<Frame> frames(kFrames);
    const auto settingsOfFrame = [&](int i) {
        RenderSettings settings = settingsOf(GetParam());
        settings.size = i < 4 ? kSize : kSize / 2;
        return settings;
    };
    const auto change = [&](int i) {
        Light sun = renderer->scene().lights[0];
        sun.intensity = 1.0f + float(i);
        ASSERT_TRUE(renderer->setLight(0, sun));
        if (i % 2 == 0)
            ASSERT_TRUE(renderer->setObjectTransform(1, glm::translate(mat4(1.0f), vec3(0.3f * float(i), 1, 0))));
    };
    for (int i = 0; i < kFrames; ++i) {
        change(i);
        frames[std::size_t(i)].expected =
            displayedPicture(renderer->render(kCamera, settingsOfFrame(i))->radiance, kExposure);
    }
    for (int i = 0; i < kFrames; ++i) {
        Frame& frame = frames[std::size_t(i)];
        frame.image = caller.makeTarget(VK_FORMAT_R8G8B8A8_UNORM, settingsOfFrame(i).size);
        caller.clear(frame.image);
        const VkCommandPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                               .queueFamilyIndex = renderer->handles().queueFamily};
        ASSERT_EQ(vk.CreateCommandPool(device.handle(), &poolInfo, nullptr, &frame.pool), VK_SUCCESS);
        const VkCommandBufferAllocateInfo bufferInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                     .commandPool = frame.pool,
                                                     .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                     .commandBufferCount = 1};
        ASSERT_EQ(vk.AllocateCommandBuffers(device.handle(), &bufferInfo, &frame.commands), VK_SUCCESS);
        const VkFenceCreateInfo fenceInfo{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        ASSERT_EQ(vk.CreateFence(device.handle(), &fenceInfo, nullptr, &frame.fence), VK_SUCCESS);
    }
    for (int i = 0; i < kFrames; ++i) {
        Frame& frame = frames[std::size_t(i)];
        if (i >= kFramesInFlight)
            ASSERT_EQ(
                vk.WaitForFences(device.handle(), 1, &frames[std::size_t(i - kFramesInFlight)].fence, VK_TRUE, ~0ull),
                VK_SUCCESS);
        change(i);
        const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                             .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        ASSERT_EQ(vk.BeginCommandBuffer(frame.commands, &begin), VK_SUCCESS);
        const auto recorded =
            renderer->record(frame.commands, targetOf(frame.image), kCamera, settingsOfFrame(i), kExposure);
        ASSERT_TRUE(recorded) << recorded.error().text();
        ASSERT_EQ(vk.EndCommandBuffer(frame.commands), VK_SUCCESS);
        const VkCommandBufferSubmitInfo commandInfo{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                                    .commandBuffer = frame.commands};
        const VkSubmitInfo2 submit{
            .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commandInfo};
        ASSERT_EQ(vk.QueueSubmit2(renderer->handles().queue, 1, &submit, frame.fence), VK_SUCCESS);
    }
    renderer->waitIdle();
    for (int i = 0; i < kFrames; ++i) {
        Frame& frame = frames[std::size_t(i)];
        EXPECT_LE(mostDifference(caller.read(frame.image), frame.expected), 1) << i;
        if (i > 0 && i < 4) EXPECT_GT(mostDifference(frame.expected, frames[std::size_t(i - 1)].expected), 3) << i;
        vk.DestroyFence(device.handle(), frame.fence, nullptr);
        vk.DestroyCommandPool(device.handle(), frame.pool, nullptr);
    }
}

TEST_F(RenderTest, DrawsOnTheCallersDevice)
{
    const BakedScene baked = yard();
    const RenderSettings settings = settingsOf(RenderPath::Forward);
    const RenderedFrame own = render(baked, kCamera, settings);
    const VulkanHandles handles = renderer->handles();
    RendererOptions options;
    options.device = &handles;
    auto second = Renderer::create(options);
    ASSERT_TRUE(second) << second.error().text();
    ASSERT_TRUE((*second)->load(baked));
    const auto frame = (*second)->render(kCamera, settings);
    ASSERT_TRUE(frame) << frame.error().text();
    EXPECT_EQ(frame->radiance.texels(), own.radiance.texels());
}

TEST_F(RenderTest, RefusesToRecordWithoutAScene)
{
    startAnew();
    const auto frame = renderer->record(nullptr, VulkanTarget{}, kCamera, settingsOf(RenderPath::Forward), kExposure);
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().code, ErrorCode::InvalidArgument);
}

} // namespace
} // namespace halflight::test::record_test
