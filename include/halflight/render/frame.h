#pragma once
// A frame's decisions, made on the CPU without any graphics API: which lights are in view and what each needs, where its
// shadow maps lie, who casts into them, which lights reach which part of the picture, what probes say at an object.
// An engine with a renderer of its own can use these functions alone.

#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Lighting mode at run time. Values equal the kMode constants of shading/law.h.
enum class RunMode { Realtime = 0, BakedIndirect = 1, Shadowmask = 2, DistanceShadowmask = 3, Subtractive = 4 };

/// The mode a baked file is drawn in unless told otherwise (spec section 1).
RunMode defaultRunMode(const BakedScene& baked);
/// InvalidArgument with the reason when the bake holds no data for this mode, e.g. subtractive from a shadowmask bake.
/// Realtime always fits; a shadowmask bake also fits baked indirect.
Status checkRunMode(const BakedScene& baked, RunMode mode);

enum class ShadowFilter { Hard, Pcf, Soft };

struct ShadowSettings {
    float distanceMeters = 60.0f; ///< from here on no realtime shadow is sampled, > 0
    float fadeRangeMeters = 1.0f; ///< >= 0.01; shadows fade over [distance - range, distance]
    int cascades = 4;             ///< 1…4
    float cascadeSplitLambda = 0.7f; ///< 0 uniform … 1 logarithmic splits (Zhang et al. 2006, parallel-split shadow maps)
    int directionalMapSize = 2048;
    int atlasSize = 4096; ///< square atlas of spot and point light tiles
    ShadowFilter filter = ShadowFilter::Pcf;
    float depthBias = 0.0f;        ///< constant, in shadow-map texels of depth slope 1
    float slopeBias = 1.5f;        ///< Vulkan's depthBiasSlopeFactor
    float normalBiasTexels = 1.2f; ///< receiver moved along its normal by this many shadow-map texels
};

struct FrameView {
    Camera camera;
    ivec2 size{1280, 720};
    [[nodiscard]] mat4 viewFromWorld() const;
    [[nodiscard]] mat4 clipFromView() const; ///< Vulkan clip space: y down, z 0…1, reversed (near = 1)
};

/// One shadow map region: a cascade's layer or a tile of the atlas.
struct ShadowTile {
    mat4 clipFromWorld{1.0f}; ///< z 0 near … 1 far (not reversed)
    ivec2 atlasOffset{0};     ///< texels; 0 for cascades
    int size = 0;             ///< texels
    int layer = 0;            ///< cascade index
    float texelMeters = 0.0f; ///< world size of a texel: everywhere for cascades, at 1 m distance for perspective tiles
};

/// A light as this frame sees it.
struct FrameLight {
    int light = -1; ///< index into Scene::lights
    /// True when shadow attenuation B is read from mask or probes: the light has a channel and the mode uses it.
    bool hasBaked = false;
    int channel = -1;
    bool skipStatic = false;    ///< no direct light on static receivers: baked there already (subtractive; see select.cpp)
    bool skipDynamic = false;
    bool hasRealtimeShadow = false; ///< it got tiles and at least one caster reaches them this frame
    bool staticCasters = true;      ///< static objects are drawn into its shadow map (law: staticCastersInShadowMap)
    int firstTile = -1;
    int tileCount = 0; ///< directional: cascades; spot 1; point 6 (+X -X +Y -Y +Z -Z)
    float importance = 0.0f;
};

/// Cluster grid over the view frustum: tiles of the picture times depth slices, one bit per light.
struct LightClusters {
    ivec3 size{0};
    float nearMeters = 0.1f; ///< depth slices grow exponentially from near to far
    float farMeters = 100.0f;
    static constexpr int kWords = 8; ///< 256 lights
    std::vector<uint32_t> words;     ///< kWords per cluster, cluster (x, y, z) at ((z * size.y + y) * size.x + x) * kWords
};

constexpr int kMaxFrameLights = 256;

/// Everything decided before the first draw.
struct FramePlan {
    RunMode mode = RunMode::Realtime;
    std::vector<FrameLight> lights;    ///< at most kMaxFrameLights, most important first; directional lights first of all
    std::vector<ShadowTile> tiles;
    std::array<float, 4> cascadeFar{}; ///< view distance (radial, metres) where each cascade ends
    int mainLight = -1;                ///< index into `lights`: subtractive's main light, -1 none
    LightClusters clusters;
    bool usesMask = false; ///< any light reads a mask channel this frame (spec S11)
    std::vector<std::string> warnings; ///< lights left out beyond 256, lights that got no tile, lights out of step with their bake
};

/// Selects lights, fits cascades, places tiles, tests casters, fills clusters.
FramePlan planFrame(const BakedScene& baked, const FrameView& view, RunMode mode, const ShadowSettings& shadows);

/// Probe light and occlusion at a point.
struct ProbeSample {
    SphericalHarmonicsL2 radiance{};
    vec4 occlusion{1.0f};
};
/// Interpolated from the valid probes around `position` (outside the grid: from its nearest cell). Sky when there is none.
ProbeSample sampleProbes(const BakedScene& baked, vec3 position);

} // namespace halflight
