#include "scene/read/looks/read_pictures.h"

#include "halflight/base/encoded_image.h"
#include "scene/format/bake_members.h"
#include "scene/format/picture_references.h"
#include "scene/pictures/ktx2.h"
#include "scene/pictures/lightmap_curve.h"

#include <cmath>

namespace halflight {

Result<std::vector<std::byte>> pictureBytes(const SourceDocument& document, const Json& reference,
                                            const std::string& path)
{
    const Json& texture = member(reference, "index");
    if (!isIndexInto(document.json, "textures", texture))
        return invalid(path, "refers to a texture that does not exist");
    const int image = pictureImage(document.json, texture.get<int>());
    if (image < 0 || std::size_t(image) >= member(document.json, "images").size())
        return invalid(path, "refers to a texture without an image");
    auto bytes = imageBytes(document, image);
    if (!bytes) return Error{bytes.error().code, bytes.error().message, path};
    return bytes;
}

namespace {

// Texels of all pages together; buffer views may overlap.
class PageTexels {
public:
    explicit PageTexels(const SourceDocument& document) : left_(mostTexels(bufferBytes(document))) {}
    Status take(uint64_t texels, const std::string& path)
    {
        if (texels > left_) return invalid(path, "pages have more texels in all than a file of this size may ask for");
        left_ -= texels;
        return {};
    }

private:
    uint64_t left_;
};

// Images of which there are as many as lightmap pages, or none. Where there are several mask layers, each page has one
// of each, and those that are lit everywhere are left out.
Status readPages(const SourceDocument& document, const Json& root, const char* key, std::size_t pageCount, int layers,
                 PageTexels& texels, std::vector<ImageRgba8>& pages)
{
    const Json& images = member(root, key);
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (layers > 1 && images[i].is_object() && !images[i].contains("index")) {
            pages.emplace_back();
            continue;
        }
        const std::string path = kBakePath + "/" + key + "/" + std::to_string(i);
        const auto bytes = pictureBytes(document, images[i], path);
        if (!bytes) return bytes.error();
        auto image = decodeImage(bytes->data(), bytes->size());
        if (!image) return Error{image.error().code, image.error().message, path};
        if (Status s = texels.take(image->texelCount(), path); !s) return s;
        pages.push_back(std::move(*image));
    }
    if (!pages.empty() && pages.size() != pageCount * std::size_t(layers)) {
        return invalid(kBakePath, "has " + std::to_string(pages.size()) + " " + key + " for " +
                                      std::to_string(pageCount) + " lightmaps" +
                                      (layers > 1 ? " in " + std::to_string(layers) + " layers" : ""));
    }
    return {};
}

// RGB9E5 in KTX2, or 8 bits a channel by the file's curve.
Result<Image<uint32_t>> decodeLightmap(std::span<const std::byte> bytes, const Json& encoding)
{
    if (encoding.is_null()) return decodeKtx2(bytes);
    const Json& scale = member(encoding, "scale");
    const Json& exponent = member(encoding, "exponent");
    const LightmapCurve curve{scale.is_number() ? scale.get<float>() : 0.0f,
                              exponent.is_number() ? exponent.get<float>() : 0.0f};
    if (!(curve.scale > 0.0f && curve.scale <= 65408.0f && curve.exponent > 0.0f && curve.exponent <= 16.0f))
        return Error{ErrorCode::FileInvalid, "lightmapEncoding has a scale or an exponent that is out of range", ""};
    const auto image = decodeImage(bytes.data(), bytes.size());
    if (!image) return image.error();
    return decodeByCurve(*image, curve);
}

} // namespace

Status readPictures(const SourceDocument& document, const Json& root, BakedScene& baked)
{
    PageTexels texels(document);
    const Json& lightmaps = member(root, "lightmaps");
    for (std::size_t i = 0; i < lightmaps.size(); ++i) {
        const std::string path = kBakePath + "/lightmaps/" + std::to_string(i);
        const auto bytes = pictureBytes(document, lightmaps[i], path);
        if (!bytes) return bytes.error();
        auto image = decodeLightmap(*bytes, member(root, "lightmapEncoding"));
        if (!image) return Error{image.error().code, image.error().message, path};
        if (Status s = texels.take(image->texelCount(), path); !s) return s;
        baked.lightmaps.push_back(std::move(*image));
    }
    if (const Json& unit = member(root, "lightmapUnitLux"); !unit.is_null()) {
        baked.lightmapUnitLux = unit.is_number() ? unit.get<float>() : 0.0f;
        if (!(baked.lightmapUnitLux > 0.0f) || !std::isfinite(baked.lightmapUnitLux))
            return invalid(kBakePath, "lightmapUnitLux is not a number above 0");
    }
    const std::size_t pages = baked.lightmaps.size();
    if (Status s = readPages(document, root, "lightmapDirections", pages, 1, texels, baked.lightmapDirections); !s)
        return s;
    return readPages(document, root, "shadowmasks", pages, baked.maskLayers, texels, baked.shadowmasks);
}

} // namespace halflight
