#pragma once
// Light of a map's texels by component (spec S33), until there are pages of it.

#include "bake/denoise/denoise.h"

#include "halflight/base/memory.h"

#include <cstddef>
#include <span>
#include <vector>

namespace halflight {

/// Has of each component what its pages need, and no more: estimates would take 52 bytes a texel and component.
class ComponentSignals {
public:
    /// What a component has besides gathered light.
    struct Content {
        bool direct = false;     ///< direct light of lights that are fully baked
        bool directions = false; ///< first moments
    };
    ComponentSignals() = default;
    ComponentSignals(std::size_t texels, std::span<const Content> contents)
    {
        for (const Content& content : contents)
            components_.push_back({largeVector<NoisyLight>(texels),
                                   largeVector<NoisyLight>(content.direct ? texels : 0),
                                   largeVector<vec3>(content.directions ? texels : 0)});
    }

    [[nodiscard]] std::size_t count() const { return components_.size(); }
    void set(std::size_t texel, std::size_t component, const IrradianceEstimate& estimate)
    {
        components_[component].set(texel, estimate);
    }
    /// `estimates`: one of each component.
    void set(std::size_t texel, std::span<const IrradianceEstimate> estimates)
    {
        for (std::size_t c = 0; c < count(); ++c) set(texel, c, estimates[c]);
    }
    [[nodiscard]] vec3 irradiance(std::size_t texel, std::size_t component) const
    {
        return components_[component].irradiance(texel);
    }
    [[nodiscard]] std::span<Signals> components() { return components_; }

private:
    std::vector<Signals> components_;
};

} // namespace halflight
