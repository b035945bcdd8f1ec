#include "scene/read/looks/decode_textures.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/parallel.h"
#include "scene/document/decode/compression.h"

#include <map>

namespace halflight {

Status decodeTextures(const SourceDocument& document, std::vector<Texture>& textures, const std::atomic<bool>* cancel)
{
    const Error cancelled = cancelledError();
    struct Encoded {
        int image = -1;
        std::vector<std::size_t> textures;
        std::vector<std::byte> bytes;
        uint64_t texels = 0;
        Status status;
    };
    std::map<ImagePlace, std::size_t> indexOf;
    std::vector<Encoded> images;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        const int image = imageOf(element(document.json, "textures", textures[i].sourceTexture));
        const auto [it, isNew] = indexOf.try_emplace(placeOf(element(document.json, "images", image)), images.size());
        if (isNew) images.emplace_back().image = image;
        images[it->second].textures.push_back(i);
    }
    const auto forEach = [&](const auto& work) -> Status {
        parallelFor(images.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                images[i].status = cancel != nullptr && *cancel ? Status(cancelled) : work(images[i]);
        });
        for (const Encoded& image : images) {
            if (!image.status) return image.status;
        }
        return {};
    };
    const auto at = [](const Encoded& image, const Error& error) {
        return Error{error.code, error.message, pathOf("images", std::size_t(image.image))};
    };
    Status status = forEach([&](Encoded& image) -> Status {
        auto bytes = imageBytes(document, image.image);
        if (!bytes) return bytes.error();
        const auto size = encodedImageSize(bytes->data(), bytes->size());
        if (!size) return at(image, size.error());
        image.bytes = std::move(*bytes);
        image.texels = uint64_t(size->x) * uint64_t(size->y);
        return {};
    });
    if (!status) return status;
    uint64_t texels = 0;
    uint64_t bytesInFiles = 0;
    const uint64_t bytesInBuffers = bufferBytes(document); // buffer views may overlap: no more than there is
    for (const Encoded& image : images) {
        texels += image.texels * image.textures.size();
        if (!element(document.json, "images", image.image).contains("bufferView")) bytesInFiles += image.bytes.size();
    }
    if (const uint64_t most = mostTexels(bytesInFiles + bytesInBuffers); texels > most) {
        return invalid("/images", "decoded, they hold " + std::to_string(texels) +
                                      " texels in all, more than the limit of " + std::to_string(most) +
                                      " for a file of this size");
    }
    return forEach([&](Encoded& image) -> Status {
        auto pixels = decodeImage(image.bytes.data(), image.bytes.size());
        if (!pixels) return at(image, pixels.error());
        image.bytes = {};
        const SharedImage<u8vec4> shared(std::move(*pixels));
        for (const std::size_t texture : image.textures) textures[texture].pixels = shared;
        return {};
    });
}

} // namespace halflight
