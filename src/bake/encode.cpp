#include "bake/stages.h"

#include "halflight/base/parallel.h"

#include <glm/gtc/packing.hpp>

namespace halflight {

std::vector<Image<uint32_t>> encodeLightmap(const std::vector<ImageRgb32f>& pages)
{
    std::vector<Image<uint32_t>> encoded;
    for (const ImageRgb32f& page : pages) {
        Image<uint32_t> out(page.width(), page.height());
        parallelFor(page.texelCount(), 65536, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                out.data()[i] = glm::packF3x9_E1x5(glm::max(page.data()[i], vec3(0.0f)));
            }
        });
        encoded.push_back(std::move(out));
    }
    return encoded;
}

ImageRgb32f decodeLightmap(const Image<uint32_t>& page)
{
    ImageRgb32f decoded(page.width(), page.height());
    for (std::size_t i = 0; i < page.texelCount(); ++i) decoded.data()[i] = glm::unpackF3x9_E1x5(page.data()[i]);
    return decoded;
}

std::vector<ImageRgba8> encodeShadowmask(const std::vector<ImageRgba32f>& pages)
{
    std::vector<ImageRgba8> encoded;
    for (const ImageRgba32f& page : pages) {
        ImageRgba8 out(page.width(), page.height());
        for (std::size_t i = 0; i < page.texelCount(); ++i) {
            out.data()[i] = u8vec4(glm::clamp(page.data()[i], 0.0f, 1.0f) * 255.0f + 0.5f);
        }
        encoded.push_back(std::move(out));
    }
    return encoded;
}

} // namespace halflight
