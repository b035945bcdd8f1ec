#pragma once
// A program that has frames recorded into its images (Renderer::record()), and a scene for them.

#include "gpu/resources.h"
#include "halflight/render/vulkan_target.h"
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cstdlib>
#include <cstring>
#include <vector>

namespace halflight::test {

inline constexpr ivec2 kSize(96, 64);

/// The caller's side: images, command buffers and fences on the renderer's device.
class Caller {
public:
    explicit Caller(const Renderer& renderer) : device_({.handles = handlesOf(renderer)}) {}

    static gpu::Handles handlesOf(const Renderer& renderer)
    {
        const VulkanHandles h = renderer.handles();
        return {h.getInstanceProcAddr, h.instance, h.physicalDevice,    h.device,
                h.queueFamily,         h.queue,    h.samplerAnisotropy, h.queueMutex};
    }

    gpu::Image makeTarget(VkFormat format, ivec2 size)
    {
        return gpu::Image(device_, {.format = format,
                                    .width = uint32_t(size.x),
                                    .height = uint32_t(size.y),
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                             VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT});
    }

    /// Fills the image with grey, and makes it ready to draw into.
    void clear(const gpu::Image& image)
    {
        const std::vector<u8vec4> grey(std::size_t(image.info().width) * image.info().height, kGrey);
        gpu::Uploader uploader(device_);
        const gpu::Uploader::Level level{0, 0, grey.data()};
        uploader.image(image, {&level, 1}, 4);
        uploader.finish();
        device_.execute([&](VkCommandBuffer commands) {
            gpu::transition(device_, commands, image, gpu::state::kFragmentRead, gpu::state::kColorAttachment);
        });
    }

    ImageRgba8 read(const gpu::Image& image)
    {
        const ivec2 size(int(image.info().width), int(image.info().height));
        const gpu::Buffer host(device_, VkDeviceSize(size.x) * size.y * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                               gpu::MemoryUse::Readback);
        device_.execute([&](VkCommandBuffer commands) {
            gpu::transition(device_, commands, image, gpu::state::kColorAttachment, gpu::state::kTransferSource);
            gpu::copyToHost(device_, commands, image, host);
        });
        ImageRgba8 picture(size.x, size.y);
        std::memcpy(picture.data(), host.mapped(), picture.texelCount() * sizeof(u8vec4));
        return picture;
    }

    gpu::Device& device() { return device_; }

    static constexpr u8vec4 kGrey{77, 77, 77, 77};

private:
    gpu::Device device_;
};

inline VulkanTarget targetOf(const gpu::Image& image)
{
    return {image.view(), image.info().format};
}

/// The most that a channel of a pixel differs.
inline int mostDifference(const ImageRgba8& a, const ImageRgba8& b)
{
    EXPECT_EQ(a.size(), b.size());
    int most = 0;
    for (std::size_t i = 0; i < a.texelCount(); ++i)
        for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(int(a.texels()[i][c]) - int(b.texels()[i][c])));
    return most;
}

/// A lit floor with a mast, the sky behind it.
inline BakedScene yard()
{
    BakedScene baked;
    Scene& scene = baked.scene;
    scene.sky = Sky{vec3(0.2f, 0.4f, 0.9f), vec3(0.6f), vec3(0.1f)};
    addObject(scene, makeRectangle(6, 6, addMaterial(scene, vec4(0.7f, 0.6f, 0.5f, 1.0f))), mat4(1.0f), true);
    addObject(scene, makeRectangle(1, 1, addMaterial(scene, vec4(0.2f, 0.5f, 0.2f, 1.0f))),
              glm::translate(mat4(1.0f), vec3(0, 1, 0)), false);
    scene.lights.push_back(directionalLight(glm::normalize(vec3(0.3f, 1.0f, 0.2f)), 3.0f));
    return baked;
}

inline RenderSettings settingsOf(RenderPath path)
{
    RenderSettings settings;
    settings.path = path;
    settings.size = kSize;
    settings.supersampling = 2;
    settings.shadows.directionalMapSize = 512;
    settings.shadows.distanceMeters = 20.0f;
    return settings;
}

inline const Camera kCamera = lookAt(vec3(2, 3, 6), vec3(0, 0.5f, 0));
inline constexpr float kExposure = 0.3f;

} // namespace halflight::test
