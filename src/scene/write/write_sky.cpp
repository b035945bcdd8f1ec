#include "scene/write/write_sky.h"

#include "halflight/base/rgb9e5.h"
#include "halflight/scene/sky_picture.h"
#include "scene/format/bake_members.h"
#include "scene/format/sky_at_bake.h"
#include "scene/pictures/ktx2.h"

#include <algorithm>

namespace halflight {

namespace {

Json colorsOf(const Sky& sky)
{
    return {{"zenith", numbers(sky.zenith)}, {"horizon", numbers(sky.horizon)}, {"ground", numbers(sky.ground)}};
}

struct Page {
    Image<uint32_t> rgb9e5;
    float unitNits = 1.0f;
};

Page pageOf(const ImageRgb32f& picture, int width)
{
    const ImageRgb32f reduced = reducedSkyPicture(picture, width);
    const float unit = rgb9e5Unit(reduced);
    return {encodeRgb9e5(reduced, unit), unit};
}

} // namespace

Result<WrittenSky> writeSky(PictureWriter& pictures, const Sky& sky, int width)
{
    WrittenSky written{colorsOf(sky), colorsOf(sky)};
    if (!sky.group.empty()) written.record["group"] = sky.group;
    if (sky.changes) written.record["changes"] = true;
    if (sky.picture == nullptr) return written;
    const Page page = pageOf(*sky.picture, width);
    auto encoded = encodeKtx2(page.rgb9e5);
    if (!encoded) return encoded.error();
    written.bytes = encoded->size();
    Json& picture = written.record["picture"];
    picture = pictures.add("sky", std::move(*encoded), PictureWriter::Wrap::RepeatAcross);
    picture["unitNits"] = page.unitNits;
    picture["rotation"] = sky.rotationRadians;
    written.atBake["picture"] = pictureHash(decodeRgb9e5(page.rgb9e5, page.unitNits), sky.rotationRadians);
    return written;
}

} // namespace halflight
