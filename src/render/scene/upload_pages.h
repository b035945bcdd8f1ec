#pragma once
// The pages of a bake as images of the device.

#include "gpu/resources.h"
#include "halflight/base/image.h"

#include <algorithm>
#include <vector>

namespace halflight {

/// Pages as layers of one array; one texel of `absent` where there are none, and a page of it in place of an empty one.
template<typename Texel> gpu::Image uploadPages(gpu::Device& device, gpu::Uploader& uploader,
                                                const std::vector<Image<Texel>>& pages, VkFormat format, Texel absent)
{
    static_assert(sizeof(Texel) == 4);
    ivec2 size(1);
    for (const Image<Texel>& page : pages) size = glm::max(size, page.size());
    const bool complete = !pages.empty() && std::none_of(pages.begin(), pages.end(), [](auto& p) { return p.empty(); });
    const Image<Texel> missing = complete ? Image<Texel>() : Image<Texel>(size.x, size.y, absent);
    gpu::Image image(device, {.format = format,
                              .width = uint32_t(size.x),
                              .height = uint32_t(size.y),
                              .layers = std::max(uint32_t(pages.size()), 1u),
                              .array = true,
                              .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    std::vector<gpu::Uploader::Level> levels;
    for (std::size_t i = 0; i < pages.size(); ++i)
        levels.push_back({0, uint32_t(i), (pages[i].empty() ? missing : pages[i]).data()});
    if (pages.empty()) levels.push_back({0, 0, missing.data()});
    uploader.image(image, levels, 4);
    uploader.finish();
    return image;
}

} // namespace halflight
