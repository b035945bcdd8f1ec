#pragma once
// What the baked probes say at a point, at many points (instances), or throughout a box (proxy volume); spec S14 to
// S17. No graphics API is needed.

#include "halflight/scene/baked_scene.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace halflight {

/// Probe light and occlusion at a point.
struct ProbeSample {
    SphericalHarmonicsL2 radiance{};
    MaskValues occlusion; ///< by channel, 0…1
};

/// The open sky as a probe sees it, nothing occluded.
ProbeSample skyProbe(const Sky& sky);

/// The same light, its bands 1 and 2 scaled down per colour channel by just so much that irradiance is negative on no
/// normal; band 0, the mean, stays. Light that rings nowhere comes back as it is.
SphericalHarmonicsL2 withoutRinging(const SphericalHarmonicsL2& radiance);

/// Four probes around a point and their shares: none negative, sum 1. Unused places have weight 0 and repeat a probe.
struct ProbeWeights {
    std::array<uint32_t, 4> probes{}; ///< indices into BakedScene::probes.probes, ascending
    std::array<float, 4> weights{};
};

struct ProbeOptions {
    bool withoutRinging = true; ///< samples go through withoutRinging()
};

class ProbeMesh;

/// Tetrahedra between the valid probes of a bake, in which light and occlusion are interpolated (Cupisz 2012, "Light
/// Probe Interpolation Using Tetrahedral Tessellations"). Build it once per BakedScene: building takes about 20 µs per
/// probe, a sample two or three. It keeps what it needs of the scene, copies share it, and any number of threads
/// may sample at once.
///
/// Inside the probes' convex hull the interpolation is linear in each Delaunay tetrahedron, hence continuous, and gives
/// linear fields exactly. A point outside takes the value at the hull's nearest point, which is continuous too: every
/// point off the hull has one nearest point, and it moves no farther than the point does. Probes in a plane, on a line
/// or at one place work the same way. Invalid probes (inside geometry) are left out and the tetrahedra span across
/// them; of probes at the same place the first counts. Shares are weighed by what the probes see (ProbeSight), so that
/// a wall stops light between valid probes. Without any valid probe every sample is skyProbe() of the scene.
class ProbeInterpolator {
public:
    explicit ProbeInterpolator(const BakedScene& baked, ProbeOptions options = {});

    /// The same probes with other light, at the price of copying it (spec S33). `radiance`: by BakedScene::probes'
    /// probes, as many; `sky`: that of skyProbe(), for bakes without valid probes.
    [[nodiscard]] ProbeInterpolator withLight(std::span<const SphericalHarmonicsL2> radiance,
                                              const SphericalHarmonicsL2& sky) const;

    /// The same for the same position, whatever was sampled before.
    [[nodiscard]] ProbeSample sample(vec3 position) const;
    /// All zero without any valid probe.
    [[nodiscard]] ProbeWeights weights(vec3 position) const;

    /// Mean distance between neighbouring probes along each world axis; infinite along an axis on which they do not
    /// differ.
    [[nodiscard]] vec3 spacingMeters() const;
    [[nodiscard]] std::size_t probeCount() const; ///< valid probes in use
    [[nodiscard]] std::size_t tetrahedronCount() const;

private:
    struct Light {
        std::vector<SphericalHarmonicsL2> radiance; ///< by place of the mesh
        SphericalHarmonicsL2 sky;
    };
    [[nodiscard]] const SphericalHarmonicsL2& radianceOf(uint32_t place) const;

    std::shared_ptr<const ProbeMesh> mesh_;
    std::shared_ptr<const Light> light_; ///< in place of the mesh's; null = that
    ProbeOptions options_;
};

/// One sample per position, on all threads: the light and occlusion of each instance of an instanced draw (spec S15).
std::vector<ProbeSample> sampleProbes(const ProbeInterpolator& probes, std::span<const vec3> positions);

/// For a single look; it builds a ProbeInterpolator each time. Keep one for more than one sample.
ProbeSample sampleProbes(const BakedScene& baked, vec3 position);

/// Where an object takes its probe light: the centre of its world bounds, or its origin where they are empty.
vec3 probeAnchor(const Object& object, const Bounds& worldBounds);

/// Probe light and occlusion throughout a box, for a large dynamic object or a group of instances (LPPV, spec S16,
/// S17).
///
/// A GPU holds it as kTextures 3D textures of `resolution` texels, RGBA32F (or RGBA16F where coefficients stay below
/// 65,504 nits), sampled with a linear filter, clamped to the edge, at volumeFromWorld * position:
///   0, 1, 2   band 0 and 1 of red, green, blue: coefficients 00, 1-1, 10, 11
///   3         occlusion by channel of the first mask layer
///   4, 5, 6   band 2 of red, green, blue: coefficients 2-2, 2-1, 20, 21
///   7         coefficient 22 in rgb; a = 0
///   8, 9, 10  occlusion by channel of mask layers 1, 2, 3; 1 where the bake has none
/// A shader content with L1 and four channels binds the first four.
struct ProxyVolume {
    static constexpr int kTextures = 8 + kMostMaskLayers - 1;

    /// To texture coordinates, [0, 1]^3 in the volume. Texel (x, y, z) is the light at coordinate (x + 1/2, y + 1/2,
    /// z + 1/2) / resolution. The outermost texel centres lie on the faces of the box asked for, so that between them,
    /// in all of the box, filtering interpolates; beyond the box it holds the value at the face.
    mat4 volumeFromWorld{1.0f};
    ivec3 resolution{0};
    /// Texel (x, y, z) at (z * resolution.y + y) * resolution.x + x.
    std::array<std::vector<vec4>, kTextures> textures;
};

constexpr int kMaxProxyResolution = 64;

struct ProxyVolumeSettings {
    /// Texels along each axis of the box, at most kMaxProxyResolution. 0: as many as keep texels no farther apart than
    /// probes are, at least 2 and at most 32.
    ivec3 resolution{0};
};

/// The volume of an object: `box` in its own space, as its mesh has it, carried along by worldFromObject. Make it again
/// when the object moves. A box or a transform flat along an axis is given thickness there; an empty box is a point.
ProxyVolume makeProxyVolume(const ProbeInterpolator& probes, const Bounds& box, const mat4& worldFromObject,
                            const ProxyVolumeSettings& settings = {});
/// The volume of a box in the world, for instance the union of the bounds of a group of instances.
ProxyVolume makeProxyVolume(const ProbeInterpolator& probes, const Bounds& worldBox,
                            const ProxyVolumeSettings& settings = {});

/// Texels of all volumes that ProbeLighting::Automatic may give a scene; the largest objects come first.
constexpr int kMaxAutomaticProxyTexels = 1 << 18;
/// Texels of all volumes that are asked for; beyond it the finest are made coarser.
constexpr int kMaxProxyTexels = 1 << 21;

/// Which objects of a scene have a proxy volume, who shares one, and how finely each is sampled.
struct ProxyVolumePlan {
    struct Volume {
        std::vector<uint32_t> objects; ///< ascending
        bool alongWorldAxes = false;   ///< a group's box in the world; else its only object's box in that one's space
        ivec3 resolution{0};           ///< stays wherever the objects move
    };
    std::vector<Volume> volumes;
    std::vector<int> volumeOf; ///< per object, -1: one sample at its probeAnchor()
};

/// By each object's probeLighting, probeResolution and probeGroup. `lightmapped[i]`: a lightmap lights object i, which
/// needs no probes; `meshBounds`: of each mesh in its own space. No volumes without valid probes.
ProxyVolumePlan planProxyVolumes(const Scene& scene, std::span<const Bounds> meshBounds,
                                 const std::vector<bool>& lightmapped, const ProbeInterpolator& probes);
/// The volume where its objects are now.
ProxyVolume makeProxyVolume(const ProbeInterpolator& probes, const Scene& scene, std::span<const Bounds> meshBounds,
                            const ProxyVolumePlan::Volume& volume);

/// What a GPU's linear filter reads there.
ProbeSample sampleProxyVolume(const ProxyVolume& volume, vec3 worldPosition);

} // namespace halflight
