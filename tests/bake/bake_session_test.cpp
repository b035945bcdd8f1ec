// A bake in the background (BakeSession): the same bytes as bake(), a first light before it, cancelled at any moment.
#include "bake/test_room.h"
#include "base/temp_folder.h"
#include "halflight/bake/bake_session.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/file.h"
#include "halflight/scene/export.h"
#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

namespace halflight::test {
namespace {

BakeSettings quick()
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.samples = 16;
    settings.lightmapSize = 128;
    settings.probeSpacingMeters = 1.0f;
    return settings;
}

/// Without layouts of its own, so that charts are made.
Scene scene()
{
    Scene scene = room(true, true, true);
    for (Object& object : scene.objects) object.lightmap = {};
    for (Mesh& mesh : scene.meshes)
        for (MeshPart& part : mesh.parts) part.lightmapUv.clear();
    return scene;
}

void waitFor(const BakeSession& session)
{
    while (!session.state().finished) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

TEST(BakeSession, HasTheBakesBytesAndAFirstLight)
{
    const Result<BakeResult> plain = bake(scene(), quick(), makeEmbreeIntegrator);
    ASSERT_TRUE(plain) << plain.error().text();

    BakeSession session(scene(), quick(), makeEmbreeIntegrator);
    std::optional<BakedScene> first;
    bool stages = false;
    while (!session.state().finished) {
        const BakeSessionState state = session.state();
        EXPECT_GE(state.fraction, 0.0);
        EXPECT_LE(state.fraction, 1.0);
        stages = stages || (!state.stage.empty() && !state.stage.starts_with("first light"));
        if (!first) first = session.takeLight();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (!first) first = session.takeLight();
    ASSERT_TRUE(first) << "a first light";
    EXPECT_FALSE(session.takeLight()) << "once";
    EXPECT_TRUE(stages);
    const Result<BakeResult> baked = session.takeResult();
    ASSERT_TRUE(baked) << baked.error().text();
    EXPECT_FALSE(session.takeResult()) << "once";

    const TempFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "plain.glb", plain->baked));
    ASSERT_TRUE(writeBakedScene(folder / "session.glb", baked->baked));
    EXPECT_EQ(*readFile(folder / "plain.glb"), *readFile(folder / "session.glb"));

    // The first light is the same scene with about the same light, on far fewer texels.
    ASSERT_EQ(first->scene.objects.size(), baked->baked.scene.objects.size());
    EXPECT_EQ(first->mode, baked->baked.mode);
    EXPECT_LT(first->lightmaps.at(0).texelCount() * 3, baked->baked.lightmaps.at(0).texelCount());
    const auto mean = [](const BakedScene& of) {
        vec3 sum(0.0f);
        int count = 0;
        for (const Probe& probe : of.probes.probes) {
            if (!probe.valid) continue;
            sum += probe.radiance[0];
            ++count;
        }
        return sum / float(std::max(count, 1));
    };
    EXPECT_NEAR(mean(*first).y, mean(baked->baked).y, 0.3f * mean(baked->baked).y);
}

TEST(BakeSession, EndsSoonWhenCancelledAtAnyMoment)
{
    std::mt19937 random(7);
    for (int i = 0; i < 12; ++i) {
        BakeSession session(scene(), quick(), makeEmbreeIntegrator);
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % 400));
        session.cancel();
        const auto start = std::chrono::steady_clock::now();
        waitFor(session);
        EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5.0);
        const Result<BakeResult> result = session.takeResult();
        if (!result) EXPECT_EQ(result.error().code, ErrorCode::Cancelled) << result.error().text();
    }
    // One that nobody waits for.
    BakeSession left(scene(), quick(), makeEmbreeIntegrator);
}

TEST(BakeSession, HasTheBakesError)
{
    BakeSettings settings = quick();
    settings.denoiser = Denoiser::OpenImage;
    if (hasOpenImageDenoise()) GTEST_SKIP() << "this build has the denoiser whose lack is the error";
    const Result<BakeResult> plain = bake(scene(), settings, makeEmbreeIntegrator);
    ASSERT_FALSE(plain);
    BakeSession session(scene(), settings, makeEmbreeIntegrator);
    const Result<BakeResult> result = session.takeResult();
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().text(), plain.error().text());
}

} // namespace
} // namespace halflight::test
