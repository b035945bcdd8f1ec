// Which lighting modes a baked file can be drawn in, and the limits of the shadow settings.
#include "halflight/base/mathematics.h"
#include "halflight/render/frame.h"
#include "halflight/shading/law.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace halflight {

static_assert(int(RunMode::Realtime) == shading::kModeRealtime &&
              int(RunMode::BakedIndirect) == shading::kModeBakedIndirect &&
              int(RunMode::Shadowmask) == shading::kModeShadowmask &&
              int(RunMode::DistanceShadowmask) == shading::kModeDistanceShadowmask &&
              int(RunMode::Subtractive) == shading::kModeSubtractive);

RunMode defaultRunMode(const BakedScene& baked)
{
    if (!baked.isBaked) return RunMode::Realtime;
    switch (baked.mode) {
    case MixedLightingMode::BakedIndirect:
        return RunMode::BakedIndirect;
    case MixedLightingMode::Shadowmask:
        return RunMode::Shadowmask;
    case MixedLightingMode::Subtractive:
        return RunMode::Subtractive;
    }
    return RunMode::Realtime;
}

Status checkRunMode(const BakedScene& baked, RunMode mode)
{
    if (mode == RunMode::Realtime) return {};
    if (!baked.isBaked) {
        return Error{ErrorCode::InvalidArgument, "the file is not baked, so it can only be drawn in realtime mode"};
    }
    const auto refuse = [](const char* bake, const char* modes) -> Status {
        return Error{ErrorCode::InvalidArgument,
                     std::string("the file was baked for ") + bake + ", so it can only be drawn in mode " + modes};
    };
    switch (baked.mode) {
    case MixedLightingMode::BakedIndirect:
        if (mode != RunMode::BakedIndirect) return refuse("baked indirect lighting", "baked-indirect or realtime");
        return {};
    case MixedLightingMode::Subtractive:
        if (mode != RunMode::Subtractive) return refuse("subtractive lighting", "subtractive or realtime");
        return {};
    case MixedLightingMode::Shadowmask:
        if (mode == RunMode::Subtractive) {
            return refuse("shadowmasks", "shadowmask, distance-shadowmask, baked-indirect or realtime");
        }
        break;
    }
    // Without the pages the channels would read as lit everywhere; baked indirect needs none.
    const bool anyChannel = std::any_of(baked.scene.lights.begin(), baked.scene.lights.end(), [](const Light& light) {
        return light.baking.isBaked && light.baking.occlusionMaskChannel >= 0;
    });
    if (mode != RunMode::BakedIndirect && anyChannel && baked.shadowmasks.size() < baked.lightmaps.size()) {
        return Error{ErrorCode::InvalidArgument,
                     "the file has lights with shadowmask channels but lacks shadowmask pages"};
    }
    return {};
}

Status checkShadowSettings(const ShadowSettings& s)
{
    const auto outside = [](const char* what, const char* limits) -> Status {
        return Error{ErrorCode::InvalidArgument, std::string(what) + " must be " + limits};
    };
    // Written so that NaN fails too.
    if (!(s.distanceMeters > 0.0f && s.distanceMeters <= 1.0e6f))
        return outside("the shadow distance", "above 0 and at most 1000000 m");
    if (!(s.fadeRangeMeters >= 0.01f && s.fadeRangeMeters <= 1.0e6f))
        return outside("the shadow fade range", "0.01…1000000 m");
    if (s.cascades < 1 || s.cascades > 4) return outside("the number of cascades", "1…4");
    if (!(s.cascadeSplitLambda >= 0.0f && s.cascadeSplitLambda <= 1.0f))
        return outside("the cascade split lambda", "0…1");
    if (s.cascadeSplits[0] != 0.0f) {
        float before = 0.0f;
        for (int i = 0; i + 1 < s.cascades; ++i) {
            const float split = s.cascadeSplits[std::size_t(i)];
            if (!(split > before && split < 1.0f))
                return outside("cascade splits", "ascending shares of the shadow distance above 0 and below 1");
            before = split;
        }
    }
    if (!(s.cascadeBlendFraction >= 0.0f && s.cascadeBlendFraction <= 0.5f)) {
        return outside("the cascade blend fraction", "0…0.5");
    }
    if (s.directionalMapSize < 64 || s.directionalMapSize > 16384) {
        return outside("the directional shadow map size", "64…16384 texels");
    }
    if (s.atlasSize < 256 || s.atlasSize > 16384) return outside("the shadow atlas size", "256…16384 texels");
    if (!std::isfinite(s.depthBias) || !std::isfinite(s.slopeBias)) return outside("shadow biases", "finite");
    if (!(s.normalBiasTexels >= 0.0f && s.normalBiasTexels <= 8.0f)) return outside("the normal bias", "0…8 texels");
    return {};
}

float halfSourceWidth(const Light& light)
{
    if (light.type == LightType::Directional) return math::tan(light.angularRadiusRadians);
    return isAreaLight(light.type) ? std::max(glm::length(light.halfWidth()), glm::length(light.halfHeight()))
                                   : light.radiusMeters;
}

ShadowSettings shadowSettingsOf(const Light& light, const ShadowSettings& settings)
{
    ShadowSettings result = settings;
    result.depthBias = light.shadowBias.depthTexels.value_or(settings.depthBias);
    result.slopeBias = light.shadowBias.slope.value_or(settings.slopeBias);
    result.normalBiasTexels = light.shadowBias.normalTexels.value_or(settings.normalBiasTexels);
    result.penumbrae = settings.penumbrae && settings.filter != ShadowFilter::Hard && halfSourceWidth(light) > 0.0f;
    return result;
}

} // namespace halflight
