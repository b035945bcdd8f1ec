// A bake in the background (BakeSession): the same bytes as bake(), a first light before it, cancelled at any moment.
#include "bake/live/session_light.h"
#include "base/temp_folder.h"
#include "halflight/bake/bake_session.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/file.h"
#include "halflight/base/system.h"
#include "halflight/scene/export.h"
#include "halflight/scene/gltf.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <thread>

namespace halflight::test::bake_session_test {
namespace {

#ifdef __SANITIZE_THREAD__
constexpr bool kSlow = true;
#else
constexpr bool kSlow = false;
#endif

/// For many bakes.
BakeSettings tiny()
{
    BakeSettings settings = quick();
    settings.lightmapSize = 64;
    settings.probeSpacingMeters = 4.0f;
    settings.reflectionProbes = false;
    return settings;
}

void waitFor(const BakeSession& session)
{
    while (!session.state().finished) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

/// Texels at an object's vertices whose light the tiles change.
int changedTexels(const BakedScene& first, const Object& object, const std::vector<LightTile>& tiles)
{
    int changed = 0;
    const ivec2 size = first.lightmaps.at(0).size();
    for (const MeshPart& part : first.scene.meshes[std::size_t(object.mesh)].parts) {
        for (const vec2 uv : part.lightmapUv) {
            const vec2 place = (uv * object.lightmap.scale + object.lightmap.offset) * vec2(size);
            const ivec2 p = glm::clamp(ivec2(place), ivec2(0), size - 1);
            for (const LightTile& tile : tiles) {
                const ivec2 q = p - tile.offset;
                if (tile.page != object.lightmap.page || q.x < 0 || q.y < 0 || q.x >= tile.texels.width() ||
                    q.y >= tile.texels.height())
                    continue;
                changed += tile.texels(q.x, q.y) != first.lightmaps[std::size_t(tile.page)](p.x, p.y) ? 1 : 0;
                break;
            }
        }
    }
    return changed;
}

vec3 meanOfProbes(const BakedScene& of)
{
    vec3 sum(0.0f);
    int count = 0;
    for (const Probe& probe : of.probes.probes) {
        if (!probe.valid) continue;
        sum += probe.radiance[0];
        ++count;
    }
    return sum / float(std::max(count, 1));
}

TEST(BakeSession, HasTheBakesBytesAndAFirstLight)
{
    const Result<BakeResult> plain = bake(scene(), quick(), embreeIntegrators());
    ASSERT_TRUE(plain) << plain.error().text();

    BakeSession session(scene(), quick(), embreeIntegrators());
    std::optional<BakedScene> first;
    bool stages = false;
    while (!session.state().finished) {
        const BakeSessionState state = session.state();
        EXPECT_GE(state.fraction, 0.0);
        EXPECT_LE(state.fraction, 1.0);
        stages = stages || (!state.stage.empty() && state.stage != "first light");
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

    // The first light is the same scene with about the same light, in the same layout.
    ASSERT_EQ(first->scene.objects.size(), baked->baked.scene.objects.size());
    EXPECT_EQ(first->mode, MixedLightingMode::BakedIndirect) << "without a mask";
    ASSERT_EQ(first->lightmaps.size(), baked->baked.lightmaps.size());
    EXPECT_EQ(first->lightmaps[0].size(), baked->baked.lightmaps[0].size());
    EXPECT_LT(errorOf(*first, *baked), 0.35);
    EXPECT_NEAR(meanOfProbes(*first).y, meanOfProbes(baked->baked).y, 0.3f * meanOfProbes(baked->baked).y);
}

/// It comes before the first light, and is about the light of the result's probes.
TEST(BakeSession, ShowsTheLightOfProbesFirst)
{
    BakeSession session(scene(), quick(), embreeIntegrators());
    std::optional<BakedScene> light;
    while (!light && !session.state().finished) {
        light = session.takeProbeLight();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(light);
    EXPECT_FALSE(session.takeProbeLight()) << "once";
    EXPECT_TRUE(light->isBaked);
    EXPECT_EQ(light->mode, MixedLightingMode::BakedIndirect) << "without a mask";
    EXPECT_TRUE(light->lightmaps.empty());
    for (const Object& object : light->scene.objects) EXPECT_LT(object.lightmap.page, 0);
    const Result<BakeResult> baked = session.takeResult();
    ASSERT_TRUE(baked) << baked.error().text();
    ASSERT_TRUE(session.takeLight());
    EXPECT_NEAR(meanOfProbes(*light).y, meanOfProbes(baked->baked).y, 0.3f * meanOfProbes(baked->baked).y);
    // Of a session that nobody asked for it, it goes with the first light.
    BakeSession other(scene(), quick(), embreeIntegrators());
    ASSERT_TRUE(other.takeResult());
    ASSERT_TRUE(other.takeLight());
    EXPECT_FALSE(other.takeProbeLight());
}

/// A picture of that light gets the whole processor, until goOn() or cancel().
TEST(BakeSession, WaitsAfterTheLightOfProbes)
{
    for (const bool cancels : {false, true}) {
        BakeSession session(scene(), tiny(), embreeIntegrators(), true);
        while (!session.takeProbeLight()) {
            ASSERT_FALSE(session.state().finished);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        while (session.state().stage != "first light") std::this_thread::sleep_for(std::chrono::milliseconds(1));
        EXPECT_FALSE(session.state().finished);
        EXPECT_FALSE(session.takeLight());
        cancels ? session.cancel() : session.goOn();
        const Result<BakeResult> baked = session.takeResult();
        ASSERT_EQ(bool(baked), !cancels);
        if (cancels) EXPECT_EQ(baked.error().code, ErrorCode::Cancelled);
    }
}

/// What a window shows comes nearer to the result, and arrives there: all tiles together are the finished pages.
TEST(BakeSession, TilesBecomeTheFinishedPages)
{
    BakeSession session(scene(), quick(), embreeIntegrators());
    EXPECT_TRUE(session.takeTiles().empty()) << "before the first light";
    const std::vector<BakedScene> states = statesOf(session);
    const Result<BakeResult> baked = session.takeResult();
    ASSERT_TRUE(baked) << baked.error().text();
    ASSERT_GE(states.size(), 2u) << "first light and tiles";
    EXPECT_LT(errorOf(states.back(), *baked), 0.02) << "but for padding, and RGB9E5 in another unit";
    EXPECT_LT(errorOf(states.back(), *baked), 0.1 * errorOf(states.front(), *baked));
}

/// Of two rooms, the one that the camera sees is finished first.
TEST(BakeSession, WhatIsInViewComesFirst)
{
    Scene rooms = scene();
    const std::size_t count = rooms.objects.size();
    for (std::size_t i = 0; i < count; ++i) {
        Object other = rooms.objects[i];
        if (!other.isStatic) continue;
        other.worldFromObject = glm::translate(mat4(1.0f), vec3(100.0f, 0.0f, 0.0f)) * other.worldFromObject;
        rooms.objects.push_back(other);
    }
    BakeSettings settings = quick();
    settings.lightmapSize = 256;
    for (const float side : {0.0f, 100.0f}) {
        BakeSession session(rooms, settings, embreeIntegrators());
        Camera camera;
        camera.worldFromCamera[3] = vec4(side, 1.0f, 0.0f, 1.0f);
        camera.worldFromCamera = glm::rotate(camera.worldFromCamera, -0.5f * kPi, vec3(1, 0, 0)); // at the floor
        session.setView(camera, 1.0f);
        std::optional<BakedScene> first;
        std::vector<LightTile> tiles;
        while (tiles.empty() && !session.state().finished) {
            if (!first)
                first = session.takeLight();
            else
                tiles = session.takeTiles();
        }
        ASSERT_FALSE(tiles.empty());
        // Texels that changed, by the room that they are in.
        session.cancel();
        waitFor(session);
        int near = 0;
        int far = 0;
        for (const Object& object : first->scene.objects) {
            if (!object.isStatic || object.mesh < 0 || object.lightmap.page < 0) continue;
            const bool isNear = std::abs(object.worldFromObject[3].x - side) < 50.0f;
            (isNear ? near : far) += changedTexels(*first, object, tiles);
        }
        EXPECT_GT(near, 0);
        EXPECT_LT(far, near / 4) << side;
    }
}

/// A hundred bakes, each cancelled at a random moment of its length; of some the light is taken meanwhile. They leave
/// nothing behind that changes a bake. Moments and limit are processor time, and parts of what a whole bake takes:
/// neither other programs nor the machine's speed count.
TEST(BakeSession, EndsSoonWhenCancelledAtAHundredMoments)
{
    const TempFolder folder;
    const auto bytesOfABake = [&] {
        const double begin = processCpuSeconds();
        BakeSession session(scene(), tiny(), embreeIntegrators());
        const Result<BakeResult> result = session.takeResult();
        const double length = processCpuSeconds() - begin;
        EXPECT_TRUE(result && writeBakedScene(folder / "whole.glb", result->baked));
        return std::pair(*readFile(folder / "whole.glb"), length);
    };
    const auto [bytes, length] = bytesOfABake();
    const double most = 0.5 * length;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> moment(0.0, length);
    std::set<std::string> stages;
    int cancelled = 0;
    for (int i = 0; i < 100; ++i) {
        const double end = processCpuSeconds() + moment(random);
        BakeSession session(scene(), tiny(), embreeIntegrators());
        while (processCpuSeconds() < end && !session.state().finished) {
            if (i % 2 == 0 && !session.takeLight()) (void)session.takeTiles();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        const std::string stage = session.state().stage;
        const double begin = processCpuSeconds();
        session.cancel();
        const Result<BakeResult> result = session.takeResult();
        EXPECT_LT(processCpuSeconds() - begin, most) << stage << ", of " << length;
        if (result) continue; // it was too late
        EXPECT_EQ(result.error().code, ErrorCode::Cancelled) << result.error().text();
        stages.insert(stage);
        ++cancelled;
    }
    EXPECT_GT(cancelled, 50);
    EXPECT_GE(stages.size(), 5u);
    EXPECT_EQ(bytesOfABake().first, bytes);
    // One that nobody waits for.
    BakeSession left(scene(), tiny(), embreeIntegrators());
}

/// The session has a copy: edits of the scene, other views and takers of tiles change nothing of the result.
TEST(BakeSession, EditsWhileItBakesChangeNothing)
{
    BakeSettings settings = kSlow ? tiny() : quick();
    settings.reflectionProbes = true;
    const Result<BakeResult> plain = bake(scene(), settings, embreeIntegrators());
    ASSERT_TRUE(plain);
    Scene edited = scene();
    BakeSession session(edited, settings, embreeIntegrators());
    std::atomic<bool> ends = false;
    std::thread taker([&] {
        while (!ends) {
            (void)session.takeLight();
            (void)session.takeTiles();
            std::this_thread::yield();
        }
    });
    Camera camera;
    for (int i = 0; !session.state().finished; ++i) {
        edited.lights[0].intensity += 1.0f;
        edited.objects[0].worldFromObject[3].x += 0.01f;
        camera.worldFromCamera = glm::rotate(camera.worldFromCamera, 0.1f, vec3(0, 1, 0));
        session.setView(camera, 1.0f + 0.1f * float(i % 5));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ends = true;
    taker.join();
    const Result<BakeResult> baked = session.takeResult();
    ASSERT_TRUE(baked);
    EXPECT_EQ(baked->baked.lightmaps[0].texels(), plain->baked.lightmaps[0].texels());
    EXPECT_EQ(baked->baked.shadowmasks.size(), plain->baked.shadowmasks.size());
}

/// With a cache tiles come in parts, and the second time from the folder: the bytes are the same.
TEST(BakeSession, WithACacheToo)
{
    const TempFolder folder;
    BakeSettings settings = kSlow ? tiny() : quick();
    const Result<BakeResult> plain = bake(scene(), settings, embreeIntegrators());
    ASSERT_TRUE(plain);
    settings.cacheDirectory = folder / "cache";
    for (int round = 0; round < 2; ++round) {
        BakeSession session(scene(), settings, embreeIntegrators());
        Camera camera;
        session.setView(camera, 1.5f);
        const Result<BakeResult> baked = session.takeResult();
        ASSERT_TRUE(baked) << baked.error().text();
        EXPECT_EQ(baked->baked.lightmaps[0].texels(), plain->baked.lightmaps[0].texels());
        EXPECT_GT(baked->report.cache.tiles, 0u);
        EXPECT_EQ(baked->report.cache.same == baked->report.cache.tiles, round == 1);
    }
}

TEST(BakeSession, HasTheBakesError)
{
    const BakeSettings settings = quick();
    IntegratorFactory broken = embreeIntegrators();
    broken.make = [](const auto&...) -> Result<std::unique_ptr<Integrator>> {
        return Error{ErrorCode::Unsupported, "there is no room for the rays"};
    };
    const Result<BakeResult> plain = bake(scene(), settings, broken);
    ASSERT_FALSE(plain);
    BakeSession session(scene(), settings, broken);
    const Result<BakeResult> result = session.takeResult();
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().text(), plain.error().text());
}

} // namespace
} // namespace halflight::test::bake_session_test
