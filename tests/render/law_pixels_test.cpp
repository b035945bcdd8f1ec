// A rendered pixel equals the law's value: a floor in four columns (lit; in static shadow; in dynamic shadow; in both),
// seen near, within the fade, and beyond the shadow distance, in every mode, forward and deferred (S26).
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <array>

namespace halflight::test {
namespace {

constexpr ivec2 kSize{384, 216};
constexpr float kShadowDistance = 30.0f;
constexpr float kFadeRange = 10.0f;
constexpr float kSunLux = 3.0f;
constexpr float kBakedShadow = 0.2f; // 51 / 255 exactly: a baked penumbra, so that min and lerp differ
constexpr std::array<float, 4> kColumns{-6.0f, -2.0f, 2.0f, 6.0f};
constexpr std::array<const char*, 4> kColumnNames{"lit", "static shadow", "dynamic shadow", "both shadows"};
constexpr std::array<float, 3> kDepths{-12.0f, -24.0f, -40.0f}; // near, inside the fade, beyond
const vec3 kToSun = glm::normalize(vec3(0.2f, 1.0f, 0.1f));
const vec3 kAlbedo(0.8f, 0.5f, 0.25f);

constexpr bool inStaticShadow(int column)
{
    return column == 1 || column == 3;
}
constexpr bool inDynamicShadow(int column)
{
    return column >= 2;
}

/// Lightmap of a column: values that RGB9E5 holds exactly.
vec3 lightmapOf(int column)
{
    return inStaticShadow(column) ? vec3(0.5f, 0.375f, 0.25f) : vec3(2.0f, 1.5f, 1.0f);
}

MixedLightingMode bakeModeFor(RunMode mode)
{
    if (mode == RunMode::Subtractive) return MixedLightingMode::Subtractive;
    if (mode == RunMode::BakedIndirect) return MixedLightingMode::BakedIndirect;
    return MixedLightingMode::Shadowmask;
}

Camera makeCamera()
{
    return lookAt(vec3(0, 4, 0), vec3(0, 2, -12), kPi / 3.0f);
}

struct LawScene {
    BakedScene baked;
    int floor = -1;
    std::vector<int> blockers;
};

/// The floor's page holds it in its middle half, so that scale and offset count; the rest has other values.
LawScene makeScene(MixedLightingMode bakeMode)
{
    LawScene result;
    BakedScene& baked = result.baked;
    Scene& scene = baked.scene;
    baked.isBaked = true;
    baked.mode = bakeMode;
    const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
    result.floor =
        addObject(scene, makeRectangle(16.0f, 100.0f, material), glm::translate(mat4(1.0f), vec3(0, 0, -50)), true);
    scene.objects[0].lightmap = {0, vec2(0.5f), vec2(0.25f)};

    // Slabs along each column, off the camera's line to the floor.
    for (int column = 0; column < 4; ++column) {
        for (const bool isStatic : {true, false}) {
            if (!(isStatic ? inStaticShadow(column) : inDynamicShadow(column))) continue;
            const float height = isStatic ? 9.0f : 7.0f;
            const vec3 center = vec3(kColumns[std::size_t(column)], 0, -50) + kToSun * (height / kToSun.y);
            result.blockers.push_back(
                addObject(scene, makeRectangle(3.0f, 110.0f, material), glm::translate(mat4(1.0f), center), isStatic));
        }
    }
    Light sun = directionalLight(kToSun, kSunLux);
    bakeAsMixed(sun, bakeMode, bakeMode == MixedLightingMode::BakedIndirect ? -1 : 0);
    scene.lights.push_back(sun);

    constexpr int kPage = 128;
    Image<uint32_t> lightmap(kPage, kPage, glm::packF3x9_E1x5(vec3(64.0f)));
    ImageRgba8 mask(kPage, kPage, u8vec4(128));
    for (int y = kPage / 4 - 1; y <= kPage * 3 / 4; ++y) {
        for (int x = kPage / 4 - 1; x <= kPage * 3 / 4; ++x) {
            const int column = glm::clamp((x - kPage / 4) / (kPage / 8), 0, 3);
            lightmap(x, y) = glm::packF3x9_E1x5(lightmapOf(column));
            mask(x, y) = u8vec4(inStaticShadow(column) ? 51 : 255, 255, 255, 255);
        }
    }
    baked.lightmaps.push_back(lightmap);
    if (bakeMode == MixedLightingMode::Shadowmask) baked.shadowmasks.push_back(mask);
    // Subtractive keeps channel 0 for probes; pages exist so that the file counts as whole.
    if (bakeMode == MixedLightingMode::Subtractive) baked.shadowmasks.push_back(mask);
    return result;
}

RenderSettings settingsFor(RunMode mode, RenderPath path = RenderPath::Forward)
{
    RenderSettings settings;
    settings.mode = mode;
    settings.path = path;
    settings.size = kSize;
    settings.shadows.distanceMeters = kShadowDistance;
    settings.shadows.fadeRangeMeters = kFadeRange;
    settings.shadows.directionalMapSize = 1024;
    return settings;
}

/// A floor point of each column and depth, where a pixel's ray meets it.
struct Site {
    int column;
    int band;
    ivec2 pixel;
    ShadedPoint point;
    float fade;
};

std::vector<Site> sites()
{
    const Camera camera = makeCamera();
    std::vector<Site> result;
    for (int column = 0; column < 4; ++column) {
        for (int band = 0; band < 3; ++band) {
            Site site{column, band, {}, {}, 0.0f};
            site.pixel = pixelOf(camera, kSize, vec3(kColumns[std::size_t(column)], 0, kDepths[std::size_t(band)]));
            const Ray ray = pixelRay(camera, kSize, site.pixel);
            site.point.position = onPlane(ray, 0.0f);
            site.point.view = -ray.direction;
            site.point.baseColor = kAlbedo;
            const float distance = glm::distance(ray.origin, site.point.position);
            site.fade = glm::clamp((distance - kShadowDistance) / kFadeRange + 1.0f, 0.0f, 1.0f);
            EXPECT_TRUE(band == 0   ? site.fade == 0.0f
                        : band == 1 ? site.fade > 0.1f && site.fade < 0.9f
                                    : site.fade == 1.0f);
            result.push_back(site);
        }
    }
    return result;
}

/// Rasterizers snap corners to 1/256 pixel, which moves a fragment by millimetres here, and t with it.
constexpr float kAbsolute = 2.0e-4f;

/// R by geometry: which slabs are in the sun's shadow map in this mode (spec section 2, last paragraph of the law).
float realtimeOf(RunMode mode, int column)
{
    const bool dynamicOnly = mode == RunMode::Shadowmask || mode == RunMode::Subtractive;
    return inDynamicShadow(column) || (!dynamicOnly && inStaticShadow(column)) ? 0.0f : 1.0f;
}

class LawPixels : public RenderTest, public testing::WithParamInterface<std::tuple<RunMode, float, RenderPath>> {};

TEST_P(LawPixels, StaticReceiver)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    Scene& scene = law.baked.scene;
    scene.lights[0].shadowStrength = strength;
    scene.subtractiveShadowColor = vec3(0.25f, 0.5f, 0.25f);
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));

    for (const Site& site : sites()) {
        const float realtime = realtimeOf(mode, site.column);
        const float faded = glm::mix(realtime, 1.0f, site.fade);
        vec3 expected(0.0f);
        if (mode == RunMode::Subtractive) {
            const vec3 main = vec3(kSunLux * kToSun.y);
            expected =
                indirectRadiance(site.point, shading::subtractiveIrradiance(lightmapOf(site.column), main, faded,
                                                                            scene.subtractiveShadowColor, strength));
        } else {
            const bool masked = mode == RunMode::Shadowmask || mode == RunMode::DistanceShadowmask;
            const float baked = inStaticShadow(site.column) ? kBakedShadow : 1.0f;
            const float attenuation =
                shading::mixShadows(int(mode), masked, baked, true, realtime, site.fade, strength);
            expected = directRadiance(site.point, scene.lights[0], attenuation);
            if (mode != RunMode::Realtime) expected += indirectRadiance(site.point, lightmapOf(site.column));
        }
        EXPECT_TRUE(near(vec3(frame.radiance(site.pixel.x, site.pixel.y)), expected, 1.0e-3f, kAbsolute))
            << kColumnNames[std::size_t(site.column)] << ", t = " << site.fade;
    }
}

class LightmapUnitS6 : public BothPaths {};

// A file whose texels are in another unit shows the same picture, bit for bit where the unit is a power of two.
TEST_P(LightmapUnitS6, ScalesTheLightmapAndNothingElse)
{
    for (const RunMode mode : {RunMode::BakedIndirect, RunMode::Subtractive}) {
        LawScene law = makeScene(bakeModeFor(mode));
        const RenderedFrame lux = render(law.baked, makeCamera(), settingsFor(mode, GetParam()));
        for (uint32_t& texel : law.baked.lightmaps[0].texels())
            texel = glm::packF3x9_E1x5(glm::unpackF3x9_E1x5(texel) / 16.0f);
        law.baked.lightmapUnitLux = 16.0f;
        const RenderedFrame scaled = render(law.baked, makeCamera(), settingsFor(mode, GetParam()));
        EXPECT_EQ(lux.radiance.texels(), scaled.radiance.texels());
    }
}
INSTANTIATE_TEST_SUITE_P(Paths, LightmapUnitS6, kBothPaths, pathNameOf);

constexpr float kProbeOcclusion = 0.4f;
const vec3 kProbeRadiance(0.25f, 0.5f, 0.75f);

TEST_P(LawPixels, DynamicReceiverReadsItsProbe)
{
    const auto [mode, strength, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    Scene& scene = law.baked.scene;
    scene.lights[0].shadowStrength = strength;
    scene.objects[std::size_t(law.floor)].isStatic = false;
    Probe probe;
    probe.radiance[0] = kProbeRadiance / 0.282094792f; // the same from everywhere
    probe.occlusion = vec4(kProbeOcclusion, 1, 1, 1);
    law.baked.probes.probes = {probe};
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));

    for (const Site& site : sites()) {
        const bool masked = mode != RunMode::Realtime && mode != RunMode::BakedIndirect;
        const float attenuation = shading::mixShadows(int(mode), masked, kProbeOcclusion, true,
                                                      realtimeOf(mode, site.column), site.fade, strength);
        vec3 expected = directRadiance(site.point, scene.lights[0], attenuation);
        if (mode != RunMode::Realtime) expected += indirectRadiance(site.point, kProbeRadiance * kPi);
        EXPECT_TRUE(near(vec3(frame.radiance(site.pixel.x, site.pixel.y)), expected, 1.0e-3f, kAbsolute))
            << kColumnNames[std::size_t(site.column)] << ", t = " << site.fade;
    }
}

std::string parameterName(const testing::TestParamInfo<std::tuple<RunMode, float, RenderPath>>& info)
{
    const char* names[] = {"Realtime", "BakedIndirect", "Shadowmask", "DistanceShadowmask", "Subtractive"};
    return std::string(names[int(std::get<0>(info.param))]) + (std::get<1>(info.param) < 1.0f ? "Strength" : "Full") +
           pathName(std::get<2>(info.param));
}

INSTANTIATE_TEST_SUITE_P(S1S7S12S13S20toS25, LawPixels,
                         testing::Combine(testing::Values(RunMode::Realtime, RunMode::BakedIndirect,
                                                          RunMode::Shadowmask, RunMode::DistanceShadowmask,
                                                          RunMode::Subtractive),
                                          testing::Values(1.0f, 0.6f), kBothPaths),
                         parameterName);

class OnlyBakedShadowsS19 : public RenderTest, public testing::WithParamInterface<std::tuple<RunMode, RenderPath>> {};

// No caster in view: the sun has no shadow map, and the mask holds at every distance.
TEST_P(OnlyBakedShadowsS19, MaskStaysWithoutCasters)
{
    const auto [mode, path] = GetParam();
    LawScene law = makeScene(MixedLightingMode::Shadowmask);
    Scene& scene = law.baked.scene;
    for (Object& object : scene.objects) object.castShadows = false;
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    for (const FrameLight& light : frame.plan.lights) EXPECT_FALSE(light.hasRealtimeShadow);
    for (const Site& site : sites()) {
        const vec3 expected =
            directRadiance(site.point, scene.lights[0], inStaticShadow(site.column) ? kBakedShadow : 1.0f) +
            indirectRadiance(site.point, lightmapOf(site.column));
        EXPECT_TRUE(near(vec3(frame.radiance(site.pixel.x, site.pixel.y)), expected))
            << site.column << ' ' << site.band;
    }
}
INSTANTIATE_TEST_SUITE_P(, OnlyBakedShadowsS19,
                         testing::Combine(testing::Values(RunMode::Shadowmask, RunMode::DistanceShadowmask),
                                          kBothPaths));

class ReceiveShadowsS30 : public RenderTest, public testing::WithParamInterface<std::tuple<RunMode, RenderPath>> {};

TEST_P(ReceiveShadowsS30, OffMeansNeitherRealtimeNorBaked)
{
    const auto [mode, path] = GetParam();
    LawScene law = makeScene(bakeModeFor(mode));
    Scene& scene = law.baked.scene;
    scene.objects[std::size_t(law.floor)].receiveShadows = false;
    const RenderedFrame frame = render(law.baked, makeCamera(), settingsFor(mode, path));
    for (const Site& site : sites()) {
        vec3 expected = indirectRadiance(site.point, lightmapOf(site.column));
        if (mode != RunMode::Subtractive) expected += directRadiance(site.point, scene.lights[0], 1.0f);
        EXPECT_TRUE(near(vec3(frame.radiance(site.pixel.x, site.pixel.y)), expected))
            << site.column << ' ' << site.band;
    }
}
INSTANTIATE_TEST_SUITE_P(, ReceiveShadowsS30,
                         testing::Combine(testing::Values(RunMode::Shadowmask, RunMode::DistanceShadowmask,
                                                          RunMode::Subtractive),
                                          kBothPaths));

class CascadesS2 : public RenderTest,
                   public testing::WithParamInterface<std::tuple<int, ShadowFilter, CascadeBlend>> {};

// Umbra is 0 and light is 1 whatever the filter, the number of cascades and the way they blend: neither acne nor a
// shadow that lets light through. Near the camera, whole columns are checked, not single points.
TEST_P(CascadesS2, UmbraDarkAndFloorCleanAcrossCascades)
{
    const auto [cascades, filter, blend] = GetParam();
    LawScene law = makeScene(MixedLightingMode::BakedIndirect);
    Scene& scene = law.baked.scene;
    RenderSettings settings = settingsFor(RunMode::Realtime);
    settings.shadows.cascades = cascades;
    settings.shadows.filter = filter;
    settings.shadows.cascadeBlend = blend;
    const Camera camera = makeCamera();
    const RenderedFrame frame = render(law.baked, camera, settings);
    int checked = 0;
    for (int column = 0; column < 4; ++column) {
        for (float z = -8.0f; z > -18.0f; z -= 0.25f) {
            const ivec2 pixel = pixelOf(camera, kSize, vec3(kColumns[std::size_t(column)], 0, z));
            if (pixel.x < 0 || pixel.y < 0 || pixel.x >= kSize.x || pixel.y >= kSize.y) continue;
            const Ray ray = pixelRay(camera, kSize, pixel);
            ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
            const float lit = inStaticShadow(column) || inDynamicShadow(column) ? 0.0f : 1.0f;
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), directRadiance(point, scene.lights[0], lit)))
                << kColumnNames[std::size_t(column)] << " z " << z;
            ++checked;
        }
    }
    EXPECT_GT(checked, 100);
}
INSTANTIATE_TEST_SUITE_P(, CascadesS2,
                         testing::Combine(testing::Values(1, 2, 3, 4),
                                          testing::Values(ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft),
                                          testing::Values(CascadeBlend::Soft, CascadeBlend::Dithered)));

// S31. What the debug views say at the same points.
TEST_F(RenderTest, DebugViewsS31)
{
    const LawScene law = makeScene(MixedLightingMode::Shadowmask);
    RenderSettings settings = settingsFor(RunMode::Shadowmask);
    const Camera camera = makeCamera();
    ASSERT_TRUE(renderer->load(law.baked));
    auto view = [&](DebugView debugView) {
        settings.view = debugView;
        auto frame = renderer->render(camera, settings);
        EXPECT_TRUE(frame);
        return std::move(frame->radiance);
    };
    const ImageRgba32f fade = view(DebugView::Fade);
    const ImageRgba32f mask = view(DebugView::Shadowmask);
    const ImageRgba32f lightmap = view(DebugView::Lightmap);
    const ImageRgba32f overlap = view(DebugView::Overlap);
    for (const Site& site : sites()) {
        const ivec2 p = site.pixel;
        EXPECT_TRUE(near(vec3(fade(p.x, p.y)), vec3(site.fade), 1.0e-3f, 1.0e-4f));
        EXPECT_TRUE(near(vec3(mask(p.x, p.y)), vec3(inStaticShadow(site.column) ? kBakedShadow : 1.0f, 1, 1)));
        EXPECT_TRUE(near(vec3(lightmap(p.x, p.y)), lightmapOf(site.column) / kPi));
        EXPECT_TRUE(near(vec3(overlap(p.x, p.y)), vec3(0, 0, 1))); // one masked light
    }
}

} // namespace
} // namespace halflight::test
