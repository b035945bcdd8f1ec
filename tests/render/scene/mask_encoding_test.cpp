// Shadowmask channels that hold distances: the edge in the picture is where it is in the world, and a pixel wide.
#include "halflight/shading/mask.h"
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

namespace halflight::test::mask_encoding_test {
namespace {

constexpr ivec2 kSize{256, 144};
const vec3 kAlbedo(0.6f);
constexpr int kPage = 32; // 20 m: a texel is 62 cm, four times a pixel

/// Metres from an edge askew to the texels, above 0 in the light.
float distanceToEdge(vec2 p)
{
    return glm::dot(p - vec2(0.21f, 0.37f), glm::normalize(vec2(1.0f, 0.4f)));
}

class MaskEncoding : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, MaskEncoding, kBothPaths, pathNameOf);

TEST_P(MaskEncoding, DistancesGiveACrispEdgeS8)
{
    BakedScene baked;
    baked.isBaked = true;
    addObject(baked.scene, makeRectangle(20, 20, addMaterial(baked.scene, vec4(kAlbedo, 1.0f))), mat4(1.0f), true);
    baked.scene.objects[0].lightmap = {0, vec2(1.0f), vec2(0.0f)};
    baked.scene.objects[0].castShadows = false;
    baked.lightmaps.emplace_back(kPage, kPage, uint32_t(0));
    ImageRgba8 mask(kPage, kPage);
    for (int y = 0; y < kPage; ++y) {
        for (int x = 0; x < kPage; ++x) {
            const vec2 p = (vec2(x, y) + 0.5f) * (20.0f / kPage) - 10.0f;
            const float value = shading::encodeMaskDistance(distanceToEdge(p) * (kPage / 20.0f), 4.0f);
            // Channel 1 holds distances; 0 is attenuation and must stay what it is.
            mask(x, y) = u8vec4(51, uint8_t(value * 255.0f + 0.5f), 255, 255);
        }
    }
    baked.shadowmasks.push_back(mask);
    baked.maskChannels[1] = {4.0f, 0.0f};
    for (const int channel : {0, 1}) {
        Light light;
        light.type = LightType::Directional;
        light.worldFromLight = lightPose(vec3(0), vec3(0.1f, -1, 0.2f));
        light.intensity = channel == 0 ? 2.0f : 3.0f;
        bakeAsMixed(light, MixedLightingMode::Shadowmask, channel);
        baked.scene.lights.push_back(light);
    }
    const Camera camera = lookAt(vec3(0, 9, 0.01f), vec3(0, 0, 0), kPi / 3.0f);
    RenderSettings settings;
    settings.path = GetParam();
    settings.mode = RunMode::Shadowmask;
    settings.size = kSize;
    const RenderedFrame frame = render(baked, camera, settings);
    const float pixelMeters = 2.0f * 9.0f * std::tan(kPi / 6.0f) / float(kSize.y);
    int checked = 0;
    int onEdge = 0;
    for (int y = 2; y < kSize.y; y += 3) {
        for (int x = 2; x < kSize.x; x += 3) {
            const Ray ray = pixelRay(camera, kSize, {x, y});
            const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
            if (std::abs(point.position.x) > 9.5f || std::abs(point.position.z) > 9.5f) continue;
            const float distance = distanceToEdge({point.position.x, point.position.z});
            const auto expected = [&](float attenuation) {
                return directRadiance(point, baked.scene.lights[0], 51.0f / 255.0f) +
                       directRadiance(point, baked.scene.lights[1], attenuation);
            };
            const vec3 seen(frame.radiance(x, y));
            // Beyond a pixel's width all or nothing (a 1/255 step of the texels is 2 cm, a fifth of a pixel).
            if (std::abs(distance) > pixelMeters) {
                EXPECT_TRUE(near(seen, expected(distance > 0.0f ? 1.0f : 0.0f))) << x << ' ' << y << ' ' << distance;
                ++checked;
            } else {
                // Within, the share of the pixel that is lit; the pixel's footprint is known to some tenths.
                const float share = glm::clamp(0.5f + distance / pixelMeters, 0.0f, 1.0f);
                EXPECT_GE(seen.x, expected(std::max(share - 0.35f, 0.0f)).x * 0.999f);
                EXPECT_LE(seen.x, expected(std::min(share + 0.35f, 1.0f)).x * 1.001f);
                ++onEdge;
            }
        }
    }
    EXPECT_GT(checked, 3000);
    EXPECT_GT(onEdge, 10);
}

} // namespace
} // namespace halflight::test::mask_encoding_test
