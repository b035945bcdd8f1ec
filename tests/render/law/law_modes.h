#pragma once
// What tests of the law over all modes have in common: values of the scene, and names of parameters.
#include "render/law_scene.h"

#include <string>
#include <tuple>

namespace halflight::test::law {

inline const vec3 kShadowColor(0.25f, 0.5f, 0.25f);
inline constexpr float kProbeOcclusion = 0.4f;
inline const vec3 kProbeRadiance(0.25f, 0.5f, 0.75f);

inline bool usesMask(RunMode mode)
{
    return mode == RunMode::Shadowmask || mode == RunMode::DistanceShadowmask;
}

/// Baked attenuation of the column.
inline float maskOf(int column)
{
    return inStaticShadow(column) ? kBakedShadow : 1.0f;
}

/// The floor becomes a dynamic receiver, lit and shadowed by one probe, the same from everywhere.
inline void makeFloorDynamic(LawScene& law)
{
    law.baked.scene.objects[std::size_t(law.floor)].isStatic = false;
    Probe probe;
    probe.radiance[0] = kProbeRadiance / 0.282094792f;
    probe.occlusion.layers[0] = vec4(kProbeOcclusion, 1, 1, 1);
    law.baked.probes.probes = {probe};
}

using ModeStrengthPath = std::tuple<RunMode, float, RenderPath>;
using ModePath = std::tuple<RunMode, RenderPath>;

inline const char* modeName(RunMode mode)
{
    const char* names[] = {"Realtime", "BakedIndirect", "Shadowmask", "DistanceShadowmask", "Subtractive"};
    return names[int(mode)];
}
inline std::string modeStrengthPathName(const testing::TestParamInfo<ModeStrengthPath>& info)
{
    return std::string(modeName(std::get<0>(info.param))) + (std::get<1>(info.param) < 1.0f ? "Strength" : "Full") +
           pathName(std::get<2>(info.param));
}
inline std::string modePathName(const testing::TestParamInfo<ModePath>& info)
{
    return std::string(modeName(std::get<0>(info.param))) + pathName(std::get<1>(info.param));
}
inline const auto kAllModes = testing::Values(RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask,
                                              RunMode::DistanceShadowmask, RunMode::Subtractive);
inline const auto kMaskModes = testing::Values(RunMode::Shadowmask, RunMode::DistanceShadowmask);
inline const auto kBakedModes =
    testing::Values(RunMode::BakedIndirect, RunMode::Shadowmask, RunMode::DistanceShadowmask, RunMode::Subtractive);
} // namespace halflight::test::law
