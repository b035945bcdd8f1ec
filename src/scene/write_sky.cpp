#include "scene/write_sky.h"

#include "halflight/base/hash.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/sky_picture.h"
#include "scene/bake_members.h"
#include "scene/ktx2.h"

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

std::string pictureHash(const ImageRgb32f& picture, float rotation)
{
    return Hasher().add(picture.size()).add(picture.texels()).add(rotation).hash().hex();
}

} // namespace

Result<WrittenSky> writeSky(PictureWriter& pictures, const Sky& sky, int width)
{
    WrittenSky written{colorsOf(sky), colorsOf(sky)};
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

bool skyDiffersFrom(const Sky& skyOfFile, const Json& atBake)
{
    if (!atBake.is_object()) return false;
    const auto differs = [&](const char* key, vec3 now) {
        vec3 then(0.0f);
        return readVector(member(atBake, key), then) &&
               glm::distance(now, then) > 1.0e-3f * std::max(glm::length(now), glm::length(then));
    };
    const Json& then = member(atBake, "picture");
    const std::string hash =
        skyOfFile.picture == nullptr ? "" : pictureHash(*skyOfFile.picture, skyOfFile.rotationRadians);
    return differs("zenith", skyOfFile.zenith) || differs("horizon", skyOfFile.horizon) ||
           differs("ground", skyOfFile.ground) || hash != (then.is_string() ? then.get<std::string>() : "");
}

} // namespace halflight
