#pragma once
// A frame's decisions, made on the CPU without any graphics API: which lights are in view and what each needs, where
// its shadow maps lie, who casts into them, which lights reach which part of the picture, what probes say at an object.
// An engine with a renderer of its own can use these functions alone.

#include "halflight/base/result.h"
#include "halflight/render/probes.h" // what probes say at an object: build one ProbeInterpolator per scene
#include "halflight/scene/baked_scene.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Lighting mode at run time. Values equal the kMode constants of shading/law.h.
enum class RunMode { Realtime = 0, BakedIndirect = 1, Shadowmask = 2, DistanceShadowmask = 3, Subtractive = 4 };
/// As --mode has it.
const char* nameOf(RunMode mode);

/// The mode a baked file is drawn in by default (spec section 1).
RunMode defaultRunMode(const BakedScene& baked);
/// InvalidArgument with the reason when the bake holds no data for this mode, e.g. subtractive from a shadowmask bake.
/// Realtime always fits; a shadowmask bake also fits baked indirect.
Status checkRunMode(const BakedScene& baked, RunMode mode);

/// Hard: one texel, no filter. Pcf: a small kernel. Soft: a wide one.
enum class ShadowFilter { Hard, Pcf, Soft };
/// As --shadow-filter has it.
const char* nameOf(ShadowFilter filter);

/// Texels by which a filter's kernel may reach beyond the texel a point falls in. Tiles are fitted with this border, or
/// the wider one of penumbrae (shading::penumbraReach()), and room for the normal bias, so a kernel that keeps to it
/// never reads outside its tile.
constexpr int filterReachTexels(ShadowFilter filter)
{
    return filter == ShadowFilter::Hard ? 1 : filter == ShadowFilter::Pcf ? 2 : 4;
}

/// How one cascade hands over to the next, over its last `cascadeBlendFraction`.
enum class CascadeBlend { Hard, Dithered, Soft };
/// As --cascade-blend has it.
const char* nameOf(CascadeBlend blend);

struct ShadowSettings {
    float distanceMeters = 60.0f; ///< from here on no realtime shadow is sampled, > 0
    float fadeRangeMeters = 1.0f; ///< >= 0.01; shadows fade over [distance - range, distance]
    int cascades = 4;             ///< 1…4
    float cascadeSplitLambda =
        0.7f; ///< 0 uniform … 1 logarithmic splits (Zhang et al. 2006, parallel-split shadow maps)
    /// Where cascades end, as shares of the shadow distance: ascending, above 0 and below 1, one fewer than there are
    /// cascades (the rest is not read). 0 first: by cascadeSplitLambda.
    std::array<float, 3> cascadeSplits{};
    CascadeBlend cascadeBlend = CascadeBlend::Soft;
    /// Cascade i blends into i + 1 from radial distance (1 - fraction) * cascadeFar[i] on; 0…0.5. Every cascade covers
    /// the blend band of the one before it.
    float cascadeBlendFraction = 0.1f;
    int directionalMapSize = 2048; ///< 64…16384
    /// Square atlas of spot and point light tiles, 256…16384; the largest power of two that fits in it is used.
    int atlasSize = 4096;
    bool pointShadows = true; ///< false: point lights have baked shadows only, as in the seeds (spec S4)
    ShadowFilter filter = ShadowFilter::Pcf;
    /// Shadows of lights that have a size are as soft as in the bake (shading/penumbra.h), and no sharper than the
    /// filter. Hard shadows have none.
    bool penumbrae = true;
    /// Receiver moved towards the light by this many shadow-map texels. Covers the rounding of depths and positions,
    /// which no slope covers on surfaces that face the light straight (the deferred path knows positions by depth
    /// alone). A light's own ShadowBias comes before this bias and the next two.
    float depthBias = 0.1f;
    float slopeBias = 1.5f; ///< Vulkan's depthBiasSlopeFactor
    /// Receiver moved along its normal by this many shadow-map texels for each two texels of filterReachTexels() (at
    /// least one time), so that a wide kernel on a tilted surface does not meet the surface itself; 0…8. Where the
    /// light meets a surface edge-on, shading::kEdgeOnShift times as far.
    float normalBiasTexels = 0.5f;
    bool operator==(const ShadowSettings&) const = default;
};

/// InvalidArgument naming the first setting outside its limits.
Status checkShadowSettings(const ShadowSettings& settings);
/// The settings with the light's own biases, where it has some, and without penumbrae where it or the filter has none.
ShadowSettings shadowSettingsOf(const Light& light, const ShadowSettings& settings);
/// Half the width of a light's source: metres, or for directional lights the tangent of the angle. 0 for points.
float halfSourceWidth(const Light& light);

/// World-space bounds of every object, empty where a mesh has no vertices. Compute once per scene, and again for an
/// object that moved.
std::vector<Bounds> objectBounds(const Scene& scene);
/// With near and far planes that show the whole scene from where the camera stands; as it is where `scene` is empty.
Camera withPlanesFor(const Bounds& scene, Camera camera);
/// Whether a ray may meet what is in the bounds before `limit` lengths of its direction.
bool rayReaches(const Bounds& bounds, vec3 origin, vec3 direction, float limit);

struct FrameView {
    Camera camera;
    ivec2 size{1280, 720};
    [[nodiscard]] mat4 viewFromWorld() const;
    [[nodiscard]] mat4 clipFromView() const; ///< Vulkan clip space: y down, z 0…1, reversed (near = 1)
};

/// Distance in metres from the camera to the farthest point that the bounds of objects have in view, 0 where none is.
/// `bounds` is objectBounds(scene).
float farthestInView(const FrameView& view, std::span<const Bounds> bounds);

/// Metres. The first of four cascades of 2048 texels then ends 16 m from the camera, and its texels are 1.5 cm wide.
constexpr float kLongestShadowDistance = 2000.0f;
/// The settings with a shadow distance that holds `farthestMeters` (farthestInView()) and the fade range beyond it, at
/// most kLongestShadowDistance, and with splits (cascadeSplitLambda) that leave the first cascades near the camera. At
/// 0, where no object is in view, they stay as they are.
ShadowSettings shadowsReaching(float farthestMeters, ShadowSettings settings);

/// One shadow map region: a cascade's layer or a tile of the atlas.
struct ShadowTile {
    mat4 clipFromWorld{1.0f}; ///< z 0 near … 1 far (not reversed)
    ivec2 atlasOffset{0};     ///< texels; 0 for cascades
    int size = 0;             ///< texels
    /// Layer of the directional lights' shadow array: light n of those with shadows has its cascades at n * cascades.
    /// 0 for atlas tiles.
    int layer = 0;
    float texelMeters = 0.0f; ///< world size of a texel: everywhere for cascades, at 1 m depth for perspective tiles
    float nearMeters =
        0.0f; ///< z = 0: depth from the light, or for cascades along its direction from the world's origin
    float farMeters = 0.0f; ///< z = 1
};

/// Why a light of the frame has no realtime shadow.
enum class NoShadow {
    None,              ///< it has one
    CastShadowsOff,    ///< Light::castShadows
    StrengthZero,      ///< Light::shadowStrength
    PointShadowsOff,   ///< ShadowSettings::pointShadows
    BeyondDistance,    ///< all it lights is beyond the shadow distance
    NoCaster,          ///< no object that may cast into its map reaches what the camera sees of it
    DirectionalsTaken, ///< kMaxDirectionalShadows other directional lights have one
    AtlasFull
};

/// A light as this frame sees it.
struct FrameLight {
    int light = -1; ///< index into Scene::lights
    /// True when shadow attenuation B is read from mask or probes: the light has a channel and the mode uses it.
    bool hasBaked = false;
    int channel = -1;
    bool skipStatic = false; ///< no direct light on static receivers: baked there already (subtractive; see lights.cpp)
    bool skipDynamic = false;
    bool hasRealtimeShadow = false;         ///< it got tiles and at least one caster reaches them this frame
    NoShadow noShadow = NoShadow::NoCaster; ///< why not
    bool staticCasters = true; ///< static objects are drawn into its shadow map (law: staticCastersInShadowMap)
    /// Fully baked, as no shadowmask channel was left for it; it lights nothing, and is in the frame for the overlap
    /// view alone.
    bool overflowed = false;
    int firstTile = -1; ///< into FramePlan::tiles; -1 without realtime shadow
    /// Directional: cascades. Spot: 1, or 6 when its cone is wider than one tile can show. Point: 6. Six tiles are the
    /// world's axes +X -X +Y -Y +Z -Z, to be chosen by the largest component of (point - light).
    int tileCount = 0;
    float importance = 0.0f; ///< illuminance (lux) it may bring to where the camera is
};

/// Cluster grid over the view frustum: tiles of the picture times depth slices, one bit per light.
struct LightClusters {
    ivec3 size{0};
    float nearMeters = 0.1f; ///< depth slices grow exponentially from near to far
    float farMeters = 100.0f;
    static constexpr int kWords = 8; ///< 256 lights
    /// kWords per cluster, cluster (x, y, z) at ((z * size.y + y) * size.x + x) * kWords; y = 0 is the picture's top
    /// row. Bit n % 32 of word n / 32 is FramePlan::lights[n]. Directional lights are in every cluster.
    std::vector<uint32_t> words;

    /// The cluster of a fragment: `uv` 0…1 over the picture from its top left, `viewDepthMeters` along the camera's
    /// axis. z = clamp(floor(log2(depth / near) * size.z / log2(far / near)), 0, size.z - 1).
    [[nodiscard]] ivec3 clusterAt(vec2 uv, float viewDepthMeters) const;
    [[nodiscard]] bool reaches(ivec3 cluster, int frameLight) const
    {
        const auto index = (std::size_t(cluster.z) * size.y + cluster.y) * size.x + cluster.x;
        return (words[index * kWords + std::size_t(frameLight) / 32] >> (frameLight % 32) & 1u) != 0;
    }
};

constexpr int kMaxFrameLights = 256;
/// Directional lights with cascades at once; further ones get a warning and keep their baked shadows.
constexpr int kMaxDirectionalShadows = 4;

/// Everything decided before the first draw.
struct FramePlan {
    RunMode mode = RunMode::Realtime;
    std::vector<FrameLight> lights; ///< at most kMaxFrameLights, most important first; directional lights first of all
    std::vector<ShadowTile> tiles;  ///< cascades of directional lights first, then the atlas
    int directionalLayers = 0;      ///< layers of the directional shadow array in use
    /// View distance (radial from the camera's position, metres) where each cascade ends: a fragment takes the first
    /// cascade whose far is not less than its distance. The last equals the shadow distance, or all that the camera can
    /// see where that is less; unused ones repeat it.
    std::array<float, 4> cascadeFar{};
    vec2 fadeConstants{0.0f}; ///< law: fadeConstants() of the settings
    int mainLight = -1;       ///< index into `lights`: subtractive's main light, -1 none
    /// Per object, 1 where the main light's realtime shadow may fall: nowhere else need its light be taken out of the
    /// lightmap (spec S22, S27). Empty when the main light has no map.
    std::vector<uint8_t> mainShadowReceivers;
    LightClusters clusters;
    bool usesMask = false;     ///< any light reads a shadowmask channel this frame (spec S11); never in subtractive
    int maskLayers = 0;        ///< layers up to that of the last channel read (spec S36); 0 where usesMask is false
    bool coloredMasks = false; ///< B of some light has a colour (spec S35); also of subtractive's main light
    /// Subtractive: the main light's own mask says how much of its light arrives where its realtime shadow is
    /// subtracted (spec S22). False without such a shadow, and for files that hold no mask.
    bool subtractsByMask = false;
    /// Objects to draw into tile i, ascending: tileCasters[tileCasterBegin[i] … tileCasterBegin[i + 1]).
    std::vector<uint32_t> tileCasters;
    std::vector<uint32_t> tileCasterBegin; ///< one more than tiles
    [[nodiscard]] std::span<const uint32_t> castersOf(int tile) const
    {
        return std::span(tileCasters)
            .subspan(tileCasterBegin[std::size_t(tile)],
                     tileCasterBegin[std::size_t(tile) + 1] - tileCasterBegin[std::size_t(tile)]);
    }
    /// Lights left out beyond 256, lights that got no tile, and what was changed of lights since their bake that shows
    /// nowhere or in part (changesSinceBake()).
    std::vector<std::string> warnings;
};

/// Selects lights, fits cascades, places tiles, tests casters, fills clusters. `bounds` is objectBounds(baked.scene);
/// `mode` and `shadows` have passed their checks.
FramePlan planFrame(const BakedScene& baked, std::span<const Bounds> bounds, const FrameView& view, RunMode mode,
                    const ShadowSettings& shadows);

/// What a frame does with one light of the scene, for a frame debugger.
struct LightRow {
    int light = -1;         ///< index into Scene::lights
    int frameLight = -1;    ///< index into FramePlan::lights, -1 = not in the frame
    std::string notInFrame; ///< why not
    /// Mask channel whose baked attenuation B the light's shadow is mixed with, -1 = none.
    int bakedChannel = -1;
    std::string noBakedShadow; ///< why none
    bool realtimeShadow = false;
    std::string noRealtimeShadow; ///< why none
    int cascades = 0;             ///< of a directional light
    int tiles = 0;                ///< in the atlas, of a spot or point light
    int tileTexels = 0;           ///< side of one cascade or tile
    int staticCasters = 0;        ///< objects that are drawn into one of its maps at least
    int dynamicCasters = 0;
};
/// One row for each light of the scene, in the scene's order. `view` is that the plan was made with.
std::vector<LightRow> lightRows(const BakedScene& baked, const FrameView& view, const FramePlan& plan);

} // namespace halflight
