#pragma once
// The steps of planFrame(), one function each; see plan.cpp for their order.

#include "halflight/render/frame.h"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// World-space bounds of a box in object space; empty stays empty.
Bounds worldBounds(const Bounds& box, const mat4& worldFromObject);

/// Six half-spaces n·p + d >= 0 of a clip space with z 0…1, reversed or not. n is unit length; a plane at infinity is
/// (0, 0, 0, 1).
using Planes = std::array<vec4, 6>;
Planes planesOf(const mat4& clipFromWorld);
/// False only when nothing of the box is inside.
bool meets(const Planes& planes, const Bounds& box);

/// Where a light's direct light can be: all of space (directional, unlimited point), a ball, or a ball's sector about
/// an axis (spot; half a ball for area lights).
struct LightVolume {
    bool everywhere = false;
    vec3 center{0.0f};
    float radius = kInfinity;
    vec3 axis{0.0f, 0.0f, -1.0f};
    float halfAngle = kPi; ///< pi = no cone
};
LightVolume volumeOf(const Light& light);
/// False only when no point of the volume is inside the planes.
bool meets(const LightVolume& volume, const Planes& planes);
/// False only when no point of the volume is in the box.
bool meets(const LightVolume& volume, const Bounds& box);

/// Smallest distance from a point to a box; 0 inside.
float distanceTo(const Bounds& box, vec3 point);
/// Largest distance from a point to a box.
float farthestIn(const Bounds& box, vec3 point);

/// Whether a part of a box in view lies beyond a distance from the camera.
bool reachesBeyond(const FrameView& view, std::span<const Bounds> bounds, float distanceMeters);

/// "light "name"", or its number where it has no name.
std::string nameOf(const Scene& scene, int light);

/// Fills plan.lights, plan.mainLight and plan.usesMask (spec S5, S9, S11, S18, S29); adds warnings.
void selectLights(const BakedScene& baked, const FrameView& view, FramePlan& plan);

/// A mixed light of a baked scene that no shadowmask channel was left for (spec S10).
inline bool lostItsChannel(const Light& light)
{
    return light.baking.isBaked && light.mode == LightMode::Mixed && light.baking.bakeType == LightMode::Baked;
}

/// Adds the lights that no shadowmask channel was left for, as far as there is room, and fills the clusters anew: for
/// the overlap view.
void addOverflowedLights(const BakedScene& baked, std::span<const Bounds> bounds, const FrameView& view,
                         FramePlan& plan);

/// What cascades share by camera and settings, whatever the light.
struct CascadeSlices {
    int count = 0;
    std::array<float, 4> farMeters{}; ///< radial
    /// Sphere that holds every visible point of each slice and of its blend band: on the camera's axis at
    /// `centerDepth`.
    std::array<float, 4> centerDepth{};
    std::array<float, 4> radius{};
};
CascadeSlices sliceView(const FrameView& view, const ShadowSettings& settings);
/// The tile of one cascade: layer and casters are the caller's.
ShadowTile fitCascade(const FrameView& view, const ShadowSettings& settings, const CascadeSlices& slices, int cascade,
                      vec3 lightDirection, const Bounds& sceneBounds);

/// Texels at a tile's border that are kept free for the kernel of the filter or of penumbrae and the receiver's shift
/// along its normal, which grows with the filter: normalBiasTexels for each two texels of its reach. `settings` are the
/// light's (shadowSettingsOf()).
int borderTexels(const ShadowSettings& settings, int mapTexels);

/// Number of tiles a spot or point light needs, and their matrices for a tile of `size` texels.
int localTileCount(const Light& light);
ShadowTile fitLocalTile(const Light& light, int face, int size, const ShadowSettings& settings,
                        const Bounds& sceneBounds);

/// Wish of a light for `count` tiles of `size` texels (a power of two).
struct AtlasRequest {
    int count = 1;
    int size = 0;
};
/// Places of all tiles, and the size each request got: 0 = none. Requests come most important first.
struct AtlasPlacement {
    std::vector<int> sizes;                  ///< per request
    std::vector<std::vector<ivec2>> offsets; ///< per request, per tile; empty where the size is 0
};
AtlasPlacement placeTiles(std::span<const AtlasRequest> requests, int atlasSize);
constexpr int kMinTileSize = 64;

/// Objects to draw into a tile of this light, ascending.
std::vector<uint32_t> castersOfTile(const Scene& scene, std::span<const Bounds> bounds, const LightVolume& volume,
                                    bool staticCasters, const mat4& clipFromWorld);

/// For each object, 1 when a shadow that some of the casters throw along `direction` may fall on it within
/// `distanceMeters` of the camera. `marginMeters` is how far beside its caster a filtered shadow reaches.
std::vector<uint8_t> directionalShadowReceivers(std::span<const Bounds> bounds, std::span<const uint32_t> casters,
                                                vec3 direction, float marginMeters, vec3 cameraPosition,
                                                float distanceMeters);

LightClusters clusterLights(const Scene& scene, const FrameView& view, const Bounds& sceneBounds,
                            std::span<const FrameLight> lights);

} // namespace halflight
