// Panels and keys, without a window: every section is drawn, and what is clicked and typed reaches the state.
#include "view/panels/panel_sections.h"
#include "view/panels/panels.h"

#include <SDL_keycode.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>
#include <random>

namespace halflight::view::panels_test {
namespace {

Scene smallScene()
{
    Scene scene;
    for (const LightType type : {LightType::Directional, LightType::Point, LightType::Spot}) {
        Light& light = scene.lights.emplace_back();
        light.name = "a light";
        light.type = type;
    }
    for (int i = 0; i < 200; ++i) scene.objects.emplace_back().name = "thing";
    scene.cameras.resize(2);
    return scene;
}

class Panels : public testing::Test {
protected:
    void SetUp() override
    {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = ImVec2(400.0f, 4000.0f); // all sections at once
        io.DeltaTime = 1.0f / 60.0f;
        unsigned char* texels = nullptr;
        int width = 0;
        int height = 0;
        io.Fonts->GetTexDataAsRGBA32(&texels, &width, &height);
        readings.modes = {RunMode::Realtime, RunMode::BakedIndirect, RunMode::Shadowmask};
        readings.passes = {{"depth", 3, 3, 100, 1.0}};
        readings.frameMilliseconds = {16.0f, 17.0f};
        readings.warnings = {"something is odd"};
        readings.title = "file.glb";
    }
    void TearDown() override { ImGui::DestroyContext(); }

    /// One frame; the vertices that were drawn.
    int frame()
    {
        ImGui::NewFrame();
        drawPanels(state, readings, scene);
        ImGui::Render();
        return ImGui::GetDrawData()->TotalVtxCount;
    }
    void click(float x, float y)
    {
        ImGuiIO& io = ImGui::GetIO();
        io.MousePos = ImVec2(x, y);
        frame();
        io.MouseDown[0] = true;
        frame();
        io.MouseDown[0] = false;
        frame();
    }

    Scene scene = smallScene();
    ViewState state;
    Readings readings;
};

TEST(PanelScale, IsOneAtUsualDisplays)
{
    for (const float usual : {0.0f, -1.0f, 72.0f, 96.0f, 100.0f, std::nanf("")}) EXPECT_EQ(panelScale(usual), 1.0f);
    EXPECT_EQ(panelScale(144.0f), 1.5f);
    EXPECT_EQ(panelScale(163.0f), 1.75f);
    EXPECT_EQ(panelScale(192.0f), 2.0f);
    EXPECT_EQ(panelScale(5000.0f), 4.0f);
}

TEST_F(Panels, AreAtTheLeftOfThePicture)
{
    frame();
    EXPECT_TRUE(overPanels(state, vec2(20.0f, 500.0f)));
    EXPECT_FALSE(overPanels(state, vec2(390.0f, 500.0f)));
    state.panels = false;
    EXPECT_FALSE(overPanels(state, vec2(20.0f, 500.0f)));
}

TEST_F(Panels, AreDrawnUnlessHidden)
{
    frame();
    EXPECT_GT(frame(), 500);
    state.panels = false;
    frame();
    EXPECT_EQ(frame(), 0);
}

TEST_F(Panels, GraphOfPassesHasAColumnForEachFrame)
{
    const auto vertices = [&] {
        ImGui::NewFrame();
        ImGui::Begin("panels");
        ImGui::SetNextItemOpen(true);
        frameSection(state, readings);
        ImGui::End();
        ImGui::Render();
        return ImGui::GetDrawData()->TotalVtxCount;
    };
    readings.frameMilliseconds.clear();
    vertices();
    const int none = vertices();
    readings.frameMilliseconds.assign(kShownFrames, 16.0f);
    EXPECT_GE(vertices(), none + 100) << "the frames' own graph";
    readings.timed = true;
    state.settings.timings = true;
    vertices();
    const int without = vertices();
    readings.passes = {{"depth", 3, 3, 100, 1.0}, {"light", 3, 3, 100, 2.0}};
    for (int i = 0; i < 10; ++i) addFrame(readings.passesOfFrames, readings.passes);
    vertices(); // the window takes its size
    const int some = vertices();
    EXPECT_GE(some, without + 10 * 2 * 4) << "a rectangle for each pass of each frame";
    for (int i = 0; i < 1000; ++i) addFrame(readings.passesOfFrames, readings.passes);
    EXPECT_EQ(readings.passesOfFrames.size(), kShownFrames);
    EXPECT_EQ(vertices(), some + int(kShownFrames - 10) * 2 * 4);
}

TEST_F(Panels, NumbersThatAreTypedStayWithinTheirLimits)
{
    float value = 0.5f;
    const auto show = [&] {
        ImGui::NewFrame();
        ImGui::SetNextWindowPos(ImVec2(0, 0));
        ImGui::SetNextWindowSize(ImVec2(300, 100));
        ImGui::Begin("panels");
        drag("number", value, 0.01f, 0.25f, 4.0f, "%.2f");
        const ImVec2 corner = ImGui::GetItemRectMin();
        ImGui::End();
        ImGui::Render();
        return corner;
    };
    const ImVec2 corner = show();
    ImGuiIO& io = ImGui::GetIO();
    for (const char* text : {"0.1", "-3", "99", "1e30"}) {
        io.MousePos = ImVec2(corner.x + 5.0f, corner.y + 5.0f);
        show();
        io.KeyCtrl = io.MouseDown[0] = true;
        show();
        io.KeyCtrl = io.MouseDown[0] = false;
        show();
        for (const char* c = text; *c != '\0'; ++c) {
            io.AddInputCharacter(unsigned(*c));
            show();
            EXPECT_GE(value, 0.25f) << text << " at " << *c;
            EXPECT_LE(value, 4.0f) << text << " at " << *c;
        }
        io.MousePos = ImVec2(390.0f, 390.0f);
        io.MouseDown[0] = true; // elsewhere: typing ends
        show();
        io.MouseDown[0] = false;
        show();
        EXPECT_EQ(value, *text == '0' || *text == '-' ? 0.25f : 4.0f) << text;
    }
}

TEST(ShownName, HidesNothing)
{
    EXPECT_EQ(shownName("a##b"), "a# #b");
    EXPECT_EQ(shownName("###"), "# # #");
    EXPECT_EQ(shownName("a#b"), "a#b");
}

/// Random clicks open sections and press what is in them. Whatever they do, values stay within their limits, and what
/// is asked for names things that exist.
TEST_F(Panels, SurviveRandomClicks)
{
    std::mt19937 random(3);
    Requests seen;
    int requestedLights = 0;
    int requestedSwitches = 0;
    for (int i = 0; i < 12000; ++i) {
        click(float(random() % 360), float(random() % 2600));
        if (i % 500 == 0) readings.bakeStatus.running = !readings.bakeStatus.running;
        if (state.requests.light) {
            ++requestedLights;
            const auto& [index, light] = *state.requests.light;
            ASSERT_LT(std::size_t(index), scene.lights.size());
            scene.lights[std::size_t(index)] = light;
        }
        if (state.requests.switches) {
            ++requestedSwitches;
            ASSERT_LT(std::size_t(state.requests.switches->object), scene.objects.size());
        }
        seen.bake |= state.requests.bake;
        seen.cancelBake |= state.requests.cancelBake;
        seen.screenshot |= state.requests.screenshot;
        seen.expose |= state.requests.expose;
        seen.reload |= state.requests.reload;
        if (state.requests.camera) ASSERT_LT(*state.requests.camera, 2);
        state.requests = {};
        ASSERT_TRUE(checkShadowSettings(state.settings.shadows)) << i;
        ASSERT_GE(state.settings.supersampling, 1);
        ASSERT_LE(state.settings.supersampling, 4);
    }
    EXPECT_TRUE(seen.bake);
    EXPECT_TRUE(seen.cancelBake);
    EXPECT_TRUE(seen.screenshot);
    EXPECT_TRUE(seen.expose);
    EXPECT_TRUE(seen.reload);
    EXPECT_GT(requestedLights, 0);
    EXPECT_GT(requestedSwitches, 0);
}

TEST_F(Panels, KeysDoWhatTheHelpSays)
{
    handleKey(state, readings, SDLK_3, false);
    EXPECT_EQ(state.settings.mode, RunMode::Shadowmask);
    handleKey(state, readings, SDLK_5, false);
    EXPECT_EQ(state.settings.mode, RunMode::Shadowmask) << "the file has no data for subtractive";
    handleKey(state, readings, SDLK_p, false);
    EXPECT_EQ(state.settings.path, RenderPath::Deferred);
    for (int i = 0; i < 8; ++i) handleKey(state, readings, SDLK_v, false);
    EXPECT_EQ(state.settings.view, DebugView::Lit) << "once round";
    handleKey(state, readings, SDLK_b, true);
    EXPECT_FALSE(state.requests.bake) << "with control it is another command";
    handleKey(state, readings, SDLK_b, false);
    EXPECT_TRUE(state.requests.bake);
    handleKey(state, readings, SDLK_TAB, false);
    EXPECT_FALSE(state.panels);
    for (const Compare with : {Compare::Mode, Compare::Reference}) {
        handleKey(state, readings, SDLK_c, false);
        EXPECT_TRUE(state.compares);
        EXPECT_EQ(state.compareWith, with);
    }
    handleKey(state, readings, SDLK_c, false);
    EXPECT_FALSE(state.compares);
    readings.hasEarlier = true;
    handleKey(state, readings, SDLK_c, false);
    EXPECT_EQ(state.compareWith, Compare::BeforeBake);
    handleKey(state, readings, SDLK_r, false);
    EXPECT_EQ(state.compareWith, Compare::Reference);
    handleKey(state, readings, SDLK_r, false);
    EXPECT_FALSE(state.compares);
    readings.bakeStatus.running = true;
    handleKey(state, readings, SDLK_ESCAPE, false);
    EXPECT_TRUE(state.requests.cancelBake);
    EXPECT_FALSE(state.requests.quit);
    handleKey(state, readings, SDLK_ESCAPE, false);
    EXPECT_TRUE(state.requests.quit) << "twice between two frames";
    state.requests = {};
    readings.bakeStatus.cancelled = true;
    handleKey(state, readings, SDLK_ESCAPE, false);
    EXPECT_TRUE(state.requests.quit) << "nothing waits until the bake has ended";
    state.requests = {};
    readings.bakeStatus = {};
    handleKey(state, readings, SDLK_ESCAPE, false);
    EXPECT_TRUE(state.requests.quit);
}

} // namespace
} // namespace halflight::view::panels_test
