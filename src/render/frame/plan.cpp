// The frame's decisions in their order: lights, cascades, tiles and their casters, clusters.
#include "halflight/base/mathematics.h"
#include "halflight/scene/turning_lights.h"
#include "halflight/shading/law.h"
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdio>

namespace halflight {
namespace {

/// Objects of each tile of one light.
using CasterLists = std::vector<std::vector<uint32_t>>;

bool anyCaster(const CasterLists& lists)
{
    return std::any_of(lists.begin(), lists.end(), [](const auto& list) { return !list.empty(); });
}

/// What shadow planning reads, in one place.
struct ShadowContext {
    const Scene& scene;
    std::span<const Bounds> bounds;
    const FrameView& view;
    const ShadowSettings& settings;
    Bounds sceneBounds;
    bool hasMask = false; ///< the file holds shadowmask pages
};

/// Why a shadow map of the light could change no pixel; None where it could.
NoShadow needsNoShadowMap(const ShadowContext& context, const Light& light)
{
    if (!light.castShadows) return NoShadow::CastShadowsOff;
    if (!(light.shadowStrength > 0.0f)) return NoShadow::StrengthZero;
    if (light.type == LightType::Directional) return NoShadow::None;
    if (light.type == LightType::Point && !context.settings.pointShadows) return NoShadow::PointShadowsOff;
    // Its light begins where shadows have already faded.
    const float distance = glm::distance(light.position(), vec3(context.view.camera.worldFromCamera[3]));
    const bool near = light.rangeMeters <= 0.0f || distance - light.rangeMeters < context.settings.distanceMeters;
    return near ? NoShadow::None : NoShadow::BeyondDistance;
}

void appendTiles(FramePlan& plan, FrameLight& light, std::span<const ShadowTile> tiles, const CasterLists& casters)
{
    light.hasRealtimeShadow = true;
    light.noShadow = NoShadow::None;
    light.firstTile = int(plan.tiles.size());
    light.tileCount = int(tiles.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        plan.tiles.push_back(tiles[i]);
        plan.tileCasters.insert(plan.tileCasters.end(), casters[i].begin(), casters[i].end());
        plan.tileCasterBegin.push_back(uint32_t(plan.tileCasters.size()));
    }
}

/// S2, S28: cascades of every directional light that has a caster.
void planDirectionalShadows(const ShadowContext& context, FramePlan& plan)
{
    const CascadeSlices slices = sliceView(context.view, context.settings);
    plan.cascadeFar = slices.farMeters;
    int shadowedLights = 0;
    for (FrameLight& frameLight : plan.lights) {
        const Light& light = context.scene.lights[std::size_t(frameLight.light)];
        if (light.type != LightType::Directional) continue;
        if (const NoShadow why = needsNoShadowMap(context, light); why != NoShadow::None) {
            frameLight.noShadow = why;
            continue;
        }
        const ShadowSettings biased = shadowSettingsOf(light, context.settings);
        std::vector<ShadowTile> tiles;
        CasterLists casters;
        for (int i = 0; i < slices.count; ++i) {
            tiles.push_back(fitCascade(context.view, biased, slices, i, light.direction(), context.sceneBounds));
            casters.push_back(castersOfTile(context.scene, context.bounds, volumeOf(light), frameLight.staticCasters,
                                            tiles.back().clipFromWorld));
        }
        if (!anyCaster(casters)) continue;
        if (shadowedLights == kMaxDirectionalShadows) {
            frameLight.noShadow = NoShadow::DirectionalsTaken;
            plan.warnings.push_back(nameOf(context.scene, frameLight.light) + " gets no realtime shadow: only " +
                                    std::to_string(kMaxDirectionalShadows) + " directional lights can have one");
            continue;
        }
        for (ShadowTile& tile : tiles) tile.layer += shadowedLights * slices.count;
        ++shadowedLights;
        appendTiles(plan, frameLight, tiles, casters);
    }
    plan.directionalLayers = shadowedLights * slices.count;
}

/// Texels a light's tile may use well: as many as its reach spans in the picture.
int wantedTileSize(const ShadowContext& context, const Light& light)
{
    const Camera& camera = context.view.camera;
    constexpr float kReachOfUnlimitedLights = 20.0f; // metres: there a light has 1/400 of its illuminance at one metre
    const float reach = light.rangeMeters > 0.0f ? light.rangeMeters : kReachOfUnlimitedLights;
    const float distance = std::max(glm::distance(light.position(), vec3(camera.worldFromCamera[3])), reach);
    const float heightThere = camera.orthographic ? camera.orthographicHeightMeters
                                                  : 2.0f * distance * math::tan(0.5f * camera.verticalFovRadians);
    const float texels = float(context.view.size.y) * 2.0f * reach / heightThere;
    // One light may take a quarter of the atlas by a single tile, or six sixteenths of a quarter by six.
    const int side = int(std::bit_floor(unsigned(context.settings.atlasSize)));
    const bool single = localTileCount(light) == 1;
    const int most = std::max(single ? side / 2 : side / 8, kMinTileSize);
    const float wish = std::clamp(single ? texels : 0.5f * texels, float(kMinTileSize), float(most));
    return std::min(int(std::bit_ceil(unsigned(std::ceil(wish)))), most);
}

/// S3, S4: atlas tiles of spot and point lights that have a caster.
void planLocalShadows(const ShadowContext& context, FramePlan& plan)
{
    const auto fit = [&](const FrameLight& frameLight, int tileSize, std::vector<ShadowTile>& tiles,
                         CasterLists& casters) {
        const Light& light = context.scene.lights[std::size_t(frameLight.light)];
        const ShadowSettings biased = shadowSettingsOf(light, context.settings);
        tiles.clear();
        casters.clear();
        for (int face = 0; face < localTileCount(light); ++face) {
            tiles.push_back(fitLocalTile(light, face, tileSize, biased, context.sceneBounds));
            casters.push_back(castersOfTile(context.scene, context.bounds, volumeOf(light), frameLight.staticCasters,
                                            tiles.back().clipFromWorld));
        }
        return anyCaster(casters);
    };

    // Casters are looked for in the smallest tile first, whose border is the widest angle; larger tiles can only lose
    // some.
    std::vector<ShadowTile> tiles;
    CasterLists casters;
    std::vector<std::size_t> candidates;
    std::vector<AtlasRequest> requests;
    for (std::size_t i = 0; i < plan.lights.size(); ++i) {
        const Light& light = context.scene.lights[std::size_t(plan.lights[i].light)];
        if (light.type == LightType::Directional) continue;
        if (const NoShadow why = needsNoShadowMap(context, light); why != NoShadow::None) {
            plan.lights[i].noShadow = why;
            continue;
        }
        if (!fit(plan.lights[i], kMinTileSize, tiles, casters)) continue;
        candidates.push_back(i);
        requests.push_back({localTileCount(light), wantedTileSize(context, light)});
    }

    const AtlasPlacement placement = placeTiles(requests, context.settings.atlasSize);
    for (std::size_t n = 0; n < candidates.size(); ++n) {
        FrameLight& frameLight = plan.lights[candidates[n]];
        if (placement.sizes[n] == 0) {
            frameLight.noShadow = NoShadow::AtlasFull;
            plan.warnings.push_back(nameOf(context.scene, frameLight.light) +
                                    " gets no realtime shadow: the shadow atlas is full");
            continue;
        }
        if (!fit(frameLight, placement.sizes[n], tiles, casters)) continue;
        for (std::size_t face = 0; face < tiles.size(); ++face) tiles[face].atlasOffset = placement.offsets[n][face];
        appendTiles(plan, frameLight, tiles, casters);
    }
}

/// S27: whom the main light's realtime shadow may reach.
void findMainShadowReceivers(const ShadowContext& context, FramePlan& plan)
{
    if (plan.mainLight < 0) return;
    const FrameLight& main = plan.lights[std::size_t(plan.mainLight)];
    if (!main.hasRealtimeShadow) return;
    std::vector<uint32_t> casters;
    float texelMeters = 0.0f;
    for (int i = main.firstTile; i < main.firstTile + main.tileCount; ++i) {
        casters.insert(casters.end(), plan.castersOf(i).begin(), plan.castersOf(i).end());
        texelMeters = std::max(texelMeters, plan.tiles[std::size_t(i)].texelMeters);
    }
    std::sort(casters.begin(), casters.end());
    casters.erase(std::unique(casters.begin(), casters.end()), casters.end());
    const Light& light = context.scene.lights[std::size_t(main.light)];
    const int border =
        borderTexels(shadowSettingsOf(light, context.settings), plan.tiles[std::size_t(main.firstTile)].size);
    plan.mainShadowReceivers =
        directionalShadowReceivers(context.bounds, casters, light.direction(), float(border) * texelMeters,
                                   vec3(context.view.camera.worldFromCamera[3]), context.settings.distanceMeters);
    plan.subtractsByMask = main.hasBaked && context.hasMask;
}

/// S34. Names lights without baked shadows because they turn, in views that reach beyond the realtime ones.
void nameMissingShadows(const ShadowContext& context, FramePlan& plan)
{
    if (plan.mode == RunMode::Realtime) return;
    for (const FrameLight& frameLight : plan.lights) {
        const Light& light = context.scene.lights[std::size_t(frameLight.light)];
        const float distance = context.settings.distanceMeters;
        if (!turns(light) || !light.castShadows || !(light.shadowStrength > 0.0f) ||
            !reachesBeyond(context.view, context.bounds, distance))
            continue;
        std::array<char, 64> text{};
        std::snprintf(text.data(), text.size(), "%.4g m", double(distance));
        plan.warnings.push_back(nameOf(context.scene, frameLight.light) +
                                " turns, so that it has no baked shadows: beyond the shadow distance of " +
                                text.data() + " it throws none; a longer shadow distance reaches farther");
    }
}

} // namespace

FramePlan planFrame(const BakedScene& baked, std::span<const Bounds> bounds, const FrameView& view, RunMode mode,
                    const ShadowSettings& shadows)
{
    assert(bounds.size() == baked.scene.objects.size());
    assert(checkShadowSettings(shadows));
    ShadowContext context{baked.scene, bounds, view, shadows, {}, !baked.shadowmasks.empty()};
    for (const Bounds& box : bounds) context.sceneBounds.extend(box);

    FramePlan plan;
    plan.mode = mode;
    plan.fadeConstants = shading::fadeConstants(shadows.distanceMeters, shadows.fadeRangeMeters);
    plan.tileCasterBegin.push_back(0);
    selectLights(baked, view, plan);
    planDirectionalShadows(context, plan);
    planLocalShadows(context, plan);
    nameMissingShadows(context, plan);
    findMainShadowReceivers(context, plan);
    plan.clusters = clusterLights(baked.scene, view, context.sceneBounds, plan.lights);
    return plan;
}

} // namespace halflight
