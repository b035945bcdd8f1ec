#include "scene/write/write_groups.h"

#include "halflight/base/encoded_image.h"
#include "scene/pictures/ktx2.h"
#include "scene/write/write_bake_pictures.h"
#include "scene/write/write_reflections.h"

namespace halflight {
namespace {

Status writeGroup(PictureWriter& pictures, const BakedGroup& group, std::span<const ImageRgb32f> irradiance,
                  const WriteOptions& options, Json& record, uint64_t& bytes)
{
    record = {{"name", group.name}, {"weight", numbers(group.weight)}, {"peak", group.peakLux}};
    if (group.sky) record["sky"] = true;
    if (group.shadowColor != vec3(0.0f)) record["shadowColor"] = numbers(group.shadowColor);
    if (group.unitLux != 1.0f) record["lightmapUnitLux"] = group.unitLux;
    // Reflected light varies little from texel to texel: its own curve holds it in a third of the bytes.
    WriteOptions own = options;
    if (!group.direct && options.lightmapFormat == LightmapFormat::Rgb9e5 && decodesWebp())
        own.lightmapFormat = LightmapFormat::Webp;
    Result<EncodedLightmaps> encoded = encodePages(group.lightmaps, group.unitLux, irradiance, own);
    if (!encoded) return encoded.error();
    std::vector<Result<std::vector<std::byte>>> pages;
    for (std::vector<std::byte>& page : encoded->pages) pages.emplace_back(std::move(page));
    const std::string name = "lightmap of " + group.name;
    if (Status s = addMasks(pictures, "lightmaps", name, std::move(pages), record, bytes); !s) return s;
    if (!encoded->encoding.is_null()) record["lightmapEncoding"] = encoded->encoding;
    if (Status s = addMasks(pictures, "lightmapDirections", "directions of " + group.name,
                            encodeMasks(group.directions, options.progress), record, bytes);
        !s)
        return s;
    if (group.reflections.size == 0) return {};
    auto reflections = encodeKtx2(group.reflections.picture);
    if (!reflections) return reflections.error();
    bytes += reflections->size();
    record["reflections"] =
        reflectionsJson(group.reflections, pictures.add("reflections of " + group.name, std::move(*reflections)));
    return {};
}

} // namespace

Status writeGroupPictures(PictureWriter& pictures, const BakedScene& baked, const WriteOptions& options, Json& root,
                          WrittenBytes& written)
{
    written.groups.assign(baked.groups.size(), 0);
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const bool known = options.groupIrradiance.size() == baked.groups.size();
        const std::span<const ImageRgb32f> irradiance =
            known ? std::span<const ImageRgb32f>(options.groupIrradiance[g]) : std::span<const ImageRgb32f>();
        Json record;
        if (Status s = writeGroup(pictures, baked.groups[g], irradiance, options, record, written.groups[g]); !s)
            return s;
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
