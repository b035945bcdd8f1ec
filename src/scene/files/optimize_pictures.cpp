#include "scene/files/optimize_pictures.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/parallel.h"
#include "scene/format/picture_references.h"
#include "scene/pictures/ktx2.h"
#include "scene/pictures/lightmap_curve.h"

#include <algorithm>

namespace halflight {

namespace {

constexpr int kZstdLevel = 19;
constexpr int kDataQuality = 90; // of normal maps and other textures that are no colours

enum class Use { None, Color, Data, Mask, Lightmap };

// What the images of the document are for. An image of two uses takes the stricter one.
class ImageUses {
public:
    explicit ImageUses(const Json& document) : document_(document), uses_(member(document, "images").size(), Use::None)
    {
        for (const Json& material : member(document, "materials")) addTextures(material, "");
        const Json& root = extensionOf(document, "HALFLIGHT_mixed_lighting");
        for (const std::string_view list : kPictureLists) {
            for (const Json& reference : member(root, std::string(list).c_str()))
                add(reference, list == "lightmaps" ? Use::Lightmap : Use::Mask);
        }
        // Groups' lightmaps stay as they are.
        for (const Json& group : member(root, "groups"))
            for (const Json& reference : member(group, "lightmapDirections")) add(reference, Use::Mask);
    }
    [[nodiscard]] const std::vector<Use>& uses() const { return uses_; }

private:
    // Members of a material that are texture references, those of its extensions included.
    void addTextures(const Json& json, const std::string& key)
    {
        if (!json.is_object()) return;
        if (member(json, "index").is_number_unsigned()) {
            const bool isColor = key == "baseColorTexture" || key == "emissiveTexture" || key == "diffuseTexture" ||
                                 key == "specularColorTexture" || key == "sheenColorTexture";
            add(json, isColor ? Use::Color : Use::Data);
        }
        for (const auto& [name, value] : json.items()) addTextures(value, name);
    }
    void add(const Json& reference, Use use)
    {
        const Json& index = member(reference, "index");
        if (!isIndexInto(document_, "textures", index)) return;
        const int image = pictureImage(document_, index.get<int>());
        if (image < 0 || std::size_t(image) >= uses_.size()) return;
        uses_[std::size_t(image)] = std::max(uses_[std::size_t(image)], use);
    }

    const Json& document_;
    std::vector<Use> uses_;
};

struct Picture {
    std::size_t image = 0;
    Use use = Use::None;
    std::vector<std::byte> before;
    std::vector<std::byte> after; // empty: stays
    std::string warning;
};

void encodePicture(Picture& picture, const OptimizeOptions& options)
{
    const auto image = decodeImage(picture.before.data(), picture.before.size());
    if (!image) {
        picture.warning = "image " + std::to_string(picture.image) + " stays as it is: " + image.error().message;
        return;
    }
    const int quality =
        picture.use == Use::Color ? options.textureQuality : std::max(options.textureQuality, kDataQuality);
    auto webp = picture.use == Use::Mask ? encodeWebpLossless(*image, true) : encodeWebp(*image, quality);
    if (!webp) {
        picture.warning = "image " + std::to_string(picture.image) + " stays as it is: " + webp.error().message;
    } else if (webp->size() < picture.before.size()) {
        picture.after = std::move(*webp);
    }
}

// Gives the image its new bytes, and its textures the extension that may name WebP.
void replace(DocumentPatcher& patcher, Picture& picture, int placeholder)
{
    Json& image = patcher.json["images"][picture.image];
    image.erase("uri");
    image["mimeType"] = "image/webp";
    image["bufferView"] = patcher.addView({std::move(picture.after), 0, 0});
    for (Json& texture : patcher.json["textures"]) {
        if (member(texture, "source") != Json(uint64_t(picture.image))) continue;
        texture.erase("source");
        texture["extensions"]["EXT_texture_webp"] = {{"source", picture.image}};
        if (picture.use == Use::Mask && placeholder >= 0) texture["source"] = placeholder;
    }
}

int placeholderOf(const Json& document)
{
    const Json& lightmaps = member(extensionOf(document, "HALFLIGHT_mixed_lighting"), "lightmaps");
    return lightmaps.empty() ? -1
                             : integerOf(element(document, "textures", integerOf(lightmaps[0], "index")), "source");
}

struct Lightmaps {
    std::vector<std::size_t> images;
    std::vector<Image<uint32_t>> pages;
};

// Lightmaps that are RGB9E5 in KTX2; others were made smaller before.
Result<Lightmaps> readLightmaps(const SourceDocument& source, const std::vector<Use>& uses, OptimizeReport& report)
{
    Lightmaps lightmaps;
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (uses[i] != Use::Lightmap) continue;
        const auto bytes = imageBytes(source, int(i));
        if (!bytes) return bytes.error();
        report.lightmaps.before += bytes->size();
        if (mimeTypeOf(*bytes) != "image/ktx2") continue;
        auto page = decodeKtx2(*bytes);
        if (!page) return Error{page.error().code, page.error().message, pathOf("images", i)};
        lightmaps.images.push_back(i);
        lightmaps.pages.push_back(std::move(*page));
    }
    return lightmaps;
}

void addError(const Lightmaps& lightmaps, std::size_t page, const Image<uint32_t>& smaller, OptimizeReport& report)
{
    const LightmapError error = lightmapError(smaller.texelCount(), texelsOf(lightmaps.pages[page]), texelsOf(smaller));
    report.lightmapError += error.mean / double(lightmaps.pages.size());
    report.lightmapErrorMost = std::max(report.lightmapErrorMost, error.most);
}

// The pages by a curve in lossless WebP.
Status toWebp(DocumentPatcher& patcher, const Lightmaps& lightmaps, OptimizeReport& report)
{
    const LightmapCurve curve = bestCurve(lightmaps.pages);
    for (std::size_t i = 0; i < lightmaps.pages.size(); ++i) {
        const ImageRgba8 image = encodeByCurve(lightmaps.pages[i], curve);
        auto webp = encodeWebpLossless(image, true);
        if (!webp) return webp.error();
        report.lightmaps.after += webp->size();
        addError(lightmaps, i, decodeByCurve(image, curve), report);
        Json& json = patcher.json["images"][lightmaps.images[i]];
        json["mimeType"] = "image/webp";
        json["bufferView"] = patcher.addView({std::move(*webp), 0, 0});
    }
    Json& root = patcher.json["extensions"]["HALFLIGHT_mixed_lighting"];
    root["lightmapEncoding"] = {{"scale", curve.scale}, {"exponent", curve.exponent}};
    for (const Json& reference : root["lightmaps"]) {
        Json& texture = patcher.json["textures"][reference["index"].get<std::size_t>()];
        texture["extensions"] = {{"EXT_texture_webp", texture["extensions"][kKtx2Extension]}};
    }
    // Reflection probes stay KTX2.
    const Json& textures = patcher.json["textures"];
    const bool stays = std::any_of(textures.begin(), textures.end(), [](const Json& texture) {
        return texture.contains("extensions") && texture["extensions"].contains(kKtx2Extension);
    });
    Json& used = patcher.json["extensionsUsed"];
    if (!stays) used.erase(std::remove(used.begin(), used.end(), Json(kKtx2Extension)), used.end());
    used.push_back("EXT_texture_webp");
    return {};
}

Status toFewerBits(DocumentPatcher& patcher, const Lightmaps& lightmaps, int bits, OptimizeReport& report)
{
    for (std::size_t i = 0; i < lightmaps.pages.size(); ++i) {
        Image<uint32_t> rounded = lightmaps.pages[i];
        roundMantissas(rounded, bits);
        addError(lightmaps, i, rounded, report);
        auto ktx2 = encodeKtx2(rounded, kZstdLevel);
        if (!ktx2) return ktx2.error();
        report.lightmaps.after += ktx2->size();
        patcher.json["images"][lightmaps.images[i]]["bufferView"] = patcher.addView({std::move(*ktx2), 0, 0});
    }
    return {};
}

Status optimizeLightmaps(DocumentPatcher& patcher, const SourceDocument& source, const std::vector<Use>& uses,
                         const OptimizeOptions& options, OptimizeReport& report)
{
    auto lightmaps = readLightmaps(source, uses, report);
    if (!lightmaps) return lightmaps.error();
    if (lightmaps->pages.empty()) {
        report.lightmaps.after = report.lightmaps.before;
        return {};
    }
    if (options.lightmapFormat == OptimizeOptions::LightmapFormat::Webp && decodesWebp())
        return toWebp(patcher, *lightmaps, report);
    return toFewerBits(patcher, *lightmaps, options.lightmapBits, report);
}

} // namespace

Status optimizePictures(DocumentPatcher& patcher, const SourceDocument& source, const OptimizeOptions& options,
                        OptimizeReport& report)
{
    const std::vector<Use> uses = ImageUses(source.json).uses();
    if (Status s = optimizeLightmaps(patcher, source, uses, options, report); !s) return s;
    std::vector<Picture> pictures;
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (uses[i] == Use::None || uses[i] == Use::Lightmap) continue;
        auto bytes = imageBytes(source, int(i));
        if (!bytes) return bytes.error();
        pictures.push_back({i, uses[i], std::move(*bytes), {}, {}});
    }
    if (decodesWebp() && options.textureQuality > 0) {
        parallelFor(pictures.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) encodePicture(pictures[i], options);
        });
    }
    bool anyOfMaterials = false;
    bool any = false;
    for (Picture& picture : pictures) {
        if (!picture.warning.empty()) report.warnings.push_back(picture.warning);
        OptimizeReport::Part& part = picture.use == Use::Mask ? report.masks : report.textures;
        part.before += picture.before.size();
        part.after += picture.after.empty() ? picture.before.size() : picture.after.size();
        if (picture.after.empty()) continue;
        any = true;
        anyOfMaterials = anyOfMaterials || picture.use != Use::Mask;
        replace(patcher, picture, placeholderOf(source.json));
    }
    if (any) patcher.json["extensionsUsed"].push_back("EXT_texture_webp");
    if (anyOfMaterials) patcher.json["extensionsRequired"].push_back("EXT_texture_webp");
    return {};
}

} // namespace halflight
