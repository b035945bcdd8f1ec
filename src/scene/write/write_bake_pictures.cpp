#include "scene/write/write_bake_pictures.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/parallel.h"
#include "scene/pictures/ktx2.h"
#include "scene/pictures/lightmap_curve.h"
#include "scene/write/write_groups.h"
#include "scene/write/write_reflections.h"
#include "scene/write/write_sky.h"

#include <algorithm>
#include <array>
#include <functional>

namespace halflight {

namespace {

using Bytes = std::vector<std::byte>;

// One page, and how far its texels are off for a reader.
struct EncodedPage {
    Result<Bytes> bytes = Bytes();
    LightmapError error;
};

// `truth`: in units of the page.
EncodedPage encodePage(const Image<uint32_t>& page, const TexelOf& truth, LightmapFormat format,
                       const LightmapCurve& curve)
{
    const auto errorOf = [&](const TexelOf& seen) { return lightmapError(page.texelCount(), truth, seen); };
    switch (format) {
    case LightmapFormat::Half: {
        ImageRgb32f floats(page.width(), page.height());
        forEachIndex(floats.texelCount(), [&](std::size_t i) { floats.texels()[i] = truth(i); });
        const Image<uint64_t> half = halfTexels(floats);
        return {encodeKtx2(half), errorOf([&](std::size_t i) { return floatsOf(half.texels()[i]); })};
    }
    case LightmapFormat::Webp: {
        const ImageRgba8 image = encodeByCurve(page, curve);
        return {encodeWebpLossless(image), errorOf(texelsOf(decodeByCurve(image, curve)))};
    }
    case LightmapFormat::Rgb9e5:
        break;
    }
    return {encodeKtx2(page), errorOf(texelsOf(page))};
}

// In units of `unitLux`.
TexelOf truthOf(const Image<uint32_t>& page, float unitLux, const ImageRgb32f* irradiance)
{
    if (irradiance != nullptr) return [=](std::size_t i) { return irradiance->texels()[i] / unitLux; };
    return texelsOf(page);
}

// PNG, or lossless WebP where that is smaller.
Result<Bytes> encodeSmallest(const ImageRgba8& image)
{
    if (!decodesWebp()) return encodePng(image);
    std::array<Result<Bytes>, 2> encoded = {Bytes(), Bytes()};
    parallelFor(encoded.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) encoded[i] = i == 0 ? encodePng(image) : encodeWebpLossless(image);
    });
    auto& [png, webp] = encoded;
    if (!png || !webp) return png ? webp : png;
    return webp->size() < png->size() ? webp : png;
}

} // namespace

std::vector<Result<Bytes>> encodeMasks(const std::vector<ImageRgba8>& pages, const Progress& progress)
{
    std::vector<Result<Bytes>> encoded(pages.size(), Bytes());
    parallelFor(pages.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !progress.cancelled(); ++i)
            if (!pages[i].empty()) encoded[i] = encodeSmallest(pages[i]);
    });
    return encoded;
}

Status addMasks(PictureWriter& pictures, const char* key, const std::string& name, std::vector<Result<Bytes>> encoded,
                Json& root, uint64_t& bytes)
{
    for (std::size_t i = 0; i < encoded.size(); ++i) {
        if (!encoded[i]) return encoded[i].error();
        if (encoded[i]->empty()) { // a mask layer's page that is lit everywhere
            root[key].push_back(Json::object());
            continue;
        }
        bytes += encoded[i]->size();
        root[key].push_back(pictures.add(name + " " + std::to_string(i), std::move(*encoded[i])));
    }
    return {};
}

namespace {

/// All pictures of a bake but the sky's.
struct EncodedPictures {
    Result<EncodedLightmaps> lightmaps = EncodedLightmaps();
    std::vector<Result<Bytes>> directions;
    std::vector<Result<Bytes>> masks;
    Result<Bytes> reflections = Bytes();
    std::vector<EncodedGroup> groups;
};

/// At one time: each takes about a second for a page of 2048 x 2048 texels, on one thread.
EncodedPictures encodePictures(const BakedScene& baked, const WriteOptions& options)
{
    EncodedPictures encoded;
    const std::array<std::function<void()>, 5> works = {
        [&] { encoded.masks = encodeMasks(baked.shadowmasks, options.progress); },
        [&] { encoded.lightmaps = encodeLightmaps(baked, options); },
        [&] { encoded.directions = encodeMasks(baked.lightmapDirections, options.progress); },
        [&] {
            if (!baked.reflections.probes.empty()) encoded.reflections = encodeKtx2(baked.reflections.picture);
        },
        [&] { encoded.groups = encodeGroups(baked, options); }};
    parallelFor(works.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) works[i]();
    });
    return encoded;
}

} // namespace

Error writingCancelled()
{
    return {ErrorCode::Cancelled, "writing was cancelled", ""};
}

const char* nameOf(LightmapFormat format)
{
    constexpr const char* kNames[] = {"rgb9e5", "half", "webp"};
    return kNames[int(format)];
}

Result<EncodedLightmaps> encodeLightmaps(const BakedScene& baked, const WriteOptions& options)
{
    return encodePages(baked.lightmaps, baked.lightmapUnitLux, options.irradiance, options);
}

Result<EncodedLightmaps> encodePages(const std::vector<Image<uint32_t>>& pages, float unitLux,
                                     std::span<const ImageRgb32f> irradiance, const WriteOptions& options)
{
    const std::size_t count = pages.size();
    EncodedLightmaps result;
    result.pages.resize(count);
    result.written.resize(count);
    const bool isWebp = options.lightmapFormat == LightmapFormat::Webp;
    if (isWebp && !decodesWebp())
        return Error{ErrorCode::Unsupported, "lightmaps as WebP need a build with libwebp, and this one has none", ""};
    const LightmapCurve curve = isWebp ? bestCurve(pages) : LightmapCurve();
    if (isWebp && count > 0) result.encoding = {{"scale", curve.scale}, {"exponent", curve.exponent}};
    std::vector<Status> statuses(count);
    parallelFor(count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !options.progress.cancelled(); ++i) {
            if (pages[i].empty()) continue;
            const TexelOf truth = truthOf(pages[i], unitLux, irradiance.size() == count ? &irradiance[i] : nullptr);
            EncodedPage page = encodePage(pages[i], truth, options.lightmapFormat, curve);
            if (!page.bytes) {
                statuses[i] = page.bytes.error();
                continue;
            }
            result.written[i] = {page.bytes->size(), page.error.mean, page.error.most};
            result.pages[i] = std::move(*page.bytes);
        }
    });
    if (options.progress.cancelled()) return writingCancelled();
    const auto failed = std::find_if(statuses.begin(), statuses.end(), [](const Status& s) { return !s; });
    if (failed != statuses.end()) return failed->error();
    return result;
}

Status writeBakePictures(PictureWriter& pictures, const BakedScene& baked, const WriteOptions& options, Json& root,
                         WrittenBytes& written)
{
    EncodedPictures encoded = encodePictures(baked, options);
    if (options.progress.cancelled()) return writingCancelled();
    Result<EncodedLightmaps>& lightmaps = encoded.lightmaps;
    if (!lightmaps) return lightmaps.error();
    for (std::size_t i = 0; i < lightmaps->pages.size(); ++i) {
        written.lightmaps += lightmaps->pages[i].size();
        root["lightmaps"].push_back(pictures.add("lightmap " + std::to_string(i), std::move(lightmaps->pages[i])));
    }
    if (!lightmaps->encoding.is_null()) root["lightmapEncoding"] = lightmaps->encoding;
    written.lightmapFormat = options.lightmapFormat;
    written.lightmapPages = std::move(lightmaps->written);
    if (Status s = addMasks(pictures, "lightmapDirections", "lightmap directions", std::move(encoded.directions), root,
                            written.lightmapDirections);
        !s)
        return s;
    if (Status s = addMasks(pictures, "shadowmasks", "shadowmask", std::move(encoded.masks), root, written.shadowmasks);
        !s)
        return s;
    if (Status s = writeGroupPictures(pictures, baked, std::move(encoded.groups), root, written); !s) return s;
    auto sky = writeSky(pictures, baked.scene.sky, options.skyWidth);
    if (!sky) return sky.error();
    root["sky"] = std::move(sky->record);
    if (baked.isBaked) root["atBake"]["sky"] = std::move(sky->atBake);
    written.sky = sky->bytes;
    if (!encoded.reflections) return encoded.reflections.error();
    if (!baked.reflections.probes.empty()) {
        written.reflections = encoded.reflections->size();
        root["reflectionProbes"] =
            reflectionsJson(baked.reflections, pictures.add("reflection probes", std::move(*encoded.reflections)));
    }
    pictures.finish();
    return {};
}

} // namespace halflight
