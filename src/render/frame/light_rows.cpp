// What a frame does with each light of the scene, in words.
#include "halflight/scene/turning_lights.h"
#include "halflight/shading/law.h"
#include "render/frame/frame_internal.h"

#include <algorithm>

namespace halflight {
namespace {

std::string wordsOf(NoShadow why)
{
    switch (why) {
    case NoShadow::None:
        return {};
    case NoShadow::CastShadowsOff:
        return "its shadows are off";
    case NoShadow::StrengthZero:
        return "its shadow strength is 0";
    case NoShadow::PointShadowsOff:
        return "realtime shadows of point lights are off";
    case NoShadow::BeyondDistance:
        return "all it lights is beyond the shadow distance";
    case NoShadow::NoCaster:
        return "no caster of its map is within its reach and near what the camera sees";
    case NoShadow::DirectionalsTaken:
        return std::to_string(kMaxDirectionalShadows) + " brighter directional lights have the cascades";
    case NoShadow::AtlasFull:
        return "the shadow atlas is full";
    }
    return {};
}

/// Why a light of the scene is not in the frame.
std::string whyNotInFrame(const BakedScene& baked, const FrameView& view, RunMode mode, const Light& light)
{
    const bool usesBake = mode != RunMode::Realtime && baked.isBaked;
    if (usesBake && lostItsChannel(light)) return "fully baked, as no shadowmask channel was left for it";
    if (usesBake && light.baking.isBaked && light.baking.bakeType == LightMode::Baked) return "fully baked";
    if (!(luminance(light.color) * light.intensity > 0.0f)) return "its colour or intensity is 0";
    if (!meets(volumeOf(light), planesOf(view.clipFromView() * view.viewFromWorld()))) return "out of view";
    return "more than " + std::to_string(kMaxFrameLights) + " lights are in view";
}

/// Why no baked attenuation is mixed into the light's shadow; FrameLight::hasBaked is false.
std::string whyNoBakedShadow(const BakedScene& baked, RunMode mode, const Light& light)
{
    if (!baked.isBaked) return "the file is not baked";
    if (!shading::modeUsesBakedShadows(int(mode))) return "the mode reads no baked shadows";
    if (!light.baking.isBaked || light.baking.bakeType == LightMode::Realtime) return "a realtime light";
    if (!light.castShadows) return wordsOf(NoShadow::CastShadowsOff);
    if (!(light.shadowStrength > 0.0f)) return wordsOf(NoShadow::StrengthZero);
    if (turns(light)) return "it turns, so that its shadows are realtime";
    if (mode == RunMode::Subtractive) return "in subtractive mode the main light alone is mixed with probes";
    return light.baking.reason.empty() ? "it has no shadowmask channel" : light.baking.reason;
}

void countCasters(const BakedScene& baked, const FramePlan& plan, const FrameLight& frameLight, LightRow& row)
{
    std::vector<uint32_t> casters;
    for (int i = frameLight.firstTile; i < frameLight.firstTile + frameLight.tileCount; ++i) {
        const auto ofTile = plan.castersOf(i);
        casters.insert(casters.end(), ofTile.begin(), ofTile.end());
        row.tileTexels = plan.tiles[std::size_t(i)].size;
    }
    std::sort(casters.begin(), casters.end());
    casters.erase(std::unique(casters.begin(), casters.end()), casters.end());
    for (const uint32_t object : casters)
        ++(baked.scene.objects[object].isStatic ? row.staticCasters : row.dynamicCasters);
}

} // namespace

std::vector<LightRow> lightRows(const BakedScene& baked, const FrameView& view, const FramePlan& plan)
{
    std::vector<LightRow> rows(baked.scene.lights.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].light = int(i);
    for (std::size_t i = 0; i < plan.lights.size(); ++i) {
        if (!plan.lights[i].overflowed) rows[std::size_t(plan.lights[i].light)].frameLight = int(i);
    }
    for (LightRow& row : rows) {
        const Light& light = baked.scene.lights[std::size_t(row.light)];
        if (row.frameLight < 0) {
            row.notInFrame = whyNotInFrame(baked, view, plan.mode, light);
            row.noBakedShadow = row.noRealtimeShadow = "not in the frame: " + row.notInFrame;
            continue;
        }
        const FrameLight& frameLight = plan.lights[std::size_t(row.frameLight)];
        row.bakedChannel = frameLight.channel;
        if (!frameLight.hasBaked) row.noBakedShadow = whyNoBakedShadow(baked, plan.mode, light);
        row.realtimeShadow = frameLight.hasRealtimeShadow;
        row.noRealtimeShadow = wordsOf(frameLight.noShadow);
        (light.type == LightType::Directional ? row.cascades : row.tiles) = frameLight.tileCount;
        if (frameLight.hasRealtimeShadow) countCasters(baked, plan, frameLight, row);
    }
    return rows;
}

} // namespace halflight
