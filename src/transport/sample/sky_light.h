#pragma once
// The sky as a light source.

#include "transport/random/alias_table.h"

#include "halflight/scene/scene.h"
#include "halflight/shading/sky_picture.h"

#include <memory>
#include <vector>

namespace halflight {

/// The sky, of which a picture's bright places are sampled as a light (next-event estimation). A picture is the sum of
/// a dim and a bright part: of a texel, the bright part is what its luminance exceeds a limit by, in the texel's
/// colour. Rays that leave the scene receive the dim part, whose few values of similar size need no importance
/// sampling. The bright part, a sun or lamps, comes from sample(). Both together are the picture, so that no weights
/// are needed where directions are cosine-distributed. A gradient is dim everywhere.
class SkyLight {
public:
    explicit SkyLight(const Sky& sky);

    [[nodiscard]] bool black() const { return sky_.black(); }
    /// Radiance from a unit direction, bilinear between a picture's texels.
    [[nodiscard]] vec3 radiance(vec3 direction) const
    {
        return picture_ == nullptr ? gradient(direction) : pictureRadiance(direction);
    }
    [[nodiscard]] vec3 dimRadiance(vec3 direction) const
    {
        return picture_ == nullptr ? gradient(direction) : pictureDim(direction);
    }
    [[nodiscard]] vec3 brightRadiance(vec3 direction) const
    {
        return samples() ? radiance(direction) - dimRadiance(direction) : vec3(0.0f);
    }

    /// The sky itself; luminance above which a picture's texels count for the bright part.
    [[nodiscard]] const Sky& sky() const { return sky_; }
    [[nodiscard]] float limit() const { return limit_; }
    [[nodiscard]] vec2 turn() const { return turn_; } ///< cosine and sine of the picture's rotation
    /// Whether there is a bright part.
    [[nodiscard]] bool samples() const { return !areas_.empty(); }
    struct Sample {
        vec3 direction{0.0f};
        vec3 radiance{0.0f}; ///< of the bright part
        float pdf = 0.0f;    ///< per steradian, above 0
    };
    [[nodiscard]] Sample sample(vec2 u) const;
    /// Density of sample(); 0 without a bright part.
    [[nodiscard]] float pdf(vec3 direction) const;
    /// About the illuminance of the bright part on a surface that faces all of it, in lux.
    [[nodiscard]] float brightIlluminance() const { return brightIlluminance_; }
    /// Row times the picture's width plus column of the areas that sample() chooses among, and their alias table.
    [[nodiscard]] std::span<const uint32_t> brightAreas() const { return areas_; }
    [[nodiscard]] std::span<const AliasBin> brightBins() const { return bins_; }

private:
    using Place = shading::SkyPlace;
    [[nodiscard]] vec3 gradient(vec3 d) const
    {
        return shading::skyRadiance(sky_.zenith, sky_.horizon, sky_.ground, d);
    }
    [[nodiscard]] vec3 pictureRadiance(vec3 direction) const;
    [[nodiscard]] vec3 pictureDim(vec3 direction) const;
    [[nodiscard]] float dimShare(vec3 texel) const;
    [[nodiscard]] Place placeOf(vec3 direction) const;
    [[nodiscard]] float brightLuminance(const Place& place) const;
    template<typename Value> vec3 interpolate(const Place& place, const Value& value) const;
    void findBrightAreas();

    Sky sky_;
    const ImageRgb32f* picture_ = nullptr; ///< of sky_
    vec2 turn_{1.0f, 0.0f};
    float limit_ = 0.0f; ///< of the dim part's luminance
    float brightIlluminance_ = 0.0f;
    std::vector<uint32_t> areas_; ///< row times the picture's width plus column
    std::vector<AliasBin> bins_;  ///< of areas_
};

} // namespace halflight
