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
                 PageTexels& texels, std::vector<ImageRgba8>& pages, const std::string& where = kBakePath)
{
    const Json& images = member(root, key);
    const bool mayLack = layers > 1 || where != kBakePath;
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (mayLack && images[i].is_object() && !images[i].contains("index")) {
            pages.emplace_back();
            continue;
        }
        const std::string path = where + "/" + key + "/" + std::to_string(i);
        const auto bytes = pictureBytes(document, images[i], path);
        if (!bytes) return bytes.error();
        auto image = decodeImage(bytes->data(), bytes->size());
        if (!image) return Error{image.error().code, image.error().message, path};
        if (Status s = texels.take(image->texelCount(), path); !s) return s;
        pages.push_back(std::move(*image));
    }
    if (!pages.empty() && pages.size() != pageCount * std::size_t(layers)) {
        return invalid(where, "has " + std::to_string(pages.size()) + " " + key + " for " + std::to_string(pageCount) +
                                  " lightmaps" + (layers > 1 ? " in " + std::to_string(layers) + " layers" : ""));
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

namespace {

/// Lightmap pages and their unit, of the root extension or of a group.
Status readLightmaps(const SourceDocument& document, const Json& record, const std::string& where, bool mayLack,
                     PageTexels& texels, std::vector<Image<uint32_t>>& pages, float& unitLux)
{
    const Json& lightmaps = member(record, "lightmaps");
    for (std::size_t i = 0; i < lightmaps.size(); ++i) {
        if (mayLack && lightmaps[i].is_object() && !lightmaps[i].contains("index")) {
            pages.emplace_back();
            continue;
        }
        const std::string path = where + "/lightmaps/" + std::to_string(i);
        const auto bytes = pictureBytes(document, lightmaps[i], path);
        if (!bytes) return bytes.error();
        auto image = decodeLightmap(*bytes, member(record, "lightmapEncoding"));
        if (!image) return Error{image.error().code, image.error().message, path};
        if (Status s = texels.take(image->texelCount(), path); !s) return s;
        pages.push_back(std::move(*image));
    }
    if (const Json& unit = member(record, "lightmapUnitLux"); !unit.is_null()) {
        unitLux = unit.is_number() ? unit.get<float>() : 0.0f;
        if (!(unitLux > 0.0f) || !std::isfinite(unitLux))
            return invalid(where, "lightmapUnitLux is not a number above 0");
    }
    return {};
}

/// Pages of a light group: as many as the lightmap has, of its sizes.
Status readGroupPages(const SourceDocument& document, const Json& record, const std::string& where, PageTexels& texels,
                      const BakedScene& baked, BakedGroup& group)
{
    if (Status s = readLightmaps(document, record, where, true, texels, group.lightmaps, group.unitLux); !s) return s;
    const std::size_t pages = baked.lightmaps.size();
    if (group.lightmaps.size() != pages)
        return invalid(where, "has " + std::to_string(group.lightmaps.size()) + " lightmaps beside the bake's " +
                                  std::to_string(pages));
    if (Status s = readPages(document, record, "lightmapDirections", pages, 1, texels, group.directions, where); !s)
        return s;
    if (!group.directions.empty() && baked.lightmapDirections.empty())
        return invalid(where, "has directions, which the bake's own lightmap lacks");
    for (std::size_t i = 0; i < pages; ++i) {
        const ivec2 size = baked.lightmaps[i].size();
        const bool fits = group.lightmaps[i].empty() || group.lightmaps[i].size() == size;
        const bool fitsToo =
            group.directions.empty() || group.directions[i].empty() || group.directions[i].size() == size;
        if (!fits || !fitsToo)
            return invalid(where, "has a page " + std::to_string(i) + " of another size than the bake's own");
    }
    return {};
}

} // namespace

Status readPictures(const SourceDocument& document, const Json& root, BakedScene& baked)
{
    PageTexels texels(document);
    if (Status s = readLightmaps(document, root, kBakePath, false, texels, baked.lightmaps, baked.lightmapUnitLux); !s)
        return s;
    const std::size_t pages = baked.lightmaps.size();
    if (Status s = readPages(document, root, "lightmapDirections", pages, 1, texels, baked.lightmapDirections); !s)
        return s;
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const std::string where = kBakePath + "/groups/" + std::to_string(g);
        if (Status s = readGroupPages(document, root["groups"][g], where, texels, baked, baked.groups[g]); !s) return s;
    }
    return readPages(document, root, "shadowmasks", pages, baked.maskLayers, texels, baked.shadowmasks);
}

} // namespace halflight
