// What comes before the filter: variances are calibrated, and outliers removed.
#include "bake/denoise/denoise_outliers.h"

#include "bake/denoise/outliers.h"
#include "bake/denoise/texel_variance.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

namespace halflight {
namespace {

/// What texel_variance.h and outliers.h read of all texels.
struct Field {
    const SurfaceGrid& grid;
    const DenoiserInput& input;
    std::vector<shading::SecondDifference> differences;
    std::vector<NoisyLight> scaled;
    std::vector<NoisyLight> clamped;
};

bool isValid(const Field& field, uint32_t texel)
{
    return field.input.estimates[texel].valid;
}
/// Covered for the most part, and all of its sample points are valid.
bool isWhole(const Field& field, uint32_t texel)
{
    return isWhole(field.input.map, field.input.map.texels[texel]);
}
uint32_t samplesOf(const Field& field, uint32_t texel)
{
    return field.input.estimates[texel].samples;
}
NoisyLight statedLight(const Field& field, uint32_t texel)
{
    const IrradianceEstimate& e = field.input.estimates[texel];
    return shading::gatheredLight(e.irradiance, e.varianceOfMean, e.direct, e.varianceOfDirect);
}
const shading::SecondDifference& differenceAt(const Field& field, uint32_t texel)
{
    return field.differences[texel];
}
const NoisyLight& scaledLight(const Field& field, uint32_t texel)
{
    return field.scaled[texel];
}

/// Calls body(texel) for all texels outside geometry.
template<typename Body> void forValid(const Field& field, const Body& body)
{
    parallelFor(field.input.estimates.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (field.input.estimates[i].valid) body(uint32_t(i));
    });
}

void scaleVariances(Field& field)
{
    field.differences = largeVector<shading::SecondDifference>(field.input.estimates.size());
    forValid(field, [&](uint32_t i) { field.differences[i] = shading::secondDifference(field, i); });
    forValid(field, [&](uint32_t i) {
        field.scaled[i] = statedLight(field, i);
        field.scaled[i].variance *= shading::varianceScaleAt(field, i);
    });
    release(field.differences);
}

/// Keeps a texel's light, and its moment.
void keep(Field& field, std::vector<vec3>& moments, uint32_t i, const shading::ClampedTexel& texel)
{
    field.clamped[i] = texel.light;
    moments[i] = shading::scaledMoment(moments[i], field.input.estimates[i].direct, texel);
}

} // namespace

bool isWhole(const TexelMap& map, const Texel& texel)
{
    return coveredArea(map, texel) > kMostlyCovered && texel.validPoints == kAllPoints;
}

Signals clampedSignals(const DenoiserInput& input)
{
    const std::size_t count = input.estimates.size();
    Field field{input.grid, input, {}, largeVector<NoisyLight>(count), largeVector<NoisyLight>(count)};
    Signals signals;
    signals.moments = largeVector<vec3>(count);
    forEachIndex(count, [&](std::size_t i) { signals.moments[i] = input.estimates[i].moment; });
    scaleVariances(field);
    forValid(field, [&](uint32_t i) { keep(field, signals.moments, i, shading::withoutOutlier(field, i)); });
    signals.gathered = std::move(field.clamped);
    if (input.hasDirect) {
        signals.direct = largeVector<NoisyLight>(count);
        forEachIndex(count, [&](std::size_t i) {
            signals.direct[i] = shading::directLight(input.estimates[i].direct, input.estimates[i].varianceOfDirect);
        });
    }
    return signals;
}

} // namespace halflight
