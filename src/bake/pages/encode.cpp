#include "bake/pages/encode.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/shading/directional.h"

#include <algorithm>
#include <cmath>

namespace halflight {

float lightmapUnitFor(const std::vector<ImageRgb32f>& pages)
{
    float brightest = 0.0f;
    for (const ImageRgb32f& page : pages) {
        for (const vec3 texel : page.texels()) {
            for (int c = 0; c < 3; ++c) {
                if (std::isfinite(texel[c])) brightest = std::max(brightest, texel[c]);
            }
        }
    }
    float unit = 1.0f;
    while (brightest > kMaxRgb9e5 * unit) unit *= 2.0f;
    return unit;
}

std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages, float unitLux)
{
    std::vector<Image<uint32_t>> encoded;
    for (const ImageRgb32f& page : pages) encoded.push_back(encodeRgb9e5(page, unitLux));
    return encoded;
}

std::vector<ImageRgba8> encodeDirections(const std::vector<ImageRgb32f>& irradiance,
                                         const std::vector<ImageRgb32f>& moments)
{
    std::vector<ImageRgba8> encoded;
    for (std::size_t p = 0; p < irradiance.size(); ++p) {
        ImageRgba8 out(irradiance[p].width(), irradiance[p].height());
        parallelFor(out.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const float light = luminance(irradiance[p].data()[i]);
                const vec3 direction = light > 0.0f ? moments[p].data()[i] / light : vec3(0.0f);
                out.data()[i] = u8vec4(vec4(shading::encodeMeanDirection(direction), 1.0f) * 255.0f + 0.5f);
            }
        });
        encoded.push_back(std::move(out));
    }
    return encoded;
}

std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages)
{
    std::vector<ImageRgba8> encoded;
    for (const ImageRgba32f& page : pages) {
        ImageRgba8 out(page.width(), page.height());
        forEachIndex(page.texelCount(), [&](std::size_t i) {
            out.data()[i] = u8vec4(glm::clamp(page.data()[i], 0.0f, 1.0f) * 255.0f + 0.5f);
        });
        encoded.push_back(std::move(out));
    }
    return encoded;
}

std::vector<uint8_t> validTexels(const TexelMap& map)
{
    std::vector<uint8_t> valid(map.texels.size());
    forEachIndex(map.texels.size(), [&](std::size_t i) { valid[i] = map.texels[i].validPoints != 0 ? 1 : 0; });
    return valid;
}

TexelValues splitEstimates(const std::vector<IrradianceEstimate>& estimates)
{
    const std::size_t count = estimates.size();
    TexelValues values{largeVector<vec3>(count), largeVector<vec3>(count)};
    forEachIndex(count, [&](std::size_t i) {
        values.irradiance[i] = estimates[i].irradiance;
        values.direct[i] = estimates[i].direct;
    });
    return values;
}

} // namespace halflight
