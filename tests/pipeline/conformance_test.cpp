// The pack of assets/conformance: its pictures are what this renderer draws of its files (docs/conformance.md).

#include "halflight/base/image.h"
#include "halflight/render/compose.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace halflight::conformance_test {
namespace {

using Json = nlohmann::json;

const std::filesystem::path kFolder = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/conformance";

RunMode modeOf(const std::string& name)
{
    if (name == "realtime") return RunMode::Realtime;
    if (name == "baked-indirect") return RunMode::BakedIndirect;
    if (name == "shadowmask") return RunMode::Shadowmask;
    if (name == "distance-shadowmask") return RunMode::DistanceShadowmask;
    EXPECT_EQ(name, "subtractive");
    return RunMode::Subtractive;
}

/// How a picture compares, as docs/conformance.md says.
struct Comparison {
    double meanRelative = 0.0; ///< mean absolute difference of luminance over the mean luminance
    double shareWithin = 0.0;  ///< share of pixels within `pixelRelative`
};
Comparison compare(const ImageRgba32f& picture, const ImageRgba32f& expected, double pixelRelative)
{
    Comparison result;
    double sum = 0.0;
    double difference = 0.0;
    double within = 0.0;
    for (const vec4 c : expected.texels()) sum += double(luminance(vec3(c)));
    const double mean = sum / double(expected.texelCount());
    for (std::size_t i = 0; i < expected.texelCount(); ++i) {
        const double a = luminance(vec3(picture.texels()[i]));
        const double b = luminance(vec3(expected.texels()[i]));
        difference += std::abs(a - b);
        within += std::abs(a - b) <= pixelRelative * (b + 0.05 * mean) ? 1.0 : 0.0;
    }
    result.meanRelative = difference / sum;
    result.shareWithin = within / double(expected.texelCount());
    return result;
}

/// A file of the pack at the weights that an entry gives its light groups.
BakedScene sceneOf(const Json& entry)
{
    const std::string file = entry["file"];
    auto baked = readBakedScene(kFolder / file);
    EXPECT_TRUE(baked) << baked.error().text();
    std::vector<GroupWeight> changes;
    const Json groups = entry.value("groups", Json::object());
    for (const auto& [name, rgb] : groups.items()) changes.push_back({name, vec3(rgb[0], rgb[1], rgb[2])});
    const auto weights = groupWeights(*baked, changes);
    EXPECT_TRUE(weights) << weights.error().text();
    composeGroups(*baked, *weights);
    EXPECT_TRUE(baked->scene.warnings.empty()) << file << ": " << baked->scene.warnings[0];
    return std::move(*baked);
}

TEST(Conformance, PicturesAreDrawnFromTheFiles)
{
    std::ifstream stream(kFolder / "pictures.json");
    const Json index = Json::parse(stream);
    const Json& tolerances = index["tolerances"];
    auto renderer = Renderer::create({});
    ASSERT_TRUE(renderer) << renderer.error().text();
    std::string loaded;
    Scene scene;
    for (const Json& entry : index["pictures"]) {
        const std::string state = entry["file"].get<std::string>() + entry.value("groups", Json::object()).dump();
        if (state != loaded) {
            const BakedScene baked = sceneOf(entry);
            ASSERT_TRUE((*renderer)->load(baked));
            scene = baked.scene;
            loaded = state;
        }
        const std::string name = entry["picture"];
        const auto expected = readExr(kFolder / name);
        ASSERT_TRUE(expected) << expected.error().text();
        RenderSettings settings;
        settings.size = ivec2(index["size"][0].get<int>(), index["size"][1].get<int>());
        settings.mode = modeOf(entry["mode"]);
        settings.shadows.distanceMeters = entry["shadowDistance"];
        settings.shadows.fadeRangeMeters = entry["shadowFadeRange"];
        settings.shadows.penumbrae = false;
        const auto camera = std::find_if(scene.cameras.begin(), scene.cameras.end(),
                                         [&](const Camera& c) { return c.name == entry["camera"].get<std::string>(); });
        ASSERT_NE(camera, scene.cameras.end());
        const auto frame = (*renderer)->render(*camera, settings);
        ASSERT_TRUE(frame) << frame.error().text();
        const Comparison found = compare(frame->radiance, *expected, tolerances["pixelRelative"]);
        EXPECT_LE(found.meanRelative, tolerances["meanRelative"].get<double>()) << name;
        EXPECT_GE(found.shareWithin, tolerances["shareOfPixels"].get<double>()) << name;
    }
}

// A picture of another mode does not pass.
TEST(Conformance, AnotherModeFails)
{
    const auto shadowmask = readExr(kFolder / "avenue_main_shadowmask.exr");
    const auto realtime = readExr(kFolder / "avenue_main_realtime.exr");
    ASSERT_TRUE(shadowmask && realtime);
    const Comparison found = compare(*realtime, *shadowmask, 0.05);
    EXPECT_GT(found.meanRelative, 0.015);
    EXPECT_LT(found.shareWithin, 0.97);
}

} // namespace
} // namespace halflight::conformance_test
