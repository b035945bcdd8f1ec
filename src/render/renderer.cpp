#include "halflight/render/renderer.h"
#include "halflight/base/finite.h"

#include "render/frame/frame_internal.h"
#include "render/frame_data.h"
#include "render/passes.h"
#include "render/samples.h"
#include "render/shadow_switches.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <new>

namespace halflight {
namespace {

constexpr int kMaxPictureSize = 16384;
constexpr int kMaxSupersampling = 4;

/// Runs `body`; a failing device or a full memory becomes an error.
template<typename T> Result<T> guarded(const std::function<Result<T>()>& body)
{
    try {
        return body();
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what(), ""};
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::DeviceFailed, "out of memory", ""};
    }
}

/// A buffer that the host writes anew every frame, and that grows as needed.
class FrameBuffer {
public:
    FrameBuffer(VkBufferUsageFlags usage) : usage_(usage) {}

    /// True when the buffer was made anew, so that descriptors must be written.
    bool write(const gpu::Device& device, const void* data, std::size_t bytes)
    {
        const bool grow = !buffer_.get() || buffer_.size() < bytes;
        if (grow)
            buffer_ =
                gpu::Buffer(device, std::max<std::size_t>(bytes + bytes / 2, 256), usage_, gpu::MemoryUse::Upload);
        if (bytes > 0) std::memcpy(buffer_.mapped(), data, bytes);
        return grow;
    }
    template<typename T> bool write(const gpu::Device& device, const std::vector<T>& values)
    {
        return write(device, values.data(), values.size() * sizeof(T));
    }
    [[nodiscard]] const gpu::Buffer& get() const { return buffer_; }

private:
    VkBufferUsageFlags usage_;
    gpu::Buffer buffer_;
};

/// An array of shadow map layers, each with a view to draw into.
struct ShadowMap {
    gpu::Image image;
    std::vector<gpu::UniqueView> layers;

    bool ensure(const gpu::Device& device, int size, int layerCount)
    {
        const gpu::ImageInfo& info = image.info();
        if (image.get() && info.width == uint32_t(size) && info.layers == uint32_t(layerCount)) return false;
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
        return true;
    }
};

/// Shadow tiles with their draws: cascades by layer of their array, the others in the atlas.
struct ShadowPasses {
    std::vector<std::vector<ShadowDraws>> cascades;
    std::vector<ShadowDraws> spots;
    std::vector<ShadowDraws> points;
};

ShadowPasses shadowPasses(const Scene& scene, const FramePlan& plan, const ShadowSettings& settings, DrawLists& lists)
{
    ShadowPasses passes;
    passes.cascades.resize(std::size_t(std::max(plan.directionalLayers, 0)));
    for (const FrameLight& light : plan.lights) {
        const LightType type = scene.lights[std::size_t(light.light)].type;
        const float slopeBias = shadowSettingsOf(scene.lights[std::size_t(light.light)], settings).slopeBias;
        for (int i = light.firstTile; i < light.firstTile + light.tileCount; ++i) {
            const ShadowTile& tile = plan.tiles[std::size_t(i)];
            if (plan.castersOf(i).empty()) continue; // shaders know, and do not look
            ShadowDraws draws{tile.clipFromWorld, tile.atlasOffset, tile.size, slopeBias,
                              lists.casters(plan.castersOf(i))};
            if (type == LightType::Directional)
                passes.cascades[std::size_t(tile.layer)].push_back(std::move(draws));
            else
                (type == LightType::Spot ? passes.spots : passes.points).push_back(std::move(draws));
        }
    }
    return passes;
}

/// S27. What the light pass cannot light: static objects whose lightmap loses light to the main light's realtime
/// shadow.
bool mustGoForward(const GpuScene& scene, const FramePlan& plan, uint32_t object)
{
    return !plan.mainShadowReceivers.empty() && plan.mainShadowReceivers[object] != 0 && scene.lightmapped[object] &&
           scene.outline.scene.objects[object].receiveShadows;
}

template<typename T> bool has(const std::vector<T>& values, int index)
{
    return index >= 0 && std::size_t(index) < values.size();
}

Status checkCamera(const Camera& camera)
{
    auto bad = [](const char* what) { return Error{ErrorCode::InvalidArgument, what, ""}; };
    if (!isFinite(camera.worldFromCamera) || std::abs(glm::determinant(mat3(camera.worldFromCamera))) < 1.0e-6f)
        return bad("the camera's transform is not finite or has no inverse");
    if (!camera.orthographic && !(camera.verticalFovRadians > 0.0f && camera.verticalFovRadians < kPi))
        return bad("the camera's vertical field of view must be between 0 and 180 degrees");
    if (camera.orthographic && !(camera.orthographicHeightMeters > 0.0f))
        return bad("the orthographic camera's height must be positive");
    if (!(camera.farMeters > camera.nearMeters) || (!camera.orthographic && !(camera.nearMeters > 0.0f)))
        return bad("the camera's near plane must be positive and nearer than its far plane");
    return {};
}

} // namespace

struct Renderer::Impl {
    explicit Impl(const RendererOptions& options)
        : device({.validation = options.validation, .preferCpu = options.preferCpu}), bindings(frameBindings(device)),
          setLayout(gpu::makeSetLayout(device, bindings)), colorFormat(chooseColorFormat(device)),
          pipelines(device, setLayout.get(), colorFormat),
          pageSampler(gpu::makeSampler(device, {.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST})),
          shadowSampler(makeShadowSampler(device)),
          texelSampler(gpu::makeSampler(device, {.magFilter = VK_FILTER_NEAREST,
                                                 .minFilter = VK_FILTER_NEAREST,
                                                 .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST})),
          timer(device, 12)
    {}

    /// Radiance in full floats; half floats where the device cannot blend those.
    static VkFormat chooseColorFormat(const gpu::Device& device)
    {
        const VkFormatFeatureFlags features = device.optimalFeatures(VK_FORMAT_R32G32B32A32_SFLOAT);
        return features & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT ? VK_FORMAT_R32G32B32A32_SFLOAT
                                                                       : VK_FORMAT_R16G16B16A16_SFLOAT;
    }
    static gpu::UniqueSampler makeShadowSampler(const gpu::Device& device)
    {
        const bool linear = device.optimalFeatures(kDepthFormat) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
        const VkFilter filter = linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
        return gpu::makeSampler(device, {.magFilter = filter,
                                         .minFilter = filter,
                                         .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                         .compareLessOrEqual = true});
    }

    void load(const BakedScene& baked)
    {
        scene.reset(); // before the next one, so that both need not fit
        set = {};
        scene = std::make_unique<GpuScene>(uploadScene(device, baked));
        switchesAtBake = shadowSwitches(baked.scene);
        set = gpu::DescriptorSet(device, setLayout.get(), bindings, uint32_t(scene->textures.size()));
        set.buffer(shading::kBindObjects, scene->objects);
        set.buffer(shading::kBindMaterials, scene->materials);
        set.image(shading::kBindLightmaps, scene->lightmaps.view(), pageSampler.get());
        set.image(shading::kBindLightmapDirections, scene->lightmapDirections.view(), pageSampler.get());
        set.image(shading::kBindDynamicLightmaps, scene->dynamicLightmaps.view(), pageSampler.get());
        set.image(shading::kBindShadowmasks, scene->shadowmasks.view(), pageSampler.get());
        set.image(shading::kBindSkyPicture, scene->sky.image.view(), scene->sky.sampler.get());
        set.buffer(shading::kBindReflectionProbes, scene->reflections.probes);
        set.image(shading::kBindReflections, scene->reflections.picture.view(), pageSampler.get());
        set.buffer(shading::kBindProbeVolumes, scene->probeVolumes.buffer());
        set.image(shading::kBindProbeTexture, scene->probeVolumes.texture().view(), pageSampler.get());
        for (std::size_t i = 0; i < scene->textures.size(); ++i)
            set.image(shading::kBindTextures, scene->textures[i].view(),
                      scene->samplers[scene->samplerOfTexture[i]].get(), uint32_t(i));
        bindAll = bindGBuffer = true;
    }

    void ensureTargets(ivec2 size, const FramePlan& plan, const ShadowSettings& shadows);
    void ensureGBuffer(const FramePlan& plan);
    void uploadFrame(const FrameView& view, const RenderSettings& settings, const FramePlan& plan,
                     const std::vector<uint32_t>& instances);
    ImageRgba32f readPicture() const;
    void endPass(VkCommandBuffer commands, const char* name);
    void recordShadows(const PassContext& context, const ShadowPasses& shadows);
    void recordDeferred(const PassContext& context, const CameraDraws& draws);
    Result<RenderedFrame> render(const Camera& camera, const RenderSettings& settings);

    gpu::Device device;
    std::vector<gpu::Binding> bindings;
    gpu::UniqueSetLayout setLayout;
    VkFormat colorFormat;
    Pipelines pipelines;
    std::unique_ptr<ForwardPipelines> forwardPipelines[2];   ///< without and with mask, made when first used
    std::unique_ptr<DeferredPipelines> deferredPipelines[2]; ///< the same
    gpu::UniqueSampler pageSampler;
    gpu::UniqueSampler shadowSampler;
    gpu::UniqueSampler texelSampler;
    gpu::Timer timer;
    bool timed = false;              ///< this frame's passes are measured
    PassReport counts;               ///< the pass being recorded
    std::vector<PassReport> reports; ///< the passes before it

    const Scene noScene;
    std::unique_ptr<GpuScene> scene;
    std::vector<ShadowSwitches> switchesAtBake; ///< of the scene's objects
    gpu::DescriptorSet set;
    bool bindAll = true; ///< the set is new: frame buffers and shadow maps are to be bound
    bool bindGBuffer = true;

    gpu::Image color;
    gpu::Image depth;
    GBuffer gBuffer;
    gpu::Buffer readback;
    ShadowMap cascades;
    ShadowMap atlas;
    FrameBuffer frameBuffer{VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT};
    FrameBuffer lightBuffer{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer tileBuffer{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer clusterBuffer{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    FrameBuffer instanceBuffer{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
};

void Renderer::Impl::ensureTargets(ivec2 size, const FramePlan& plan, const ShadowSettings& shadows)
{
    if (!color.get() || color.info().width != uint32_t(size.x) || color.info().height != uint32_t(size.y)) {
        color = {};
        depth = {};
        readback = {};
        bindGBuffer = true;
        color = gpu::Image(device, {.format = colorFormat,
                                    .width = uint32_t(size.x),
                                    .height = uint32_t(size.y),
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
        depth = gpu::Image(device, {.format = kDepthFormat,
                                    .width = uint32_t(size.x),
                                    .height = uint32_t(size.y),
                                    .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                                    .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
        const VkDeviceSize texel = colorFormat == VK_FORMAT_R32G32B32A32_SFLOAT ? 16 : 8;
        readback = gpu::Buffer(device, VkDeviceSize(size.x) * VkDeviceSize(size.y) * texel,
                               VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback);
    }
    // Without shadow maps one texel stands in for them, and is never read.
    const bool hasCascades = plan.directionalLayers > 0;
    const bool hasAtlas = int(plan.tiles.size()) > plan.directionalLayers;
    if (cascades.ensure(device, hasCascades ? shadows.directionalMapSize : 1,
                        hasCascades ? plan.directionalLayers : 1) ||
        bindAll)
        set.image(shading::kBindCascades, cascades.image.view(), shadowSampler.get());
    if (atlas.ensure(device, hasAtlas ? shadows.atlasSize : 1, 1) || bindAll)
        set.image(shading::kBindAtlas, atlas.image.view(), shadowSampler.get());
}

void Renderer::Impl::ensureGBuffer(const FramePlan& plan)
{
    std::unique_ptr<DeferredPipelines>& made = deferredPipelines[plan.usesMask];
    if (!made) made = std::make_unique<DeferredPipelines>(device, pipelines.layout.get(), colorFormat, plan.usesMask);
    const ivec2 size(int(color.info().width), int(color.info().height));
    if (!gBuffer.ensure(device, size, plan.usesMask) && !bindGBuffer) return;
    set.image(shading::kBindGBufferBaseColor, gBuffer.baseColor.view(), texelSampler.get());
    set.image(shading::kBindGBufferNormals, gBuffer.normals.view(), texelSampler.get());
    set.image(shading::kBindGBufferMaterial, gBuffer.material.view(), texelSampler.get());
    if (plan.usesMask) set.image(shading::kBindGBufferMask, gBuffer.mask.view(), texelSampler.get());
    set.image(shading::kBindDepth, depth.view(), texelSampler.get());
    bindGBuffer = false;
}

void Renderer::Impl::uploadFrame(const FrameView& view, const RenderSettings& settings, const FramePlan& plan,
                                 const std::vector<uint32_t>& instances)
{
    auto bind = [&](int binding, const FrameBuffer& buffer, bool isNew) {
        if (isNew || bindAll) set.buffer(uint32_t(binding), buffer.get());
    };
    const shading::GpuFrame frame = gpuFrame(*scene, view, settings, plan);
    bind(shading::kBindFrame, frameBuffer, frameBuffer.write(device, &frame, sizeof(frame)));
    bind(shading::kBindLights, lightBuffer,
         lightBuffer.write(device, gpuLights(scene->outline.scene, plan, settings.shadows)));
    bind(shading::kBindTiles, tileBuffer, tileBuffer.write(device, gpuTiles(plan)));
    bind(shading::kBindClusters, clusterBuffer, clusterBuffer.write(device, plan.clusters.words));
    bind(shading::kBindInstances, instanceBuffer, instanceBuffer.write(device, instances));
    bindAll = false;
}

ImageRgba32f Renderer::Impl::readPicture() const
{
    ImageRgba32f picture(int(color.info().width), int(color.info().height));
    if (colorFormat == VK_FORMAT_R32G32B32A32_SFLOAT) {
        std::memcpy(picture.data(), readback.mapped(), picture.texelCount() * sizeof(vec4));
    } else {
        const auto* texels = reinterpret_cast<const uint64_t*>(readback.mapped());
        for (std::size_t i = 0; i < picture.texelCount(); ++i) picture.texels()[i] = glm::unpackHalf4x16(texels[i]);
    }
    return picture;
}

void Renderer::Impl::endPass(VkCommandBuffer commands, const char* name)
{
    counts.name = name;
    reports.push_back(counts);
    counts = {};
    if (timed) timer.mark(commands, name);
}

void Renderer::Impl::recordShadows(const PassContext& context, const ShadowPasses& shadows)
{
    VkCommandBuffer commands = context.commands;
    gpu::transition(device, commands, cascades.image, gpu::state::kUndefined, gpu::state::kDepthAttachment);
    gpu::transition(device, commands, atlas.image, gpu::state::kUndefined, gpu::state::kDepthAttachment);
    for (std::size_t i = 0; i < shadows.cascades.size(); ++i) {
        if (shadows.cascades[i].empty()) continue;
        beginShadowLayer(context, cascades.layers[i].get(), ivec2(0), ivec2(int(cascades.image.info().width)));
        drawShadowTiles(context, shadows.cascades[i]);
        endRendering(context);
    }
    endPass(commands, "directional shadows");
    // Only what tiles cover is cleared: an atlas is large, and often nearly empty.
    const bool hasAtlas = !shadows.spots.empty() || !shadows.points.empty();
    ivec2 low(int(atlas.image.info().width));
    ivec2 high(0);
    for (const auto* tiles : {&shadows.spots, &shadows.points}) {
        for (const ShadowDraws& tile : *tiles) {
            low = glm::min(low, tile.offset);
            high = glm::max(high, tile.offset + tile.size);
        }
    }
    if (hasAtlas) beginShadowLayer(context, atlas.layers[0].get(), low, high);
    drawShadowTiles(context, shadows.spots);
    endPass(commands, "spot shadows");
    drawShadowTiles(context, shadows.points);
    if (hasAtlas) endRendering(context);
    endPass(commands, "point shadows");
    gpu::transition(device, commands, cascades.image, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, atlas.image, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
}

void Renderer::Impl::recordDeferred(const PassContext& context, const CameraDraws& draws)
{
    VkCommandBuffer commands = context.commands;
    const DeferredPipelines& deferred = *deferredPipelines[bool(gBuffer.mask.get())];
    for (const gpu::Image* image : gBuffer.images())
        gpu::transition(device, commands, *image, gpu::state::kUndefined, gpu::state::kColorAttachment);
    drawGBuffer(context, deferred, gBuffer, color, depth, draws);
    endPass(commands, "g-buffer");

    for (const gpu::Image* image : gBuffer.images())
        gpu::transition(device, commands, *image, gpu::state::kColorAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, depth, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kColorAttachment);
    drawDeferredLight(context, deferred, color);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kColorAttachment);
    gpu::transition(device, commands, depth, gpu::state::kFragmentRead, gpu::state::kDepthAttachment);
    endPass(commands, "deferred light");
}

Result<RenderedFrame> Renderer::Impl::render(const Camera& camera, const RenderSettings& settings)
{
    if (!scene) return Error{ErrorCode::InvalidArgument, "no scene was loaded", ""};
    if (settings.supersampling < 1 || settings.supersampling > kMaxSupersampling)
        return Error{ErrorCode::InvalidArgument, "supersampling must be 1…" + std::to_string(kMaxSupersampling), ""};
    const int limit =
        std::min(kMaxPictureSize, int(device.properties().limits.maxImageDimension2D)) / settings.supersampling;
    if (settings.size.x < 1 || settings.size.y < 1 || settings.size.x > limit || settings.size.y > limit)
        return Error{ErrorCode::InvalidArgument, "the picture's size must be 1…" + std::to_string(limit), ""};
    const vec3 shadowColor = settings.subtractiveShadowColor.value_or(vec3(0.0f));
    for (int c = 0; c < 3; ++c)
        if (!(std::isfinite(shadowColor[c]) && shadowColor[c] >= 0.0f))
            return Error{ErrorCode::InvalidArgument, "the subtractive shadow colour is not finite or negative", ""};
    for (const Status& status :
         {checkCamera(camera), checkShadowSettings(settings.shadows), checkRunMode(scene->outline, settings.mode)})
        if (!status) return status.error();

    uploadChangedObjects(device, *scene);
    const FrameView view{camera, settings.size * settings.supersampling};
    FramePlan plan = planFrame(scene->outline, scene->bounds, view, settings.mode, settings.shadows);
    for (std::string& warning : switchWarnings(scene->outline, switchesAtBake, settings.mode))
        plan.warnings.push_back(std::move(warning));

    if (settings.view == DebugView::Overlap) addOverflowedLights(scene->outline, scene->bounds, view, plan);

    DrawLists lists(*scene);
    const ShadowPasses shadows = shadowPasses(scene->outline.scene, plan, settings.shadows, lists);
    CameraDraws draws;
    draws.clipFromWorld = view.clipFromView() * view.viewFromWorld();
    const std::vector<uint32_t> visible = objectsInView(scene->bounds, draws.clipFromWorld);
    const bool deferred = settings.path == RenderPath::Deferred && settings.view == DebugView::Lit;
    std::vector<uint32_t> toGBuffer;
    std::vector<uint32_t> toForward;
    for (const uint32_t object : visible)
        (deferred && !mustGoForward(*scene, plan, object) ? toGBuffer : toForward).push_back(object);
    draws.deferred = lists.solid(toGBuffer);
    draws.forward = lists.solid(toForward);
    draws.blended = lists.blended(visible, vec3(camera.worldFromCamera[3]));

    ensureTargets(view.size, plan, settings.shadows);
    if (deferred) ensureGBuffer(plan);
    const bool readsMask = plan.usesMask || plan.subtractsByMask || settings.view == DebugView::Shadowmask;
    std::unique_ptr<ForwardPipelines>& forward = forwardPipelines[readsMask];
    if (!forward) forward = std::make_unique<ForwardPipelines>(device, pipelines.layout.get(), colorFormat, readsMask);
    uploadFrame(view, settings, plan, lists.instances());

    device.execute([&](VkCommandBuffer commands) {
        const PassContext context{device, *scene, pipelines, set.get(), commands, counts};
        timed = settings.timings && device.timestamps();
        counts = {};
        reports.clear();
        if (timed) timer.begin(commands);
        bindScene(context);

        recordShadows(context, shadows);

        gpu::transition(device, commands, color, gpu::state::kUndefined, gpu::state::kColorAttachment);
        gpu::transition(device, commands, depth, gpu::state::kUndefined, gpu::state::kDepthAttachment);
        drawDepth(context, depth, draws);
        gpu::transition(device, commands, depth, gpu::state::kDepthAttachment, gpu::state::kDepthAttachment);
        endPass(commands, "depth");
        if (deferred) recordDeferred(context, draws);
        beginForward(context, color, depth, deferred ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR);
        drawLit(context, *forward, draws);
        endPass(commands, "forward");
        drawSky(context);
        endPass(commands, "sky");
        drawBlended(context, *forward, draws);
        endPass(commands, "blended");
        endRendering(context);

        gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kTransferSource);
        gpu::copyToHost(device, commands, color, readback);
        endPass(commands, "readback");
    });

    RenderedFrame frame;
    frame.radiance = downsampled(withoutCracks(readPicture()), settings.supersampling);
    frame.forwardReadsMask = readsMask;
    frame.forwardObjects = int(toForward.size());
    frame.gBufferTargets = deferred ? int(gBuffer.images().size()) + 1 : 0;
    if (settings.lightRows) frame.lights = lightRows(scene->outline, view, plan);
    frame.plan = std::move(plan);
    frame.timed = timed;
    frame.passes = std::move(reports);
    if (timed) {
        const std::vector<gpu::Timer::Span> spans = timer.results();
        for (std::size_t i = 0; i < spans.size(); ++i) frame.passes[i].milliseconds = spans[i].milliseconds;
    }
    return frame;
}

Renderer::Renderer() = default;
Renderer::~Renderer() = default;

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererOptions& options)
{
    return guarded<std::unique_ptr<Renderer>>([&]() -> Result<std::unique_ptr<Renderer>> {
        std::unique_ptr<Renderer> renderer(new Renderer);
        renderer->impl_ = std::make_unique<Impl>(options);
        return renderer;
    });
}

std::string Renderer::deviceName() const
{
    return impl_->device.properties().deviceName;
}

std::string Renderer::driver() const
{
    return impl_->device.driver();
}

Status Renderer::load(const BakedScene& baked)
{
    if (Status status = checkScene(baked); !status) return status;
    const Result<bool> loaded = guarded<bool>([&]() -> Result<bool> {
        impl_->load(baked);
        return true;
    });
    return loaded ? Status() : Status(loaded.error());
}

const Scene& Renderer::scene() const
{
    return impl_->scene ? impl_->scene->outline.scene : impl_->noScene;
}

Status Renderer::setLight(int light, const Light& changed)
{
    if (!has(scene().lights, light)) return Error{ErrorCode::InvalidArgument, "the light does not exist", ""};
    if (const char* problem = problemOf(changed))
        return Error{ErrorCode::InvalidArgument, problem, "/lights/" + std::to_string(light)};
    Light& current = impl_->scene->outline.scene.lights[std::size_t(light)];
    Light next = changed;
    next.name = current.name;
    next.type = current.type;
    next.mode = current.mode;
    next.baking = current.baking;
    next.sourceNode = current.sourceNode;
    current = std::move(next);
    return {};
}

Status Renderer::setObjectTransform(int object, const mat4& worldFromObject)
{
    if (!has(scene().objects, object)) return Error{ErrorCode::InvalidArgument, "the object does not exist", ""};
    if (!isFinite(worldFromObject))
        return Error{ErrorCode::InvalidArgument, "the transform is not finite", "/objects/" + std::to_string(object)};
    impl_->scene->outline.scene.objects[std::size_t(object)].worldFromObject = worldFromObject;
    impl_->scene->changedObjects.push_back(uint32_t(object));
    return {};
}

Status Renderer::setObjectShadows(int object, bool castShadows, bool receiveShadows)
{
    if (!has(scene().objects, object)) return Error{ErrorCode::InvalidArgument, "the object does not exist", ""};
    Object& current = impl_->scene->outline.scene.objects[std::size_t(object)];
    current.castShadows = castShadows;
    current.receiveShadows = receiveShadows;
    impl_->scene->changedObjects.push_back(uint32_t(object));
    return {};
}

Status Renderer::setDynamicLightmaps(std::span<const ImageRgb32f> irradiance)
{
    if (!impl_->scene) return Error{ErrorCode::InvalidArgument, "no scene was loaded", ""};
    if (Status status = checkDynamicLightmaps(impl_->scene->outline, irradiance); !status) return status;
    const int limit = int(impl_->device.properties().limits.maxImageDimension2D);
    if (!irradiance.empty() && (irradiance[0].width() > limit || irradiance[0].height() > limit))
        return Error{ErrorCode::InvalidArgument,
                     "dynamic lightmap pages are larger than the Vulkan device's images, " + std::to_string(limit), ""};
    const Result<bool> done = guarded<bool>([&]() -> Result<bool> {
        if (uploadDynamicLightmaps(impl_->device, *impl_->scene, irradiance))
            impl_->set.image(shading::kBindDynamicLightmaps, impl_->scene->dynamicLightmaps.view(),
                             impl_->pageSampler.get());
        return true;
    });
    return done ? Status() : Status(done.error());
}

Result<RenderedFrame> Renderer::render(const Camera& camera, const RenderSettings& settings)
{
    return guarded<RenderedFrame>([&] { return impl_->render(camera, settings); });
}

std::vector<std::string> Renderer::validationMessages() const
{
    return impl_->device.validationMessages();
}

} // namespace halflight
