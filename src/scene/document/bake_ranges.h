#pragma once
// The range of every number of the bake's extensions. docs/schemas has the same limits (a test compares them), and
// web/scripts/generate.mjs makes the web plug-in's table from these lines: one path, its limits as plain numbers and,
// where the least value itself is out of the range, `true`.

#include <string>
#include <string_view>

namespace halflight {

struct Range {
    std::string_view path; // as Rule::path; of arrays of numbers, each number
    double least;
    double most;
    bool above = false; // numbers are above `least`
};

// Lengths are metres. 1e7 is how far a scene may reach from its own origin, 33554432 how far that may be from the
// world's, and their sum with room for rounding 5e7. Light has two limits: 1e12 for a source, as scene/format/limits.h
// has it, and 1e18 for what arrives, which is such a source at one millimetre; squares of it stay within floats. A
// texel of RGB9E5 is at most 65408, so that its unit ends at 1e13. 3.4e38 is where floats end.
inline constexpr Range kBakeRanges[] = {
    {"extensions/HALFLIGHT_mixed_lighting/origin", -33554432, 33554432},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/zenith", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/horizon", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/ground", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapUnitLux", 0, 1e13, true},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapEncoding/scale", 0, 65408, true},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapEncoding/exponent", 0, 16, true},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskLayers", 1, 4},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskChannels/*/rangeTexels", 0, 8192, true},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskChannels/*/penumbraTexels", 0, 8192},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/weight", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/peak", 0, 1e18},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/shadowColor", 0, 1e18},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/lightmapUnitLux", 0, 1e13, true},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/lightmapEncoding/scale", 0, 65408, true},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/lightmapEncoding/exponent", 0, 16, true},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/reflections/unitNits", 0, 1e13, true},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/reflections/size", 32, 1024},
    {"extensions/HALFLIGHT_mixed_lighting/sky/zenith", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/sky/horizon", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/sky/ground", 0, 1e12},
    {"extensions/HALFLIGHT_mixed_lighting/sky/picture/unitNits", 0, 1e12, true},
    {"extensions/HALFLIGHT_mixed_lighting/sky/picture/rotation", -63, 63},
    {"extensions/HALFLIGHT_mixed_lighting/subtractiveShadowColor", 0, 1e18},
    {"extensions/HALFLIGHT_mixed_lighting/authoredProbes/*", -5e7, 5e7},
    {"extensions/HALFLIGHT_mixed_lighting/authoredReflectionProbes/*", -5e7, 5e7},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/unitNits", 0, 1e13, true},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/size", 32, 1024},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/probes/*/position", -1e7, 1e7},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/probes/*/box", -1e7, 1e7},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/probes/*/fade", 1e-6, 1e7},
    {"extensions/HALFLIGHT_mixed_lighting/probes/count", 1, 268435456},
    {"extensions/HALFLIGHT_mixed_lighting/probes/grid/origin", -1e7, 1e7},
    {"extensions/HALFLIGHT_mixed_lighting/probes/grid/spacing", 1e-10, 1e7},
    {"extensions/HALFLIGHT_mixed_lighting/probes/grid/size", 1, 1048576},
    {"materials/*/extensions/HALFLIGHT_material/baking/group", 0, 15},
    {"materials/*/extensions/HALFLIGHT_material/baking/white", 0, 1e12},
    {"nodes/*/extensions/HALFLIGHT_node/lightmapScale", 0, 1000},
    {"nodes/*/extensions/HALFLIGHT_node/probeResolution", 1, 64},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/min", -2e7, 2e7},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/max", -2e7, 2e7},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/centroid", -2e7, 2e7},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/spread", 0, 2e7},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/area", 0, 1e20},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/switches", 0, 1.001},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/color", 0, 1e6},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/emission", 0, 1e6},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/opacity", 0, 1e6},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/metallic", 0, 1e6},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/scale", -1e6, 1e6},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/offset", -1e6, 1e6},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/texCoord", 1, 16},
    {"nodes/*/extensions/HALFLIGHT_light/shadowStrength", 0, 1},
    {"nodes/*/extensions/HALFLIGHT_light/indirectMultiplier", 0, 1e6},
    {"nodes/*/extensions/HALFLIGHT_light/radius", 0, 1e7},
    {"nodes/*/extensions/HALFLIGHT_light/range", 0, 3.4e38, true},
    {"nodes/*/extensions/HALFLIGHT_light/angularRadius", 0, 3.1415928},
    {"nodes/*/extensions/HALFLIGHT_light/directions/*", -1.001, 1.001},
    {"nodes/*/extensions/HALFLIGHT_light/shadowBias/depth", 0, 100},
    {"nodes/*/extensions/HALFLIGHT_light/shadowBias/slope", 0, 100},
    {"nodes/*/extensions/HALFLIGHT_light/shadowBias/normal", 0, 8},
    {"nodes/*/extensions/HALFLIGHT_light/baking/occlusionMaskChannel", -1, 15},
    {"nodes/*/extensions/HALFLIGHT_light/baking/group", 0, 15},
    {"nodes/*/extensions/HALFLIGHT_light/baking/white", 0, 1e12},
    {"nodes/*/extensions/HALFLIGHT_light/baking/turns/group", 0, 15},
    {"nodes/*/extensions/HALFLIGHT_light/baking/turns/directions/*", -1.001, 1.001},
    {"nodes/*/extensions/HALFLIGHT_light/baking/worldFromLight", -1e9, 1e9},
    {"nodes/*/extensions/HALFLIGHT_light/baking/reach", 0, 3.4e38, true},
    {"nodes/*/extensions/HALFLIGHT_light/baking/outerConeAngle", 0, 3.1415928},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/colorIntensity", 0, 1e12},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/indirectMultiplier", 0, 1e6},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/range", 0, 3.4e38},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/innerConeAngle", 0, 3.1415928},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/shadowStrength", 0, 1},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/radius", 0, 1e7},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/angularRadius", 0, 3.1415928},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/size", 0, 1e7},
};

// The same of the values of accessors.
inline constexpr Range kBakeValueRanges[] = {
    {"extensions/HALFLIGHT_mixed_lighting/probes/positions", -1e7, 1e7},
    {"extensions/HALFLIGHT_mixed_lighting/probes/radiance", -1e18, 1e18},
    {"extensions/HALFLIGHT_mixed_lighting/groups/*/radiance", -1e18, 1e18},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion", -0.001, 1.001},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion1", -0.001, 1.001},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion2", -0.001, 1.001},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion3", -0.001, 1.001},
    {"extensions/HALFLIGHT_mixed_lighting/probes/sightRanges", 0, 6e7},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/_HALFLIGHT_LIGHTMAP_ST", -1e6, 1e6},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/_HALFLIGHT_LIGHTMAP_PAGE", -1, 2147483647},
};

/// False for NaN.
constexpr bool isWithin(double value, const Range& range)
{
    return value <= range.most && (range.above ? value > range.least : value >= range.least);
}

/// "from 0 to 1", "above 0 and at most 1e+13".
std::string textOf(const Range& range);

} // namespace halflight
