#pragma once

#include "halflight/base/math.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace halflight {

/// Layers that masks may have (spec S36), and channels of a layer. Channel c is in layer c / 4.
constexpr int kMostMaskLayers = 4;
constexpr int kLayerChannels = 4;

/// A value for each channel of all mask layers, such as the baked attenuation of their lights at a probe. Arithmetic is
/// by channel.
struct MaskValues {
    std::array<vec4, kMostMaskLayers> layers;

    MaskValues() : MaskValues(1.0f) {}
    explicit MaskValues(float value) { layers.fill(vec4(value)); }

    [[nodiscard]] float& operator[](int channel)
    {
        return layers[std::size_t(channel / kLayerChannels)][channel % kLayerChannels];
    }
    [[nodiscard]] float operator[](int channel) const
    {
        return layers[std::size_t(channel / kLayerChannels)][channel % kLayerChannels];
    }
    MaskValues& operator+=(const MaskValues& other)
    {
        for (std::size_t k = 0; k < layers.size(); ++k) layers[k] += other.layers[k];
        return *this;
    }
    friend MaskValues operator-(MaskValues a, const MaskValues& b)
    {
        for (std::size_t k = 0; k < a.layers.size(); ++k) a.layers[k] -= b.layers[k];
        return a;
    }
    friend MaskValues operator*(float factor, MaskValues values)
    {
        for (vec4& layer : values.layers) layer *= factor;
        return values;
    }
    friend MaskValues operator/(MaskValues values, float divisor)
    {
        for (vec4& layer : values.layers) layer /= divisor;
        return values;
    }
    friend bool operator==(const MaskValues&, const MaskValues&) = default;
};

inline MaskValues min(MaskValues a, const MaskValues& b)
{
    for (std::size_t k = 0; k < a.layers.size(); ++k) a.layers[k] = glm::min(a.layers[k], b.layers[k]);
    return a;
}
inline MaskValues max(MaskValues a, const MaskValues& b)
{
    for (std::size_t k = 0; k < a.layers.size(); ++k) a.layers[k] = glm::max(a.layers[k], b.layers[k]);
    return a;
}
inline MaskValues saturate(MaskValues values)
{
    for (vec4& layer : values.layers) layer = glm::clamp(layer, 0.0f, 1.0f);
    return values;
}
/// By how much `a` is larger than `b` in the channel where it is most so; negative where it is nowhere.
inline float largestExcess(const MaskValues& a, const MaskValues& b)
{
    float largest = a.layers[0].x - b.layers[0].x;
    for (std::size_t k = 0; k < a.layers.size(); ++k) {
        const vec4 excess = a.layers[k] - b.layers[k];
        largest = std::max({largest, excess.x, excess.y, excess.z, excess.w});
    }
    return largest;
}

} // namespace halflight
