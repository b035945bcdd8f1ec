// Blended surfaces keep back the share of light that their alpha says, in realtime shadow maps as in the bake (the
// bake's side: ShadowmaskS8.PanesDimEvenly; both in one picture: MixedPicture.BlendedShadowsDoNotPopS13).
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace halflight::test::blended_casters_test {
namespace {

constexpr ivec2 kSize{512, 288};
const vec3 kAlbedo(0.5f);

int addSheetMaterial(Scene& scene, float alpha)
{
    const int material = addMaterial(scene, vec4(kAlbedo, alpha));
    scene.materials[std::size_t(material)].alphaMode = Material::AlphaMode::Blend;
    scene.materials[std::size_t(material)].doubleSided = true;
    return material;
}

/// A floor, a light above it, and between them whatever a test adds. The camera looks at the floor below all that.
struct Stage {
    BakedScene baked;
    Camera camera = lookAt(vec3(0, 0.9f, 9), vec3(0, 0, 0), kPi / 5.0f);
    RenderSettings settings;

    explicit Stage(LightType type)
    {
        Scene& scene = baked.scene;
        addObject(scene, makeRectangle(40, 40, addMaterial(scene, vec4(kAlbedo, 1.0f))), mat4(1.0f), true);
        Light light;
        light.type = type;
        light.worldFromLight = lightPose(vec3(0.3f, 6, 0.2f), vec3(0.05f, -1, 0.03f));
        light.intensity = 50.0f;
        light.rangeMeters = type == LightType::Directional ? 0.0f : 30.0f;
        light.innerConeRadians = 0.7f;
        light.outerConeRadians = 0.8f;
        scene.lights.push_back(light);
        settings.mode = RunMode::Realtime;
        settings.size = kSize;
        settings.shadows.directionalMapSize = 1024;
        settings.shadows.atlasSize = 2048;
    }
    void addSheet(float height, int material)
    {
        addObject(baked.scene, makeRectangle(8, 8, material), glm::translate(mat4(1.0f), vec3(0, height, 0)), true);
    }
};

/// What of the light arrives at the middle of the floor: mean, and standard deviation from pixel to pixel.
struct Arriving {
    double mean = 0.0;
    double deviation = 0.0;
};

class BlendedCasters : public RenderTest, public testing::WithParamInterface<LightType> {
protected:
    Arriving arriving(Stage& stage)
    {
        const RenderedFrame shadowed = render(stage.baked, stage.camera, stage.settings);
        for (const FrameLight& light : shadowed.plan.lights) EXPECT_TRUE(light.hasRealtimeShadow);
        BakedScene lit = stage.baked;
        for (Object& object : lit.scene.objects) object.castShadows = false;
        const RenderedFrame unshadowed = render(lit, stage.camera, stage.settings);
        double sum = 0.0;
        double squares = 0.0;
        int count = 0;
        const ivec2 low = pixelOf(stage.camera, kSize, vec3(-2.0f, 0, -2.0f));
        const ivec2 high = pixelOf(stage.camera, kSize, vec3(2.0f, 0, 2.0f));
        for (int y = low.y; y <= high.y; ++y) {
            for (int x = low.x; x <= high.x; ++x) {
                const double share = double(shadowed.radiance(x, y).x) / double(unshadowed.radiance(x, y).x);
                sum += share;
                squares += share * share;
                ++count;
            }
        }
        EXPECT_GT(count, 500);
        const double mean = sum / count;
        return {mean, std::sqrt(std::max(squares / count - mean * mean, 0.0))};
    }
};
INSTANTIATE_TEST_SUITE_P(S2S3S4, BlendedCasters,
                         testing::Values(LightType::Directional, LightType::Spot, LightType::Point),
                         [](const auto& info) { return std::string(nameOf(info.param)); });

TEST_P(BlendedCasters, OneSheetKeepsBackItsAlpha)
{
    for (const float alpha : {0.0f, 0.04f, 0.25f, 0.4f, 0.5f, 0.75f, 1.0f}) {
        Stage stage(GetParam());
        stage.addSheet(1.5f, addSheetMaterial(stage.baked.scene, alpha));
        const Arriving a = arriving(stage);
        EXPECT_NEAR(a.mean, 1.0 - double(alpha), 0.015) << alpha;
        EXPECT_LT(a.deviation, 0.1) << alpha << ": white noise would leave 0.15 of a half covered texel";
    }
}

TEST_P(BlendedCasters, EachFilterHasTheSameMean)
{
    for (const ShadowFilter filter : {ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft}) {
        Stage stage(GetParam());
        stage.settings.shadows.filter = filter;
        stage.addSheet(1.5f, addSheetMaterial(stage.baked.scene, 0.3f));
        const Arriving a = arriving(stage);
        EXPECT_NEAR(a.mean, 0.7, 0.02) << int(filter);
        if (filter == ShadowFilter::Soft) {
            EXPECT_LT(a.deviation, 0.03);
        }
    }
}

// Light passes two sheets as it would pass two independent ones, and both faces of a closed pane.
TEST_P(BlendedCasters, SheetsMultiply)
{
    for (const float alpha : {0.25f, 0.5f}) {
        Stage two(GetParam());
        two.addSheet(1.5f, addSheetMaterial(two.baked.scene, alpha));
        two.addSheet(2.0f, addSheetMaterial(two.baked.scene, 0.5f));
        EXPECT_NEAR(arriving(two).mean, (1.0 - double(alpha)) * 0.5, 0.03) << alpha;

        Stage pane(GetParam());
        Mesh mesh = makeRectangle(8, 8, addSheetMaterial(pane.baked.scene, alpha));
        MeshPart& part = mesh.parts[0];
        const auto corners = uint32_t(part.positions.size());
        for (uint32_t i = 0; i < corners; ++i) { // the lower face, which looks down
            part.positions.push_back(part.positions[i] - vec3(0, 0.2f, 0));
            part.normals.push_back(-part.normals[i]);
            part.uv[0].push_back(part.uv[0][i]);
            part.lightmapUv.push_back(part.lightmapUv[i]);
            if (!part.tangents.empty()) part.tangents.push_back(part.tangents[i]);
            if (!part.uv[1].empty()) part.uv[1].push_back(part.uv[1][i]);
            if (!part.colors.empty()) part.colors.push_back(part.colors[i]);
        }
        const std::vector<uint32_t> upper = part.indices;
        for (std::size_t i = 0; i < upper.size(); i += 3)
            for (const std::size_t k : {0u, 2u, 1u}) part.indices.push_back(upper[i + k] + corners);
        addObject(pane.baked.scene, std::move(mesh), glm::translate(mat4(1.0f), vec3(0, 1.7f, 0)), true);
        EXPECT_NEAR(arriving(pane).mean, std::pow(1.0 - double(alpha), 2.0), 0.03) << alpha;
    }
}

// The pattern rests in the world while the camera moves, by no whole number of texels.
TEST_F(RenderTest, BlendedShadowsRestUnderMotionS2)
{
    Stage stage(LightType::Directional);
    stage.addSheet(1.5f, addSheetMaterial(stage.baked.scene, 0.45f));
    stage.settings.shadows.directionalMapSize = 256;
    stage.settings.shadows.cascades = 1;
    stage.settings.shadows.distanceMeters = 15.0f;
    stage.camera.orthographic = true;
    stage.camera.orthographicHeightMeters = 2.88f;
    stage.camera.nearMeters = 0.05f;
    stage.camera.farMeters = 30.0f;
    constexpr int kStep = 37; // pixels of a centimetre
    const RenderedFrame before = render(stage.baked, stage.camera, stage.settings);
    stage.camera.worldFromCamera[3] += 0.01f * float(kStep) * stage.camera.worldFromCamera[0];
    const RenderedFrame after = render(stage.baked, stage.camera, stage.settings);
    double difference = 0.0;
    double spread = 0.0;
    double sum = 0.0;
    int count = 0;
    for (int y = 20; y < kSize.y - 20; ++y) {
        for (int x = 20; x + kStep < kSize.x - 20; ++x) {
            const auto a = double(before.radiance(x + kStep, y).x);
            difference += std::abs(double(after.radiance(x, y).x) - a);
            spread += std::abs(a - double(before.radiance(x, y).x));
            sum += a;
            ++count;
        }
    }
    ASSERT_GT(sum / count, 0.0);
    EXPECT_GT(spread, 0.02 * sum) << "there is a pattern to rest";
    EXPECT_LT(difference, 0.1 * spread);
}

} // namespace
} // namespace halflight::test::blended_casters_test
