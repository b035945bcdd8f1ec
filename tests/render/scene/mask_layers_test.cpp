// S36. More than four masked lights at a point: masks, probes and proxy volumes hold up to four layers of channels, and
// both paths read each light's own.
#include "halflight/shading/mask.h"
#include "render/scene/probe_field.h"

namespace halflight::test::mask_layers_test {
namespace {

constexpr ivec2 kSize{160, 90};
constexpr int kPage = 16; // 12 m
const vec3 kAlbedo(0.6f, 0.5f, 0.4f);

/// Attenuation that the mask of a page holds in a channel, n / 255.
float maskOf(int page, int channel)
{
    return float((37 * channel + 90 * page + 11) % 256) / 255.0f;
}

/// As linearField(), with its channels in other orders and of other strengths in the further layers.
ProbeSample layeredField(vec3 p)
{
    ProbeSample sample = linearField(p);
    const vec4 first = sample.occlusion.layers[0];
    sample.occlusion.layers[1] = 0.9f * vec4(first.w, first.x, first.y, first.z);
    sample.occlusion.layers[2] = 1.0f - 0.8f * vec4(first.z, first.y, first.w, first.x);
    sample.occlusion.layers[3] = 0.5f * vec4(first.y, first.w, first.x, first.z);
    return sample;
}

/// Two static floors on pages of their own, and a dynamic board above between them, under a sun for each channel in
/// use.
struct LayeredScene {
    BakedScene baked;
    Camera camera = lookAt(vec3(0.5f, 9.0f, 6.0f), vec3(0));
    int board = 0;

    explicit LayeredScene(int layers, ProbeLighting boardLighting = ProbeLighting::Single)
    {
        addProbes(baked, layeredField);
        baked.maskLayers = layers;
        const int material = addMaterial(baked.scene, vec4(kAlbedo, 1.0f));
        for (int page = 0; page < 2; ++page) {
            const int floor =
                addObject(baked.scene, makeRectangle(5, 8, material), at(vec3(page == 0 ? -5 : 5, 0, 0)), true);
            Object& object = baked.scene.objects[std::size_t(floor)];
            object.castShadows = false;
            object.lightmap = {page, vec2(1.0f), vec2(0.0f)};
            baked.lightmaps.emplace_back(kPage, kPage, uint32_t(0));
            for (int layer = 0; layer < layers; ++layer) baked.shadowmasks.push_back(maskPage(page, layer));
        }
        board = addObject(baked.scene, makeRectangle(4, 6, material), mat4(1.0f), false);
        Object& object = baked.scene.objects[std::size_t(board)];
        object.castShadows = false;
        object.probeLighting = boardLighting;
        object.probeResolution = {9, 2, 9};
        for (int channel = 0; channel < layers * kLayerChannels; ++channel) {
            Light sun = directionalLight(vec3(0.1f * float(channel % 3), 1, -0.1f * float(channel % 5)),
                                         0.2f + 0.1f * float(channel));
            sun.color = vec3(1.0f, 0.5f + 0.03f * float(channel), 1.0f - 0.05f * float(channel));
            sun.castShadows = true;
            bakeAsMixed(sun, MixedLightingMode::Shadowmask, channel);
            baked.scene.lights.push_back(sun);
        }
    }
    static mat4 at(vec3 place) { return {vec4(1, 0, 0, 0), vec4(0, 1, 0, 0), vec4(0, 0, 1, 0), vec4(place, 1)}; }

    static ImageRgba8 maskPage(int page, int layer)
    {
        u8vec4 texel;
        for (int c = 0; c < kLayerChannels; ++c)
            texel[c] = uint8_t(maskOf(page, layer * kLayerChannels + c) * 255.0f + 0.5f);
        return {kPage, kPage, texel};
    }

    /// What a pixel shows; false beside the objects and at their edges. `attenuation` by page (-1: the board) and
    /// channel.
    template<typename Attenuation> bool expected(ivec2 pixel, const Attenuation& attenuation, vec3& radiance) const
    {
        const Ray ray = pixelRay(camera, kSize, pixel);
        const ShadedPoint point{onPlane(ray, 0.0f), vec3(0, 1, 0), -ray.direction, kAlbedo};
        const vec3 p = point.position;
        const bool onBoard = std::abs(p.x) < 1.9f && std::abs(p.z) < 2.9f;
        const bool onFloor = std::abs(std::abs(p.x) - 5.0f) < 2.4f && std::abs(p.z) < 3.9f;
        if (!onBoard && !onFloor) return false;
        const int page = onBoard ? -1 : (p.x < 0.0f ? 0 : 1);
        radiance = vec3(0.0f);
        if (onBoard) {
            const bool isVolume = baked.scene.objects[std::size_t(board)].probeLighting == ProbeLighting::Volume;
            radiance = indirectRadiance(point, irradianceOf(layeredField(isVolume ? p : vec3(0.0f)), vec3(0, 1, 0)));
        }
        for (const Light& light : baked.scene.lights)
            radiance += directRadiance(point, light, attenuation(page, light.baking.occlusionMaskChannel, p));
        return true;
    }
    template<typename Attenuation> void expectPicture(const RenderedFrame& frame, const Attenuation& attenuation) const
    {
        int compared = 0;
        for (int y = 1; y < kSize.y; y += 3)
            for (int x = 1; x < kSize.x; x += 3) {
                vec3 radiance;
                if (!expected({x, y}, attenuation, radiance)) continue;
                ++compared;
                ASSERT_TRUE(near(vec3(frame.radiance(x, y)), radiance, 4.0e-3f, 1.0e-3f)) << "at " << x << ' ' << y;
            }
        EXPECT_GT(compared, 300);
    }
};

RenderSettings settingsFor(RenderPath path)
{
    RenderSettings settings;
    settings.path = path;
    settings.mode = RunMode::Shadowmask;
    settings.size = kSize;
    return settings;
}

class MaskLayersS36 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, MaskLayersS36, kBothPaths, pathNameOf);

TEST_P(MaskLayersS36, EveryLightHasItsOwnShadow)
{
    for (const int layers : {1, 2, 3, 4}) {
        SCOPED_TRACE(testing::Message() << layers << " layers");
        const LayeredScene scene(layers);
        const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam()));
        EXPECT_EQ(frame.plan.maskLayers, layers);
        if (GetParam() == RenderPath::Deferred) EXPECT_EQ(frame.gBufferTargets, layers > 2 ? 6 : 5);
        scene.expectPicture(frame, [](int page, int channel, vec3) {
            return page < 0 ? layeredField(vec3(0.0f)).occlusion[channel] : maskOf(page, channel);
        });
    }
}

TEST_P(MaskLayersS36, ProxyVolumesHoldAllLayers)
{
    for (const int layers : {2, 4}) {
        SCOPED_TRACE(testing::Message() << layers << " layers");
        const LayeredScene scene(layers, ProbeLighting::Volume);
        const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam()));
        scene.expectPicture(frame, [](int page, int channel, vec3 p) {
            return page < 0 ? layeredField(p).occlusion[channel] : maskOf(page, channel);
        });
    }
}

TEST_P(MaskLayersS36, APictureThatIsLeftOutIsLit)
{
    LayeredScene scene(3);
    scene.baked.shadowmasks[1] = {}; // page 0, layer 1
    scene.baked.shadowmasks[5] = {}; // page 1, layer 2
    const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam()));
    scene.expectPicture(frame, [](int page, int channel, vec3) {
        if (page < 0) return layeredField(vec3(0.0f)).occlusion[channel];
        return channel / kLayerChannels == page + 1 ? 1.0f : maskOf(page, channel);
    });
}

TEST_P(MaskLayersS36, DistancesAreReadInEachLayer)
{
    LayeredScene scene(2);
    constexpr int kChannel = 6;
    scene.baked.maskChannels[kChannel] = {4.0f, 6.0f};
    const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam()));
    scene.expectPicture(frame, [](int page, int channel, vec3) {
        if (page < 0) return layeredField(vec3(0.0f)).occlusion[channel];
        const float stored = maskOf(page, channel);
        return channel == kChannel ? shading::decodeMask(stored, 4.0f, 6.0f, 0.5f) : stored;
    });
}

// A frame in which only lights of the first layer are in view reads that alone.
TEST_P(MaskLayersS36, AFrameReadsTheLayersThatItsLightsHave)
{
    LayeredScene scene(4);
    std::erase_if(scene.baked.scene.lights, [](const Light& light) { return light.baking.occlusionMaskChannel >= 4; });
    const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam()));
    EXPECT_EQ(frame.plan.maskLayers, 1);
    scene.expectPicture(frame, [](int page, int channel, vec3) {
        return page < 0 ? layeredField(vec3(0.0f)).occlusion[channel] : maskOf(page, channel);
    });
}

} // namespace
} // namespace halflight::test::mask_layers_test
