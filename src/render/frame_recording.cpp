// From a camera to recorded commands.
#include "halflight/shading/color.h"
#include "render/frame/frame_internal.h"
#include "render/renderer_impl.h"

#include <algorithm>
#include <utility>

namespace halflight {
namespace {

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

void bindSceneImages(gpu::DescriptorSet& set, const GpuScene& scene, VkSampler pages)
{
    set.buffer(shading::kBindObjects, scene.objects);
    set.buffer(shading::kBindMaterials, scene.materials);
    set.image(shading::kBindLightmaps, scene.lightmaps.view(), pages);
    set.image(shading::kBindLightmapDirections, scene.lightmapDirections.view(), pages);
    set.image(shading::kBindShadowmasks, scene.shadowmasks.view(), pages);
    set.image(shading::kBindSkyPicture, scene.sky.image.view(), scene.sky.sampler.get());
    set.buffer(shading::kBindReflectionProbes, scene.reflections.probes);
    set.image(shading::kBindReflections, scene.reflections.picture.view(), pages);
    set.buffer(shading::kBindProbeVolumes, scene.probeVolumes.buffer());
    set.image(shading::kBindProbeTexture, scene.probeVolumes.texture().view(), pages);
    for (std::size_t i = 0; i < scene.textures.size(); ++i)
        set.image(shading::kBindTextures, scene.textures[i]->view(), scene.samplers[scene.samplerOfTexture[i]].get(),
                  uint32_t(i));
}

} // namespace

/// Textures are most of a scene, and often those of the one before.
TextureImages Renderer::Impl::textureImages()
{
    const std::lock_guard lock(sceneMutex);
    TextureImages images;
    for (std::size_t i = 0; scene && i < scene->textures.size(); ++i)
        images.emplace(scene->textureHashes[i], scene->textures[i]);
    return images;
}

void Renderer::Impl::load(const BakedScene& baked)
{
    device.waitIdle();
    TextureImages kept = textureImages();
    scene.reset(); // before the next one, so that both need not fit
    for (FrameSlot& each : slots) {
        each.set = {};
        each.composeSet = {};
    }
    Uploaded uploaded;
    uploaded.scene = std::make_unique<GpuScene>(uploadScene(device, baked, std::move(kept), TextureDetail::Full));
    uploaded.switchesAtBake = shadowSwitches(baked.scene);
    show(uploaded);
}

void Renderer::Impl::show(Uploaded& uploaded)
{
    {
        const std::lock_guard lock(sceneMutex);
        scene = std::move(uploaded.scene);
    }
    ++revision;
    switchesAtBake = std::move(uploaded.switchesAtBake);
    for (FrameSlot& each : slots) {
        each.set = gpu::DescriptorSet(device, setLayout.get(), bindings, uint32_t(scene->textures.size()));
        bindSceneImages(each.set, *scene, pageSampler.get());
    }
}

PreparedFrame Renderer::Impl::prepare(const Camera& camera, const RenderSettings& settings)
{
    if (scene->groups.membersChanged || !scene->changedObjects.empty()) {
        device.waitIdle(); // frames in flight read objects and materials as they were
        if (scene->groups.membersChanged) uploadGroupMembers(device, *scene);
        uploadChangedObjects(device, *scene);
    }
    PreparedFrame frame;
    frame.view = {camera, settings.size * settings.supersampling};
    frame.plan = planFrame(scene->outline, scene->bounds, frame.view, settings.mode, settings.shadows);
    for (std::string& warning : switchWarnings(scene->outline, switchesAtBake, settings.mode))
        frame.plan.warnings.push_back(std::move(warning));
    if (settings.reflectionProbes && settings.mode != RunMode::Realtime)
        for (std::string& warning : oldReflections(scene->outline, scene->groups.weights))
            frame.plan.warnings.push_back(std::move(warning));
    if (settings.view == DebugView::Overlap) addOverflowedLights(scene->outline, scene->bounds, frame.view, frame.plan);

    DrawLists lists(*scene);
    frame.shadows = shadowPasses(scene->outline.scene, frame.plan, settings.shadows, lists);
    frame.draws.clipFromWorld = frame.view.clipFromView() * frame.view.viewFromWorld();
    const std::vector<uint32_t> visible = objectsInView(scene->bounds, frame.draws.clipFromWorld);
    frame.deferred = settings.path == RenderPath::Deferred && settings.view == DebugView::Lit;
    std::vector<uint32_t> toGBuffer;
    std::vector<uint32_t> toForward;
    for (const uint32_t object : visible)
        (frame.deferred && !mustGoForward(*scene, frame.plan, object) ? toGBuffer : toForward).push_back(object);
    frame.draws.deferred = lists.solid(toGBuffer);
    frame.draws.forward = lists.solid(toForward);
    if (settings.view == DebugView::Lit) frame.draws.volumes = lists.volumes(visible);
    frame.draws.blended = lists.blended(visible, vec3(camera.worldFromCamera[3]));
    frame.instances = lists.instances();
    // Subtractive's main light leaves one value in the G-buffer (shaders/gbuffer.glsl), unless its mask has a colour.
    const bool colored = frame.plan.coloredMasks;
    frame.deferredMasks = {shaderMaskLayers(std::max(frame.plan.maskLayers, int(colored))), colored};
    if (settings.view == DebugView::Shadowmask)
        frame.masks = {shaderMaskLayers(scene->outline.maskLayers), colored};
    else
        frame.masks = {std::max(frame.deferredMasks.layers, int(frame.plan.subtractsByMask)), colored};
    frame.forwardObjects = int(toForward.size());
    return frame;
}

void Renderer::Impl::ensureTargets(const PreparedFrame& frame, const ShadowSettings& shadows)
{
    const ivec2 size = frame.view.size;
    if (!color.get() || color.info().width != uint32_t(size.x) || color.info().height != uint32_t(size.y)) {
        device.waitIdle(); // frames in flight use the images before
        color = {};
        depth = {};
        readback = {};
        color = gpu::Image(device, {.format = colorFormat,
                                    .width = uint32_t(size.x),
                                    .height = uint32_t(size.y),
                                    .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                             VK_IMAGE_USAGE_SAMPLED_BIT});
        depth = gpu::Image(device, {.format = kDepthFormat,
                                    .width = uint32_t(size.x),
                                    .height = uint32_t(size.y),
                                    .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                                    .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
    }
    // Without shadow maps one texel stands in for them, and is never read.
    const FramePlan& plan = frame.plan;
    const bool hasCascades = plan.directionalLayers > 0;
    const bool hasAtlas = int(plan.tiles.size()) > plan.directionalLayers;
    cascades.ensure(device, hasCascades ? shadows.directionalMapSize : 1, hasCascades ? plan.directionalLayers : 1);
    atlas.ensure(device, hasAtlas ? shadows.atlasSize : 1, 1);

    VkPipelineLayout layout = pipelines.layout.get();
    const auto [layers, colored] = frame.masks;
    std::unique_ptr<ForwardPipelines>& made = forwardPipelines[frame.masks.number()];
    if (!made && !colored && layers < 2 && preparedForward[layers].valid()) made = preparedForward[layers].get();
    if (!made) made = std::make_unique<ForwardPipelines>(device, layout, colorFormat, frame.masks);
    if (!frame.draws.blended.empty()) made->ensureBlend(device, layout, colorFormat, frame.masks, frame.draws.blended);
    if (!frame.draws.volumes.empty()) {
        if (!volumePasses) volumePasses = std::make_unique<VolumePasses>(device, layout, colorFormat);
        volumePasses->ensure(device, size);
    }
    if (!frame.deferred) return;
    if (std::unique_ptr<DeferredPipelines>& passes = deferredPipelines[frame.deferredMasks.number()]; !passes)
        passes = std::make_unique<DeferredPipelines>(device, layout, colorFormat, frame.deferredMasks);
    gBuffer.ensure(device, size, frame.deferredMasks.layers);
}

void Renderer::Impl::bindFrame(FrameSlot& to, const PreparedFrame& frame, const RenderSettings& settings,
                               const DisplayValues& display)
{
    shading::GpuFrame data = gpuFrame(*scene, frame.view, settings, frame.plan);
    data.displaySize = vec4(display.size, 0.0f, 0.0f);
    data.display =
        vec4(shading::exposureFactor(display.exposureEv), float(settings.supersampling),
             display.showsLight ? float(int(display.toneMapping)) : -1.0f, display.encodesSrgb ? 1.0f : 0.0f);
    gpu::DescriptorSet& set = to.set;
    set.buffer(shading::kBindFrame, to.frame.write(device, &data, sizeof(data)));
    set.buffer(shading::kBindLights,
               to.lights.write(device, gpuLights(scene->outline.scene, frame.plan, settings.shadows)));
    set.buffer(shading::kBindTiles, to.tiles.write(device, gpuTiles(frame.plan)));
    set.buffer(shading::kBindClusters, to.clusters.write(device, frame.plan.clusters.words));
    set.buffer(shading::kBindInstances, to.instances.write(device, frame.instances));
    set.image(shading::kBindDynamicLightmaps, scene->dynamicLightmaps.view(), pageSampler.get());
    set.image(shading::kBindCascades, cascades.image.view(), shadowSampler.get());
    set.image(shading::kBindAtlas, atlas.image.view(), shadowSampler.get());
    set.image(shading::kBindCascadeDepths, cascades.image.view(), texelSampler.get());
    set.image(shading::kBindAtlasDepths, atlas.image.view(), texelSampler.get());
    set.image(shading::kBindRadiance, color.view(), texelSampler.get());
    set.image(shading::kBindDepth, depth.view(), texelSampler.get());
    if (!frame.draws.volumes.empty())
        set.image(shading::kBindOpticalDepths, volumePasses->depths.view(), texelSampler.get());
    if (!frame.deferred) return;
    set.image(shading::kBindGBufferBaseColor, gBuffer.baseColor.view(), texelSampler.get());
    set.image(shading::kBindGBufferNormals, gBuffer.normals.view(), texelSampler.get());
    set.image(shading::kBindGBufferMaterial, gBuffer.material.view(), texelSampler.get());
    if (gBuffer.mask.get()) set.image(shading::kBindGBufferMask, gBuffer.mask.view(), texelSampler.get());
    if (gBuffer.furtherMask.get())
        set.image(shading::kBindGBufferFurtherMask, gBuffer.furtherMask.view(), texelSampler.get());
}

void Renderer::Impl::endPass(const PassContext& context, const char* name)
{
    counts.name = name;
    slot->reports.push_back(counts);
    counts = {};
    if (slot->timed) slot->timer.mark(context.commands, name);
}

void Renderer::Impl::recordCompose(const PassContext& context)
{
    GroupState& groups = scene->groups;
    if (!groups.pagesChanged) return;
    groups.pagesChanged = false;
    if (!composePipeline) composePipeline = std::make_unique<ComposePipeline>(device, scene->lightmaps.info().format);
    const gpu::Buffer& sources = slot->lightSources.write(device, groups.pages.sources(groups.weights));
    slot->composeSet = composePipeline->makeSet(device, groups.pages, sources, scene->lightmaps,
                                                scene->lightmapDirections, texelSampler.get());
    composePages(device, context.commands, *composePipeline, slot->composeSet.get(), groups.pages, scene->lightmaps,
                 scene->lightmapDirections);
    endPass(context, "compose");
}

void Renderer::Impl::recordShadows(const PassContext& context, const ShadowPasses& shadows)
{
    VkCommandBuffer commands = context.commands;
    gpu::transition(device, commands, cascades.image, gpu::state::kReused, gpu::state::kDepthAttachment);
    gpu::transition(device, commands, atlas.image, gpu::state::kReused, gpu::state::kDepthAttachment);
    for (std::size_t i = 0; i < shadows.cascades.size(); ++i) {
        if (shadows.cascades[i].empty()) continue;
        beginShadowLayer(context, cascades.layers[i].get(), ivec2(0), ivec2(int(cascades.image.info().width)));
        drawShadowTiles(context, shadows.cascades[i]);
        endRendering(context);
    }
    endPass(context, "directional shadows");
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
    endPass(context, "spot shadows");
    drawShadowTiles(context, shadows.points);
    if (hasAtlas) endRendering(context);
    endPass(context, "point shadows");
    gpu::transition(device, commands, cascades.image, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, atlas.image, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
}

void Renderer::Impl::recordDeferred(const PassContext& context, const CameraDraws& draws, MaskUse masks)
{
    VkCommandBuffer commands = context.commands;
    const DeferredPipelines& deferred = *deferredPipelines[masks.number()];
    for (const gpu::Image* image : gBuffer.images())
        gpu::transition(device, commands, *image, gpu::state::kReused, gpu::state::kColorAttachment);
    drawGBuffer(context, deferred, gBuffer, color, depth, draws);
    endPass(context, "g-buffer");

    for (const gpu::Image* image : gBuffer.images())
        gpu::transition(device, commands, *image, gpu::state::kColorAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, depth, gpu::state::kDepthAttachment, gpu::state::kFragmentRead);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kColorAttachment);
    drawOverPicture(context, deferred.light.get(), color);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kColorAttachment);
    gpu::transition(device, commands, depth, gpu::state::kFragmentRead, gpu::state::kDepthAttachment);
    endPass(context, "deferred light");
}

void Renderer::Impl::beginRecording(VkCommandBuffer commands, FrameSlot& to, bool timings)
{
    slot = &to;
    to.timed = timings && device.timestamps();
    to.reports.clear();
    counts = {};
    if (to.timed) to.timer.begin(commands);
    bindScene({device, *scene, pipelines, to.set.get(), commands, counts});
}

void Renderer::Impl::recordFrame(VkCommandBuffer commands, FrameSlot& to, const PreparedFrame& frame, bool timings)
{
    beginRecording(commands, to, timings);
    const PassContext context{device, *scene, pipelines, to.set.get(), commands, counts};
    recordCompose(context);
    recordShadows(context, frame.shadows);

    gpu::transition(device, commands, color, gpu::state::kReused, gpu::state::kColorAttachment);
    gpu::transition(device, commands, depth, gpu::state::kReused, gpu::state::kDepthAttachment);
    drawDepth(context, depth, frame.draws);
    gpu::transition(device, commands, depth, gpu::state::kDepthAttachment, gpu::state::kDepthAttachment);
    endPass(context, "depth");
    if (frame.deferred) recordDeferred(context, frame.draws, frame.deferredMasks);
    const ForwardPipelines& forward = *forwardPipelines[frame.masks.number()];
    beginForward(context, color, depth, frame.deferred ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR);
    drawLit(context, forward, frame.draws);
    endPass(context, "forward");
    drawSky(context);
    endPass(context, "sky");
    if (!frame.draws.volumes.empty()) {
        endRendering(context);
        drawVolumes(context, *volumePasses, color, depth, frame.draws);
        endPass(context, "volumes");
        beginForward(context, color, depth, VK_ATTACHMENT_LOAD_OP_LOAD);
    }
    drawBlended(context, forward, frame.draws);
    endPass(context, "blended");
    endRendering(context);
}

/// Shadows and surfaces into `color`, with a set of descriptors for them and for the display.
void Renderer::Impl::recordPicture(VkCommandBuffer commands, FrameSlot& to, PictureContent content,
                                   const DisplayValues& display)
{
    picture.reset();
    PreparedFrame frame = prepare(content.camera, content.settings);
    ensureTargets(frame, content.settings.shadows);
    bindFrame(to, frame, content.settings, display);
    recordFrame(commands, to, frame, content.settings.timings);
    gpu::transition(device, commands, color, gpu::state::kColorAttachment, gpu::state::kFragmentRead);
    picture.emplace(Picture{std::move(content), std::move(frame)});
}

Result<RenderedFrame> Renderer::Impl::record(VkCommandBuffer commands, const VulkanTarget& target, const Camera& camera,
                                             const RenderSettings& settings, float exposureEv, ToneMapping toneMapping)
{
    if (Status status = check(camera, settings); !status) return status.error();
    gpu::UniquePipeline& display = displayPipelines[target.format];
    if (!display) display = makeDisplayPipeline(device, pipelines.layout.get(), target.format);
    FrameSlot& to = slots[nextSlot];
    nextSlot = (nextSlot + 1) % slots.size();
    // The commands of two frames before have finished, so their times are there.
    std::vector<PassReport> earlier = passesOf(to);
    const bool timed = to.timed;
    const ivec2 shownSize = target.size == ivec2(0) ? settings.size : target.size;
    const DisplayValues values{exposureEv, toneMapping, showsLight(settings.view), encodesSrgb(target.format),
                               shownSize};
    PictureContent content{camera, settings, revision};
    const bool isKept = settings.keepsPicture && picture && picture->content == content;
    if (isKept) {
        bindFrame(to, picture->frame, settings, values);
        beginRecording(commands, to, settings.timings);
    } else {
        recordPicture(commands, to, std::move(content), values);
    }
    const PassContext context{device, *scene, pipelines, to.set.get(), commands, counts};
    drawDisplay(context, display.get(), target, shownSize);
    endPass(context, "display");
    RenderedFrame report = reportOf(picture->frame, settings);
    report.passes = std::move(earlier);
    report.timed = timed;
    report.isKept = isKept;
    return report;
}

} // namespace halflight
