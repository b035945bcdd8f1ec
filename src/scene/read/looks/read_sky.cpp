#include "scene/read/looks/read_sky.h"

#include "halflight/base/rgb9e5.h"
#include "halflight/scene/light_groups.h"
#include "halflight/scene/sky_picture.h"
#include "scene/format/bake_members.h"
#include "scene/pictures/ktx2.h"
#include "scene/read/looks/read_pictures.h"

#include <cmath>
#include <string>

namespace halflight {

namespace {

const std::string kSkyPath = kBakePath + "/sky/picture";

const Json& recordOf(const SourceDocument& document)
{
    return member(extensionOf(document.json, "HALFLIGHT_mixed_lighting"), "sky");
}

float numberOr(const Json& json, float otherwise)
{
    return json.is_number() ? json.get<float>() : otherwise;
}

Result<ImageRgb32f> pictureOfBake(const SourceDocument& document, const Json& record)
{
    const float unit = numberOr(member(record, "unitNits"), 0.0f);
    if (!(unit > 0.0f) || !std::isfinite(unit)) return invalid(kSkyPath, "unitNits is not a number above 0");
    const auto bytes = pictureBytes(document, record, kSkyPath);
    if (!bytes) return bytes.error();
    const auto page = decodeKtx2(*bytes);
    if (!page) return Error{page.error().code, page.error().message, kSkyPath};
    if (page->empty() || int64_t(page->texelCount()) > kMostSkyPictureTexels)
        return invalid(kSkyPath, "has no texels, or more than a sky's picture may have");
    ImageRgb32f picture = decodeRgb9e5(*page, unit);
    return picture.width() > kMostSkyTexels ? reducedSkyPicture(picture, kMostSkyTexels) : std::move(picture);
}

} // namespace

SceneSettings recordedSky(const SourceDocument& document)
{
    SceneSettings record;
    const Json& sky = recordOf(document);
    if (!sky.is_object()) return record;
    const auto color = [&](const char* key) -> std::optional<vec3> {
        vec3 c(0.0f);
        return readVector(member(sky, key), c) ? std::optional(c) : std::nullopt;
    };
    record.skyZenith = color("zenith");
    record.skyHorizon = color("horizon");
    record.skyGround = color("ground");
    record.skyOfBake = member(sky, "picture").is_object();
    if (std::string group = stringOf(sky, "group"); isGroupName(group)) record.skyGroup = std::move(group);
    if (const Json& changes = member(sky, "changes"); changes.is_boolean()) record.skyChanges = changes.get<bool>();
    return record;
}

Result<Sky> readSky(const SourceDocument& document, const SceneSettings& settings, std::vector<std::string>& warnings)
{
    const vec3 black(0.0f);
    Sky sky{settings.skyZenith.value_or(black), settings.skyHorizon.value_or(black),
            settings.skyGround.value_or(black)};
    for (const char* color : {"zenith", "horizon", "ground"}) {
        if (recordOf(document).is_object() && !recordOf(document).contains(color))
            return invalid(kBakePath + "/sky", std::string(color) + " is missing");
    }
    const float intensity = settings.skyIntensity.value_or(1.0f);
    std::optional<float> rotation;
    if (settings.skyRotationDegrees) rotation = glm::radians(*settings.skyRotationDegrees);
    if (!settings.skyImage && !settings.skyOfBake) {
        if (rotation || settings.skyIntensity)
            warnings.emplace_back(
                "the sky has a rotation or an intensity, which only an image has: they have no effect");
        return sky;
    }
    const Json& record = member(recordOf(document), "picture");
    auto read = settings.skyImage ? readSkyPicture(*settings.skyImage, &warnings) : pictureOfBake(document, record);
    if (!read) return read.error();
    if (settings.skyIntensity) {
        for (vec3& texel : read->texels()) texel *= intensity;
    }
    auto picture = std::make_shared<const ImageRgb32f>(std::move(*read));
    if (settings.skyImage || settings.skyIntensity) {
        sky.setPicture(std::move(picture), rotation.value_or(0.0f));
    } else { // the gradient is as the bake recorded it
        sky.picture = std::move(picture);
    }
    if (!settings.skyImage) {
        sky.pictureOfBake = true;
        sky.rotationRadians = rotation.value_or(numberOr(member(record, "rotation"), 0.0f));
        if (!std::isfinite(sky.rotationRadians)) return invalid(kSkyPath, "rotation is not a finite number");
    }
    return sky;
}

} // namespace halflight
