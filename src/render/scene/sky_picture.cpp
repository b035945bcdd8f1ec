#include "render/scene/sky_picture.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/sky_picture.h"

namespace halflight {
SkyTexture uploadSky(gpu::Device& device, gpu::Uploader& uploader, const Sky& sky)
{
    ImageRgb32f picture = sky.picture ? reducedSkyPicture(*sky.picture, kMostSkyTexels) : ImageRgb32f(1, 1);
    SkyTexture result;
    result.unitNits = rgb9e5Unit(picture);
    std::vector<Image<uint32_t>> levels = {encodeRgb9e5(picture, result.unitNits)};
    const ivec2 full = picture.size();
    while (picture.width() > 1 || picture.height() > 1) {
        picture = reducedSkyPicture(picture, glm::max(picture.size() / 2, ivec2(1)));
        levels.push_back(encodeRgb9e5(picture, result.unitNits));
    }
    result.image = gpu::Image(device, {.format = VK_FORMAT_E5B9G9R9_UFLOAT_PACK32,
                                       .width = uint32_t(full.x),
                                       .height = uint32_t(full.y),
                                       .mipLevels = uint32_t(levels.size()),
                                       .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    std::vector<gpu::Uploader::Level> uploads;
    for (std::size_t i = 0; i < levels.size(); ++i) uploads.push_back({uint32_t(i), 0, levels[i].data()});
    uploader.image(result.image, uploads, 4);
    uploader.finish();
    result.sampler = gpu::makeSampler(device, {.addressU = VK_SAMPLER_ADDRESS_MODE_REPEAT});
    return result;
}

vec4 skyPictureOfFrame(const SkyTexture& texture, const Sky& sky)
{
    const float width = sky.picture ? float(texture.image.info().width) : 0.0f;
    return {math::cos(sky.rotationRadians), math::sin(sky.rotationRadians), width, 0.0f};
}

} // namespace halflight
