#pragma once

#include "halflight/scene/mask_values.h"
#include "halflight/scene/scene.h"
#include "halflight/scene/tetrahedra.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Real spherical-harmonic coefficients, one RGB value each. Order: l,m = 00, 1-1, 10, 11, 2-2, 2-1, 20, 21, 22.
using SphericalHarmonicsL2 = std::array<vec3, 9>;

/// One light and occlusion probe.
struct Probe {
    vec3 position{0.0f};
    /// SH L2 coefficients of incoming *radiance* (cd/m2) from what is baked: the same light as a lightmap texel here
    /// would see. Irradiance for a normal comes from shading/sh.h.
    SphericalHarmonicsL2 radiance{};
    /// Baked attenuation (1 lit … 0 shadowed) by shadowmask channel; unused channels are 1 (spec S14).
    MaskValues occlusion;
    bool valid = true; ///< false: inside geometry; to be left out of interpolation
};

/// How far probes see. A probe that sees all points of its tetrahedra that another corner sees needs no map.
struct ProbeSight {
    /// Corners along each side of a map, odd; 0: no probe has one.
    int size = 0;
    /// By probe, in the norm |x| + |y| + |z|: what the map's distances are fractions of. It says nothing of points
    /// farther away. 0: no map.
    std::vector<float> rangeMeters;
    struct Corner {
        uint16_t distance = 0;  ///< 1 / nearness, 65535 = range
        uint16_t deviation = 0; ///< of the nearness, over it; 65535 = 1 and more
    };
    /// `size` squared corners for each probe with a map, in the order of the probes: rows of the octahedral map
    /// (shading/sight.h), from y = -1 up. Those on the square's rim come twice.
    std::vector<Corner> corners;
};

/// Probes on a regular grid: probe i sits at origin + spacing * (x, y, z) with i = (z * size.y + y) * size.x + x.
/// The grid may be empty (size 0), and then probes is a free list.
struct ProbeSet {
    vec3 origin{0.0f};
    vec3 spacingMeters{1.0f};
    ivec3 size{0};
    std::vector<Probe> probes;
    /// Delaunay tetrahedra between the valid probes, as a file brought them; vertices are indices into `probes`. Empty:
    /// probeCells() makes them.
    std::vector<Tetrahedron> tetrahedra;
    ProbeSight sight; ///< nothing in files of earlier versions: every probe sees through walls
};

/// Radiance around a point, as glossy surfaces near it reflect it. See shading/reflection.h.
struct ReflectionProbe {
    vec3 position{0.0f};     ///< where the picture was taken
    mat4 worldFromBox{1.0f}; ///< from the cube [-1, 1]^3 to the box on which the picture's surfaces are taken to lie
    float fadeMeters = 0.0f; ///< distance outside of the box at which the probe counts a quarter, above 0
};

/// All reflection probes. In the blend, each leaves to those after it what it does not cover.
struct ReflectionSet {
    static constexpr std::size_t kMost = 32; ///< probes that a file may hold
    std::vector<ReflectionProbe> probes;
    int size = 0; ///< width of a probe's tile in texels
    /// RGB9E5 in units of `unitNits`: one tile for each probe, one below the other, each 3/2 of `size` high.
    Image<uint32_t> picture;
    float unitNits = 1.0f;
};

/// How a channel of the shadowmask is to be read: see decodeMask() in shading/mask.h.
struct MaskChannel {
    float rangeTexels = 0.0f;    ///< 0: attenuation; else distance to the shadow's edge, this many texels at 0 and at 1
    float penumbraTexels = 0.0f; ///< mean width of the penumbra, for channels that hold distances
};

/// Light of a group by itself, at the weight 1 (spec S33). Members name their group: BakingOutput::group,
/// Material::bakedGroup.
struct BakedGroup {
    std::string name;
    vec3 weight{1.0f};    ///< by channel, with which the light is added; that of the scene's lights as they are
    bool sky = false;     ///< the sky is a member
    float peakLux = 0.0f; ///< of the brightest channel of a texel
    float unitLux = 1.0f;
    bool direct = true; ///< some of its light is direct; false: all has been reflected, and varies little
    /// As BakedScene::lightmaps, in units of `unitLux`, and lightmapDirections; pages without light have no texels.
    std::vector<Image<uint32_t>> lightmaps;
    std::vector<ImageRgba8> directions;
    std::vector<SphericalHarmonicsL2> radiance; ///< by probe
    vec3 shadowColor{0.0f};                     ///< as BakedScene::defaultShadowColor, of the group's light
    /// Tiles of the bake's reflection probes with the group's light alone; `probes` is empty. Size 0: the group has
    /// less than 1 % of their light, and BakedScene::reflections holds it at the saved weight.
    ReflectionSet reflections;
};

/// Result of a bake and input of the renderer.
struct BakedScene {
    /// Objects carry their lightmap binding, parts their lightmapUv, lights their baking output.
    Scene scene;
    MixedLightingMode mode = MixedLightingMode::Shadowmask;
    bool isBaked = false; ///< false: a plain glTF, to be rendered in realtime mode
    /// Irradiance in units of `lightmapUnitLux`, RGB9E5 (glm::packF3x9_E1x5 layout =
    /// VK_FORMAT_E5B9G9R9_UFLOAT_PACK32), one per page.
    std::vector<Image<uint32_t>> lightmaps;
    /// Mean direction of each lightmap texel's light in world space, as colour: encodeMeanDirection() in
    /// shading/directional.h, alpha 255. One per page, or none when the bake was not directional.
    std::vector<ImageRgba8> lightmapDirections;
    /// Lux that a texel of 1 stands for; above 1 where light is brighter than RGB9E5's 65,408 (full daylight is).
    float lightmapUnitLux = 1.0f;
    /// Layers that masks have, 1 to kMostMaskLayers: one for each four channels in use (spec S36).
    int maskLayers = 1;
    /// Baked attenuation by channel, 255 = lit; `maskLayers` pictures per page, those of a page together, or none when
    /// no light has a channel. Where there are several layers, a picture without texels is lit everywhere. A
    /// subtractive bake holds the main light's alone, in channel 0, or none (BakeSettings::subtractiveMask).
    std::vector<ImageRgba8> shadowmasks;
    std::array<MaskChannel, kMostMaskLayers * kLayerChannels> maskChannels{};
    /// Lower limit of subtractive shadows that the bake chose, irradiance in lux (spec S23): the light where the main
    /// light is shadowed. Counts where the author asks for none. In bakes with groups it is the rest's.
    vec3 defaultShadowColor{0.0f};
    ProbeSet probes;
    ReflectionSet reflections;
    /// Groups whose light is not in lightmaps and probes, which then hold the rest; nor in reflections, where the group
    /// has tiles. composeGroups() adds them.
    std::vector<BakedGroup> groups;
    /// What a tool dropped of the bake since it was written, as phrases; scene.warnings has them as sentences.
    std::vector<std::string> lost;
};

/// Layers that hold the channels of all lights, at least 1.
int maskLayersOf(const Scene& scene);

/// Whether a light's mask has a colour (BakingOutput::coloredMask).
bool hasColoredMasks(const Scene& scene);

/// Of the mask's pictures; zero where none has texels.
ivec2 maskPageSize(const BakedScene& baked);

/// Lower limit of subtractive shadows, irradiance in lux: the author's, else the bake's. `weights`: by group; the saved
/// ones where there are none.
inline vec3 subtractiveShadowColor(const BakedScene& baked, std::span<const vec3> weights = {})
{
    if (baked.scene.subtractiveShadowColor) return *baked.scene.subtractiveShadowColor;
    vec3 color = baked.defaultShadowColor;
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const BakedGroup& group = baked.groups[g];
        color += (weights.empty() ? group.weight : weights[g]) * group.shadowColor;
    }
    return color;
}

} // namespace halflight
