#include "scene/pictures/lightmap_curve.h"

#include "halflight/base/math.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/base/rgb9e5.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace halflight {

namespace {

float brightest(vec3 v)
{
    return std::max({v.x, v.y, v.z});
}

float brightest(const Image<uint32_t>& page)
{
    float most = 0.0f;
    for (const uint32_t texel : page.texels()) most = std::max(most, brightest(unpackRgb9e5(texel)));
    return most;
}

std::array<float, 256> valuesOf(const LightmapCurve& curve)
{
    std::array<float, 256> values{};
    for (std::size_t c = 0; c < 256; ++c) values[c] = curve.scale * math::pow(float(c) / 255.0f, curve.exponent);
    return values;
}

uint8_t numberOf(float value, const LightmapCurve& curve)
{
    const float share = std::clamp(value / curve.scale, 0.0f, 1.0f);
    return uint8_t(std::lround(255.0f * math::pow(share, 1.0f / curve.exponent)));
}

} // namespace

LightmapCurve bestCurve(std::span<const Image<uint32_t>> pages)
{
    LightmapCurve best;
    best.scale = 0.0f;
    for (const Image<uint32_t>& page : pages) best.scale = std::max(best.scale, brightest(page));
    if (!(best.scale > 0.0f)) best.scale = 1.0f;
    constexpr std::size_t kEvery = 61; // texels that are looked at: a prime, so that no row pattern is
    double least = kInfinity;
    for (const float exponent : {1.5f, 2.0f, 2.5f, 3.0f, 4.0f}) {
        const LightmapCurve curve{best.scale, exponent};
        const std::array<float, 256> values = valuesOf(curve);
        double sum = 0.0;
        for (const Image<uint32_t>& page : pages) {
            for (std::size_t i = 0; i < page.texelCount(); i += kEvery) {
                const float truth = brightest(unpackRgb9e5(page.texels()[i]));
                if (truth > 0.0f)
                    sum += std::abs(values[numberOf(truth, curve)] - truth) / std::max(truth, best.scale / 4096.0f);
            }
        }
        if (sum >= least) continue;
        least = sum;
        best.exponent = exponent;
    }
    return best;
}

ImageRgba8 encodeByCurve(const Image<uint32_t>& rgb9e5, const LightmapCurve& curve)
{
    ImageRgba8 image(rgb9e5.width(), rgb9e5.height());
    forEachIndex(rgb9e5.texelCount(), [&](std::size_t i) {
        const vec3 v = unpackRgb9e5(rgb9e5.texels()[i]);
        image.texels()[i] = u8vec4(numberOf(v.x, curve), numberOf(v.y, curve), numberOf(v.z, curve), 255);
    });
    return image;
}

Image<uint32_t> decodeByCurve(const ImageRgba8& image, const LightmapCurve& curve)
{
    const std::array<float, 256> values = valuesOf(curve);
    Image<uint32_t> rgb9e5(image.width(), image.height());
    forEachIndex(image.texelCount(), [&](std::size_t i) {
        const u8vec4 c = image.texels()[i];
        rgb9e5.texels()[i] = packRgb9e5(vec3(values[c.x], values[c.y], values[c.z]));
    });
    return rgb9e5;
}

TexelOf texelsOf(const Image<uint32_t>& rgb9e5)
{
    return [&rgb9e5](std::size_t i) { return unpackRgb9e5(rgb9e5.texels()[i]); };
}

LightmapError lightmapError(std::size_t count, const TexelOf& truth, const TexelOf& other)
{
    struct Part {
        float brightest = 0.0f;
        double sum = 0.0;
        double most = 0.0;
        std::size_t lit = 0;
    };
    constexpr std::size_t kTexels = std::size_t(1) << 16; // of a part; parts are added in their order
    std::vector<Part> parts((count + kTexels - 1) / kTexels);
    const auto forTexels = [&](const auto& body) {
        parallelFor(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p) {
                for (std::size_t i = p * kTexels; i < std::min((p + 1) * kTexels, count); ++i) body(parts[p], i);
            }
        });
    };
    forTexels([&](Part& part, std::size_t i) { part.brightest = std::max(part.brightest, brightest(truth(i))); });
    float floor = 0.0f;
    for (const Part& part : parts) floor = std::max(floor, part.brightest / 4096.0f);
    forTexels([&](Part& part, std::size_t i) {
        const vec3 was = truth(i);
        if (!(brightest(was) > 0.0f)) return;
        const double off = double(brightest(glm::abs(other(i) - was)) / std::max(brightest(was), floor));
        part.sum += off;
        part.most = std::max(part.most, off);
        ++part.lit;
    });
    LightmapError error;
    std::size_t lit = 0;
    for (const Part& part : parts) {
        error.mean += part.sum;
        error.most = std::max(error.most, part.most);
        lit += part.lit;
    }
    if (lit > 0) error.mean /= double(lit);
    return error;
}

} // namespace halflight
