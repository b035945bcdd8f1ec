// The user's changes stay in the picture when another scene of the same objects is shown: light of a bake, its end.
#include "view/scene/edited_scene.h"

#include "bake/test_room.h"
#include "base/temp_folder.h"
#include "halflight/base/file.h"
#include "render/scene/light_groups_scene.h"

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

/// The same with light groups.
class EditedGroupsS33 : public EditedScenes {
protected:
    void SetUp() override
    {
        EditedScenes::SetUp();
        baked = test::groupedScene();
        ASSERT_TRUE(renderer->load(baked));
        edited.beginFile(baked.scene);
        edited.showGroups(baked, EditedScene::Clock::now());
    }
    vec3 lightOf(const Scene& scene, std::size_t i) { return scene.lights[i].color * scene.lights[i].intensity; }
};

// What is baked next, and what the reference traces, has the light that is drawn.
TEST_F(EditedGroupsS33, SceneFollowsTheWeights)
{
    edited.change(ChangeGroup{"lamp", vec3(2.0f)}, *renderer, notices);
    edited.change(ChangeGroup{"neon", vec3(0.5f)}, *renderer, notices);
    edited.change(ChangeGroup{"day", vec3(3.0f)}, *renderer, notices);
    EXPECT_EQ(lightOf(edited.scene(), 0), vec3(40.0f));
    const auto scene = edited.snapshot();
    EXPECT_EQ(scene->materials[1].emissiveNits, 0.5f * baked.scene.materials[1].whiteNits);
    EXPECT_EQ(scene->sky.zenith, 3.0f * baked.scene.sky.zenith);
    for (std::size_t i = 0; i < baked.scene.lights.size(); ++i) {
        EXPECT_EQ(lightOf(renderer->scene(), i), lightOf(edited.scene(), i));
        EXPECT_EQ(lightOf(edited.atLoadWithWeights(), i), lightOf(edited.scene(), i));
    }
    EXPECT_EQ(edited.groups()[0].weight, vec3(2.0f));
    EXPECT_EQ(edited.groups()[0].saved, baked.groups[0].weight);
    edited.change(ChangeGroup{"neon", vec3(0.0f)}, *renderer, notices);
    EXPECT_EQ(edited.groups()[3].color, vec3(1.0f)) << "of the weight before";
    EXPECT_TRUE(notices.warnings().empty());
}

TEST_F(EditedGroupsS33, ALightOfItsOwnSetsTheWeight)
{
    Light sun = edited.scene().lights[1];
    sun.intensity *= 2.0f;
    edited.change(ChangeLight{1, sun}, *renderer, notices);
    EXPECT_EQ(edited.groups()[1].weight, 2.0f * baked.groups[1].weight);
    EXPECT_EQ(renderer->lightGroups()[1].weight, edited.groups()[1].weight);
}

TEST_F(EditedGroupsS33, WeightsAreRepeatedInTheNextScene)
{
    const auto begin = EditedScene::Clock::now();
    edited.change(ChangeGroup{"lamp", vec3(2.0f)}, *renderer, notices);
    ASSERT_TRUE(renderer->load(baked));
    edited.showGroups(baked, begin);
    EXPECT_EQ(edited.groups()[0].weight, vec3(2.0f));
    EXPECT_EQ(renderer->lightGroups()[0].weight, baked.groups[0].weight);
    EXPECT_TRUE(edited.repeat(begin, *renderer));
    EXPECT_EQ(renderer->lightGroups()[0].weight, vec3(2.0f));
    BakedScene plain; // first light of a bake
    plain.scene = *edited.snapshot();
    for (Light& light : plain.scene.lights) light.baking.group = -1;
    edited.showGroups(plain, EditedScene::Clock::now());
    EXPECT_TRUE(edited.groups().empty());
    EXPECT_EQ(lightOf(edited.scene(), 0), vec3(40.0f));
    EXPECT_EQ(lightOf(*edited.snapshot(), 0), vec3(40.0f));
}

/// Weights that were changed before a bake are in its light: its groups begin at the weights that it saved.
TEST_F(EditedGroupsS33, ABakeOfTheWindowBeginsAtItsOwnWeights)
{
    edited.change(ChangeGroup{"lamp", vec3(2.0f)}, *renderer, notices);
    BakedScene again = baked;
    again.scene = *edited.snapshot();
    again.scene.lights[0].baking.white = vec3(40.0f);
    again.groups[0].weight = vec3(1.0f);
    ASSERT_TRUE(renderer->load(again));
    edited.showGroups(again, EditedScene::Clock::now());
    EXPECT_EQ(edited.groups()[0].weight, vec3(1.0f));
    EXPECT_EQ(lightOf(edited.scene(), 0), vec3(40.0f));
    edited.change(ChangeGroup{"lamp", vec3(0.5f)}, *renderer, notices);
    EXPECT_EQ(lightOf(edited.scene(), 0), vec3(20.0f));
    edited.change(ChangeGroup{"lamp", vec3(1.0f)}, *renderer, notices);
    EXPECT_EQ(lightOf(edited.scene(), 0), vec3(40.0f)) << "as it was baked, not as the file has it";
}

class EditedTurningS34 : public EditedGroupsS33 {};

/// The panel's light, the groups' rows and what is drawn agree when a light turns.
TEST_F(EditedTurningS34, ALightThatTurnsIsOneRow)
{
    const std::vector<vec3> directions = {vec3(0, -1, 0), glm::normalize(vec3(0.3f, -1, 0))};
    const auto begin = EditedScene::Clock::now();
    baked.groups[test::kSun].name = "the sun.1";
    baked.groups.insert(baked.groups.begin() + test::kSun + 1, baked.groups[test::kSun]);
    baked.groups[test::kSun + 1].name = "the sun.2";
    baked.groups[test::kSun + 1].weight = vec3(0.0f);
    Light& light = baked.scene.lights[1];
    light.baking.group = -1;
    light.baking.turning = {test::kSun, directions};
    light.worldFromLight = test::lightPose(vec3(0), directions[0]);
    for (Light& other : baked.scene.lights) other.baking.group += other.baking.group > test::kSun ? 1 : 0;
    baked.scene.materials[1].bakedGroup += 1;
    ASSERT_TRUE(renderer->load(baked));
    edited.beginFile(baked.scene);
    edited.showGroups(baked, begin);
    ASSERT_EQ(edited.groups().size(), 4u);
    EXPECT_EQ(edited.groups()[1].name, "the sun");
    const vec3 saved = edited.groups()[1].saved;
    Light turned = edited.scene().lights[1];
    turned.worldFromLight = test::lightPose(vec3(0), glm::normalize(vec3(0.15f, -1, 0)));
    edited.change(ChangeLight{1, turned}, *renderer, notices);
    EXPECT_EQ(edited.groups()[1].weight, saved) << "its light is the same";
    EXPECT_EQ(lightOf(edited.atLoadWithWeights(), 1), lightOf(baked.scene, 1));
    edited.change(ChangeGroup{"the sun", 2.0f * saved}, *renderer, notices);
    EXPECT_LT(glm::distance(lightOf(edited.scene(), 1), 2.0f * lightOf(baked.scene, 1)), 1e-3f);
    EXPECT_LT(glm::distance(renderer->lightGroups()[1].weight, edited.groups()[1].weight), 1e-4f);
    EXPECT_TRUE(notices.warnings().empty());
    ASSERT_TRUE(renderer->load(baked)); // the same scene, uploaded once more
    edited.showGroups(baked, begin);
    EXPECT_LT(glm::distance(edited.groups()[1].weight, 2.0f * saved), 1e-4f);
    EXPECT_TRUE(edited.repeat(begin, *renderer));
    EXPECT_LT(glm::distance(renderer->lightGroups()[1].weight, 2.0f * saved), 1e-4f);
    EXPECT_LT(glm::distance(renderer->scene().lights[1].direction(), turned.direction()), 1e-5f);
}

} // namespace
} // namespace halflight::view::edited_scene_test
