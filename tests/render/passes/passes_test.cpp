// What a frame reports of its passes.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace halflight::test::passes_test {
namespace {

const PassReport& passOf(const RenderedFrame& frame, const std::string& name)
{
    static const PassReport none;
    const auto it = std::find_if(frame.passes.begin(), frame.passes.end(),
                                 [&](const PassReport& pass) { return pass.name == name; });
    EXPECT_NE(it, frame.passes.end()) << name;
    return it != frame.passes.end() ? *it : none;
}

/// A static floor of one rectangle, twelve dynamic rectangles of one mesh above it, one of another mesh.
BakedScene scene()
{
    BakedScene baked;
    addObject(baked.scene, makeRectangle(20, 20), mat4(1.0f), true);
    const int first = addObject(baked.scene, makeRectangle(0.5f, 0.5f), mat4(1.0f), false);
    for (int i = 0; i < 12; ++i) {
        if (i > 0) baked.scene.objects.push_back(baked.scene.objects[std::size_t(first)]);
        baked.scene.objects.back().worldFromObject =
            glm::translate(mat4(1.0f), vec3(float(i % 4) - 1.5f, 1, float(i / 4) - 1.0f));
    }
    addObject(baked.scene, makeRectangle(1, 1), glm::translate(mat4(1.0f), vec3(0, 0.5f, 2)), false);
    return baked;
}

RenderSettings smallPicture(RenderPath path)
{
    RenderSettings settings;
    settings.path = path;
    settings.size = {64, 36};
    settings.shadows.cascades = 2;
    return settings;
}

class PassReports : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(Paths, PassReports, kBothPaths, pathNameOf);

TEST_P(PassReports, CountDrawsAndTriangles)
{
    BakedScene baked = scene();
    baked.scene.lights.push_back(directionalLight(vec3(0.1f, 1, 0.2f), 2.0f));
    Light spot;
    spot.type = LightType::Spot;
    spot.mode = LightMode::Realtime;
    spot.intensity = 50.0f;
    spot.worldFromLight = lightPose(vec3(0, 4, 0), vec3(0, -1, 0));
    baked.scene.lights.push_back(spot);
    Light point = spot;
    point.type = LightType::Point;
    point.worldFromLight = lightPose(vec3(0, 3, 0), vec3(0, -1, 0));
    baked.scene.lights.push_back(point);
    const RenderedFrame frame = render(baked, lookAt(vec3(0, 6, 9), vec3(0)), smallPicture(GetParam()));

    const PassReport& depth = passOf(frame, "depth");
    EXPECT_EQ(depth.draws, 3); // one for each mesh
    EXPECT_EQ(depth.instances, 14);
    EXPECT_EQ(depth.triangles, 28);
    const PassReport& lit = passOf(frame, GetParam() == RenderPath::Deferred ? "g-buffer" : "forward");
    EXPECT_EQ(lit.draws, 3);
    EXPECT_EQ(lit.triangles, 28);
    EXPECT_EQ(passOf(frame, "blended").draws, 0);
    EXPECT_EQ(frame.plan.lights.size(), 3u);

    // Every caster of every tile, no more: what the plan says, counted anew.
    int64_t expected[3] = {};
    for (const FrameLight& light : frame.plan.lights)
        for (int i = 0; i < light.tileCount; ++i)
            expected[int(baked.scene.lights[std::size_t(light.light)].type)] +=
                2 * int64_t(frame.plan.castersOf(light.firstTile + i).size());
    EXPECT_EQ(passOf(frame, "directional shadows").triangles, expected[int(LightType::Directional)]);
    EXPECT_EQ(passOf(frame, "spot shadows").triangles, expected[int(LightType::Spot)]);
    EXPECT_EQ(passOf(frame, "point shadows").triangles, expected[int(LightType::Point)]);
    for (const int64_t triangles : expected) EXPECT_GE(triangles, 28);
}

TEST_P(PassReports, AreTimedWhenAsked)
{
    ASSERT_TRUE(renderer->load(scene()));
    RenderSettings settings = smallPicture(GetParam());
    const Camera camera = lookAt(vec3(0, 6, 9), vec3(0));
    const auto plain = renderer->render(camera, settings);
    settings.timings = true;
    const auto timed = renderer->render(camera, settings);
    ASSERT_TRUE(plain && timed);
    EXPECT_FALSE(plain->timed);
    for (const PassReport& pass : plain->passes) EXPECT_EQ(pass.milliseconds, 0.0) << pass.name;
    ASSERT_TRUE(timed->timed);
    ASSERT_EQ(plain->passes.size(), timed->passes.size());
    EXPECT_EQ(plain->radiance.texels(), timed->radiance.texels());
    for (const PassReport& pass : timed->passes) {
        EXPECT_GE(pass.milliseconds, 0.0) << pass.name;
        EXPECT_LT(pass.milliseconds, 60000.0) << pass.name;
    }
    EXPECT_GT(passOf(*timed, "depth").milliseconds, 0.0);
    EXPECT_GT(passOf(*timed, "readback").milliseconds, 0.0);
}

} // namespace
} // namespace halflight::test::passes_test
