#pragma once
// What a Renderer holds: the device, one uploaded scene, the targets of a frame, and what each frame in flight has of
// its own.

#include "halflight/render/renderer.h"
#include "halflight/render/vulkan_target.h"
#include "render/passes/compose_pass.h"
#include "render/passes/display_pass.h"
#include "render/passes/passes.h"
#include "render/passes/volumes.h"
#include "render/scene/frame_data.h"
#include "render/scene/shadow_switches.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace halflight {

/// A buffer that the host writes anew every frame, and that grows as needed.
class FrameBuffer {
public:
    explicit FrameBuffer(VkBufferUsageFlags usage) : usage_(usage) {}

    const gpu::Buffer& write(const gpu::Device& device, const void* data, std::size_t bytes)
    {
        if (!buffer_.get() || buffer_.size() < bytes)
            buffer_ =
                gpu::Buffer(device, std::max<std::size_t>(bytes + bytes / 2, 256), usage_, gpu::MemoryUse::Upload);
        if (bytes > 0) std::memcpy(buffer_.mapped(), data, bytes);
        return buffer_;
    }
    template<typename T> const gpu::Buffer& write(const gpu::Device& device, const std::vector<T>& values)
    {
        return write(device, values.data(), values.size() * sizeof(T));
    }

private:
    VkBufferUsageFlags usage_;
    gpu::Buffer buffer_;
};

/// An array of shadow map layers, each with a view to draw into.
struct ShadowMap {
    gpu::Image image;
    std::vector<gpu::UniqueView> layers;

    /// Frames in flight may still read the one before.
    void ensure(const gpu::Device& device, int size, int layerCount)
    {
        const gpu::ImageInfo& info = image.info();
        if (image.get() && info.width == uint32_t(size) && info.layers == uint32_t(layerCount)) return;
        device.waitIdle();
        layers.clear();
        image = {};
        image = gpu::Image(device, {.format = kDepthFormat,
                                    .width = uint32_t(size),
                                    .height = uint32_t(size),
                                    .layers = uint32_t(layerCount),
                                    .array = true,
                                    .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                                    .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
        for (int i = 0; i < layerCount; ++i) layers.push_back(image.layerView(device, uint32_t(i)));
    }
};

/// Shadow tiles with their draws: cascades by layer of their array, the others in the atlas.
struct ShadowPasses {
    std::vector<std::vector<ShadowDraws>> cascades;
    std::vector<ShadowDraws> spots;
    std::vector<ShadowDraws> points;
};

/// What is decided of a frame before its commands are recorded.
struct PreparedFrame {
    FrameView view; ///< its size is in samples
    FramePlan plan;
    ShadowPasses shadows;
    CameraDraws draws;
    std::vector<uint32_t> instances;
    bool deferred = false;
    MaskUse masks;         ///< of surfaces lit as they are drawn
    MaskUse deferredMasks; ///< of the G-buffer
    int forwardObjects = 0;
};

/// What the picture in Renderer::Impl::color shows.
struct PictureContent {
    Camera camera;
    RenderSettings settings;
    uint64_t revision = 0; ///< Renderer::Impl::revision
    bool operator==(const PictureContent&) const = default;
};

/// What a frame has to itself while the device may still be working on the one before.
struct FrameSlot {
    explicit FrameSlot(const gpu::Device& device);

    gpu::DescriptorSet set;
    FrameBuffer frame{VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT};
    FrameBuffer lights{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer tiles{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer clusters{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer instances{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer lightSources{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT}; ///< of the compose pass, and its set
    gpu::DescriptorSet composeSet;
    gpu::Timer timer;
    bool timed = false;              ///< its passes are measured
    std::vector<PassReport> reports; ///< of the passes recorded so far
};

/// Reports of the slot's finished frame, with times if it was timed.
std::vector<PassReport> passesOf(FrameSlot& slot);

class Renderer::Uploaded {
public:
    std::unique_ptr<GpuScene> scene;
    std::vector<ShadowSwitches> switchesAtBake;
};

struct Renderer::Impl {
    explicit Impl(const RendererOptions& options);

    void load(const BakedScene& baked);
    [[nodiscard]] TextureImages textureImages();
    void show(Uploaded& uploaded);
    Result<RenderedFrame> render(const Camera& camera, const RenderSettings& settings);
    Result<RenderedFrame> record(VkCommandBuffer commands, const VulkanTarget& target, const Camera& camera,
                                 const RenderSettings& settings, float exposureEv, ToneMapping toneMapping);

    [[nodiscard]] Status check(const Camera& camera, const RenderSettings& settings) const;
    PreparedFrame prepare(const Camera& camera, const RenderSettings& settings);
    void ensureTargets(const PreparedFrame& frame, const ShadowSettings& shadows);
    void bindFrame(FrameSlot& slot, const PreparedFrame& frame, const RenderSettings& settings,
                   const DisplayValues& display);
    /// Shadow maps and picture: `color` then holds the frame's samples, in state kColorAttachment.
    void recordFrame(VkCommandBuffer commands, FrameSlot& slot, const PreparedFrame& frame, bool timings);
    void recordPicture(VkCommandBuffer commands, FrameSlot& slot, PictureContent content, const DisplayValues& display);
    void beginRecording(VkCommandBuffer commands, FrameSlot& slot, bool timings);
    /// Adds up the pages of light groups where weights have changed.
    void recordCompose(const PassContext& context);
    void recordShadows(const PassContext& context, const ShadowPasses& shadows);
    void recordDeferred(const PassContext& context, const CameraDraws& draws, MaskUse masks);
    void endPass(const PassContext& context, const char* name);
    /// What the caller of the frame gets, but for the picture.
    [[nodiscard]] RenderedFrame reportOf(PreparedFrame frame, const RenderSettings& settings) const;
    [[nodiscard]] ImageRgba32f readPicture() const;

    gpu::Device device;
    std::vector<gpu::Binding> bindings;
    gpu::UniqueSetLayout setLayout;
    VkFormat colorFormat;
    Pipelines pipelines;
    /// By MaskUse::number(), made when first used.
    std::unique_ptr<ForwardPipelines> forwardPipelines[MaskUse::kCount];
    std::future<std::unique_ptr<ForwardPipelines>> preparedForward[2];     ///< the same, while a thread makes them
    std::unique_ptr<DeferredPipelines> deferredPipelines[MaskUse::kCount]; ///< as forwardPipelines
    std::unique_ptr<VolumePasses> volumePasses;               ///< made with the first frame that has volumes
    std::unique_ptr<ComposePipeline> composePipeline;         ///< made with the first scene that has light groups
    std::map<VkFormat, gpu::UniquePipeline> displayPipelines; ///< by the target's format, made when first used
    gpu::UniqueSampler pageSampler;
    gpu::UniqueSampler shadowSampler;
    gpu::UniqueSampler texelSampler;
    std::vector<FrameSlot> slots; ///< kFramesInFlight
    std::size_t nextSlot = 0;
    FrameSlot* slot = nullptr; ///< of the frame being recorded
    PassReport counts;         ///< the pass being recorded

    const Scene noScene;
    std::mutex sceneMutex; ///< held where `scene` is replaced, and by upload() where it reads it
    std::unique_ptr<GpuScene> scene;
    std::vector<ShadowSwitches> switchesAtBake; ///< of the scene's objects

    uint64_t revision = 0; ///< changes with the scene and what setters change of it
    struct Picture {
        PictureContent content;
        PreparedFrame frame;
    };
    std::optional<Picture> picture; ///< in `color`, which is then in state kFragmentRead
    gpu::Image color;
    gpu::Image depth;
    GBuffer gBuffer;
    gpu::Buffer readback; ///< made when a picture is first read
    ShadowMap cascades;
    ShadowMap atlas;
};

} // namespace halflight
