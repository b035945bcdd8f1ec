// Bakes in the window, without the window: what a cancelled one leaves.
#include "view/scene/live_bake.h"

#include "bake/test_room.h"
#include "base/temp_folder.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/file.h"
#include "halflight/scene/gltf.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

namespace halflight::view::live_bake_test {
namespace {

TEST(LiveBake, ACancelledOneLeavesTheFinishedOneToBeSaved)
{
    const test::TempFolder folder;
    auto renderer = Renderer::create({.validation = true, .preferCpu = true});
    ASSERT_TRUE(renderer) << renderer.error().text();
    BakedScene file;
    file.scene = test::room(true, true, false);
    for (Object& object : file.scene.objects) object.lightmap = {};
    ASSERT_TRUE((*renderer)->load(file));

    const std::atomic<bool> ends = false;
    ViewState state;
    Notices notices{nullptr};
    ShownScene shown(state, ends);
    Comparison comparison(state);
    LiveBake bake(state, shown, comparison, notices);
    shown.take(file, TextureDetail::Full, ShownScene::Clock::now());
    const auto follow = [&] {
        while (bake.runs() || shown.isUploading()) {
            ASSERT_TRUE(bake.poll(**renderer, 1.0f, 0.0));
            const auto isShown = shown.poll(**renderer);
            ASSERT_TRUE(isShown) << isShown.error().text();
            if (*isShown) bake.uploadIsShown();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    };
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 64;
    settings.samples = 4;
    settings.reflectionProbes = false;
    bake.start(std::make_unique<BakeSession>(file.scene, settings, embreeIntegrators()));
    EXPECT_FALSE(bake.hasUnsaved()) << "it runs";
    follow();
    ASSERT_TRUE(bake.hasUnsaved()) << bake.status().outcome;

    settings.samples = 1 << 16; // minutes
    bake.start(std::make_unique<BakeSession>(file.scene, settings, embreeIntegrators()));
    bake.cancel();
    follow();
    EXPECT_EQ(bake.status().outcome, "cancelled");
    EXPECT_TRUE(bake.hasUnsaved()) << "the first one is shown again";
    state.bakeOutput = (folder / "room.txt").string();
    bake.save({});
    EXPECT_TRUE(bake.hasUnsaved()) << "no kind of file";
    state.bakeOutput = (folder / "room.glb").string();
    ASSERT_TRUE(writeFileAtomically(folder / "room.glb", "the scene"));
    FilesInUse read;
    addReadFiles(read, folder / "." / "room.glb", {});
    bake.save(read);
    EXPECT_TRUE(bake.hasUnsaved()) << "it would replace the scene";
    EXPECT_NE(bake.status().outcome.find("would replace the scene"), std::string::npos) << bake.status().outcome;
    EXPECT_EQ(readFile(folder / "room.glb")->size(), 9u);
    bake.save({});
    EXPECT_FALSE(bake.hasUnsaved());

    settings.samples = 4;
    const auto whole = halflight::bake(file.scene, settings, embreeIntegrators());
    ASSERT_TRUE(whole) << whole.error().text();
    WriteOptions write;
    write.irradiance = whole->irradiance;
    ASSERT_TRUE(writeBakedScene(folder / "whole.glb", whole->baked, write));
    EXPECT_EQ(*readFile(folder / "room.glb"), *readFile(folder / "whole.glb"));
    EXPECT_TRUE((*renderer)->validationMessages().empty());
}

} // namespace
} // namespace halflight::view::live_bake_test
