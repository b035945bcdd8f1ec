// The command line of a view, and the user's changes as a settings file.
#include "view/state/changes.h"

#include <gmock/gmock.h>

namespace halflight::view::view_state_test {
namespace {

using testing::HasSubstr;
using testing::Not;

Scene twoLights()
{
    Scene scene;
    for (const char* name : {"sun", "lamp \"1\""}) {
        Light& light = scene.lights.emplace_back();
        light.name = name;
        light.type = LightType::Point;
    }
    Object& door = scene.objects.emplace_back();
    door.name = "Door";
    return scene;
}

TEST(CommandLine, NamesWhatDiffersFromTheDefaults)
{
    ViewState state;
    Camera camera;
    camera.worldFromCamera[3] = vec4(1, 2, 3, 1);
    state.navigator = Navigator(camera, 1.0f);
    state.exposureEv = 1.5f;
    Scene scene = twoLights();
    scene.originMeters = dvec3(1000, 0, 0);
    const Scene before = scene;
    std::string line = commandLine(state, {"it's.glb", ""}, {640, 360}, scene, before);
    EXPECT_EQ(line, "halflight render 'it'\\''s.glb' -o picture.png --size 640x360 --eye 1001,2,3 --target 1001,2,2 "
                    "--fov 60 --mode realtime --path forward --samples 1 --exposure 1.5");
    state.settings.mode = RunMode::Shadowmask;
    state.settings.path = RenderPath::Deferred;
    state.settings.view = DebugView::Fade;
    state.settings.shadows.filter = ShadowFilter::Soft;
    state.followsShadowDistance = false;
    state.toneMapping = ToneMapping::Agx;
    scene.lights[0].intensity = 3.0f;
    scene.lights[0].color = vec3(1.0f, 0.5f, 0.25f);
    line = commandLine(state, {"a.glb", "my lights.toml"}, {640, 360}, scene, before);
    for (const char* part :
         {"--mode shadowmask", "--path deferred", "--view fade", "--shadow-filter soft", "--shadow-distance 60",
          "--tone-mapping agx", "--settings 'my lights.toml'", "--light 'sun:intensity=3,color=1,0.5,0.25'"})
        EXPECT_THAT(line, HasSubstr(part));
    EXPECT_THAT(line, Not(HasSubstr("lamp")));
}

TEST(SettingsFile, HasTheChangesAlone)
{
    Scene scene = twoLights();
    const Scene before = scene;
    EXPECT_EQ(settingsFile(scene, before), "");
    scene.lights[1].mode = LightMode::Baked;
    scene.lights[1].radiusMeters = 0.25f;
    scene.objects[0].castShadows = false;
    EXPECT_EQ(settingsFile(scene, before),
              "[[light]]\npattern = \"lamp \\\"1\\\"\"\nmode = \"baked\"\nradius = 0.25\n\n"
              "[[node]]\npattern = \"Door\"\ncast_shadows = false\n\n");
}

TEST(CommandLine, NamesTheFilesCameraUntilItMoves)
{
    ViewState state;
    Scene scene;
    Camera& camera = scene.cameras.emplace_back();
    camera.name = "front";
    camera.orthographic = true;
    camera.worldFromCamera[3] = vec4(1, 2, 3, 1);
    state.navigator = Navigator(camera, 1.0f);
    EXPECT_THAT(commandLine(state, {"a.glb", ""}, {64, 64}, scene, scene), HasSubstr(" --camera 'front' "));
    EXPECT_EQ(leftOutOfCommandLine(state, scene, scene), "");
    state.navigator.orbit(vec2(0.1f, 0.0f));
    EXPECT_THAT(commandLine(state, {"a.glb", ""}, {64, 64}, scene, scene), Not(HasSubstr("--camera")));
    EXPECT_THAT(leftOutOfCommandLine(state, scene, scene), HasSubstr("orthographic"));
}

TEST(CommandLine, HasTheFieldOfViewToTheBit)
{
    ViewState state;
    Camera camera;
    for (const float radians : {glm::radians(45.0f), glm::radians(60.0f), 0.8f, 1.0471f}) {
        camera.verticalFovRadians = radians;
        state.navigator = Navigator(camera, 1.0f);
        const std::string line = commandLine(state, {"a.glb", ""}, {64, 64}, Scene(), Scene());
        EXPECT_EQ(glm::radians(std::stof(line.substr(line.find("--fov ") + 6))), radians) << line;
    }
    camera.verticalFovRadians = glm::radians(45.0f);
    state.navigator = Navigator(camera, 1.0f);
    EXPECT_THAT(commandLine(state, {"a.glb", ""}, {64, 64}, Scene(), Scene()), HasSubstr("--fov 45 "));
}

TEST(CommandLine, HasTheShadowsThatWereAskedFor)
{
    ViewState state;
    ShadowSettings& shadows = state.settings.shadows;
    shadows.cascades = 3;
    shadows.cascadeSplits = {0.1f, 0.4f, 0.0f};
    shadows.depthBias = 1.0f;
    shadows.slopeBias = 2.0f;
    shadows.normalBiasTexels = 3.0f;
    state.settings.subtractiveShadowColor = vec3(1, 2, 3);
    const std::string line = commandLine(state, {"a.glb", ""}, {64, 64}, Scene(), Scene());
    for (const char* part : {"--cascade-splits 0.1,0.4", "--shadow-depth-bias 1", "--shadow-slope-bias 2",
                             "--shadow-normal-bias 3", "--shadow-color 1,2,3"})
        EXPECT_THAT(line, HasSubstr(part));
}

TEST(LeftOut, NamesWhatTheTextsCannotSay)
{
    Scene scene = twoLights();
    const Scene before = scene;
    scene.lights[0].intensity = 2.0f;
    ViewState state;
    EXPECT_EQ(leftOutOfCommandLine(state, scene, before), "");
    scene.lights[0].radiusMeters = 0.5f;
    EXPECT_EQ(leftOutOfCommandLine(state, scene, before), "more changes of the light 'sun'");
    scene.objects[0].castShadows = false;
    EXPECT_EQ(leftOutOfCommandLine(state, scene, before), "more changes of the light 'sun', switches of 'Door'");
    EXPECT_EQ(leftOutOfSettings(scene, before), "");
    scene.objects[0].worldFromObject[3].x = 1.0f;
    EXPECT_EQ(leftOutOfSettings(scene, before), "the place of 'Door'");
    EXPECT_THAT(leftOutOfCommandLine(state, scene, before), HasSubstr("'Door', the place of 'Door'"));
    state.settings.shadows.atlasSize = 1024;
    state.settings.shadows.pointShadows = false;
    EXPECT_EQ(leftOutOfCommandLine(state, before, before), "the size of the shadow atlas, shadows of point lights off");
}

TEST(SettingsFile, HasNoRuleForOneOfSeveralOfAName)
{
    Scene scene = twoLights();
    scene.lights[1].name = scene.lights[0].name;
    const Scene before = scene;
    scene.lights[1].intensity = 2.0f;
    EXPECT_EQ(settingsFile(scene, before), "") << "it would change both";
    EXPECT_EQ(leftOutOfSettings(scene, before), "changes of one of several 'sun'");
    const std::string line = commandLine(ViewState(), {"a.glb", ""}, {640, 360}, scene, before);
    EXPECT_THAT(line, Not(HasSubstr("--light")));
    EXPECT_EQ(leftOutOfCommandLine(ViewState(), scene, before), "changes of one of several 'sun'");
}

TEST(SubjectOf, IsTheFirstNameInTheText)
{
    Scene scene = twoLights();
    for (const char* name : {"Door frame", "D", ""}) scene.objects.emplace_back().name = name;
    EXPECT_EQ(subjectOf("the light sun overlaps four others", scene).light, 0);
    EXPECT_EQ(subjectOf("the Door is closed", scene).object, 0);
    EXPECT_EQ(subjectOf("'Door frame' has no texels", scene).object, 1) << "the longest there";
    EXPECT_EQ(subjectOf("the light sun overlaps Door frame and D", scene).light, 0);
    EXPECT_EQ(subjectOf("D and Door frame overlap", scene).object, 2);
    EXPECT_EQ(subjectOf("Doors and sunshine", scene).object, -1) << "no whole word";
    EXPECT_EQ(subjectOf("Doors and sunshine", scene).light, -1);
}

} // namespace
} // namespace halflight::view::view_state_test
