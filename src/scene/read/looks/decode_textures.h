#pragma once
// The pixels of a scene's textures.

#include "halflight/scene/scene.h"
#include "scene/document/document.h"

#include <atomic>
#include <string_view>
#include <utility>
#include <vector>

namespace halflight {

/// Where an image's bytes are: a buffer view or a URI. Images that name the same place are one.
using ImagePlace = std::pair<int, std::string_view>;
inline ImagePlace placeOf(const Json& image)
{
    const int view = integerOf(image, "bufferView");
    return {view, view >= 0 ? std::string_view() : std::string_view(image["uri"].get_ref<const std::string&>())};
}

/// Decodes each image once, all cores at work; textures that show it with different samplers share it.
Status decodeTextures(const SourceDocument& document, std::vector<Texture>& textures, const std::atomic<bool>* cancel);

} // namespace halflight
