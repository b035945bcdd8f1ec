#include "halflight/render/renderer.h"
#include "halflight/base/finite.h"
#include "halflight/base/function_ref.h"
#include "halflight/base/rgb9e5.h"

#include "render/passes/samples.h"
#include "render/renderer_impl.h"
#include "render/scene/frame_bindings.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <new>

namespace halflight {
namespace {

constexpr int kMaxPictureSize = 16384;
constexpr int kMaxSupersampling = 4;
/// Passes of a frame that are measured: compose, shadows of three kinds, depth, two of the deferred path, forward, sky,
/// blended, readback or display.
constexpr uint32_t kMostPasses = 12;

/// Runs `body`; a failing device or a full memory becomes an error.
template<typename T> Result<T> guarded(FunctionRef<Result<T>()> body)
{
    try {
        return body();
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what(), ""};
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::DeviceFailed, "out of memory", ""};
    }
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

/// Radiance in full floats; half floats where the device cannot blend those.
VkFormat chooseColorFormat(const gpu::Device& device)
{
    const VkFormatFeatureFlags features = device.optimalFeatures(VK_FORMAT_R32G32B32A32_SFLOAT);
    return features & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT ? VK_FORMAT_R32G32B32A32_SFLOAT
                                                                   : VK_FORMAT_R16G16B16A16_SFLOAT;
}

gpu::UniqueSampler makeShadowSampler(const gpu::Device& device)
{
    const bool linear = device.optimalFeatures(kDepthFormat) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
    const VkFilter filter = linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
    return gpu::makeSampler(device, {.magFilter = filter,
                                     .minFilter = filter,
                                     .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                     .compareLessOrEqual = true});
}

gpu::DeviceOptions deviceOptions(const RendererOptions& options)
{
    gpu::DeviceOptions result{.validation = options.validation,
                              .preferCpu = options.preferCpu,
                              .instanceExtensions = options.instanceExtensions,
                              .deviceExtensions = options.deviceExtensions};
    if (options.device != nullptr) {
        const VulkanHandles& handles = *options.device;
        result.handles =
            gpu::Handles{handles.getInstanceProcAddr, handles.instance, handles.physicalDevice,    handles.device,
                         handles.queueFamily,         handles.queue,    handles.samplerAnisotropy, handles.queueMutex};
    }
    return result;
}

} // namespace

FrameSlot::FrameSlot(const gpu::Device& device) : timer(device, kMostPasses) {}

Renderer::Impl::Impl(const RendererOptions& options)
    : device(deviceOptions(options)), bindings(frameBindings(device)), setLayout(gpu::makeSetLayout(device, bindings)),
      colorFormat(chooseColorFormat(device)), pipelines(device, setLayout.get(), colorFormat),
      pageSampler(gpu::makeSampler(device, {.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST})),
      shadowSampler(makeShadowSampler(device)),
      texelSampler(gpu::makeSampler(device, {.magFilter = VK_FILTER_NEAREST,
                                             .minFilter = VK_FILTER_NEAREST,
                                             .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST}))
{
    for (int i = 0; i < kFramesInFlight; ++i) slots.emplace_back(device);
}

Status Renderer::Impl::check(const Camera& camera, const RenderSettings& settings) const
{
    const auto bad = [](const std::string& what) { return Error{ErrorCode::InvalidArgument, what, ""}; };
    if (!scene) return bad("no scene was loaded");
    if (settings.supersampling < 1 || settings.supersampling > kMaxSupersampling)
        return bad("supersampling must be 1…" + std::to_string(kMaxSupersampling));
    const int limit =
        std::min(kMaxPictureSize, int(device.properties().limits.maxImageDimension2D)) / settings.supersampling;
    if (settings.size.x < 1 || settings.size.y < 1 || settings.size.x > limit || settings.size.y > limit)
        return bad("the picture's size must be 1…" + std::to_string(limit));
    const vec3 shadowColor = settings.subtractiveShadowColor.value_or(vec3(0.0f));
    for (int c = 0; c < 3; ++c)
        if (!(std::isfinite(shadowColor[c]) && shadowColor[c] >= 0.0f))
            return bad("the subtractive shadow colour is not finite or negative");
    for (const Status& status :
         {checkCamera(camera), checkShadowSettings(settings.shadows), checkRunMode(scene->outline, settings.mode)})
        if (!status) return status;
    return {};
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

RenderedFrame Renderer::Impl::reportOf(PreparedFrame frame, const RenderSettings& settings) const
{
    RenderedFrame report;
    report.forwardReadsMask = frame.masks.layers > 0;
    report.forwardObjects = frame.forwardObjects;
    report.gBufferTargets = frame.deferred ? int(gBuffer.images().size()) + 1 : 0;
    if (settings.lightRows) report.lights = lightRows(scene->outline, frame.view, frame.plan);
    report.plan = std::move(frame.plan);
    return report;
}

std::vector<PassReport> passesOf(FrameSlot& slot)
{
    std::vector<PassReport> passes = slot.reports;
    if (!slot.timed) return passes;
    const std::vector<gpu::Timer::Span> spans = slot.timer.results();
    for (std::size_t i = 0; i < spans.size(); ++i) passes[i].milliseconds = spans[i].milliseconds;
    return passes;
}

Result<RenderedFrame> Renderer::Impl::render(const Camera& camera, const RenderSettings& settings)
{
    if (Status status = check(camera, settings); !status) return status.error();
    device.waitIdle(); // frames in flight have their own slots
    picture.reset();
    PreparedFrame frame = prepare(camera, settings);
    ensureTargets(frame, settings.shadows);
    if (!readback.get()) {
        const VkDeviceSize texel = colorFormat == VK_FORMAT_R32G32B32A32_SFLOAT ? 16 : 8;
        readback = gpu::Buffer(device, VkDeviceSize(color.info().width) * color.info().height * texel,
                               VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback);
    }
    FrameSlot& to = slots[nextSlot];
    bindFrame(to, frame, settings, {});
    device.execute([&](VkCommandBuffer commands) {
        recordFrame(commands, to, frame, settings.timings);
        gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kTransferSource);
        gpu::copyToHost(device, commands, color, readback);
        endPass({device, *scene, pipelines, to.set.get(), commands, counts}, "readback");
        gpu::transition(device, commands, color, gpu::state::kTransferSource, gpu::state::kFragmentRead);
    });
    RenderedFrame report = reportOf(frame, settings);
    if (settings.keepsPicture) picture.emplace(Picture{PictureContent{camera, settings, revision}, std::move(frame)});
    report.radiance = downsampled(withoutCracks(readPicture()), settings.supersampling);
    report.passes = passesOf(to);
    report.timed = to.timed;
    return report;
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

Result<std::shared_ptr<Renderer::Uploaded>> Renderer::upload(const BakedScene& baked, TextureDetail detail,
                                                             const std::atomic<bool>* cancel)
{
    if (Status status = checkScene(baked); !status) return status.error();
    return guarded<std::shared_ptr<Uploaded>>([&]() -> Result<std::shared_ptr<Uploaded>> {
        auto uploaded = std::make_shared<Uploaded>();
        uploaded->scene =
            std::make_unique<GpuScene>(uploadScene(impl_->device, baked, impl_->textureImages(), detail, cancel));
        if (cancel != nullptr && *cancel) return cancelledError();
        uploaded->switchesAtBake = shadowSwitches(baked.scene);
        return uploaded;
    });
}

Status Renderer::show(const std::shared_ptr<Uploaded>& uploaded)
{
    if (!uploaded || !uploaded->scene)
        return Error{ErrorCode::InvalidArgument, "the scene was not uploaded, or was shown before", ""};
    const Result<bool> shown = guarded<bool>([&]() -> Result<bool> {
        impl_->device.waitIdle();
        impl_->show(*uploaded);
        return true;
    });
    return shown ? Status() : Status(shown.error());
}

void Renderer::prepareForward(bool shadowmask)
{
    Impl& impl = *impl_;
    const MaskUse masks{int(shadowmask), false};
    if (impl.forwardPipelines[masks.number()] || impl.preparedForward[shadowmask].valid()) return;
    impl.preparedForward[shadowmask] = std::async(
        std::launch::async, [&device = impl.device, layout = impl.pipelines.layout.get(), format = impl.colorFormat,
                             masks] { return std::make_unique<ForwardPipelines>(device, layout, format, masks); });
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
    followLight(*impl_->scene, light);
    ++impl_->revision;
    return {};
}

Status Renderer::setLightGroup(const std::string& name, vec3 weight)
{
    if (!impl_->scene) return Error{ErrorCode::InvalidArgument, "no scene was loaded", ""};
    const Status status = setGroupWeight(*impl_->scene, name, weight);
    if (status) ++impl_->revision;
    return status;
}

std::vector<GroupWeight> Renderer::lightGroups() const
{
    if (!impl_->scene) return {};
    return settableWeights(impl_->scene->outline, impl_->scene->groups.weights);
}

Status Renderer::setObjectTransform(int object, const mat4& worldFromObject)
{
    if (!has(scene().objects, object)) return Error{ErrorCode::InvalidArgument, "the object does not exist", ""};
    if (!isFinite(worldFromObject))
        return Error{ErrorCode::InvalidArgument, "the transform is not finite", "/objects/" + std::to_string(object)};
    impl_->scene->outline.scene.objects[std::size_t(object)].worldFromObject = worldFromObject;
    impl_->scene->changedObjects.push_back(uint32_t(object));
    ++impl_->revision;
    return {};
}

Status Renderer::setObjectShadows(int object, bool castShadows, bool receiveShadows)
{
    if (!has(scene().objects, object)) return Error{ErrorCode::InvalidArgument, "the object does not exist", ""};
    Object& current = impl_->scene->outline.scene.objects[std::size_t(object)];
    current.castShadows = castShadows;
    current.receiveShadows = receiveShadows;
    impl_->scene->changedObjects.push_back(uint32_t(object));
    ++impl_->revision;
    return {};
}

Status Renderer::updateLightmaps(std::span<const LightmapRectangle> rectangles)
{
    if (!impl_->scene) return Error{ErrorCode::InvalidArgument, "no scene was loaded", ""};
    GroupPages& groups = impl_->scene->groups.pages;
    const gpu::Image& target = groups.any() ? groups.pages() : impl_->scene->lightmaps;
    const gpu::ImageInfo& pages = target.info();
    std::vector<gpu::Uploader::Box> boxes;
    for (const LightmapRectangle& r : rectangles) {
        if (r.texels == nullptr || r.texels->empty()) continue;
        const ivec2 size = r.texels->size();
        const ivec2 end = r.offset + size;
        if (r.page < 0 || std::size_t(r.page) >= impl_->scene->outline.lightmaps.size() || r.offset.x < 0 ||
            r.offset.y < 0 || end.x > int(pages.width) || end.y > int(pages.height))
            return Error{ErrorCode::InvalidArgument, "a rectangle is not on a lightmap page", ""};
        boxes.push_back({.offset = {r.offset.x, r.offset.y, 0},
                         .size = {uint32_t(size.x), uint32_t(size.y), 1},
                         .texels = r.texels->data(),
                         .layer = uint32_t(r.page)});
    }
    if (boxes.empty()) return {};
    const Result<bool> done = guarded<bool>([&]() -> Result<bool> {
        impl_->device.waitIdle(); // frames in flight read the pages before
        gpu::Uploader uploader(impl_->device);
        // One at a time, with a barrier between, because they may overlap.
        for (const gpu::Uploader::Box& box : boxes)
            uploader.boxes(target, gpu::state::kFragmentRead, {&box, 1}, sizeof(uint32_t));
        uploader.finish();
        for (const LightmapRectangle& r : rectangles)
            if (groups.any() && r.texels != nullptr) groups.raisePeak(brightestOf(*r.texels));
        if (groups.any()) pagesOfGroupsChanged(*impl_->scene);
        ++impl_->revision;
        return true;
    });
    return done ? Status() : Status(done.error());
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
        impl_->device.waitIdle(); // frames in flight read the pages before
        uploadDynamicLightmaps(impl_->device, *impl_->scene, irradiance);
        ++impl_->revision;
        return true;
    });
    return done ? Status() : Status(done.error());
}

Result<RenderedFrame> Renderer::render(const Camera& camera, const RenderSettings& settings)
{
    return guarded<RenderedFrame>([&] { return impl_->render(camera, settings); });
}

Result<RenderedFrame> Renderer::record(VkCommandBuffer commands, const VulkanTarget& target, const Camera& camera,
                                       const RenderSettings& settings, float exposureEv, ToneMapping toneMapping)
{
    return guarded<RenderedFrame>(
        [&] { return impl_->record(commands, target, camera, settings, exposureEv, toneMapping); });
}

VulkanHandles Renderer::handles() const
{
    const gpu::Handles handles = impl_->device.handles();
    return {handles.getInstanceProcAddr, handles.instance, handles.physicalDevice,    handles.device,
            handles.queueFamily,         handles.queue,    handles.samplerAnisotropy, handles.queueMutex};
}

void Renderer::waitIdle() const
{
    impl_->device.waitIdle();
}

std::vector<std::string> Renderer::validationMessages() const
{
    return impl_->device.validationMessages();
}

} // namespace halflight
