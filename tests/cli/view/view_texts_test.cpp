// The command line of a view, and the user's changes as a settings file.
#include "view_texts.h"

#include <gmock/gmock.h>

namespace halflight::cli::view_texts_test {
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

ViewedPicture pictureOf(const Scene& scene, const Scene& atLoad)
{
    ViewedPicture picture{.file = "a.glb", .scene = scene, .atLoad = atLoad};
    picture.render.size = ivec2(640, 360);
    picture.camera.worldFromCamera[3] = vec4(1, 2, 3, 1);
    picture.ahead = vec3(1, 2, 2);
    return picture;
}

// The weights of light groups are options of their own, and not changes of lights.
TEST(CommandLine, HasTheWeightsOfGroupsS33)
{
    const Scene scene = twoLights();
    ViewedPicture picture = pictureOf(scene, scene);
    picture.groups = {{"the lamps", vec3(0.5f, 0.25f, 0.0f)}};
    const ViewText command = commandLine(picture);
    EXPECT_THAT(command.text, HasSubstr(" --group 'the lamps=0.5,0.25,0'"));
    EXPECT_THAT(command.text, Not(HasSubstr("--light")));
    EXPECT_TRUE(command.leftOut.empty());
    Scene brighter = scene;
    brighter.materials.emplace_back().name = "neon";
    Scene before = brighter;
    brighter.materials[0].emissiveNits = vec3(2.0f);
    brighter.sky.zenith = vec3(1.0f);
    EXPECT_EQ(settingsFile(brighter, before).leftOut, "the emission of 'neon', the sky's weight");
}

TEST(CommandLine, HasTheDirectionOfALightThatTurnsS34)
{
    Scene before = twoLights();
    before.lights[0].type = LightType::Directional;
    before.lights[0].baking.turning = {0, {vec3(0, 0, -1), vec3(0, -1, 0)}};
    Scene scene = before;
    scene.lights[0].worldFromLight[1] = vec4(0, 0, -1, 0);
    scene.lights[0].worldFromLight[2] = vec4(0, 1, 0, 0);
    EXPECT_THAT(commandLine(pictureOf(scene, before)).text, HasSubstr(" --light 'sun:direction=-0,-1,-0'"));
    EXPECT_EQ(settingsFile(scene, before).leftOut, "the direction of the light 'sun'");
    EXPECT_THAT(commandLine(pictureOf(before, before)).text, Not(HasSubstr("--light")));
}

TEST(CommandLine, NamesWhatDiffersFromTheDefaults)
{
    Scene scene = twoLights();
    scene.originMeters = dvec3(1000, 0, 0);
    const Scene before = scene;
    ViewedPicture picture = pictureOf(scene, before);
    picture.file = "it's.glb";
    picture.exposureEv = 1.5f;
    std::string line = commandLine(picture).text;
    EXPECT_EQ(line, "halflight render 'it'\\''s.glb' -o picture.png --size 640x360 --eye 1001,2,3 --target 1001,2,2 "
                    "--fov 60 --mode realtime --path forward --samples 1 --exposure 1.5");
    picture.render.mode = RunMode::Shadowmask;
    picture.render.path = RenderPath::Deferred;
    picture.render.view = DebugView::Fade;
    picture.render.shadows.filter = ShadowFilter::Soft;
    picture.shadowDistanceGiven = true;
    picture.toneMapping = ToneMapping::Agx;
    scene.lights[0].intensity = 3.0f;
    scene.lights[0].color = vec3(1.0f, 0.5f, 0.25f);
    picture.settingsFile = "my lights.toml";
    line = commandLine(picture).text;
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
    EXPECT_EQ(settingsFile(scene, before).text, "");
    scene.lights[1].mode = LightMode::Baked;
    scene.lights[1].radiusMeters = 0.25f;
    scene.objects[0].castShadows = false;
    EXPECT_EQ(settingsFile(scene, before).text,
              "[[light]]\npattern = \"lamp \\\"1\\\"\"\nmode = \"baked\"\nradius = 0.25\n\n"
              "[[node]]\npattern = \"Door\"\ncast_shadows = false\n\n");
}

TEST(CommandLine, NamesTheFilesCameraUntilItMoves)
{
    Scene scene;
    Camera& camera = scene.cameras.emplace_back();
    camera.name = "front";
    camera.orthographic = true;
    ViewedPicture picture = pictureOf(scene, scene);
    picture.camera = camera;
    EXPECT_THAT(commandLine(picture).text, HasSubstr(" --camera 'front' "));
    EXPECT_EQ(commandLine(picture).leftOut, "");
    picture.camera.worldFromCamera[3].x = 1.0f;
    EXPECT_THAT(commandLine(picture).text, Not(HasSubstr("--camera")));
    EXPECT_THAT(commandLine(picture).leftOut, HasSubstr("orthographic"));
}

TEST(CommandLine, HasTheFieldOfViewToTheBit)
{
    const Scene none;
    ViewedPicture picture = pictureOf(none, none);
    for (const float radians : {glm::radians(45.0f), glm::radians(60.0f), 0.8f, 1.0471f}) {
        picture.camera.verticalFovRadians = radians;
        const std::string line = commandLine(picture).text;
        EXPECT_EQ(glm::radians(std::stof(line.substr(line.find("--fov ") + 6))), radians) << line;
    }
    picture.camera.verticalFovRadians = glm::radians(45.0f);
    EXPECT_THAT(commandLine(picture).text, HasSubstr("--fov 45 "));
}

TEST(CommandLine, HasTheShadowsThatWereAskedFor)
{
    const Scene none;
    ViewedPicture picture = pictureOf(none, none);
    ShadowSettings& shadows = picture.render.shadows;
    shadows.cascades = 3;
    shadows.cascadeSplits = {0.1f, 0.4f, 0.0f};
    shadows.depthBias = 1.0f;
    shadows.slopeBias = 2.0f;
    shadows.normalBiasTexels = 3.0f;
    picture.render.subtractiveShadowColor = vec3(1, 2, 3);
    const std::string line = commandLine(picture).text;
    for (const char* part : {"--cascade-splits 0.1,0.4", "--shadow-depth-bias 1", "--shadow-slope-bias 2",
                             "--shadow-normal-bias 3", "--shadow-color 1,2,3"})
        EXPECT_THAT(line, HasSubstr(part));
}

TEST(LeftOut, NamesWhatTheTextsCannotSay)
{
    Scene scene = twoLights();
    const Scene before = scene;
    const ViewedPicture picture = pictureOf(scene, before);
    scene.lights[0].intensity = 2.0f;
    EXPECT_EQ(commandLine(picture).leftOut, "");
    scene.lights[0].radiusMeters = 0.5f;
    EXPECT_EQ(commandLine(picture).leftOut, "more changes of the light 'sun'");
    scene.objects[0].castShadows = false;
    EXPECT_EQ(commandLine(picture).leftOut, "more changes of the light 'sun', switches of 'Door'");
    EXPECT_EQ(settingsFile(scene, before).leftOut, "");
    scene.objects[0].worldFromObject[3].x = 1.0f;
    EXPECT_EQ(settingsFile(scene, before).leftOut, "the place of 'Door'");
    EXPECT_THAT(commandLine(picture).leftOut, HasSubstr("'Door', the place of 'Door'"));
    ViewedPicture unchanged = pictureOf(before, before);
    unchanged.render.shadows.atlasSize = 1024;
    unchanged.render.shadows.pointShadows = false;
    EXPECT_EQ(commandLine(unchanged).leftOut, "the size of the shadow atlas, shadows of point lights off");
}

TEST(SettingsFile, HasNoRuleForOneOfSeveralOfAName)
{
    Scene scene = twoLights();
    scene.lights[1].name = scene.lights[0].name;
    const Scene before = scene;
    scene.lights[1].intensity = 2.0f;
    EXPECT_EQ(settingsFile(scene, before).text, "") << "it would change both";
    EXPECT_EQ(settingsFile(scene, before).leftOut, "changes of one of several 'sun'");
    const ViewText line = commandLine(pictureOf(scene, before));
    EXPECT_THAT(line.text, Not(HasSubstr("--light")));
    EXPECT_EQ(line.leftOut, "changes of one of several 'sun'");
}

} // namespace
} // namespace halflight::cli::view_texts_test
