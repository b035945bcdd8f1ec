// The showcase, baked, forward and deferred: the same picture.
#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace halflight::showcase_test {
namespace {

// Pixels that differ in a channel by more than half a percent of the brighter one and 1/2000 of the picture's mean.
int differing(const ImageRgba32f& a, const ImageRgba32f& b)
{
    double sum = 0.0;
    for (const vec4& texel : a.texels()) sum += double(luminance(vec3(texel)));
    const float absolute = float(sum / double(a.texelCount())) / 2000.0f;
    int count = 0;
    for (std::size_t i = 0; i < a.texelCount(); ++i) {
        const vec3 x(a.texels()[i]);
        const vec3 y(b.texels()[i]);
        bool same = true;
        for (int c = 0; c < 3; ++c) same &= std::abs(x[c] - y[c]) <= 0.005f * std::max(x[c], y[c]) + absolute;
        count += same ? 0 : 1;
    }
    return count;
}

TEST(ShowcaseS26, ForwardAndDeferredAgreeOnEveryPixel)
{
    Result<Scene> scene = readScene(std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets" / "courtyard.glb");
    ASSERT_TRUE(scene) << scene.error().text();
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = 4; // noise is the same in both
    settings.bounces = 1;
    settings.texelsPerMeter = 4.0f;
    const Result<BakeResult> baked = bake(std::move(*scene), settings, embreeIntegrators());
    ASSERT_TRUE(baked) << baked.error().text();
    auto renderer = Renderer::create({});
    ASSERT_TRUE(renderer) << renderer.error().text();
    ASSERT_TRUE((*renderer)->load(baked->baked));
    for (const Camera& camera : baked->baked.scene.cameras) {
        for (const RunMode mode : {RunMode::Realtime, RunMode::Shadowmask, RunMode::DistanceShadowmask}) {
            RenderSettings render;
            render.mode = mode;
            render.size = {480, 270};
            render.shadows.distanceMeters = 12.0f;
            render.shadows.fadeRangeMeters = 3.0f;
            const auto forward = (*renderer)->render(camera, render);
            render.path = RenderPath::Deferred;
            const auto deferred = (*renderer)->render(camera, render);
            ASSERT_TRUE(forward && deferred);
            EXPECT_EQ(differing(forward->radiance, deferred->radiance), 0) << camera.name << ", mode " << int(mode);
        }
    }
}

} // namespace
} // namespace halflight::showcase_test
