#pragma once
// The pages of a bake as images of the device.

#include "gpu/resources.h"
#include "halflight/base/image.h"

#include <algorithm>
#include <vector>

namespace halflight {

/// Layers of one array; one texel of `absent` where there are none, and a page of it in place of a null one.
template<typename Texel> gpu::Image uploadLayers(gpu::Device& device, gpu::Uploader& uploader,
                                                 const std::vector<const Image<Texel>*>& layers, VkFormat format,
                                                 Texel absent)
{
    static_assert(sizeof(Texel) == 4);
    ivec2 size(1);
    for (const Image<Texel>* layer : layers)
        if (layer != nullptr) size = glm::max(size, layer->size());
    const bool complete = !layers.empty() && std::find(layers.begin(), layers.end(), nullptr) == layers.end();
    const Image<Texel> missing = complete ? Image<Texel>() : Image<Texel>(size.x, size.y, absent);
    gpu::Image image(device, {.format = format,
                              .width = uint32_t(size.x),
                              .height = uint32_t(size.y),
                              .layers = std::max(uint32_t(layers.size()), 1u),
                              .array = true,
                              .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    std::vector<gpu::Uploader::Level> levels;
    for (std::size_t i = 0; i < layers.size(); ++i)
        levels.push_back({0, uint32_t(i), (layers[i] != nullptr ? layers[i] : &missing)->data()});
    if (layers.empty()) levels.push_back({0, 0, missing.data()});
    uploader.image(image, levels, 4);
    uploader.finish();
    return image;
}

/// The same of the pages of a bake, of which some may be empty.
template<typename Texel> gpu::Image uploadPages(gpu::Device& device, gpu::Uploader& uploader,
                                                const std::vector<Image<Texel>>& pages, VkFormat format, Texel absent)
{
    std::vector<const Image<Texel>*> layers;
    for (const Image<Texel>& page : pages) layers.push_back(page.empty() ? nullptr : &page);
    return uploadLayers(device, uploader, layers, format, absent);
}

} // namespace halflight
