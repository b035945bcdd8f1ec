// Light groups in a bake in the background (S33): what is shown, and what comes out.

#include "bake/live/session_light.h"
#include "base/temp_folder.h"

#include "halflight/bake/bake.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/file.h"
#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

namespace halflight::test::session_groups_test {
namespace {

/// Of the lightmap.
vec3 meanLight(const BakedScene& shown)
{
    vec3 sum(0.0f);
    for (const Image<uint32_t>& page : shown.lightmaps) {
        const ImageRgb32f lux = decodeRgb9e5(page, shown.lightmapUnitLux);
        for (const vec3 light : lux.texels()) sum += light;
    }
    return sum;
}

/// Groups are baked in white. What is shown meanwhile has the scene's own light, and the bytes are those of bake().
TEST(BakeSession, ShowsGroupsInTheirOwnLightS33)
{
    Scene grouped = scene();
    Light& sun = grouped.lights[0];
    sun.color = vec3(1.0f, 0.3f, 0.1f);
    sun.directions = {sun.direction(), glm::normalize(sun.direction() + vec3(0.2f, 0.0f, 0.0f))};
    grouped.lights[1].group = "spot";
    for (Material& material : grouped.materials)
        if (material.emissiveNits != vec3(0.0f)) material.group = "lamp";
    const Result<BakeResult> plain = bake(grouped, quick(), embreeIntegrators());
    ASSERT_TRUE(plain) << plain.error().text();
    ASSERT_EQ(plain->baked.groups.size(), 4u);

    BakeSession session(grouped, quick(), embreeIntegrators());
    std::optional<BakedScene> probes;
    while (!probes && !session.state().finished) probes = session.takeProbeLight();
    const std::vector<BakedScene> states = statesOf(session);
    Result<BakeResult> baked = session.takeResult();
    ASSERT_TRUE(baked) << baked.error().text();
    const TempFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "plain.glb", plain->baked));
    ASSERT_TRUE(writeBakedScene(folder / "session.glb", baked->baked));
    EXPECT_EQ(*readFile(folder / "plain.glb"), *readFile(folder / "session.glb"));

    for (std::size_t g = 0; g < baked->groupIrradiance.size(); ++g)
        for (std::size_t p = 0; p < baked->irradiance.size(); ++p)
            for (std::size_t i = 0; i < baked->irradiance[p].texelCount(); ++i)
                baked->irradiance[p].data()[i] +=
                    baked->baked.groups[g].weight * baked->groupIrradiance[g][p].data()[i];
    ASSERT_GE(states.size(), 2u) << "first light and tiles";
    for (const BakedScene& state : {states.front(), states.back()}) {
        EXPECT_TRUE(state.groups.empty());
        ASSERT_EQ(state.scene.lights.size(), grouped.lights.size());
        EXPECT_EQ(state.scene.lights[0].color, sun.color);
        EXPECT_EQ(state.scene.lights[0].direction(), sun.direction());
    }
    // Texels are shown before they are denoised. In white light there would be three times the green.
    const vec3 finished = meanLight(states.back());
    for (const BakedScene& state : states) {
        const vec3 light = meanLight(state);
        EXPECT_NEAR(light.g / light.r, finished.g / finished.r, 0.2f * finished.g / finished.r);
    }
    EXPECT_LT(errorOf(states.front(), *baked), 0.35);
    EXPECT_LT(errorOf(states.back(), *baked), 0.02) << "but for padding, and RGB9E5 in another unit";
    ASSERT_TRUE(probes);
    EXPECT_EQ(probes->scene.lights[0].color, sun.color);
}

} // namespace
} // namespace halflight::test::session_groups_test
