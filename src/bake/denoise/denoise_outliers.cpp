// What comes before the filter: variances are calibrated, and outliers removed.
#include "bake/denoise/denoise_outliers.h"

#include "bake/denoise/outliers.h"
#include "bake/denoise/texel_variance.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <array>
#include <utility>

namespace halflight {
namespace {

/// What texel_variance.h reads of all texels.
struct StatedField {
    const SurfaceGrid& grid;
    std::span<const uint8_t> valid;
    const Signals& stated;
    std::vector<shading::SecondDifference>& differences;
};

bool isValid(const StatedField& field, uint32_t texel)
{
    return field.valid[texel] != 0;
}
const NoisyLight& statedLight(const StatedField& field, uint32_t texel)
{
    return field.stated.gathered[texel];
}
const shading::SecondDifference& differenceAt(const StatedField& field, uint32_t texel)
{
    return field.differences[texel];
}

/// The 5 × 5 texels around one on its surface, found once for all components. outliers.h takes it for a grid.
class Neighbours {
public:
    Neighbours(const SurfaceGrid& grid, uint32_t texel)
    {
        for (int i = 0; i < kCount; ++i)
            texels_[std::size_t(i)] =
                shading::texelOnSurface(grid, texel, ivec2(i % kWidth - kRadius, i / kWidth - kRadius));
    }
    friend uint32_t texelOnSurface(const Neighbours& neighbours, uint32_t /*texel*/, ivec2 offset)
    {
        return neighbours.texels_[std::size_t((offset.y + kRadius) * kWidth + offset.x + kRadius)];
    }

private:
    static constexpr int kRadius = 2;
    static constexpr int kWidth = 2 * kRadius + 1;
    static constexpr int kCount = kWidth * kWidth;
    std::array<uint32_t, kCount> texels_;
};

/// What outliers.h reads of the texels around one, of one component.
struct OutlierField {
    const Neighbours& grid;
    const DenoiserTexels& texels;
    const Signals& stated;
    std::span<const float> variances; ///< calibrated
    bool whole = false;               ///< isWhole() of the texel in the middle
};

bool isValid(const OutlierField& field, uint32_t texel)
{
    return field.texels.valid[texel] != 0;
}
bool isWhole(const OutlierField& field, uint32_t /*texel*/)
{
    return field.whole;
}
bool hasFewSamples(const OutlierField& field, uint32_t texel)
{
    return hasFewSamples(field.texels, texel);
}
const NoisyLight& statedLight(const OutlierField& field, uint32_t texel)
{
    return field.stated.gathered[texel];
}
NoisyLight scaledLight(const OutlierField& field, uint32_t texel)
{
    return {field.stated.gathered[texel].irradiance, field.variances[texel]};
}

/// Calls body(texel) for all texels outside geometry.
template<typename Body> void forValid(std::span<const uint8_t> valid, const Body& body)
{
    parallelFor(valid.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (valid[i] != 0) body(uint32_t(i));
    });
}

std::vector<float> calibratedVariances(const DenoiserTexels& texels, const Signals& stated)
{
    auto differences = largeVector<shading::SecondDifference>(texels.valid.size());
    const StatedField field{texels.grid, texels.valid, stated, differences};
    forValid(texels.valid, [&](uint32_t i) { differences[i] = shading::secondDifference(field, i); });
    auto variances = largeVector<float>(texels.valid.size());
    forValid(texels.valid,
             [&](uint32_t i) { variances[i] = stated.gathered[i].variance * shading::varianceScaleAt(field, i); });
    return variances;
}

} // namespace

bool isWhole(const TexelMap& map, const Texel& texel)
{
    return coveredArea(map, texel) > kMostlyCovered && texel.validPoints == kAllPoints;
}

bool hasFewSamples(const DenoiserTexels& texels, std::size_t texel)
{
    return texels.samples[texel] < shading::kReliableSamples;
}

void clampSignals(const DenoiserTexels& texels, std::span<Signals> components)
{
    std::vector<std::vector<float>> variances;
    std::vector<std::vector<NoisyLight>> clamped;
    for (const Signals& stated : components) {
        variances.push_back(calibratedVariances(texels, stated));
        clamped.push_back(largeVector<NoisyLight>(texels.valid.size()));
    }
    forValid(texels.valid, [&](uint32_t i) {
        const Neighbours neighbours(texels.grid, i);
        const bool whole = isWhole(texels.map, texels.map.texels[i]);
        for (std::size_t c = 0; c < components.size(); ++c) {
            Signals& own = components[c];
            const OutlierField field{neighbours, texels, own, variances[c], whole};
            const shading::ClampedTexel texel = shading::withoutOutlier(field, i);
            clamped[c][i] = texel.light;
            if (own.moments.empty()) continue;
            // The moment is that of all light.
            const vec3 direct = own.direct.empty() ? vec3(0.0f) : own.direct[i].irradiance;
            own.moments[i] = shading::scaledMoment(own.moments[i], direct, texel);
        }
    });
    for (std::size_t c = 0; c < components.size(); ++c) components[c].gathered = std::move(clamped[c]);
}

} // namespace halflight
