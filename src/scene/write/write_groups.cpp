#include "scene/write/write_groups.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/parallel.h"
#include "scene/pictures/ktx2.h"
#include "scene/write/write_reflections.h"

namespace halflight {
namespace {

EncodedGroup encodeGroup(const BakedGroup& group, std::span<const ImageRgb32f> irradiance, const WriteOptions& options)
{
    // Reflected light varies little from texel to texel: its own curve holds it in a third of the bytes.
    WriteOptions own = options;
    if (!group.direct && options.lightmapFormat == LightmapFormat::Rgb9e5 && decodesWebp())
        own.lightmapFormat = LightmapFormat::Webp;
    EncodedGroup encoded;
    encoded.lightmaps = encodePages(group.lightmaps, group.unitLux, irradiance, own);
    encoded.directions = encodeMasks(group.directions, options.progress);
    if (group.reflections.size > 0) encoded.reflections = encodeKtx2(group.reflections.picture);
    return encoded;
}

Status writeGroup(PictureWriter& pictures, const BakedGroup& group, EncodedGroup& encoded, Json& record,
                  uint64_t& bytes)
{
    record = {{"name", group.name}, {"weight", numbers(group.weight)}, {"peak", group.peakLux}};
    if (group.sky) record["sky"] = true;
    if (group.shadowColor != vec3(0.0f)) record["shadowColor"] = numbers(group.shadowColor);
    if (group.unitLux != 1.0f) record["lightmapUnitLux"] = group.unitLux;
    if (!encoded.lightmaps) return encoded.lightmaps.error();
    std::vector<Result<std::vector<std::byte>>> pages;
    for (std::vector<std::byte>& page : encoded.lightmaps->pages) pages.emplace_back(std::move(page));
    const std::string name = "lightmap of " + group.name;
    if (Status s = addMasks(pictures, "lightmaps", name, std::move(pages), record, bytes); !s) return s;
    if (!encoded.lightmaps->encoding.is_null()) record["lightmapEncoding"] = encoded.lightmaps->encoding;
    if (Status s = addMasks(pictures, "lightmapDirections", "directions of " + group.name,
                            std::move(encoded.directions), record, bytes);
        !s)
        return s;
    if (group.reflections.size == 0) return {};
    if (!encoded.reflections) return encoded.reflections.error();
    bytes += encoded.reflections->size();
    record["reflections"] = reflectionsJson(
        group.reflections, pictures.add("reflections of " + group.name, std::move(*encoded.reflections)));
    return {};
}

} // namespace

std::vector<EncodedGroup> encodeGroups(const BakedScene& baked, const WriteOptions& options)
{
    const bool known = options.groupIrradiance.size() == baked.groups.size();
    std::vector<EncodedGroup> encoded(baked.groups.size());
    parallelFor(encoded.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end && !options.progress.cancelled(); ++g) {
            const std::span<const ImageRgb32f> irradiance =
                known ? std::span<const ImageRgb32f>(options.groupIrradiance[g]) : std::span<const ImageRgb32f>();
            encoded[g] = encodeGroup(baked.groups[g], irradiance, options);
        }
    });
    return encoded;
}

Status writeGroupPictures(PictureWriter& pictures, const BakedScene& baked, std::vector<EncodedGroup> encoded,
                          Json& root, WrittenBytes& written)
{
    written.groups.assign(baked.groups.size(), 0);
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        Json record;
        if (Status s = writeGroup(pictures, baked.groups[g], encoded[g], record, written.groups[g]); !s) return s;
        root["groups"].push_back(std::move(record));
    }
    return {};
}

void writeGroupProbes(DocumentPatcher& patcher, const BakedScene& baked, Json& root, WrittenBytes& written)
{
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        if (baked.groups[g].radiance.empty()) continue;
        std::vector<vec3> radiance;
        for (const SphericalHarmonicsL2& probe : baked.groups[g].radiance)
            radiance.insert(radiance.end(), probe.begin(), probe.end());
        NewView view{bytesOf(radiance)};
        written.groups[g] += view.bytes.size();
        root["groups"][g]["radiance"] = patcher.addAccessor(
            {{"componentType", gltf::kFloat}, {"count", radiance.size()}, {"type", "VEC3"}}, std::move(view));
    }
}

} // namespace halflight
