#pragma once
// Types of members of the bake's extensions, for checkTypes().

#include <cstddef>
#include <string_view>

namespace halflight {

enum class Kind {
    Any,
    Object,
    Array,
    Text,
    Flag,
    Number,
    Index,   // unsigned, at most 31 bits: indices, enumerators, small counts
    Length,  // unsigned, at most 32 bits: bytes and counts
    Signed,  // an integer
    Indices, // an array of `count` unsigned integers
    Numbers, // an array of `count` numbers; 0 = any number of them
    Bounds   // an array of numbers of any size or null, as exporters write NaN: read by nobody
};

struct Rule {
    std::string_view path; // from the document's root; * is any index or name
    Kind kind;
    std::size_t count = 0;
};

inline constexpr Rule kBakeRules[] = {
    {"materials/*/extensions/HALFLIGHT_material/castShadows", Kind::Flag},
    {"materials/*/extensions/HALFLIGHT_material/receiveShadows", Kind::Flag},
    {"materials/*/extensions/HALFLIGHT_material/tinted", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_node/static", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_node/castShadows", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_node/receiveShadows", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_node/lightmapScale", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_node/twoSided", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_node/probes", Kind::Text},
    {"nodes/*/extensions/HALFLIGHT_node/probeResolution", Kind::Indices, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/min", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/max", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/centroid", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/spread", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/area", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/switches", Kind::Numbers, 4},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/color", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/emission", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/opacity", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_node/atBake/metallic", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/page", Kind::Index},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/scale", Kind::Numbers, 2},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/offset", Kind::Numbers, 2},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/texCoord", Kind::Index},
    {"nodes/*/extensions/HALFLIGHT_node/lightmap/perInstance", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_light/mode", Kind::Text},
    {"nodes/*/extensions/HALFLIGHT_light/shadowStrength", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/indirectMultiplier", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/castShadows", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_light/radius", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/range", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/angularRadius", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/added", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_light/shadowBias/depth", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/shadowBias/slope", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/shadowBias/normal", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/bakeType", Kind::Text},
    {"nodes/*/extensions/HALFLIGHT_light/baking/mixedLightingMode", Kind::Text},
    {"nodes/*/extensions/HALFLIGHT_light/baking/occlusionMaskChannel", Kind::Signed},
    {"nodes/*/extensions/HALFLIGHT_light/baking/reason", Kind::Text},
    {"nodes/*/extensions/HALFLIGHT_light/baking/worldFromLight", Kind::Numbers, 16},
    {"nodes/*/extensions/HALFLIGHT_light/baking/reach", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/outerConeAngle", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/colorIntensity", Kind::Numbers, 3},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/indirectMultiplier", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/range", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/innerConeAngle", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/shadowStrength", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/castShadows", Kind::Flag},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/radius", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/angularRadius", Kind::Number},
    {"nodes/*/extensions/HALFLIGHT_light/baking/atBake/size", Kind::Numbers, 2},
    {"extensions/HALFLIGHT_mixed_lighting/version", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/mode", Kind::Text},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/staticNodes", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/lightmappedNodes", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/bakedLights", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/members/*", Kind::Text},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/zenith", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/horizon", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/ground", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/atBake/sky/picture", Kind::Text},
    {"extensions/HALFLIGHT_mixed_lighting/lightmaps/*/index", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapDirections/*/index", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmasks/*/index", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapUnitLux", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapEncoding/scale", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/lightmapEncoding/exponent", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskLayers", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskChannels/*/encoding", Kind::Text},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskChannels/*/rangeTexels", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/shadowmaskChannels/*/penumbraTexels", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/sky/zenith", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/sky/horizon", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/sky/ground", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/sky/picture/index", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/sky/picture/unitNits", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/sky/picture/rotation", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/subtractiveShadowColor", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/shadowColorFromBake", Kind::Flag},
    {"extensions/HALFLIGHT_mixed_lighting/origin", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/authoredProbes/*", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/authoredReflectionProbes/*", Kind::Numbers, 16},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/picture/index", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/unitNits", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/size", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/probes/*/position", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/probes/*/box", Kind::Numbers, 16},
    {"extensions/HALFLIGHT_mixed_lighting/reflectionProbes/probes/*/fade", Kind::Number},
    {"extensions/HALFLIGHT_mixed_lighting/probes/count", Kind::Length},
    {"extensions/HALFLIGHT_mixed_lighting/probes/positions", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/radiance", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion1", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion2", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/occlusion3", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/valid", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/tetrahedra", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/neighbors", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/sightRanges", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/sight", Kind::Index},
    {"extensions/HALFLIGHT_mixed_lighting/probes/grid/origin", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/probes/grid/spacing", Kind::Numbers, 3},
    {"extensions/HALFLIGHT_mixed_lighting/probes/grid/size", Kind::Indices, 3},
    {"textures/*/extensions/HALFLIGHT_texture_ktx2/source", Kind::Index},
};

} // namespace halflight
