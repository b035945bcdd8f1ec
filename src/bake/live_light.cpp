#include "bake/live_light.h"

#include "bake/stages.h"

#include "halflight/base/rgb9e5.h"

#include <algorithm>
#include <array>
#include <utility>

namespace halflight {
namespace {

/// Texels along a side of the squares that first light has a sample in; more where that makes more than kMostSquares.
constexpr int kSide = 2;
constexpr std::size_t kMostSquares = 16'384;
/// Paths of a sample: with its neighbours' about 64, whose noise does not hide the light.
constexpr int kPaths = 16;
constexpr int kPathsOfProbe = 32;
/// How much brighter than first light the lightmap may get before it is clamped.
constexpr float kHeadroom = 8.0f;
/// Texels between two looks at the view: a fraction of a second on few cores, enough work for many.
constexpr std::size_t kTexelsAtOnce = 16'384;

/// A grid of light probes, roughly.
bool addProbes(BakedScene& light, float spacingMeters, const Gather& gather, const Progress& progress)
{
    std::vector<std::string> unread; // the bake says it
    light.probes = probeGrid(light.scene, spacingMeters, unread);
    std::vector<vec3> positions;
    for (const Probe& probe : light.probes.probes) positions.push_back(probe.position);
    std::vector<ProbeEstimate> estimates(positions.size());
    if (!gather.integrator.probes(positions, allIndices(positions.size()), kPathsOfProbe, estimates, progress))
        return false;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        Probe& probe = light.probes.probes[i];
        probe.radiance = estimates[i].radiance;
        probe.valid = estimates[i].valid;
    }
    fillInvalidProbes(light.probes);
    return true;
}

/// No mask is there yet: lights with a channel are realtime lights of baked indirect.
void withoutMask(BakedScene& light)
{
    light.mode = MixedLightingMode::BakedIndirect;
    for (Light& each : light.scene.lights) {
        BakingOutput& baking = each.baking;
        if (!baking.isBaked || baking.bakeType != LightMode::Mixed) continue;
        // Subtractive bakes have the direct light of all but the main light in the lightmap.
        if (baking.mixedMode == MixedLightingMode::Subtractive && baking.occlusionMaskChannel < 0)
            baking.bakeType = LightMode::Baked;
        baking.mixedMode = MixedLightingMode::BakedIndirect;
        baking.occlusionMaskChannel = -1;
    }
}

} // namespace

bool LiveLight::begin(const BakedScene& scene, const BakeSettings& settings, const Gather& gather,
                      const Progress& progress)
{
    progress("first light", 0.0);
    const TexelMap& map = gather.map;
    const Progress quiet{{}, progress.cancel};
    int side = kSide;
    while (map.texels.size() / std::size_t(side * side) > kMostSquares) side *= 2;
    const std::vector<uint32_t> texels = sampleTexels(map, side);
    std::vector<vec3> values(texels.size());
    if (!gather.integrator.roughIrradiance(map, texels, kPaths, values, quiet)) return false;
    progress("first light", 0.5);
    LivePages pages(map);
    pages.spread(texels, values, side);
    BakedScene light = scene;
    if (!addProbes(light, settings.probeSpacingMeters, gather, quiet)) return false;
    withoutMask(light);
    while (kHeadroom * pages.brightest() > kMaxRgb9e5 * light.lightmapUnitLux) light.lightmapUnitLux *= 2.0f;
    light.lightmaps = pages.takeAll(light.lightmapUnitLux);
    progress("first light", 1.0);

    const std::lock_guard lock(mutex_);
    map_ = &map;
    pages_.emplace(std::move(pages));
    unitLux_ = light.lightmapUnitLux;
    light_ = std::move(light);
    return true;
}

bool LiveLight::irradiance(const Gather& gather, std::span<IrradianceEstimate> out, const Progress& progress)
{
    const TexelMap& map = gather.map;
    TexelOrder order = gather.cache != nullptr
                           ? TexelOrder::ofRuns(gather.geometry, map, texelsOfPart(map.texels.size()))
                           : TexelOrder::ofCharts(gather.geometry, map);
    std::vector<uint32_t> texels;
    std::vector<IrradianceEstimate> estimates;
    std::size_t done = 0;
    while (done < map.texels.size()) {
        std::vector<std::size_t> pieces = order.next(view(), kTexelsAtOnce);
        std::sort(pieces.begin(), pieces.end()); // requests are ascending
        texels.clear();
        for (const std::size_t piece : pieces)
            texels.insert(texels.end(), order.texelsOf(piece).begin(), order.texelsOf(piece).end());
        std::sort(texels.begin(), texels.end());
        const double share = 1.0 / double(map.texels.size());
        const Progress part = partOf(progress, double(done) * share, double(done + texels.size()) * share);
        if (gather.cache != nullptr) {
            if (!gather.irradianceOfParts(pieces, out, part)) return false;
        } else {
            estimates.assign(texels.size(), {});
            if (!gather.integrator.irradiance(map, {texels}, estimates, part)) return false;
            for (std::size_t i = 0; i < texels.size(); ++i) out[texels[i]] = estimates[i];
        }
        done += texels.size();
        show(map, texels, out);
    }
    return true;
}

void LiveLight::show(const TexelMap& map, std::span<const uint32_t> texels, std::span<const IrradianceEstimate> all)
{
    const std::lock_guard lock(mutex_);
    if (!pages_ || map_ != &map) return;
    for (const uint32_t texel : texels)
        if (all[texel].valid) pages_->set(texel, all[texel].irradiance);
}

void LiveLight::finish(const std::vector<ImageRgb32f>& pages)
{
    const std::lock_guard lock(mutex_);
    if (!pages_) return;
    for (std::size_t i = 0; i < map_->texels.size(); ++i) {
        const Texel& texel = map_->texels[i];
        pages_->set(uint32_t(i), pages[texel.page](texel.x, texel.y));
    }
}

void LiveLight::setView(const BakeView& view)
{
    const std::lock_guard lock(mutex_);
    view_ = view;
}

std::optional<BakeView> LiveLight::view() const
{
    const std::lock_guard lock(mutex_);
    return view_;
}

std::optional<BakedScene> LiveLight::takeLight()
{
    const std::lock_guard lock(mutex_);
    taken_ = taken_ || light_.has_value();
    return std::exchange(light_, std::nullopt);
}

std::vector<LightTile> LiveLight::takeTiles()
{
    const std::lock_guard lock(mutex_);
    return taken_ && pages_ ? pages_->takeChanged(unitLux_) : std::vector<LightTile>();
}

} // namespace halflight
