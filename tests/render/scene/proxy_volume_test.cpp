// Light probe proxy volumes on the GPU: light and occlusion point by point (S16), for groups of instances (S17).
#include "render/scene/probe_field.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace halflight::test::proxy_volume_test {
namespace {

constexpr ivec2 kSize{160, 90};
const vec3 kAlbedo(0.6f, 0.5f, 0.4f);

RenderSettings settingsFor(RenderPath path, RunMode mode)
{
    RenderSettings settings;
    settings.path = path;
    settings.mode = mode;
    settings.size = kSize;
    return settings;
}

/// A dynamic rectangle of 6 x 4 m in the linear field, lit by two suns with channels. It casts no shadow, so that every
/// shadow is a baked one.
struct BigObject {
    BakedScene baked;
    mat4 worldFromObject;
    Camera camera = lookAt(vec3(0.5f, 6.0f, 4.0f), vec3(0));

    explicit BigObject(const mat4& transform = mat4(1.0f), MixedLightingMode mode = MixedLightingMode::Shadowmask)
        : worldFromObject(transform)
    {
        addProbes(baked, linearField);
        baked.mode = mode;
        baked.scene.sky = {vec3(0.2f, 0.3f, 0.4f), vec3(0.2f), vec3(0.1f)};
        const int material = addMaterial(baked.scene, vec4(kAlbedo, 1.0f));
        baked.scene.materials[std::size_t(material)].doubleSided = true;
        addObject(baked.scene, makeRectangle(6, 4, material), worldFromObject, false);
        object().castShadows = false;
        object().probeLighting = ProbeLighting::Volume;
        object().probeResolution = {9, 2, 9};
        addSun(vec3(0.3f, 1, 0.2f), vec3(1.0f, 0.9f, 0.7f), 0);
        addSun(vec3(-0.5f, 1, 0.4f), vec3(0.2f, 0.4f, 0.8f), 2);
    }
    void addSun(vec3 toLight, vec3 color, int channel)
    {
        Light sun = directionalLight(toLight, 2.0f);
        sun.color = color;
        bakeAsMixed(sun, baked.mode, baked.mode == MixedLightingMode::Shadowmask || channel == 0 ? channel : -1);
        baked.scene.lights.push_back(sun);
    }
    Object& object() { return baked.scene.objects[0]; }

    /// What a pixel shows if it shows the rectangle; false if not. `place` maps the point to where probes are read.
    template<typename Place> bool expected(ivec2 pixel, RunMode mode, Place place, vec3& radiance) const
    {
        const Ray ray = pixelRay(camera, kSize, pixel);
        const mat4 objectFromWorld = glm::inverse(worldFromObject);
        const vec3 o(objectFromWorld * vec4(ray.origin, 1.0f));
        const vec3 d(objectFromWorld * vec4(ray.direction, 0.0f));
        const vec3 hit = o - d * (o.y / d.y);
        if (std::abs(hit.x) > 2.9f || std::abs(hit.z) > 1.9f) return false;
        vec3 n = glm::normalize(glm::transpose(mat3(objectFromWorld)) * vec3(0, 1, 0));
        if (glm::dot(n, ray.direction) > 0.0f) n = -n;
        ShadedPoint point;
        point.position = vec3(worldFromObject * vec4(hit, 1.0f));
        point.normal = n;
        point.view = -ray.direction;
        point.baseColor = kAlbedo;
        const ProbeSample probes = linearField(place(point.position));
        radiance = indirectRadiance(point, irradianceOf(probes, n));
        for (const Light& light : baked.scene.lights) {
            const int channel = light.baking.occlusionMaskChannel;
            const bool masked = mode != RunMode::BakedIndirect && channel >= 0;
            if (glm::dot(n, -light.direction()) > 0.0f)
                radiance += directRadiance(point, light, masked ? probes.occlusion[channel] : 1.0f);
        }
        return true;
    }
    template<typename Place> void expectPicture(const ImageRgba32f& picture, RunMode mode, Place place) const
    {
        int compared = 0;
        for (int y = 1; y < kSize.y; y += 3)
            for (int x = 1; x < kSize.x; x += 3) {
                vec3 radiance;
                if (!expected({x, y}, mode, place, radiance)) continue;
                ++compared;
                ASSERT_TRUE(near(vec3(picture(x, y)), radiance, 4.0e-3f, 1.0e-3f)) << "at " << x << ' ' << y;
            }
        EXPECT_GT(compared, 150);
    }
};

const auto kWhereItIs = [](vec3 p) { return p; };

class ProxyVolumeS16 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(Paths, ProxyVolumeS16, kBothPaths, pathNameOf);

TEST_P(ProxyVolumeS16, EachPixelHasTheProbeLightOfItsPlace)
{
    const BigObject scene;
    const RunMode mode = RunMode::BakedIndirect;
    const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam(), mode));
    scene.expectPicture(frame.radiance, mode, kWhereItIs);
}

TEST_P(ProxyVolumeS16, OneSampleIsThatOfTheMiddle)
{
    BigObject scene;
    const RunMode mode = RunMode::Shadowmask;
    const auto middle = [](vec3) { return vec3(0.0f); };
    scene.object().probeLighting = ProbeLighting::Single;
    scene.expectPicture(render(scene.baked, scene.camera, settingsFor(GetParam(), mode)).radiance, mode, middle);
    // Volumes switched off for a whole picture.
    scene.object().probeLighting = ProbeLighting::Volume;
    RenderSettings settings = settingsFor(GetParam(), mode);
    settings.proxyVolumes = false;
    scene.expectPicture(render(scene.baked, scene.camera, settings).radiance, mode, middle);
    // A volume of one texel.
    scene.object().probeResolution = ivec3(1);
    scene.expectPicture(render(scene.baked, scene.camera, settingsFor(GetParam(), mode)).radiance, mode, middle);
}

TEST_P(ProxyVolumeS16, OcclusionInEveryMixingMode)
{
    const BigObject masked;
    for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask, RunMode::BakedIndirect}) {
        SCOPED_TRACE(int(mode));
        const RenderedFrame frame = render(masked.baked, masked.camera, settingsFor(GetParam(), mode));
        masked.expectPicture(frame.radiance, mode, kWhereItIs);
    }
    const BigObject subtractive(mat4(1.0f), MixedLightingMode::Subtractive);
    const RenderedFrame frame =
        render(subtractive.baked, subtractive.camera, settingsFor(GetParam(), RunMode::Subtractive));
    subtractive.expectPicture(frame.radiance, RunMode::Subtractive, kWhereItIs);
}

TEST_P(ProxyVolumeS16, TurnsScalesAndMirrorsWithItsObject)
{
    const mat4 turned = glm::rotate(glm::translate(mat4(1.0f), vec3(0.3f, -0.2f, 0.1f)), 0.7f, vec3(0.3f, 1, 0.2f));
    for (const vec3 scale : {vec3(0.8f, 1, 0.9f), vec3(-0.7f, 2, 1.1f)}) {
        const BigObject scene(glm::scale(turned, scale));
        const RenderedFrame frame = render(scene.baked, scene.camera, settingsFor(GetParam(), RunMode::Shadowmask));
        scene.expectPicture(frame.radiance, RunMode::Shadowmask, kWhereItIs);
    }
}

TEST_P(ProxyVolumeS16, FollowsAnObjectThatMoves)
{
    BigObject scene;
    ASSERT_TRUE(renderer->load(scene.baked));
    scene.worldFromObject = glm::rotate(glm::translate(mat4(1.0f), vec3(-0.5f, 0.4f, 0.2f)), -0.5f, vec3(0, 1, 0.4f));
    ASSERT_TRUE(renderer->setObjectTransform(0, scene.worldFromObject));
    const auto frame = renderer->render(scene.camera, settingsFor(GetParam(), RunMode::Shadowmask));
    ASSERT_TRUE(frame);
    scene.expectPicture(frame->radiance, RunMode::Shadowmask, kWhereItIs);
}

TEST_P(ProxyVolumeS16, DebugViewShowsTheVolume)
{
    const BigObject scene;
    RenderSettings settings = settingsFor(GetParam(), RunMode::Shadowmask);
    settings.view = DebugView::Probes;
    const RenderedFrame frame = render(scene.baked, scene.camera, settings);
    for (const vec3 place : {vec3(-2, 0, -1), vec3(2, 0, 0.5f), vec3(0.3f, 0, 1.5f)}) {
        const ivec2 pixel = pixelOf(scene.camera, kSize, place);
        const vec3 p = onPlane(pixelRay(scene.camera, kSize, pixel), 0.0f);
        EXPECT_TRUE(
            near(vec3(frame.radiance(pixel.x, pixel.y)), irradianceOf(linearField(p), vec3(0, 1, 0)) / kPi, 2.0e-3f));
    }
}

/// Light that grows a tenfold per metre along x.
ProbeSample steepField(vec3 p)
{
    ProbeSample sample;
    sample.radiance[0] = vec3(std::pow(10.0f, p.x));
    return sample;
}

// Volumes of many sizes, in light of many sizes, lie side by side in one texture: none reads another's texels.
TEST_P(ProxyVolumeS16, NeighboursInTheTextureStayApart)
{
    BakedScene baked;
    addProbes(baked, steepField);
    const int material = addMaterial(baked.scene, vec4(1.0f));
    for (int i = 0; i < 24; ++i) {
        const vec3 place(float(i % 6) * 1.2f - 3.0f, 0.0f, float(i / 6) * 1.2f - 1.8f);
        addObject(baked.scene, makeRectangle(1, 1, material), glm::translate(mat4(1.0f), place), false);
        baked.scene.objects.back().probeLighting = ProbeLighting::Volume;
        baked.scene.objects.back().probeResolution = ivec3(2 + i % 5, 1 + i % 3, 2 + i % 4);
    }
    const Camera camera = lookAt(vec3(0, 7, 0.01f), vec3(0));
    const RenderedFrame frame = render(baked, camera, settingsFor(GetParam(), RunMode::BakedIndirect));
    const ProbeInterpolator probes(baked);
    for (std::size_t i = 0; i < baked.scene.objects.size(); ++i) {
        const Object& object = baked.scene.objects[i];
        const ProxyVolume volume = makeProxyVolume(probes, Bounds{vec3(-0.5f, 0, -0.5f), vec3(0.5f, 0, 0.5f)},
                                                   object.worldFromObject, {object.probeResolution});
        for (const vec3 corner : {vec3(-0.45f, 0, -0.45f), vec3(0.45f, 0, 0.4f), vec3(-0.4f, 0, 0.45f)}) {
            const ivec2 pixel = pixelOf(camera, kSize, vec3(object.worldFromObject * vec4(corner, 1)));
            const Ray ray = pixelRay(camera, kSize, pixel);
            const vec3 p = onPlane(ray, 0.0f);
            const vec3 irradiance = irradianceOf(sampleProxyVolume(volume, p), vec3(0, 1, 0));
            const ShadedPoint point{p, vec3(0, 1, 0), -ray.direction, vec3(1.0f)};
            EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), indirectRadiance(point, irradiance), 1.5e-2f))
                << "object " << i;
        }
    }
}

class ProxyGroupS17 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(Paths, ProxyGroupS17, kBothPaths, pathNameOf);

// Instances of one mesh, drawn at once: some share a group's volume, some have one of their own, some one sample each.
TEST_P(ProxyGroupS17, OneDrawForGroupsVolumesAndSingleProbes)
{
    BakedScene baked;
    addProbes(baked, linearField);
    const int material = addMaterial(baked.scene, vec4(kAlbedo, 1.0f));
    addObject(baked.scene, makeRectangle(0.9f, 0.9f, material), mat4(1.0f), false);
    const Object first = baked.scene.objects[0];
    baked.scene.objects.clear();
    for (int i = 0; i < 24; ++i) {
        Object object = first;
        object.worldFromObject =
            glm::translate(mat4(1.0f), vec3(float(i % 6) - 2.5f, 0.1f * float(i % 4), float(i / 6) - 1.5f));
        object.castShadows = false; // no realtime shadow of one on another
        if (i % 3 != 0) object.probeLighting = ProbeLighting::Volume;
        object.probeGroup = i % 3 == 1 ? 5 : -1;
        object.probeResolution = ivec3(6, 3, 6);
        baked.scene.objects.push_back(object);
    }
    Light sun = directionalLight(vec3(0.3f, 1, 0.2f), 2.0f);
    bakeAsMixed(sun, MixedLightingMode::Shadowmask, 1);
    baked.scene.lights.push_back(sun);
    const Camera camera = lookAt(vec3(0, 6, 0.01f), vec3(0));
    const RenderedFrame frame = render(baked, camera, settingsFor(GetParam(), RunMode::Shadowmask));

    for (int i = 0; i < 24; ++i) {
        const vec3 middle(baked.scene.objects[std::size_t(i)].worldFromObject[3]);
        const ivec2 pixel = pixelOf(camera, kSize, middle + vec3(0.3f, 0, -0.3f));
        const Ray ray = pixelRay(camera, kSize, pixel);
        const vec3 p = onPlane(ray, middle.y);
        const ProbeSample probes = linearField(i % 3 == 0 ? middle : p);
        const ShadedPoint point{p, vec3(0, 1, 0), -ray.direction, kAlbedo};
        const vec3 expected = indirectRadiance(point, irradianceOf(probes, point.normal)) +
                              directRadiance(point, sun, probes.occlusion[1]);
        EXPECT_TRUE(near(vec3(frame.radiance(pixel.x, pixel.y)), expected, 2.0e-3f)) << "instance " << i;
    }
    int draws = 0;
    for (const PassReport& pass : frame.passes)
        if (pass.name == "forward" || pass.name == "g-buffer") draws += pass.draws;
    EXPECT_EQ(draws, 1);
}

} // namespace
} // namespace halflight::test::proxy_volume_test
