// The user's changes stay in the picture when another scene of the same objects is shown: light of a bake, its end.
#include "view/scene/edited_scene.h"

#include "bake/test_room.h"
#include "base/temp_folder.h"
#include "halflight/base/file.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <memory>

namespace halflight::view::edited_scene_test {
namespace {

class EditedScenes : public testing::Test {
protected:
    void SetUp() override
    {
        auto made = Renderer::create({.validation = true, .preferCpu = true});
        ASSERT_TRUE(made) << made.error().text();
        renderer = std::move(*made);
        baked.scene = test::room(false, true, false);
        baked.scene.objects[0].isStatic = false;
        ASSERT_TRUE(renderer->load(baked));
        edited.beginFile(baked.scene);
    }
    void TearDown() override { EXPECT_TRUE(renderer->validationMessages().empty()); }

    ImageRgba32f picture()
    {
        RenderSettings settings;
        settings.size = ivec2(48, 32);
        settings.mode = RunMode::Realtime;
        Camera camera;
        camera.worldFromCamera = glm::inverse(glm::lookAt(vec3(2.5f, 1.5f, 2.5f), vec3(0, 0.8f, 0), vec3(0, 1, 0)));
        const auto frame = renderer->render(camera, settings);
        EXPECT_TRUE(frame) << frame.error().text();
        return frame ? frame->radiance : ImageRgba32f();
    }

    std::unique_ptr<Renderer> renderer;
    BakedScene baked;
    EditedScene edited;
    Notices notices{nullptr};
};

TEST_F(EditedScenes, RepeatWhatTheSceneThatIsShownHasNot)
{
    const ImageRgba32f before = picture();
    const auto begin = EditedScene::Clock::now();
    Light brighter = edited.scene().lights[1];
    brighter.intensity *= 5.0f;
    edited.change(ChangeLight{1, brighter}, *renderer, notices);
    const mat4 up = glm::translate(mat4(1.0f), vec3(0, 0.3f, 0));
    edited.change(MoveObject{0, up * edited.scene().objects[0].worldFromObject}, *renderer, notices);
    edited.change(ChangeSwitches{1, false, false, true}, *renderer, notices);
    EXPECT_FALSE(edited.scene().objects[1].isStatic) << "in the next bake";
    const ImageRgba32f changed = picture();
    ASSERT_NE(changed.texels(), before.texels());

    ASSERT_TRUE(renderer->load(baked));
    EXPECT_EQ(picture().texels(), before.texels());
    EXPECT_FALSE(edited.repeat(EditedScene::Clock::now(), *renderer)) << "the scene has them";
    EXPECT_EQ(picture().texels(), before.texels());
    EXPECT_TRUE(edited.repeat(begin, *renderer));
    EXPECT_EQ(picture().texels(), changed.texels());

    edited.beginFile(baked.scene);
    EXPECT_FALSE(edited.repeat(begin, *renderer)) << "another file";
    EXPECT_EQ(edited.snapshot(), edited.snapshot()) << "no copy without a change";
}

TEST_F(EditedScenes, AreWrittenAsASettingsFileAfterTheRulesInUse)
{
    const test::TempFolder folder;
    const auto textOf = [](const std::filesystem::path& file) {
        const auto bytes = readFile(file);
        return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "none";
    };
    const std::filesystem::path mine = folder / "mine.toml";
    const std::string rules = "[[light]]\npattern = \"*\"\nintensity = 3\n";
    ASSERT_TRUE(writeFileAtomically(mine, rules));
    edited.beginFile(baked.scene);
    EXPECT_EQ(edited.writeSettings({}, mine, "room.glb"), "nothing was changed");
    const std::string wrote = "wrote " + (folder / "mine_2.toml").string();
    EXPECT_EQ(edited.writeSettings({"one change", ""}, mine, "room.glb"), wrote);
    EXPECT_EQ(textOf(folder / "mine_2.toml"), rules + "\none change");
    EXPECT_EQ(edited.writeSettings({"another", "a place"}, mine, "room.glb"),
              wrote + "; settings files cannot hold a place");
    EXPECT_EQ(textOf(folder / "mine_2.toml"), rules + "\nanother") << "this session's own";
    EXPECT_EQ(textOf(mine), rules) << "it is the user's";
}

} // namespace
} // namespace halflight::view::edited_scene_test
