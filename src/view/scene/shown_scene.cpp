#include "view/scene/shown_scene.h"

#include <utility>

namespace halflight::view {
namespace {

std::vector<RunMode> modesOf(const BakedScene& baked)
{
    std::vector<RunMode> modes;
    for (const RunMode mode : {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask,
                               RunMode::DistanceShadowmask, RunMode::Subtractive})
        if (checkRunMode(baked, mode)) modes.push_back(mode);
    return modes;
}

SceneReport reportOf(const BakedScene& baked)
{
    SceneReport s;
    s.isBaked = baked.isBaked;
    for (const Light& light : baked.scene.lights) s.maskChannels.push_back(light.baking.occlusionMaskChannel);
    s.modes = modesOf(baked);
    s.objects = baked.scene.objects.size();
    for (const Object& object : baked.scene.objects)
        if (object.mesh >= 0) s.triangles += baked.scene.meshes[std::size_t(object.mesh)].triangleCount();
    s.lightmapPages = baked.lightmaps.size();
    std::size_t bytes = 0;
    for (const auto& page : baked.lightmaps) bytes += page.texelCount() * sizeof(uint32_t);
    for (const auto* pages : {&baked.lightmapDirections, &baked.shadowmasks})
        for (const ImageRgba8& page : *pages) bytes += page.texelCount() * sizeof(u8vec4);
    s.lightmapMegabytes = double(bytes) / 1.0e6;
    if (!baked.lightmaps.empty()) s.pageSize = baked.lightmaps[0].size();
    s.probes = baked.probes.probes.size();
    s.reflectionProbes = baked.reflections.probes.size();
    return s;
}

} // namespace

void ShownScene::take(BakedScene baked, TextureDetail textures, Clock::time_point time)
{
    report_ = reportOf(baked);
    if (!checkRunMode(baked, state_.settings.mode)) state_.settings.mode = defaultRunMode(baked);
    if (!checkRunMode(baked, state_.otherMode)) state_.otherMode = RunMode::Realtime;
    baked_ = std::move(baked);
    textures_ = textures;
    time_ = time;
}

void ShownScene::showLater(Renderer& renderer, BakedScene baked, Clock::time_point time)
{
    next_ = std::move(baked);
    nextTime_ = time;
    upload(renderer);
}

void ShownScene::upload(Renderer& renderer)
{
    uploading_ = std::async(std::launch::async,
                            [this, &renderer] { return renderer.upload(*next_, TextureDetail::Full, &ends_); });
}

Result<bool> ShownScene::poll(Renderer& renderer)
{
    if (!next_ || uploading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    const auto uploaded = uploading_.get();
    if (!uploaded) return uploaded.error();
    if (Status status = renderer.show(*uploaded); !status) return status.error();
    take(*std::exchange(next_, std::nullopt), TextureDetail::Full, nextTime_);
    return true;
}

void ShownScene::dropUpload()
{
    uploading_ = {};
    next_.reset();
}

Status ShownScene::moveTo(Renderer& renderer)
{
    if (Status status = renderer.load(*baked_); !status) return status;
    textures_ = TextureDetail::Full;
    if (next_) upload(renderer);
    return {};
}

} // namespace halflight::view
